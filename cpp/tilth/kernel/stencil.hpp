// SPDX-License-Identifier: BSD-3-Clause
// Groups of points and their stencils. A *group* is the set of points that share the same nodes (a
// cell in standard MPM).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <vector>

#include "../grid.hpp"
#include "../grid_lines.hpp"
#include "../parallel.hpp"

namespace tilth::kernel {

/// Support key of each point, `x` in cells from the grid's origin; returns the number of points
/// outside the range that a key can represent (their key is -1): those that are too far from the
/// origin, whose position is not a number, or whose domain needs more nodes than the basis has.
template <class Basis, int Dim>
std::int64_t support_keys(std::int64_t points, const double* position, const double* half_length,
                          const GridLines& grid, std::int64_t* keys) {
  std::int64_t outside = 0;
#pragma omp parallel for schedule(static) reduction(+ : outside) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    Lattice first{0, 0, 0};
    std::array<int, 3> count{2, 2, 2};
    bool inside = true;
    for (int k = 0; k < Dim; ++k) {
      const double half = Basis::has_domain ? Basis::extent(half_length[p * Dim + k]) : 0.0;
      const auto [low, high] = grid[k].around(position[p * Dim + k], half);
      inside = inside && std::fabs(low) <= static_cast<double>(largest_index) &&
               std::fabs(high) <= static_cast<double>(largest_index);
      if (!inside) break;
      const auto support = Basis::support(low, high);
      inside = std::fabs(support.first) < static_cast<double>(largest_index) &&
               support.count >= 2 && support.count <= Basis::maximum_count;
      first[k] = static_cast<std::int64_t>(support.first);
      count[k] = support.count;
    }
    keys[p] = inside ? pack_support(first, count) : -1;
    outside += !inside;
  }
  return outside;
}

/// Groups of sorted support keys: first point of each (and the number of points), first node,
/// number of nodes per direction.
struct Groups {
  std::vector<std::int64_t> start;
  std::vector<std::int64_t> first;  // (groups, 3)
  std::vector<std::int32_t> count;  // (groups, 3); 1 in the direction that 2D lacks
};

template <int Dim>
Groups group_points(std::int64_t points, const std::int64_t* keys) {
  Groups groups;
  for (std::int64_t p = 0; p < points; ++p) {
    if (p > 0 && keys[p] == keys[p - 1]) continue;
    Lattice first;
    std::array<int, 3> count;
    unpack_support(keys[p], first, count);
    if constexpr (Dim == 2) count[2] = 1;
    groups.start.push_back(p);
    groups.first.insert(groups.first.end(), first.begin(), first.end());
    groups.count.insert(groups.count.end(), count.begin(), count.end());
  }
  groups.start.push_back(points);
  return groups;
}

/// Sorted keys of all nodes of the groups. Groups are sorted by their first node (body by
/// body), so the nodes at one offset in y and z are sorted already: the union of a few sorted
/// lists.
inline std::vector<std::int64_t> active_nodes(std::int64_t groups, const std::int64_t* first,
                                              const std::int32_t* count) {
  std::int32_t largest[3] = {0, 0, 0};
  for (std::int64_t g = 0; g < groups; ++g)
    for (int k = 0; k < 3; ++k) largest[k] = std::max(largest[k], count[3 * g + k]);
  std::vector<std::int64_t> all, list, merged;
  const auto merge_list = [&] {
    merged.clear();
    std::set_union(all.begin(), all.end(), list.begin(), list.end(), std::back_inserter(merged));
    std::swap(all, merged);
    list.clear();
  };
  for (int k = 0; k < largest[2]; ++k)
    for (int j = 0; j < largest[1]; ++j) {
      std::int64_t before = 0;
      for (std::int64_t g = 0; g < groups; ++g) {
        if (j >= count[3 * g + 1] || k >= count[3 * g + 2]) continue;
        const std::int64_t* f = first + 3 * g;
        const std::int64_t key = pack({f[0], f[1] + j, f[2] + k});
        if (key < before) merge_list();  // the next body begins
        before = key;
        for (std::int64_t node = key; node < key + count[3 * g]; ++node)
          if (list.empty() || node > list.back()) list.push_back(node);
      }
      merge_list();
    }
  return all;
}

/// Node numbers of each group, x fastest; `node_start` (groups + 1) must be filled. Returns whether
/// the sorted `node_keys` have all nodes.
inline bool group_nodes(std::int64_t groups, const std::int64_t* first, const std::int32_t* count,
                        std::int64_t nodes, const std::int64_t* node_keys,
                        const std::int64_t* node_start, std::int32_t* node_of_group) {
  bool missing = false;
#pragma omp parallel for schedule(static) reduction(|| : missing) if (8 * groups >= parallel_from)
  for (std::int64_t g = 0; g < groups; ++g) {
    std::int64_t at = node_start[g];
    for (int k = 0; k < count[3 * g + 2]; ++k)
      for (int j = 0; j < count[3 * g + 1]; ++j) {
        const auto key = pack({first[3 * g], first[3 * g + 1] + j, first[3 * g + 2] + k});
        const std::int64_t found = std::lower_bound(node_keys, node_keys + nodes, key) - node_keys;
        const std::int64_t last = found + count[3 * g] - 1;  // nodes along x have consecutive keys
        missing = missing || last >= nodes || node_keys[last] != key + count[3 * g] - 1;
        const auto number = static_cast<std::int32_t>(found);
        for (int i = 0; i < count[3 * g]; ++i) node_of_group[at++] = number + i;
      }
  }
  return !missing;
}

