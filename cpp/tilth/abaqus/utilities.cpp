// SPDX-License-Identifier: BSD-3-Clause
// Utility routines that UMATs of Abaqus call, in a library of their own: it is loaded before a
// library of the user that needs it (src/tilth/model/abaqus_utilities.py). Names and arguments are
// those of the Abaqus User Subroutines Reference Guide, chapter "Utility routines", as gfortran
// calls them: by reference, a trailing underscore, lengths of texts at the end.
//
// A tensor has NDI direct components, then NSHR shear components in the order 12, 13, 23. With
// LSTR = 1 it is a stress, with LSTR = 2 a strain with engineering shear strains.

#include <dlfcn.h>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "symmetric.hpp"

#define TILTH_UTILITY extern "C" __attribute__((visibility("default")))

namespace {

using tilth::abaqus::Tensor;

constexpr int most_names = 64, most_characters = 512, most_messages = 20;
constexpr std::uintptr_t first_page = 4096;  // no object has a smaller address
constexpr std::size_t word = 8;              // characters of an entry of CHARV

struct Name {
  char library[most_characters], material[most_characters];
};
Name names[most_names];
int count_of_names = 0;
std::atomic<int> messages = 0;

/// Returns what the material whose routine has this address is called in messages. The address is
/// not in its library where the compiler has made a jump of a call at the end of the routine.
const char* material_of(void* address) {
  Dl_info info;
  if (dladdr(address, &info) != 0 && info.dli_fname != nullptr)
    for (int i = 0; i < count_of_names; ++i)
      if (std::strcmp(names[i].library, info.dli_fname) == 0) return names[i].material;
  return count_of_names == 1 ? names[0].material : "one of the materials with a UMAT";
}

[[noreturn]] void end(const char* material, const char* routine) {
  std::fprintf(
      stderr,
      "\ntilth: %s: its routine called Abaqus' %s, which ends the analysis\n"
      "  steps before this one are on the disk; look for what the routine did not accept\n",
      material, routine);
  std::fflush(nullptr);
  std::exit(1);
}

/// Writes a text, whose %I, %R and %S stand for the next whole number, number and text.
void write(const char* kind, const char* material, const char* text, std::size_t length,
           const int* whole, const double* real, const char* words) {
  char line[4 * most_characters];
  std::size_t used = 0;
  const auto room = [&] { return sizeof(line) - used; };
  while (length > 0 && text[length - 1] == ' ') --length;
  for (std::size_t i = 0; i < length && room() > 1; ++i) {
    const char next = text[i] == '%' && i + 1 < length ? text[i + 1] : ' ';
    int added = -1;
    if (next == 'I' && whole != nullptr)
      added = std::snprintf(line + used, room(), "%d", *whole++);
    else if (next == 'R' && real != nullptr)
      added = std::snprintf(line + used, room(), "%.6g", *real++);
    else if (next == 'S' && words != nullptr) {
      std::size_t end = word;
      while (end > 0 && words[end - 1] == ' ') --end;
      added = std::snprintf(line + used, room(), "%.*s", static_cast<int>(end), words);
      words += word;
    }
    if (added < 0) {
      line[used++] = text[i];
      continue;
    }
    used += static_cast<std::size_t>(added) < room() ? added : room() - 1;
    ++i;
  }
  line[used] = '\0';
  std::fprintf(stderr, "\ntilth: %s: %s of its routine: %s\n", material, kind, line);
}

}  // namespace

/// Keeps the name of a material with the law of a library, for messages.
TILTH_UTILITY void tilth_name_material(const char* library, const char* material) {
  for (int i = 0; i < count_of_names; ++i)
    if (std::strcmp(names[i].library, library) == 0 &&
        std::strcmp(names[i].material, material) == 0)
      return;
  if (count_of_names == most_names) return;
  Name& name = names[count_of_names];
  std::snprintf(name.library, sizeof(name.library), "%s", library);
  std::snprintf(name.material, sizeof(name.material), "%s", material);
  ++count_of_names;
}

TILTH_UTILITY void xit_() { end(material_of(__builtin_return_address(0)), "XIT"); }

TILTH_UTILITY void sinv_(const double* stress, double* first, double* mises, const int* ndi,
                         const int* nshr) {
  const Tensor t(stress, 1.0, *ndi, *nshr);
  const double mean = (t(0, 0) + t(1, 1) + t(2, 2)) / 3.0;
  double square = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double deviator = t(i, j) - (i == j ? mean : 0.0);
      square += deviator * deviator;
    }
  *first = mean;
  *mises = std::sqrt(1.5 * square);
}

TILTH_UTILITY void sprind_(const double* s, double* principal, double* cosines, const int* lstr,
                           const int* ndi, const int* nshr) {
  double directions[3][3];
  Tensor(s, *lstr == 2 ? 0.5 : 1.0, *ndi, *nshr).principal(principal, directions);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i) cosines[k + 3 * i] = directions[k][i];
}

TILTH_UTILITY void sprinc_(const double* s, double* principal, const int* lstr, const int* ndi,
                           const int* nshr) {
  double cosines[9];
  sprind_(s, principal, cosines, lstr, ndi, nshr);
}

TILTH_UTILITY void rotsig_(const double* s, const double* r, double* rotated, const int* lstr,
                           const int* ndi, const int* nshr) {
  const double factor = *lstr == 2 ? 0.5 : 1.0;
  Tensor(s, factor, *ndi, *nshr).rotated(r).store(rotated, factor, *ndi, *nshr);
}

TILTH_UTILITY void stdb_abqerr_(const int* lop, const char* text, const int* whole,
                                const double* real, const char* words, std::size_t length) {
  const char* material = material_of(__builtin_return_address(0));
  const auto third = reinterpret_cast<std::uintptr_t>(whole);
  if (third < first_page) {  // called with two arguments: the length of the text comes third
    length = third;
    whole = nullptr;
    real = nullptr;
    words = nullptr;
  }
  const int number = messages.fetch_add(1);
  const char* kind = *lop > 0 ? "message" : *lop == -1 ? "warning" : "error";
  if (number < most_messages || *lop <= -3) write(kind, material, text, length, whole, real, words);
  if (number == most_messages) std::fprintf(stderr, "tilth: further messages are left out\n");
  if (*lop <= -3) end(material, "STDB_ABQERR with LOP = -3");
}
