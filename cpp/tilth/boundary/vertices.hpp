// SPDX-License-Identifier: BSD-3-Clause
// Vertices of the multiplier space of implicit boundaries (docs/theory/implicit_boundaries.md): the
// edges of cells that a boundary cuts, chosen so that no two vertices that hold the same direction
// share a node (the vital vertices of Moes, Bechet & Tourbier 2006; Bechet, Moes & Wohlmuth 2009).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>
#include <vector>

namespace tilth::boundary {

inline constexpr double on_node = 1e-3;     // distance from a node, in cells, that counts as none
inline constexpr double near = 0.5;         // a vertex has a quadrature point within so many cells
inline constexpr double aligned = 0.7;      // of the largest component of a normal
inline constexpr double same_side = 0.5;    // cosine between normals that one multiplier may hold
inline constexpr double hardly_free = 0.9;  // part of a direction that is prescribed at a node
inline constexpr double shared = 0.5;       // part of a direction that other vertices hold already

/// Quadrature points that touch soil, grouped by boundary and within it by the cell they act on:
/// those of cell c are `start[c]` to `start[c + 1]`, `node` (cells, 2^Dim) its corners, `lattice`
/// (nodes, 3) the nodes' places; `local` (points, Dim) in cells from the lowest corner, `normal`
/// (points, Dim) unit.
template <int Dim>
struct TouchedCells {
  std::int64_t cells;
  const std::int64_t* start;
  const std::int32_t* node;
  const double* local;
  const double* normal;
  const std::int64_t* lattice;
  const double* cell_size;
};

/// Directions that boundaries hold: family f holds `direction` (all families' points, Dim) at the
/// points of the cells `first_cell[f]` to `end_cell[f]`; two families of one boundary share them.
struct Families {
  std::int64_t families;
  const std::int64_t* first_cell;
  const std::int64_t* end_cell;
  const std::int64_t* first_direction;
  const double* direction;
};

/// A place where a boundary cuts an edge of a cell, or lies on a node (`low` == `high`).
template <int Dim>
struct Candidate {
  std::int32_t low, high;  // nodes
  int rank[2];             // cut edges at its nodes: the greater number and the sum
  std::int64_t point;      // the quadrature point nearest to it
  double place[Dim];       // in cells, on the lattice
};

/// The vertices that were chosen, and the one that each direction of a point belongs to.
template <int Dim>
struct Vertices {
  std::vector<std::int64_t> family;
  std::vector<double> place;        // (vertices, Dim), in cells, on the lattice
  std::vector<std::int64_t> point;  // nearest quadrature point
  std::vector<std::int64_t> owner;  // (all families' points)
};

/// Signed distance of a node from the boundary, by the plane through its nearest point.
struct NodeDistance {
  std::int32_t node;
  double apart, signed_distance;  // squared length; length
};

/// Finds all candidates of the cells `first` to `end` of one boundary, in the order of their nodes.
template <int Dim>
std::vector<Candidate<Dim>> find_candidates(const TouchedCells<Dim>& at, std::int64_t first,
                                            std::int64_t end) {
  constexpr int corners = 1 << Dim;
  const double* h = at.cell_size;
  const double least = *std::min_element(h, h + Dim);

  std::vector<NodeDistance> distance;
  distance.reserve((end - first) * corners);
  for (std::int64_t c = first; c < end; ++c)
    for (int a = 0; a < corners; ++a) {
      NodeDistance best{at.node[c * corners + a], std::numeric_limits<double>::infinity(), 0.0};
      for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q) {
        double apart = 0.0, along = 0.0;
        for (int k = 0; k < Dim; ++k) {
          const double way = (((a >> k) & 1) - at.local[q * Dim + k]) * h[k];
          apart += way * way;
          along += way * at.normal[q * Dim + k];
        }
        if (apart < best.apart) best.apart = apart, best.signed_distance = along;
      }
      distance.push_back(best);
    }
  std::sort(distance.begin(), distance.end(), [](const NodeDistance& a, const NodeDistance& b) {
    return std::tie(a.node, a.apart, a.signed_distance) <
           std::tie(b.node, b.apart, b.signed_distance);
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
    double apart = std::numeric_limits<double>::infinity(), local[Dim];
    for (int k = 0; k < Dim; ++k) {
      const double from = (a >> k) & 1, to = (b >> k) & 1;
      local[k] = from + share * (to - from);
    }
    for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q) {
      double sum = 0.0;
      for (int k = 0; k < Dim; ++k)
        sum += (local[k] - at.local[q * Dim + k]) * (local[k] - at.local[q * Dim + k]);
      if (sum < apart) apart = sum, candidate.point = q;
    }
    if (apart > near * near) return;
    const std::int64_t* lowest = at.lattice + 3 * std::int64_t{at.node[c * corners]};
    for (int k = 0; k < Dim; ++k) candidate.place[k] = static_cast<double>(lowest[k]) + local[k];
    found.push_back(candidate);
  };
  for (std::int64_t c = first; c < end; ++c) {
    double signed_distance[corners];
    bool lies_on[corners], touched = false;
    int positive = 0;
    for (int a = 0; a < corners; ++a) {
      signed_distance[a] = distance[number_of(at.node[c * corners + a])].signed_distance;
      lies_on[a] = std::abs(signed_distance[a]) <= on_node * least;
      touched = touched || lies_on[a];
      positive += signed_distance[a] > 0.0;
      if (lies_on[a]) add(c, a, a, 0.0);
    }
    // a boundary that lies beyond the soil's cells acts on the nearest one: its edges go on
    const bool beyond = !touched && (positive == 0 || positive == corners);
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
        if (cut || (beyond && across[k] >= aligned * most))
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

/// What the vertices chosen so far hold at each node: the sum of their directions' squares.
template <int Dim>
class HeldDirections {
 public:
  /// `constrained` (nodes * Dim): components that are prescribed at nodes.
  HeldDirections(std::vector<std::int32_t> node, const bool* constrained) : node_(std::move(node)) {
    std::sort(node_.begin(), node_.end());
    node_.erase(std::unique(node_.begin(), node_.end()), node_.end());
    sum_.assign(node_.size() * Dim * Dim, 0.0);
    for (std::size_t i = 0; constrained != nullptr && i < node_.size(); ++i)
      for (int k = 0; k < Dim; ++k)
        if (constrained[std::int64_t{node_[i]} * Dim + k]) sum_[(i * Dim + k) * Dim + k] = 1.0;
  }

  /// The part of a unit direction that is constrained at a node, 0 to 1.
  double part(std::int32_t node, const double* direction) const {
    const double* sum = sum_.data() + number(node) * Dim * Dim;
    double part = 0.0;
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j) part += direction[i] * sum[i * Dim + j] * direction[j];
    return part;
  }

  void hold(std::int32_t node, const double* direction) {
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
