// SPDX-License-Identifier: BSD-3-Clause
// Storage of a level's matrix for products. Up to 16 consecutive nodes form a strip: their
// neighbours are at the same distances in the numbering, so that one instruction handles eight
// nodes without a gather. Coefficients have 16 bits, which halves the memory traffic that limits
// products; rows of nodes that share a diagonal block have single precision.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "../caught.hpp"
#include "../parallel.hpp"
#include "field.hpp"

namespace tilth::multigrid {

inline constexpr int widest = 16;  // nodes in a strip

/// Vectors of numbers that the compiler keeps in registers.
struct Four {
  static constexpr int width = 4;
  typedef float Reals __attribute__((vector_size(16)));
  typedef std::int32_t Integers __attribute__((vector_size(16)));
  typedef std::int16_t Shorts __attribute__((vector_size(8)));
};
struct Eight {
  static constexpr int width = 8;
  typedef float Reals __attribute__((vector_size(32)));
  typedef std::int32_t Integers __attribute__((vector_size(32)));
  typedef std::int16_t Shorts __attribute__((vector_size(16)));
};

template <class Vector>
inline void load(const float* from, typename Vector::Reals& to) {
  std::memcpy(&to, from, sizeof to);
}
template <class Vector>
inline void load(const std::int16_t* from, typename Vector::Reals& to) {
  typename Vector::Shorts shorts;
  std::memcpy(&shorts, from, sizeof shorts);
  to = __builtin_convertvector(__builtin_convertvector(shorts, typename Vector::Integers),
                               typename Vector::Reals);
}

/// The nearest integer, for numbers of less than 16 bits: the added constant shifts the fraction
/// out of the mantissa, whose last 16 bits are then the integer. Without a library call, so that
/// loops over it are vectorised. What is not a number gives any integer.
inline std::int16_t rounded_to_short(float number) {
  constexpr float no_fraction = 0x1.8p23f;
  return static_cast<std::int16_t>(std::bit_cast<std::uint32_t>(number + no_fraction));
}

/// Copies the first `count` of `widest` numbers.
inline void store(const float* from, std::int32_t count, float* to) {
  if (count == widest)
    std::memcpy(to, from, widest * sizeof *from);
  else
    std::copy_n(from, count, to);
}

struct Strip {
  std::int32_t first, count, width;      // its nodes, padded to `width`
  std::int64_t distance, distances = 0;  // where its list of distances begins, and their number
  std::int64_t value = 0;                // where its coefficients begin
  bool single = false;                   // whether they have single precision, not 16 bits
};

template <int Components>
class Strips {
 public:
  /// Sets the pattern. A node joins the preceding strip if that takes fewer coefficients, zeros
  /// included, than a new strip.
  void set_pattern(const std::vector<std::int64_t>& row_start,
                   const std::vector<std::int32_t>& column) {
    const auto nodes = static_cast<std::int32_t>(row_start.size()) - 1;
    strip_.clear(), distance_.clear();
    std::vector<std::int32_t> open, own, both;
    std::int32_t first = 0;
    const auto padded = [](std::int64_t count) { return (count + 3) / 4 * 4; };
    for (std::int32_t v = 0; v < nodes; ++v) {
      own.resize(row_start[v + 1] - row_start[v]);
      for (std::size_t e = 0; e < own.size(); ++e) own[e] = column[row_start[v] + e] - v;
      std::sort(own.begin(), own.end());
      if (v > first && own == open && v - first < widest) continue;
      both.clear();
      std::set_union(open.begin(), open.end(), own.begin(), own.end(), std::back_inserter(both));
      const std::int64_t count = v - first, joined = padded(count + 1) * both.size();
      const std::int64_t apart = padded(count) * open.size() + padded(1) * own.size();
      if (count == widest || (count > 0 && joined > apart)) {
        close(first, v, open);
        first = v, std::swap(open, own);
      } else {
        std::swap(open, both);
      }
    }
    if (nodes > first) close(first, nodes, open);
    scale_ = Field<Components>(nodes);
    slot_.resize(column.size());
#pragma omp parallel for schedule(static) if (row_start.back() >= 8 * parallel_from)
    for (std::size_t s = 0; s < strip_.size(); ++s) {
      const auto begin = distance_.begin() + strip_[s].distance;
      const auto end = begin + strip_[s].distances;
      for (std::int32_t v = strip_[s].first; v < strip_[s].first + strip_[s].count; ++v)
        for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e)
          slot_[e] =
              static_cast<std::uint16_t>(std::lower_bound(begin, end, column[e] - v) - begin);
    }
  }

  /// Sets the rows of a level, row(v, buffer); `has_own_block` (nodes): whether 16 bits suffice for
  /// the row.
  template <class Row>
  void set_values(const std::vector<std::int64_t>& row_start,
                  const std::vector<char>& has_own_block, Row row) {
    std::int64_t shorts = 0, reals = 0;
    for (Strip& strip : strip_) {
      const auto own = has_own_block.begin() + strip.first;
      strip.single = std::find(own, own + strip.count, 0) != own + strip.count;
      std::int64_t& total = strip.single ? reals : shorts;
      strip.value = total;
      total += strip.distances * Components * Components * strip.width;
    }
    short_.resize(shorts);
    real_.resize(reals);
    threaded_ = row_start.back() >= 8 * parallel_from;
    Caught caught;
#pragma omp parallel if (threaded_)
    {
      Floats buffer;
      const auto row_of = [&](std::int32_t v) { return row(v, buffer); };
#pragma omp for schedule(static)
      for (std::size_t s = 0; s < strip_.size(); ++s)
        caught.run([&] {
          const Strip& strip = strip_[s];
          if (strip.single)
            pack<true>(strip, row_start, row_of, real_.data() + strip.value);
          else
            pack<false>(strip, row_start, row_of, short_.data() + strip.value);
        });
    }
    caught.rethrow();
  }

