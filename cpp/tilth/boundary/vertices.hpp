// SPDX-License-Identifier: BSD-3-Clause
// Vertices of the multiplier space of implicit boundaries (docs/theory/implicit_boundaries.md):
// edges of cells that a boundary cuts, selected so that no two vertices that constrain the same
// direction have a common node (vital vertices: Moes, Bechet & Tourbier 2006; Bechet, Moes &
// Wohlmuth 2009).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>
#include <vector>

#include "../grid_lines.hpp"

namespace tilth::boundary {

/// Distance between the boundary and a node, in cells, up to which the node lies on the boundary.
inline constexpr double node_tolerance = 1e-3;
/// Greatest distance between a vertex and its nearest quadrature point, in cells.
inline constexpr double largest_point_distance = 0.5;
/// Least component of the normal relative to the largest one, for an edge to be extended.
inline constexpr double least_normal_component = 0.7;
/// Least cosine between the normals of the points of one multiplier.
inline constexpr double least_normal_cosine = 0.5;
/// Greatest fraction of a direction that may be prescribed at the nodes of a vertex.
inline constexpr double largest_prescribed_fraction = 0.9;
/// Greatest fraction of a direction that other vertices may constrain at the nodes of a vertex.
inline constexpr double largest_common_fraction = 0.5;

/// Quadrature points in contact with soil, ordered by boundary and by cell: cell c has the points
/// `start[c]` to `start[c + 1]` and the corners `node` (cells, 2^Dim); `lattice` (nodes, 3) are the
/// nodes' lattice coordinates, `local` (points, Dim) the points' coordinates in cells from the
/// lowest corner, `normal` (points, Dim) unit vectors.
template <int Dim>
struct CellsInContact {
  std::int64_t cells;
  const std::int64_t* start;
  const std::int32_t* node;
  const double* local;
  const double* normal;
  const std::int64_t* lattice;
  const GridLines& grid;

  /// Lattice coordinates of a cell's lowest corner.
  const std::int64_t* lowest(std::int64_t cell) const {
    return lattice + 3 * std::int64_t{node[cell << Dim]};
  }

  /// Fills the size of a cell [length].
  void size(std::int64_t cell, double h[Dim]) const {
    for (int k = 0; k < Dim; ++k) h[k] = grid[k].width(lowest(cell)[k]);
  }
};

/// Constrained directions: family f constrains `direction` (all families' points, Dim) at the
/// points of the cells `first_cell[f]` to `end_cell[f]`. The families of one boundary have the same
/// cells.
struct Families {
  std::int64_t families;
  const std::int64_t* first_cell;
  const std::int64_t* end_cell;
  const std::int64_t* first_direction;
  const double* direction;
};

/// A possible vertex: where a boundary cuts an edge of a cell or contains a node (`low` == `high`).
template <int Dim>
struct Candidate {
  std::int32_t low, high;  // nodes
  int rank[2];             // cut edges at its two nodes: the greater number and the sum
  std::int64_t point;      // nearest quadrature point
  double position[Dim];    // in cells, from the lattice's origin
};

/// The selected vertices, and the vertex to which each direction of a point belongs.
template <int Dim>
struct Vertices {
  std::vector<std::int64_t> family;
  std::vector<double> position;     // (vertices, Dim), in cells, from the lattice's origin
  std::vector<std::int64_t> point;  // nearest quadrature point
  std::vector<std::int64_t> owner;  // (all families' points)
};

/// Signed distance of a node from the plane through its nearest quadrature point.
struct NodeDistance {
  std::int32_t node;
  double squared_distance, signed_distance;  // squared length; length
};

/// Returns all candidates of the cells `first` to `end` of one boundary, in the order of their
/// nodes.
template <int Dim>
std::vector<Candidate<Dim>> find_candidates(const CellsInContact<Dim>& at, std::int64_t first,
                                            std::int64_t end) {
  constexpr int corners = 1 << Dim;

  std::vector<NodeDistance> distance;
  distance.reserve((end - first) * corners);
  for (std::int64_t c = first; c < end; ++c) {
    double h[Dim];
    at.size(c, h);
    for (int a = 0; a < corners; ++a) {
      NodeDistance best{at.node[c * corners + a], std::numeric_limits<double>::infinity(), 0.0};
      for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q) {
        double squared_distance = 0.0, along = 0.0;
        for (int k = 0; k < Dim; ++k) {
          const double offset = (((a >> k) & 1) - at.local[q * Dim + k]) * h[k];
          squared_distance += offset * offset;
          along += offset * at.normal[q * Dim + k];
        }
        if (squared_distance < best.squared_distance)
          best.squared_distance = squared_distance, best.signed_distance = along;
      }
      distance.push_back(best);
    }
  }
  std::sort(distance.begin(), distance.end(), [](const NodeDistance& a, const NodeDistance& b) {
    return std::tie(a.node, a.squared_distance, a.signed_distance) <
           std::tie(b.node, b.squared_distance, b.signed_distance);
  });
  distance.erase(std::unique(distance.begin(), distance.end(),
                             [](const auto& a, const auto& b) { return a.node == b.node; }),
                 distance.end());
  const auto number_of = [&](std::int32_t node) {
    return std::lower_bound(distance.begin(), distance.end(), node,
                            [](const NodeDistance& a, std::int32_t b) { return a.node < b; }) -
           distance.begin();
  };

