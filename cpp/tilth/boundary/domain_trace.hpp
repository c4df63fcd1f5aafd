// SPDX-License-Identifier: BSD-3-Clause
// The displacement at places on the faces of domains with corners (CPDI) in terms of the nodes': it
// is interpolated between a domain's corners, u(y) = sum_c w_c(xi) u(x_c), and there by the grid.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "../basis/corners.hpp"
#include "../parallel.hpp"
#include "points_in_cells.hpp"

namespace tilth::boundary {

/// Fills the weights of a domain's corners at a place; they sum to one and reproduce the place.
/// Returns whether it belongs to the domain: a tracked surface is not exactly the boundary of the
/// domains, so that local coordinates up to `farthest`, 1 on the faces, still do.
///
/// `corner` (2^Dim, Dim) and `offset` (Dim) are relative to the domain's point.
template <int Dim>
bool weights_in_domain(const double* corner, const double* offset,
                       double weight[basis::corners_of<Dim>]) {
  constexpr int corners = basis::corners_of<Dim>, iterations = 12;  // four, unless degenerate
  constexpr double farthest = 1.5, limit = 4.0, exact = 1e-14, good = 1e-9, round_off = 1e-12;
  constexpr double flat = 1e-9;  // volume over that of a cube of the same extent
  double size = 0.0, xi[Dim] = {}, error[Dim], worst = 0.0;
  for (int i = 0; i < corners * Dim; ++i) size = std::max(size, std::fabs(corner[i]));
  const double least = flat * (Dim == 3 ? size : 1.0) * size * size;
  for (int i = 0;; ++i) {
    double slope[corners][Dim], cofactor[Dim][Dim];
    basis::corner_functions<Dim>(xi, weight, slope);
    worst = 0.0;
    for (int k = 0; k < Dim; ++k) {
      error[k] = offset[k];
      for (int c = 0; c < corners; ++c) error[k] -= weight[c] * corner[Dim * c + k];
      worst = std::max(worst, std::fabs(error[k]));
    }
    if (worst <= exact * size || i == iterations) break;
    const double volume = basis::cofactors<Dim>(corner, slope, cofactor);
    for (int k = 0; k < Dim; ++k) {
      double change = 0.0;
      for (int j = 0; j < Dim; ++j) change += cofactor[j][k] * error[j];
      change = std::fabs(volume) <= least ? farthest : change / volume;
      xi[k] = std::clamp(xi[k] + change, -limit, limit);
    }
  }
  for (int c = 0; c < corners; ++c)
    if (std::fabs(weight[c]) < round_off) weight[c] = 0.0;
  bool inside = worst <= good * size;
  for (int k = 0; k < Dim; ++k) inside = inside && std::fabs(xi[k]) <= farthest;
  return inside;
}

/// Domains with corners: of each point its position (points, Dim) and its corners relative to it
/// (points, 2^Dim, Dim).
struct Domains {
  const double* centre;
  const double* corner;
};

/// Samples of places: place q has `start[q]` to `start[q + 1]`, each at a position (samples, Dim)
/// on the domain of its `owner`, whose overlay adds `shift` to the keys of nodes.
struct TraceSamples {
  const std::int64_t* start;
  const double* position;
  const std::int64_t* owner;
  const std::int64_t* shift;
};

/// Sorted keys of nodes.
struct NodeKeys {
  std::int64_t count;
  const std::int64_t* key;

  /// Returns the number of a node, -1 without it.
  std::int64_t find(std::int64_t sought) const {
    const std::int64_t* at = std::lower_bound(key, key + count, sought);
    return at == key + count || *at != sought ? -1 : at - key;
  }
};

/// Shares of nodes' displacements at places: `count` of each place, ascending nodes.
struct TraceTerms {
  std::vector<std::int64_t> count, node;
  std::vector<double> value;

  void append(const TraceTerms& other) {
    count.insert(count.end(), other.count.begin(), other.count.end());
    node.insert(node.end(), other.node.begin(), other.node.end());
    value.insert(value.end(), other.value.begin(), other.value.end());
  }
};

/// The mean of the domains' displacement over the samples of one place after another.
template <int Dim>
class MeanTrace {
 public:
  MeanTrace(const TraceSamples& samples, const Domains& domains, const CellsWithSoil& cells,
            const NodeKeys& nodes)
      : samples_(samples), domains_(domains), cells_(cells), nodes_(nodes) {}

  /// Appends the terms of a place; returns whether any of its samples belongs to its domain. Sets
  /// `missing` if a node is not there.
  bool append(std::int64_t place, TraceTerms& terms, Found& missing) {
    weights_.clear(), terms_.clear();
    double number = 0.0;
    for (std::int64_t s = samples_.start[place]; s < samples_.start[place + 1]; ++s)
      if (add_sample(s)) number += 1.0;
    if (number == 0.0) return false;
    for (const DomainWeights& each : weights_)
      for (int c = 0; c < corners; ++c)
        if (each.weight[c] != 0.0 && !add_corner(each, c, each.weight[c] / number)) missing.set();
    std::sort(terms_.begin(), terms_.end());
    terms.count.push_back(std::ssize(terms_));
    for (const auto& [node, value] : terms_)
      terms.node.push_back(node), terms.value.push_back(value);
    return true;
  }

 private:
  static constexpr int corners = basis::corners_of<Dim>;