  /// Calls `use(first, count, product)` with the components product[Components][widest] of A x for
  /// the nodes of each strip.
  template <class Use>
  void for_product(const Field<Components>& x, Use use) const {
#pragma omp parallel for schedule(static) if (threaded_)
    for (std::size_t s = 0; s < strip_.size(); ++s) {
      const Strip& strip = strip_[s];
      alignas(64) float product[Components][widest];
      if (strip.single)
        multiply(strip, real_.data() + strip.value, x, product);
      else
        multiply(strip, short_.data() + strip.value, x, product);
      for (int i = 0; i < Components; ++i)
        for (int k = 0; k < widest; ++k) product[i][k] *= scale_[i][strip.first + k];
      use(strip.first, strip.count, product);
    }
  }

  std::int64_t bytes() const {
    return bytes_of(strip_, distance_, slot_, short_, real_) + scale_.bytes();
  }

 private:
  void close(std::int32_t first, std::int32_t end, const std::vector<std::int32_t>& distances) {
    for (std::int32_t count = end - first; count > 0; first = end - count) {
      const std::int32_t width = count <= 4 ? 4 : count <= 12 ? 8 : widest;
      const std::int32_t own = std::min(count, width);
      strip_.push_back({first, own, width, static_cast<std::int64_t>(distance_.size()),
                        static_cast<std::int64_t>(distances.size())});
      count -= own;
    }
    distance_.insert(distance_.end(), distances.begin(), distances.end());
  }

  template <bool Single, class Row, class T>
  void pack(const Strip& strip, const std::vector<std::int64_t>& row_start, const Row& row,
            T* out) {
    std::fill_n(out, strip.distances * Components * Components * strip.width, T(0));
    for (std::int32_t k = 0; k < strip.count; ++k) {
      constexpr int size = Components * Components;
      const std::int32_t v = strip.first + k;
      const float* const begin = row(v);
      const float* const end = begin + (row_start[v + 1] - row_start[v]) * size;
      float largest[size] = {}, factor[size];
      for (const float* block = begin; !Single && block < end; block += size)
        for (int n = 0; n < size; ++n) largest[n] = std::max(largest[n], std::abs(block[n]));
      for (int i = 0; i < Components; ++i) {
        const float largest_in_row =
            *std::max_element(largest + i * Components, largest + (i + 1) * Components);
        scale_[i][v] = Single ? 1.0f : largest_in_row / 32767.0f;
        std::fill_n(factor + i * Components, Components,
                    largest_in_row > 0.0f ? 32767.0f / largest_in_row : 0.0f);
      }
      const std::uint16_t* slot = slot_.data() + row_start[v];
      for (const float* block = begin; block < end; block += size, ++slot) {
        T rounded[size];
        for (int n = 0; n < size; ++n) {
          if constexpr (Single)
            rounded[n] = block[n];
          else
            rounded[n] = rounded_to_short(factor[n] * block[n]);
        }
        T* entry = out + std::int64_t{*slot} * size * strip.width + k;
        for (int n = 0; n < size; ++n) entry[n * strip.width] = rounded[n];
      }
    }
  }

  template <class T>
  void multiply(const Strip& strip, const T* value, const Field<Components>& x,
                float (*product)[widest]) const {
    if (strip.width == widest)
      multiply<Eight, 2>(strip, value, x, product);
    else if (strip.width == Eight::width)
      multiply<Eight, 1>(strip, value, x, product);
    else
      multiply<Four, 1>(strip, value, x, product);
  }

  template <class Vector, int Pieces, class T>
  void multiply(const Strip& strip, const T* value, const Field<Components>& x,
                float (*product)[widest]) const {
    typename Vector::Reals sum[Components][Pieces] = {}, factor, other;
    const float* from[Components];
    for (int j = 0; j < Components; ++j) from[j] = x[j] + strip.first;
    const std::int32_t* distance = distance_.data() + strip.distance;
    for (std::int64_t s = 0; s < strip.distances;
         ++s, value += Components * Components * Pieces * Vector::width)
      for (int j = 0; j < Components; ++j)
        for (int p = 0; p < Pieces; ++p) {
          load<Vector>(from[j] + distance[s] + p * Vector::width, other);
          for (int i = 0; i < Components; ++i) {
            load<Vector>(value + ((i * Components + j) * Pieces + p) * Vector::width, factor);
            sum[i][p] += factor * other;
          }
        }
    for (int i = 0; i < Components; ++i)
      for (int p = 0; p < Pieces; ++p)
        std::memcpy(product[i] + p * Vector::width, &sum[i][p], sizeof sum[i][p]);
  }

  std::vector<Strip> strip_;
  std::vector<std::int32_t> distance_;  // in the numbering, from a node to a neighbour
  std::vector<std::uint16_t> slot_;     // which distance of its strip an entry has
  std::vector<std::int16_t, Aligned<std::int16_t>> short_;
  Floats real_;
  Field<Components> scale_;  // of the 16-bit coefficients of a row
  bool threaded_ = false;
};

}  // namespace tilth::multigrid
