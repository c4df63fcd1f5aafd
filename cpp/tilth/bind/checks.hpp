// SPDX-License-Identifier: BSD-3-Clause
// Checks of arguments, once per call: whatever a function of the core is given, it returns or
// raises. Each check costs at most one pass over an array, without a branch in its loop. An
// exception must not leave a parallel loop: kernels that find a problem inside of one report it
// when the loop has ended.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "../grid.hpp"
#include "../indices.hpp"
#include "../kind.hpp"
#include "arrays.hpp"

namespace tilth::bind {

/// Refuses an argument: "NAME PROBLEM".
[[noreturn]] inline void refuse(const std::string& name, const std::string& problem) {
  throw std::invalid_argument(name + " " + problem);
}

inline void require(bool condition, const std::string& name, const char* problem) {
  if (!condition) refuse(name, problem);
}

template <class Array>
std::int64_t size_of(const Array& array) {
  return static_cast<std::int64_t>(array.size());
}

/// Refuses an array whose number of entries is not the expected one.
template <class Array>
void require_size(const Array& array, std::int64_t size, const std::string& name) {
  if (size_of(array) != size)
    refuse(name,
           "has " + std::to_string(array.size()) + " entries, expected " + std::to_string(size));
}

/// Returns the number of rows; refuses an array that has not this number of axes.
template <class Array>
std::int64_t rows_of(const Array& array, std::size_t axes, const std::string& name) {
  if (array.ndim() != axes)
    refuse(name, "has " + std::to_string(array.ndim()) + " axes, expected " + std::to_string(axes));
  return static_cast<std::int64_t>(array.shape(0));
}

/// Returns the number of columns; refuses an array that is not two-dimensional.
template <class Array>
std::int64_t columns_of(const Array& array, const std::string& name) {
  rows_of(array, 2, name);
  return static_cast<std::int64_t>(array.shape(1));
}

/// Returns the number of columns, the dimension of space; refuses what is not (n, 2) or (n, 3).
template <class Array>
int dimension_of(const Array& array, const std::string& name) {
  const std::int64_t columns = columns_of(array, name);
  if (columns != 2 && columns != 3)
    refuse(name, "has " + std::to_string(columns) + " columns, expected 2 or 3");
  return static_cast<int>(columns);
}

/// Refuses an array that has not this number of rows and columns.
template <class Array>
void require_table(const Array& array, std::int64_t rows, std::int64_t columns,
                   const std::string& name) {
  const std::int64_t own = columns_of(array, name);
  if (own != columns)
    refuse(name, "has " + std::to_string(own) + " columns, expected " + std::to_string(columns));
  require_size(array, rows * columns, name);
}

/// Returns the number of lists whose first entries are `start`: they begin at 0, do not overlap and
/// end at `end`.
template <class Array>
std::int64_t require_starts(const Array& start, std::int64_t end, const std::string& name) {
  const std::int64_t lists = size_of(start) - 1;
  require(lists >= 0, name, "is empty, expected one entry more than lists");
  const auto* at = start.data();
  require(at[0] == 0, name, "does not begin with 0");
  require(ascends_from_zero(at, lists), name, "is not ascending");
  if (at[lists] != end)
    refuse(name, "ends with " + std::to_string(at[lists]) + ", expected " + std::to_string(end));
  return lists;
}

/// Refuses indices that are negative or not below `limit`.
template <class T>
void require_indices(const T* index, std::int64_t count, std::int64_t limit,
                     const std::string& name) {
  if (!all_below(index, count, limit))
    refuse(name, "has an index outside of 0 to " + std::to_string(limit - 1));
}

template <class Array>
void require_indices(const Array& array, std::int64_t limit, const std::string& name) {
  require_indices(array.data(), size_of(array), limit, name);
}

/// Refuses numbers whose magnitude is not at most `limit`, such as NaN.
inline void require_magnitude(const ConstDoubles& array, double limit, const std::string& name) {
  bool beyond = false;
  const double* number = array.data();
  for (std::int64_t i = 0; i < size_of(array); ++i) beyond |= !(std::fabs(number[i]) <= limit);
  require(!beyond, name, "has entries that are not numbers or too large");
}

inline void require_finite(const ConstDoubles& array, const std::string& name) {
  require_magnitude(array, std::numeric_limits<double>::max(), name);
}

/// Coordinates that a lattice index can represent, and those beyond that can still be converted to
/// integers, in cells from the origin.
inline constexpr double in_lattice = largest_index, in_integers = 0x1p40;

/// Returns the number of lattice indices (n, 3); refuses those that no key represents.
inline std::int64_t require_lattice(const ConstIntegers& lattice, const std::string& name) {
  const std::int64_t rows = rows_of(lattice, 2, name);
  require_table(lattice, rows, 3, name);
  bool outside = false;
  const std::int64_t* index = lattice.data();
  for (std::int64_t i = 0; i < 3 * rows; ++i)
    outside |= index[i] < -key_bias || index[i] >= key_bias;
  require(!outside, name, "has a lattice index that is too large");
  return rows;
}

/// Refuses keys of nodes or cells that are negative or too large.
inline void require_keys(const ConstIntegers& keys, const std::string& name) {
  require_indices(keys, std::int64_t{1} << (3 * key_bits), name);
}

/// Returns the dimension of a kind of analysis.
inline int dimension_of_kind(const std::string& kind_name) {
  int dim = 0;
  with_kind(kind_name, [&](auto kind) { dim = decltype(kind)::dim; });
  return dim;
}

/// Returns an array that is an attribute of a Python object; refuses what would need a conversion.
template <class Array>
Array attribute(nb::handle of, const char* name) {
  Array array;
  const nb::object found = nb::getattr(of, name, nb::none());
  if (found.is_none()) throw nb::type_error((std::string("there is no attribute ") + name).c_str());
  if (!nb::try_cast<Array>(found, array, false))
    throw nb::type_error(
        (std::string(name) + " has another type than the core expects, or is not contiguous")
            .c_str());
  return array;
}

template <class T>
T number_attribute(nb::handle of, const char* name) {
  T number{};
  if (!nb::try_cast<T>(nb::getattr(of, name, nb::none()), number, false))
    throw nb::type_error((std::string(name) + " is missing or has another type").c_str());
  return number;
}

}  // namespace tilth::bind