  struct DomainWeights {
    std::int64_t owner, shift;
    double weight[corners];
  };

  const TraceSamples& samples_;
  const Domains& domains_;
  const CellsWithSoil& cells_;
  const NodeKeys& nodes_;
  std::vector<DomainWeights> weights_;  // of the samples in each domain
  std::vector<std::pair<std::int64_t, double>> terms_;

  struct NodesOfCell {
    std::int64_t cell = -1;
    std::int64_t node[corners];
  };
  static constexpr int kept = 64;  // cells whose nodes are at hand
  NodesOfCell at_hand_[kept];

  /// Returns the nodes of a cell by its key, x fastest; the first is -1 if one is not there.
  const std::int64_t* nodes_of(std::int64_t cell) {
    const std::int64_t hash = cell ^ (cell >> (key_bits - 2)) ^ (cell >> (2 * key_bits - 4));
    NodesOfCell& at = at_hand_[hash & (kept - 1)];
    if (at.cell == cell) return at.node;
    at.cell = cell;
    for (int a = 0; a < corners; a += 2) {
      const std::int64_t key = cell + (std::int64_t{(a >> 1) & 1} << key_bits) +
                               (std::int64_t{(a >> 2) & 1} << (2 * key_bits));
      at.node[a] = nodes_.find(key);
      at.node[a + 1] = nodes_.find(key + 1);
      if (at.node[a] < 0 || at.node[a + 1] < 0) return at.cell = -1, at.node[0] = -1, at.node;
    }
    return at.node;
  }

  bool add_sample(std::int64_t sample) {
    const std::int64_t owner = samples_.owner[sample];
    double offset[Dim], weight[corners];
    for (int k = 0; k < Dim; ++k)
      offset[k] = samples_.position[Dim * sample + k] - domains_.centre[Dim * owner + k];
    if (!weights_in_domain<Dim>(domains_.corner + corners * Dim * owner, offset, weight))
      return false;
    auto found = std::find_if(weights_.begin(), weights_.end(),
                              [&](const DomainWeights& each) { return each.owner == owner; });
    if (found == weights_.end())
      found = weights_.insert(found, DomainWeights{owner, samples_.shift[sample], {}});
    for (int c = 0; c < corners; ++c) found->weight[c] += weight[c];
    return true;
  }

  /// Adds a corner's share of the nodes of its cell; returns whether they are there.
  bool add_corner(const DomainWeights& domain, int corner, double share) {
    double position[Dim], local[Dim], value[corners];
    const double* from = domains_.corner + (corners * domain.owner + corner) * Dim;
    for (int k = 0; k < Dim; ++k) position[k] = domains_.centre[Dim * domain.owner + k] + from[k];
    const Lattice cell = find_cell<Dim>(position, cells_, domain.shift, local);
    shape_functions_at<Dim>(local, nullptr, value, nullptr);
    const std::int64_t* node_of = nodes_of(pack(cell) + domain.shift);
    if (node_of[0] < 0) return false;
    for (int a = 0; a < corners; ++a) {
      const std::int64_t node = node_of[a];
      const auto found = std::find_if(terms_.begin(), terms_.end(),
                                      [&](const auto& each) { return each.first == node; });
      if (found == terms_.end())
        terms_.emplace_back(node, share * value[a]);
      else
        found->second += share * value[a];
    }
    return true;
  }
};

/// Returns the terms of the trace at places `at` in cells: on domains with corners the mean over a
/// place's samples; without samples that belong to their domains by the functions of its cell.
/// `missing` is set if a domain reaches cells whose nodes are not there.
template <int Dim>
TraceTerms trace_of_domains(const PointsInCells& at, const TraceSamples& samples,
                            const Domains& domains, const CellsWithSoil& cells,
                            const NodeKeys& nodes, Found& missing) {
  constexpr std::int64_t work = 64;  // about that of as many points of a simple kernel
  const std::int64_t places = at.start[at.cells];
  const std::int64_t chunks = work * places >= parallel_from ? 64 : 1;
  std::vector<TraceTerms> found(chunks);
#pragma omp parallel for schedule(static) if (chunks > 1)
  for (std::int64_t chunk = 0; chunk < chunks; ++chunk) {
    MeanTrace<Dim> mean(samples, domains, cells, nodes);
    TraceTerms& terms = found[chunk];
    const std::int64_t first = places * chunk / chunks, last = places * (chunk + 1) / chunks;
    std::int64_t cell = std::upper_bound(at.start, at.start + at.cells + 1, first) - at.start - 1;
    for (std::int64_t place = first; place < last; ++place) {
      while (at.start[cell + 1] <= place) ++cell;
      if (mean.append(place, terms, missing)) continue;
      std::vector<std::pair<std::int64_t, double>> own;
      for (int a = 0; a < at.nodes; ++a)
        own.emplace_back(at.node[cell * at.nodes + a], at.value[place * at.nodes + a]);
      std::sort(own.begin(), own.end());
      terms.count.push_back(at.nodes);
      for (const auto& [node, value] : own)
        terms.node.push_back(node), terms.value.push_back(value);
    }
  }
  for (std::int64_t chunk = 1; chunk < chunks; ++chunk) found[0].append(found[chunk]);
  return std::move(found[0]);
}

}  // namespace tilth::boundary