  std::vector<Candidate<Dim>> found;
  const auto add = [&](std::int64_t c, int a, int b, double share) {
    Candidate<Dim> candidate{at.node[c * corners + a], at.node[c * corners + b], {0, 0}, -1, {}};
    double squared_distance = std::numeric_limits<double>::infinity(), local[Dim];
    for (int k = 0; k < Dim; ++k) {
      const double from = (a >> k) & 1, to = (b >> k) & 1;
      local[k] = from + share * (to - from);
    }
    for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q) {
      double sum = 0.0;
      for (int k = 0; k < Dim; ++k)
        sum += (local[k] - at.local[q * Dim + k]) * (local[k] - at.local[q * Dim + k]);
      if (sum < squared_distance) squared_distance = sum, candidate.point = q;
    }
    if (squared_distance > largest_point_distance * largest_point_distance) return;
    for (int k = 0; k < Dim; ++k)
      candidate.position[k] = static_cast<double>(at.lowest(c)[k]) + local[k];
    found.push_back(candidate);
  };
  for (std::int64_t c = first; c < end; ++c) {
    double h[Dim], signed_distance[corners];
    at.size(c, h);
    const double least = *std::min_element(h, h + Dim);
    bool lies_on[corners], cuts_node = false;
    int positive = 0;
    for (int a = 0; a < corners; ++a) {
      signed_distance[a] = distance[number_of(at.node[c * corners + a])].signed_distance;
      lies_on[a] = std::abs(signed_distance[a]) <= node_tolerance * least;
      cuts_node = cuts_node || lies_on[a];
      positive += signed_distance[a] > 0.0;
      if (lies_on[a]) add(c, a, a, 0.0);
    }
    // a boundary outside the soil's cells acts on the nearest one, with extended edges
    const bool outside = !cuts_node && (positive == 0 || positive == corners);
    double across[Dim], most = 0.0;
    for (int k = 0; k < Dim; ++k) {
      across[k] = std::abs(at.normal[at.start[c] * Dim + k]) * h[k];
      most = std::max(most, across[k]);
    }
    for (int a = 0; a < corners; ++a)
      for (int k = 0; k < Dim; ++k) {
        const int b = a | (1 << k);
        if (b == a || lies_on[a] || lies_on[b]) continue;
        const bool cut = (signed_distance[a] > 0.0) != (signed_distance[b] > 0.0);
        if (cut || (outside && across[k] >= least_normal_component * most))
          add(c, a, b, signed_distance[a] / (signed_distance[a] - signed_distance[b]));
      }
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::tie(a.low, a.high, a.point) < std::tie(b.low, b.high, b.point);
  });
  found.erase(
      std::unique(found.begin(), found.end(),
                  [](const auto& a, const auto& b) { return a.low == b.low && a.high == b.high; }),
      found.end());
  std::vector<int> edges(distance.size(), 0);
  for (const auto& candidate : found)
    if (candidate.low != candidate.high)
      ++edges[number_of(candidate.low)], ++edges[number_of(candidate.high)];
  for (auto& candidate : found) {
    if (candidate.low == candidate.high) continue;
    const int low = edges[number_of(candidate.low)], high = edges[number_of(candidate.high)];
    candidate.rank[0] = std::max(low, high), candidate.rank[1] = low + high;
  }
  return found;
}

/// Constrained directions at each node: the sum over the vertices of the directions' dyads.
template <int Dim>
class ConstrainedDirections {
 public:
  /// `constrained` (nodes * Dim): components that are prescribed at nodes.
  ConstrainedDirections(std::vector<std::int32_t> node, const bool* constrained)
      : node_(std::move(node)) {
    std::sort(node_.begin(), node_.end());
    node_.erase(std::unique(node_.begin(), node_.end()), node_.end());
    sum_.assign(node_.size() * Dim * Dim, 0.0);
    for (std::size_t i = 0; constrained != nullptr && i < node_.size(); ++i)
      for (int k = 0; k < Dim; ++k)
        if (constrained[std::int64_t{node_[i]} * Dim + k]) sum_[(i * Dim + k) * Dim + k] = 1.0;
  }

  /// Returns the fraction of a unit direction that is constrained at a node, 0 to 1.
  double fraction(std::int32_t node, const double* direction) const {
    const double* sum = sum_.data() + number(node) * Dim * Dim;
    double fraction = 0.0;
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j) fraction += direction[i] * sum[i * Dim + j] * direction[j];
    return fraction;
  }

  /// Adds the direction to those that are constrained at a node.
  void constrain(std::int32_t node, const double* direction) {
    double* sum = sum_.data() + number(node) * Dim * Dim;
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j) sum[i * Dim + j] += direction[i] * direction[j];
  }

 private:
  std::int64_t number(std::int32_t node) const {
    return std::lower_bound(node_.begin(), node_.end(), node) - node_.begin();
  }
  std::vector<std::int32_t> node_;
  std::vector<double> sum_;
};

}  // namespace tilth::boundary
