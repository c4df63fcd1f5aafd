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

/// Sorted keys of exterior nodes and their depth along each axis [-] (nodes, Dim).
struct ExteriorNodes {
  std::vector<std::int64_t> key;
  std::vector<double> depth;
};

/// Returns the exterior nodes of the cells that boundaries act on and of the next cells around
/// them. A node is exterior if it lies behind the plane through the nearest quadrature point. With
/// s the square of its distance from this plane in units of the cell's extent along the normal n,
/// at most 1, its depth along axis k is s n_k^2.
template <int Dim>
ExteriorNodes exterior_nodes(const CellsInContact<Dim>& at) {
  struct Node {
    std::int64_t key;
    double squared_distance, depth;
    std::int64_t point;
  };
  constexpr int side = 4, around = Dim == 2 ? side * side : side * side * side;
  std::vector<Node> nodes;
  nodes.reserve(at.cells * around);
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
    for (int a = 0; a < around; ++a) {
      int offset[3] = {a % side - 1, a / side % side - 1, Dim == 2 ? 0 : a / (side * side) - 1};
      Node node{0, std::numeric_limits<double>::infinity(), 0.0, -1};
      for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q) {
        double squared_distance = 0.0, along = 0.0;
        for (int k = 0; k < Dim; ++k) {
          const double component = (line[k][offset[k] + 1] - at.local[q * Dim + k]) * h[k];
          squared_distance += component * component;
          along += component * at.normal[q * Dim + k];
        }
        if (squared_distance < node.squared_distance)
          node.squared_distance = squared_distance, node.depth = -along, node.point = q;
      }
      double extent = 0.0;  // of the cell along the normal
      for (int k = 0; k < Dim; ++k) extent += std::fabs(at.normal[node.point * Dim + k]) * h[k];
      node.depth = std::min(node.depth / extent, 1.0);
      node.key = pack({lowest[0] + offset[0], lowest[1] + offset[1], lowest[2] + offset[2]});
      nodes.push_back(node);
    }
  }
  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) {
    return std::tie(a.key, a.squared_distance, a.depth, a.point) <
           std::tie(b.key, b.squared_distance, b.depth, b.point);
  });
  ExteriorNodes result;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (i > 0 && nodes[i].key == nodes[i - 1].key) continue;
    if (nodes[i].depth <= node_tolerance) continue;
    result.key.push_back(nodes[i].key);
    const double* n = at.normal + nodes[i].point * Dim;
    for (int k = 0; k < Dim; ++k)
      result.depth.push_back(nodes[i].depth * nodes[i].depth * n[k] * n[k]);
  }
  return result;
}

}  // namespace tilth::boundary
