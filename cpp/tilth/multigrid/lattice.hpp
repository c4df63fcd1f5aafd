// SPDX-License-Identifier: BSD-3-Clause
// The nodes of one level: any set of points of an integer lattice, and the next coarser set.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "field.hpp"

namespace tilth::multigrid {

using LatticeIndex = std::array<std::int32_t, 3>;

/// Half of an integer, rounded down and up.
inline std::int32_t half_below(std::int32_t i) { return i >> 1; }
inline std::int32_t half_above(std::int32_t i) { return (i + 1) >> 1; }

/// Lattice indices sorted along z, y, x, with a table of the lines along x, so that an index is
/// found without a search if its line has no gap.
class Lattice {
 public:
  explicit Lattice(std::vector<LatticeIndex> sorted) : index_(std::move(sorted)) {
    low_ = {0, 0, 0}, size_ = {0, 0, 0};
    if (index_.empty()) return;
    LatticeIndex high = low_ = index_.front();
    for (const LatticeIndex& p : index_)
      for (int k = 0; k < 3; ++k)
        low_[k] = std::min(low_[k], p[k]), high[k] = std::max(high[k], p[k]);
    for (int k = 0; k < 3; ++k) size_[k] = high[k] - low_[k] + 1;
    line_.assign(std::size_t(size_[1]) * size_[2] + 1, 0);
    for (const LatticeIndex& p : index_) ++line_[line_of(p[1], p[2]) + 1];
    for (std::size_t l = 1; l < line_.size(); ++l) line_[l] += line_[l - 1];
  }

  std::int64_t bytes() const { return bytes_of(index_, line_); }
  std::int32_t nodes() const { return static_cast<std::int32_t>(index_.size()); }
  const LatticeIndex& operator[](std::int64_t node) const { return index_[node]; }

  /// The node at a lattice index; -1 if there is none.
  std::int32_t find(const LatticeIndex& p) const {
    if (!has_line(p[1], p[2])) return -1;
    const std::int32_t begin = line_[line_of(p[1], p[2])], end = line_[line_of(p[1], p[2]) + 1];
    if (begin == end || p[0] < index_[begin][0] || p[0] > index_[end - 1][0]) return -1;
    const std::int32_t guess = begin + p[0] - index_[begin][0];
    if (guess < end && index_[guess][0] == p[0]) return guess;
    const auto from = index_.begin();
    const auto found =
        std::lower_bound(from + begin, from + end, p[0],
                         [](const LatticeIndex& q, std::int32_t x) { return q[0] < x; });
    return (*found)[0] == p[0] ? static_cast<std::int32_t>(found - from) : -1;
  }

  /// The lattice of twice the spacing: every point from which a node is interpolated.
  Lattice coarser() const {
    std::vector<LatticeIndex> coarse;
    if (index_.empty()) return Lattice(coarse);
    const std::int32_t first = half_below(low_[0]);
    std::vector<char> used(half_above(low_[0] + size_[0] - 1) - first + 1, 0);
    for (std::int32_t z = half_below(low_[2]); z <= half_above(low_[2] + size_[2] - 1); ++z)
      for (std::int32_t y = half_below(low_[1]); y <= half_above(low_[1] + size_[1] - 1); ++y) {
        std::int32_t least = static_cast<std::int32_t>(used.size()), greatest = -1;
        for (std::int32_t fz = 2 * z - 1; fz <= 2 * z + 1; ++fz)
          for (std::int32_t fy = 2 * y - 1; fy <= 2 * y + 1; ++fy) {
            if (!has_line(fy, fz)) continue;
            for (auto v = line_[line_of(fy, fz)]; v < line_[line_of(fy, fz) + 1]; ++v) {
              const std::int32_t below = half_below(index_[v][0]) - first;
              const std::int32_t above = half_above(index_[v][0]) - first;
              used[below] = used[above] = 1;
              least = std::min(least, below), greatest = std::max(greatest, above);
            }
          }
        for (std::int32_t x = least; x <= greatest; ++x) {
          if (used[x]) coarse.push_back({first + x, y, z});
          used[x] = 0;
        }
      }
    return Lattice(std::move(coarse));
  }

 private:
  bool has_line(std::int32_t y, std::int32_t z) const {
    return y >= low_[1] && y < low_[1] + size_[1] && z >= low_[2] && z < low_[2] + size_[2];
  }
  std::size_t line_of(std::int32_t y, std::int32_t z) const {
    return std::size_t(z - low_[2]) * size_[1] + (y - low_[1]);
  }

  std::vector<LatticeIndex> index_;
  LatticeIndex low_, size_;
  std::vector<std::int32_t> line_;  // first node of each line along x
};

}  // namespace tilth::multigrid
