// SPDX-License-Identifier: BSD-3-Clause
// The stencil of one body's points, as kernels read it: groups and nodes (stencil.hpp), basis
// values (basis_values.hpp).
#pragma once

#include <cstdint>

#include "../parallel.hpp"

namespace tilth::kernel {

struct Stencil {
  std::int64_t groups;
  const std::int64_t* start;        // (groups + 1) first point of each group
  const std::int64_t* node_start;   // (groups + 1)
  const std::int32_t* node;         // node numbers of the groups
  const std::int32_t* count;        // (groups, 3) nodes per direction; null where not in a box
  const std::int64_t* value_start;  // (groups) first entry of each group in `value`
  const double* value;              // see basis_values.hpp
  const double* hat_slope;          // slopes of the linear basis; null with others
  std::int64_t hat_slopes;          // entries of `hat_slope` from one group to the next
  std::int64_t colours;
  const std::int64_t* colour_start;
  const std::int64_t* slab_start;
  const std::int64_t* order;

  int nodes_of(std::int64_t group) const {
    return static_cast<int>(node_start[group + 1] - node_start[group]);
  }

  /// Number of points: from `parallel_from` of them on, loops are threaded.
  std::int64_t work() const { return start[groups]; }
};

/// Calls `body(begin, end)` for the groups of each slab of a stencil, or its elements, in parallel,
/// such that no two calls at the same time share a node and the order of calls that share a node
/// does not depend on the number of threads.
template <class List, class Body>
void for_each_slab(const List& list, Body&& body) {
#pragma omp parallel if (list.work() >= parallel_from)
  for (std::int64_t c = 0; c < list.colours; ++c) {
#pragma omp for schedule(dynamic, 1)
    for (std::int64_t slab = list.colour_start[c]; slab < list.colour_start[c + 1]; ++slab)
      body(list.order + list.slab_start[slab], list.order + list.slab_start[slab + 1]);
  }
}

/// Calls `body(item)` for all groups of a stencil or all elements, slab by slab.
template <class List, class Body>
void for_each_by_colour(const List& list, Body&& body) {
  for_each_slab(list, [&](const std::int64_t* item, const std::int64_t* end) {
    for (; item < end; ++item) body(*item);
  });
}

/// Calls `body(group)` for all groups, in parallel, for kernels that write to points only.
template <class Body>
void for_groups(const Stencil& stencil, Body&& body) {
#pragma omp parallel for schedule(static) if (stencil.work() >= parallel_from)
  for (std::int64_t g = 0; g < stencil.groups; ++g) body(g);
}

/// Largest number of nodes that support one point (kernels have buffers of this size).
inline constexpr int maximum_nodes = 64;

/// Largest number of nodes of an element (elements.hpp).
inline constexpr int maximum_element_nodes = 256;

/// Calls `body.template operator()<N>()` with N the number of nodes if it is a common one, so
/// that inner loops have a fixed length, else N = 0 (length at run time).
template <int Dim, class Body>
void with_node_count(int nodes, Body&& body) {
  if constexpr (Dim == 2) {
    switch (nodes) {
      case 4:
        return body.template operator()<4>();
      case 6:
        return body.template operator()<6>();
      case 9:
        return body.template operator()<9>();
      default:
        return body.template operator()<0>();
    }
  } else {
    switch (nodes) {
      case 8:
        return body.template operator()<8>();
      case 12:
        return body.template operator()<12>();
      case 18:
        return body.template operator()<18>();
      case 27:
        return body.template operator()<27>();
      default:
        return body.template operator()<0>();
    }
  }
}

}  // namespace tilth::kernel
