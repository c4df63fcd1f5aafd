// SPDX-License-Identifier: BSD-3-Clause
// Exterior nodes: nodes on the far side of boundaries, and their distances from the boundaries.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

#include "../grid.hpp"
#include "vertices.hpp"

namespace tilth::boundary {

/// Sorted keys of exterior nodes and their depth along each axis [-] (nodes, Dim, 2), first of
/// those with their soil above them on the axis, then of those with their soil below.
struct ExteriorNodes {
  std::vector<std::int64_t> key;
  std::vector<double> depth;
};

/// Returns the exterior nodes of the cells that boundaries act on and of the next cells around
/// them. A node is exterior if it lies behind the plane through the nearest quadrature point. With
/// s the square of its distance from this plane in units of the cell's extent along the normal n,
/// at most 1, its depth along axis k is s n_k^2, with the soil on the side to which n_k points.
template <int Dim>
ExteriorNodes exterior_nodes(const CellsInContact<Dim>& at) {
  struct Node {
    std::int64_t key;
    double squared_distance, depth;
    std::int64_t point;
  };
  constexpr int side = 4, around = Dim == 2 ? side * side : side * side * side;
  double squared_distance[around], depth[around];
  std::int64_t point[around];
  const auto before = [](const Node& a, const Node& b) {
    return std::tie(a.key, a.squared_distance, a.depth, a.point) <
           std::tie(b.key, b.squared_distance, b.depth, b.point);
  };
  std::vector<Node> nodes;
  std::vector<std::int64_t> recent(1 << 16, -1);  // where nodes are in `nodes`, by hash
  for (std::int64_t c = 0; c < at.cells; ++c) {
    const std::int64_t* lowest = at.lowest(c);
    double h[Dim], line[Dim][side];  // of the nodes, from the lowest corner in sizes of the cell
    at.size(c, h);
    for (int k = 0; k < Dim; ++k)
      for (int i = 0; i < side; ++i)
        line[k][i] =
            at.grid[k].graded()
                ? (at.grid[k].distance(lowest[k] + i - 1) - at.grid[k].distance(lowest[k])) / h[k]
                : i - 1;
    std::fill_n(squared_distance, around, std::numeric_limits<double>::infinity());
    for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q) {
      double square[3][side] = {}, along[3][side] = {};
      for (int k = 0; k < Dim; ++k)
        for (int i = 0; i < side; ++i) {
          const double component = (line[k][i] - at.local[q * Dim + k]) * h[k];
          square[k][i] = component * component;
          along[k][i] = component * at.normal[q * Dim + k];
        }
      for (int a = 0; a < around; ++a) {
        const int i = a % side, j = a / side % side, k = a / (side * side);
        const double sum = square[0][i] + square[1][j] + square[2][k];
        const bool nearer = sum < squared_distance[a];
        squared_distance[a] = nearer ? sum : squared_distance[a];
        depth[a] = nearer ? -(along[0][i] + along[1][j] + along[2][k]) : depth[a];
        point[a] = nearer ? q : point[a];
      }
    }
    for (int a = 0; a < around; ++a) {
      const int offset[3] = {a % side - 1, a / side % side - 1,
                             Dim == 2 ? 0 : a / (side * side) - 1};
      Node node{0, squared_distance[a], depth[a], point[a]};
      double extent = 0.0;  // of the cell along the normal
      for (int k = 0; k < Dim; ++k) extent += std::fabs(at.normal[node.point * Dim + k]) * h[k];
      node.depth = std::min(node.depth / extent, 1.0);
      node.key = pack({lowest[0] + offset[0], lowest[1] + offset[1], lowest[2] + offset[2]});
      std::int64_t& slot = recent[static_cast<std::uint64_t>(node.key) * 0x9e3779b97f4a7c15u >> 48];
      if (slot >= 0 && nodes[slot].key == node.key) {
        nodes[slot] = std::min(nodes[slot], node, before);
      } else {
        slot = static_cast<std::int64_t>(nodes.size());
        nodes.push_back(node);
      }
    }
  }
  std::sort(nodes.begin(), nodes.end(), before);
  ExteriorNodes result;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (i > 0 && nodes[i].key == nodes[i - 1].key) continue;
    if (nodes[i].depth <= node_tolerance) continue;
    result.key.push_back(nodes[i].key);
    const double* n = at.normal + nodes[i].point * Dim;
    for (int k = 0; k < Dim; ++k) {
      const double depth = nodes[i].depth * nodes[i].depth * n[k] * n[k];
      result.depth.push_back(n[k] > 0.0 ? depth : 0.0);
      result.depth.push_back(n[k] > 0.0 ? 0.0 : depth);
    }
  }
  return result;
}

}  // namespace tilth::boundary
