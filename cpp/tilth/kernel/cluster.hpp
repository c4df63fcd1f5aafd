// SPDX-License-Identifier: BSD-3-Clause
// Clusters of groups: groups whose boxes of nodes begin at the same node, such as those of points
// whose domains begin in one cell and are cut by different grid lines. They share a local matrix
// (local_matrix.hpp), so that few blocks are added to the matrix (decision 3).
#pragma once

#include <algorithm>
#include <cstdint>

#include "../grid.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Boxes of nodes around the supports of the groups.
struct Boxes {
  const std::int64_t* first;     // (groups, 3) lattice index of the first node
  const std::int32_t* count;     // (groups, 3) nodes per direction
  const std::int64_t* node_key;  // of the nodes of all groups; null where they fill the boxes
};

/// Groups that follow one another in the order of assembly and whose boxes begin at the same node.
/// The nodes of several groups are numbered in the box that encloses them, at most
/// `maximum_nodes`; those of one group as they are.
template <int Dim>
class Cluster {
 public:
  static constexpr int maximum_groups = 64;

  /// Takes the first group of a list and those after it that share its first node.
  Cluster(const Stencil& stencil, const Boxes& boxes, const std::int64_t* begin,
          const std::int64_t* end)
      : group(begin) {
    std::copy_n(boxes.count + 3 * *begin, Dim, box_);
    while (groups < maximum_groups && begin + groups < end && extend(boxes, begin[groups]))
      ++groups;
    nodes = groups == 1 ? stencil.nodes_of(*begin) : box_[0] * box_[1] * box_[2];
    for (int i = 0; i < groups; ++i) number_nodes(stencil, boxes, i);
    for (int i = 0; i < groups; ++i) widest_ |= std::uint64_t{is_widest(i)} << i;
  }

  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  const std::int64_t* const group;
  int groups = 1;
  int nodes;
  bool valid = true;                                  // whether the nodes are inside of the box
  std::uint8_t place[maximum_groups][maximum_nodes];  // of each group's nodes, ascending

  /// Calls `body(i, last)` for the groups whose nodes no other group has; `last` for the last one.
  template <class Body>
  void for_widest(Body&& body) const {
    for (int i = 0; i < groups; ++i)
      if (widest_ >> i & 1) body(i, widest_ >> i == 1);
  }

 private:
  std::int32_t box_[3] = {1, 1, 1};
  std::uint64_t set_[maximum_groups];  // one bit for each place
  std::uint64_t widest_ = 0;           // one bit for each group

  bool is_widest(int i) const {
    for (int j = 0; j < groups; ++j)
      if (j != i && (set_[i] & ~set_[j]) == 0 && (set_[i] != set_[j] || j < i)) return false;
    return true;
  }

  bool extend(const Boxes& boxes, std::int64_t next) {
    const std::int64_t* first = boxes.first + 3 * *group;
    if (!std::equal(first, first + 3, boxes.first + 3 * next)) return false;
    std::int64_t box[Dim], size = 1;
    for (int k = 0; k < Dim; ++k) {
      box[k] = std::max(box_[k], boxes.count[3 * next + k]);
      if (box[k] > maximum_nodes) return false;
      size *= box[k];
    }
    if (size > maximum_nodes) return false;
    std::copy_n(box, Dim, box_);
    return true;
  }

  void number_nodes(const Stencil& stencil, const Boxes& boxes, int i) {
    const int n = stencil.nodes_of(group[i]);
    set_[i] = 0;
    if (groups == 1) {
      for (int a = 0; a < n; ++a) place[i][a] = static_cast<std::uint8_t>(a);
      return;
    }
    if (boxes.node_key == nullptr) {
      const std::int32_t* count = boxes.count + 3 * group[i];
      int a = 0;
      for (int z = 0; z < (Dim == 3 ? count[2] : 1); ++z)
        for (int y = 0; y < count[1]; ++y)
          for (int x = 0; x < count[0]; ++x) add_node(i, a++, {x, y, z});
      return;
    }
    const std::int64_t* key = boxes.node_key + stencil.node_start[group[i]];
    const std::int64_t* first = boxes.first + 3 * group[i];
    const std::int64_t origin = pack({first[0], first[1], first[2]});
    for (int a = 0; a < n; ++a) {
      const std::int64_t from = key[a] - origin;
      const Lattice at = {from & key_mask, from >> key_bits & key_mask, from >> 2 * key_bits};
      const bool inside = at[2] >= 0 && at[0] < box_[0] && at[1] < box_[1] && at[2] < box_[2];
      valid = valid && inside;
      add_node(i, a, inside ? at : Lattice{0, 0, 0});
    }
  }

  void add_node(int i, int a, const Lattice& at) {
    const auto number = at[0] + box_[0] * (at[1] + box_[1] * at[2]);
    place[i][a] = static_cast<std::uint8_t>(number);
    set_[i] |= std::uint64_t{1} << number;
  }
};

}  // namespace tilth::kernel
