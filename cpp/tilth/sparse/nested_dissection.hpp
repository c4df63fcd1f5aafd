// SPDX-License-Identifier: BSD-3-Clause
// Fill-reducing order of the nodes of a regular grid by geometric nested dissection (George 1973):
// a separator of lattice planes as thick as the coupling distance splits the longest direction, the
// two halves are ordered first, the separator last.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace tilth::sparse {

class NestedDissection {
 public:
  NestedDissection(std::int64_t nodes, const std::int64_t* lattice, int coupling_distance)
      : lattice_(lattice), coupling_distance_(coupling_distance), node_(nodes) {
    std::iota(node_.begin(), node_.end(), 0);
    dissect(0, nodes);
  }

  /// Node numbers in the order of elimination.
  const std::vector<std::int64_t>& order() const { return node_; }

 private:
  static constexpr std::int64_t leaf = 24;

  void dissect(std::int64_t begin, std::int64_t end) {
    if (end - begin <= leaf) return;
    int axis = 0;
    std::int64_t longest = -1, low = 0;
    for (int k = 0; k < 3; ++k) {
      std::int64_t lowest = lattice_[3 * node_[begin] + k], highest = lowest;
      for (std::int64_t e = begin; e < end; ++e) {
        lowest = std::min(lowest, lattice_[3 * node_[e] + k]);
        highest = std::max(highest, lattice_[3 * node_[e] + k]);
      }
      if (highest - lowest > longest) longest = highest - lowest, axis = k, low = lowest;
    }
    if (longest < coupling_distance_ + 1) return;
    const std::int64_t plane = low + (longest + 1 - coupling_distance_) / 2;
    const auto first = node_.begin();
    const auto below = std::stable_partition(
        first + begin, first + end, [&](std::int64_t v) { return lattice_[3 * v + axis] < plane; });
    const auto above = std::stable_partition(below, first + end, [&](std::int64_t v) {
      return lattice_[3 * v + axis] >= plane + coupling_distance_;
    });
    dissect(begin, below - first);
    dissect(below - first, above - first);
  }

  const std::int64_t* lattice_;
  std::int64_t coupling_distance_;
  std::vector<std::int64_t> node_;
};

}  // namespace tilth::sparse