/// Fills a point's factors along a uniform axis: the values of the nodes, then their slopes.
template <class Basis>
void factors_in_cells(const Axis& axis, std::int64_t first, int nodes, double position, double half,
                      double* value) {
  double x = axis.in_cells(position), l = half / axis.size;
  const double cells_per_length = 1.0 / axis.size;
  Basis::cut(static_cast<double>(first), static_cast<double>(first + nodes - 1), x, l);
  for (int i = 0; i < nodes; ++i) {
    const double s = x - static_cast<double>(first + i);
    Basis::evaluate(s, l, 1.0, 1.0, value[i], value[nodes + i]);
    value[nodes + i] *= cells_per_length;
  }
}

/// The same between the lines of a graded axis, at a distance `x` from its origin.
template <class Basis>
void factors_between(const Axis& axis, std::int64_t first, int nodes, double x, double half,
                     double* value) {
  Basis::cut(axis.distance(first), axis.distance(first + nodes - 1), x, half);
  for (int i = 0; i < nodes; ++i)
    Basis::evaluate(x - axis.distance(first + i), half, axis.width(first + i - 1),
                    axis.width(first + i), value[i], value[nodes + i]);
}

/// Fills the factors of every point's basis, or its local coordinates in the cell, in the layout of
/// basis_values.hpp; `value_start` (groups) is the first entry of each group.
template <class Basis, int Dim>
void basis_factors(std::int64_t groups, const std::int64_t* start, const std::int64_t* first,
                   const std::int32_t* count, const std::int64_t* value_start,
                   const double* position, const double* half_length, const GridLines& grid,
                   double* factors) {
#pragma omp parallel for schedule(static) if (start[groups] >= parallel_from)
  for (std::int64_t g = 0; g < groups; ++g) {
    const std::int32_t* nodes = count + 3 * g;
    double* value = factors + value_start[g];
    for (std::int64_t p = start[g]; p < start[g + 1]; ++p)
      for (int k = 0; k < Dim; ++k) {
        const Axis& axis = grid[k];
        const std::int64_t lowest = first[3 * g + k];
        const double at = position[p * Dim + k];
        if constexpr (Basis::is_hat) {
          *value++ = axis.in_cells_like(lowest, at) - static_cast<double>(lowest);
        } else {
          const double half = half_length[p * Dim + k];
          if (axis.graded())
            factors_between<Basis>(axis, lowest, nodes[k], at - axis.origin, half, value);
          else
            factors_in_cells<Basis>(axis, lowest, nodes[k], at, half, value);
          value += 2 * nodes[k];
        }
      }
  }
}

/// Order of parallel assembly. The grid is cut into slabs across its longest direction, at least as
/// many cells thick as a stencil; slabs of even number are one colour, those of odd number the
/// other. The slabs of one colour share no node and may be assembled at the same time; within a
/// slab the groups follow their order. The cuts depend on the grid only, so sums are identical for
/// any number of threads, and two synchronisations per assembly suffice.
struct Colouring {
  std::vector<std::int64_t> colour_start;  // (colours + 1) in `slab_start`
  std::vector<std::int64_t> slab_start;    // (slabs + 1) in `order`
  std::vector<std::int64_t> order;         // group numbers
};

inline Colouring colour_groups(std::int64_t groups, const std::int64_t* first,
                               const std::int32_t* count) {
  constexpr std::int64_t maximum_slabs = 64;
  std::int64_t lowest[3], highest[3], thickest[3] = {1, 1, 1};
  for (int k = 0; k < 3; ++k) lowest[k] = highest[k] = groups > 0 ? first[k] : 0;
  for (std::int64_t g = 0; g < groups; ++g)
    for (int k = 0; k < 3; ++k) {
      lowest[k] = std::min(lowest[k], first[3 * g + k]);
      highest[k] = std::max(highest[k], first[3 * g + k]);
      thickest[k] = std::max<std::int64_t>(thickest[k], count[3 * g + k]);
    }
  int axis = 2;  // for equal extents: the slowest direction of the order
  for (int k = 1; k >= 0; --k)
    if (highest[k] - lowest[k] > highest[axis] - lowest[axis]) axis = k;
  const std::int64_t layers = highest[axis] - lowest[axis] + 1;
  const std::int64_t thickness =
      std::max({thickest[axis] - 1, std::int64_t{1}, (layers + maximum_slabs - 1) / maximum_slabs});
  const std::int64_t slabs = (layers + thickness - 1) / thickness;

  Colouring result;
  std::vector<std::vector<std::int64_t>> group_of_slab(slabs);
  for (std::int64_t g = 0; g < groups; ++g)
    group_of_slab[(first[3 * g + axis] - lowest[axis]) / thickness].push_back(g);
  result.colour_start.push_back(0);
  result.slab_start.push_back(0);
  for (std::int64_t colour = 0; colour < 2; ++colour) {
    for (std::int64_t slab = colour; slab < slabs; slab += 2) {
      const auto& members = group_of_slab[slab];
      result.order.insert(result.order.end(), members.begin(), members.end());
      result.slab_start.push_back(static_cast<std::int64_t>(result.order.size()));
    }
    result.colour_start.push_back(static_cast<std::int64_t>(result.slab_start.size()) - 1);
  }
  return result;
}

}  // namespace tilth::kernel
