// SPDX-License-Identifier: BSD-3-Clause
// Which nodes lie behind boundaries, and by how much.
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

/// Nodes behind boundaries: sorted keys, and how far behind they are along each axis (nodes, Dim).
struct Behind {
  std::vector<std::int64_t> key;
  std::vector<double> depth;
};

/// Looks at the nodes of the cells that a boundary acts on, and at those one further. Where the
/// plane through the nearest quadrature point has a node behind it, its distance in units of the
/// cell's extent along the normal, at most 1, times the square of the normal's component along each
/// axis.
template <int Dim>
Behind nodes_behind(const TouchedCells<Dim>& at) {
  struct Node {
    std::int64_t key;
    double apart, depth;
    std::int64_t point;
  };
  constexpr int side = 4, around = Dim == 2 ? side * side : side * side * side;
  const double* h = at.cell_size;
  std::vector<Node> nodes;
  nodes.reserve(at.cells * around);
  std::vector<double> extent(at.start[at.cells] - at.start[0], 0.0);  // of a cell along the normals
  for (std::int64_t q = at.start[0]; q < at.start[at.cells]; ++q)
    for (int k = 0; k < Dim; ++k)
      extent[q - at.start[0]] += std::fabs(at.normal[q * Dim + k]) * h[k];
  for (std::int64_t c = 0; c < at.cells; ++c) {
    const std::int64_t* lowest = at.lattice + 3 * std::int64_t{at.node[c << Dim]};
    for (int a = 0; a < around; ++a) {
      int offset[3] = {a % side - 1, a / side % side - 1, Dim == 2 ? 0 : a / (side * side) - 1};
      Node node{0, std::numeric_limits<double>::infinity(), 0.0, -1};
      for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q) {
        double apart = 0.0, along = 0.0;
        for (int k = 0; k < Dim; ++k) {
          const double way = (offset[k] - at.local[q * Dim + k]) * h[k];
          apart += way * way;
          along += way * at.normal[q * Dim + k];
        }
        if (apart < node.apart) node.apart = apart, node.depth = -along, node.point = q;
      }
      node.depth = std::min(node.depth / extent[node.point - at.start[0]], 1.0);
      node.key = pack({lowest[0] + offset[0], lowest[1] + offset[1], lowest[2] + offset[2]});
      nodes.push_back(node);
    }
  }
  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) {
    return std::tie(a.key, a.apart, a.depth, a.point) < std::tie(b.key, b.apart, b.depth, b.point);
  });
  Behind result;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (i > 0 && nodes[i].key == nodes[i - 1].key) continue;
    if (nodes[i].depth <= on_node) continue;
    result.key.push_back(nodes[i].key);
    const double* n = at.normal + nodes[i].point * Dim;
    for (int k = 0; k < Dim; ++k)
      result.depth.push_back(nodes[i].depth * nodes[i].depth * n[k] * n[k]);
  }
  return result;
}

}  // namespace tilth::boundary
