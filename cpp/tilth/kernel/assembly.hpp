// SPDX-License-Identifier: BSD-3-Clause
// Assembly of the points of one body, cluster by cluster (cluster.hpp): the groups of a cluster are
// added to its local matrix (local_matrix.hpp), and that once to the matrix of node blocks.
#pragma once

#include "local_matrix.hpp"

namespace tilth::kernel {

/// Adds the groups of a cluster. Returns whether all their blocks are inside of the matrix; if not,
/// nothing is added.
template <int Dim, int Entries, class IsSymmetric, class AddGroup>
bool add_cluster(const Stencil& stencil, const BlockPositions& blocks, const Cluster<Dim>& cluster,
                 const IsSymmetric& is_symmetric, const AddGroup& add_group, double* matrix) {
  bool empty = true, symmetric = true;
  for (int i = 0; i < cluster.groups; ++i) {
    const std::int64_t g = cluster.group[i];
    const std::int64_t first = stencil.start[g], last = stencil.start[g + 1];
    empty = empty && first == last;
    for (std::int64_t p = first; symmetric && p < last; ++p) symmetric = is_symmetric(p);
  }
  if (empty) return true;
  bool inside = true;
  cluster.for_widest([&](int i, bool) {
    const std::int64_t g = cluster.group[i];
    const NodeRuns runs(stencil.nodes_of(g), stencil.node + stencil.node_start[g]);
    inside = inside && prefetch_blocks<Entries>(g, stencil.nodes_of(g), runs, blocks, matrix);
  });
  if (!inside) return false;
  LocalMatrix<Entries> local(cluster.nodes, symmetric);
  const bool overwrite = cluster.groups == 1;
  if (!overwrite) local.clear();
  for (int i = 0; i < cluster.groups; ++i) {
    const std::int64_t g = cluster.group[i];
    if (stencil.start[g] == stencil.start[g + 1] || stencil.nodes_of(g) == 0) continue;
    with_node_count<Dim>(stencil.nodes_of(g), [&]<int N>() {
      add_group.template operator()<N>(g, cluster.place[i], overwrite, local);
    });
  }
  cluster.for_widest([&](int i, bool last) {
    const std::int64_t g = cluster.group[i];
    const int n = stencil.nodes_of(g);
    const NodeRuns runs(n, stencil.node + stencil.node_start[g]);
    local.scatter(n, cluster.place[i], runs, blocks.position + blocks.start[g], matrix);
    if (!last) local.clear(n, cluster.place[i]);
  });
  return true;
}

/// Adds all groups to the matrix, whose blocks have so many entries. `is_symmetric(p)`: whether the
/// contribution of a point is; `add_group.template operator()<N>(g, place, overwrite, local)` adds
/// a group of N nodes, 0 for a number known at run time, that have these places in the local
/// matrix; `overwrite`: see ProductSum. Returns whether all `blocks` are inside of the matrix and
/// all nodes inside of `boxes`; those of other clusters are not added.
template <int Dim, int Entries, class IsSymmetric, class AddGroup>
bool add_groups(const Stencil& stencil, const Boxes& boxes, const BlockPositions& blocks,
                const IsSymmetric& is_symmetric, const AddGroup& add_group, double* matrix) {
  Found outside;
  for_each_slab(stencil, [&](const std::int64_t* group, const std::int64_t* end) {
    while (group < end) {
      const Cluster<Dim> cluster(stencil, boxes, group, end);
      if (!cluster.valid ||
          !add_cluster<Dim, Entries>(stencil, blocks, cluster, is_symmetric, add_group, matrix))
        outside.set();
      group += cluster.groups;
    }
  });
  return !outside;
}

}  // namespace tilth::kernel
