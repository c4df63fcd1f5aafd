// SPDX-License-Identifier: BSD-3-Clause
// The multiplier space of implicit boundaries: multipliers that are constant on the parts of a
// boundary nearest to its vertices, and the means of the grid's displacement over these patches.
#pragma once

#include "../grid.hpp"
#include "vertices.hpp"

namespace tilth::boundary {

/// Selects vertices and assigns each direction of each point to the nearest vertex of its family.
template <int Dim>
class MultiplierSpace {
 public:
  MultiplierSpace(const CellsInContact<Dim>& at, const Families& families, const bool* constrained)
      : at_(at), families_(families) {
    for (std::int64_t f = 0; f < families.families; ++f) {
      const bool same = f > 0 && families.first_cell[f] == families.first_cell[f - 1];
      candidates_.push_back(
          same ? candidates_.back()
               : find_candidates(at, families.first_cell[f], families.end_cell[f]));
    }
    std::vector<std::int32_t> nodes;
    for (const auto& of_family : candidates_)
      for (const auto& candidate : of_family)
        nodes.push_back(candidate.low), nodes.push_back(candidate.high);
    const std::int64_t last = families.families - 1;
    vertices_.owner.assign(last < 0 ? 0 : families.first_direction[last] + points_of(last), -1);

    const ConstrainedDirections<Dim> prescribed(nodes, constrained);
    ConstrainedDirections<Dim> all(nodes, nullptr);
    std::vector<ConstrainedDirections<Dim>> own(families.families,
                                                ConstrainedDirections<Dim>(nodes, nullptr));
    choose(prescribed, all, own, [](std::int64_t, std::int64_t) { return true; }, false);
    assign();
    // second pass: points whose nearby edges are all constrained by other families
    choose(
        prescribed, all, own,
        [&](std::int64_t f, std::int64_t q) { return vertices_.owner[slot(f, q)] < 0; }, true);
    assign();
    for (std::int64_t f = 0; f < families.families; ++f) add_remaining(f);
    remove_empty();
  }

  Vertices<Dim> vertices() && { return std::move(vertices_); }

 private:
  std::int64_t first_point(std::int64_t f) const { return at_.start[families_.first_cell[f]]; }
  std::int64_t points_of(std::int64_t f) const {
    return at_.start[families_.end_cell[f]] - first_point(f);
  }
  std::int64_t slot(std::int64_t f, std::int64_t q) const {
    return families_.first_direction[f] + q - first_point(f);
  }
  const double* direction(std::int64_t f, std::int64_t q) const {
    return families_.direction + slot(f, q) * Dim;
  }

  /// Selects candidates whose nodes are free in the direction, in ascending order of the cut edges
  /// at their nodes, if `eligible(family, nearest point)`. `own_only`: regards only what the family
  /// itself constrains.
  template <class Eligible>
  void choose(const ConstrainedDirections<Dim>& prescribed, ConstrainedDirections<Dim>& all,
              std::vector<ConstrainedDirections<Dim>>& own, Eligible eligible, bool own_only) {
    std::vector<std::pair<std::int64_t, std::int64_t>> order;  // family, candidate
    for (std::int64_t f = 0; f < families_.families; ++f)
      for (std::size_t i = 0; i < candidates_[f].size(); ++i)
        if (eligible(f, candidates_[f][i].point))
          order.push_back({f, static_cast<std::int64_t>(i)});
    const auto key = [&](const auto& entry) {
      const auto& c = candidates_[entry.first][entry.second];
      return std::make_tuple(c.rank[0], c.rank[1], c.low, c.high, entry.first);
    };
    std::sort(order.begin(), order.end(),
              [&](const auto& a, const auto& b) { return key(a) < key(b); });
    for (const auto& [f, i] : order) {
      const auto& candidate = candidates_[f][i];
      const double* vector = direction(f, candidate.point);
      if (!own_only &&
          std::max(prescribed.fraction(candidate.low, vector),
                   prescribed.fraction(candidate.high, vector)) > largest_prescribed_fraction)
        continue;
      const auto& before = own_only ? own[f] : all;
      if (std::max(before.fraction(candidate.low, vector),
                   before.fraction(candidate.high, vector)) > largest_common_fraction)
        continue;
      for (auto* constrained : {&all, &own[f]}) {
        constrained->constrain(candidate.low, vector);
        if (candidate.high != candidate.low) constrained->constrain(candidate.high, vector);
      }
      add_vertex(f, candidate.position, candidate.point);
    }
  }

  void add_vertex(std::int64_t f, const double* position, std::int64_t point) {
    vertices_.family.push_back(f);
    vertices_.position.insert(vertices_.position.end(), position, position + Dim);
    vertices_.point.push_back(point);
  }

  void position_of(std::int64_t c, std::int64_t q, double* position) const {
    for (int k = 0; k < Dim; ++k)
      position[k] = static_cast<double>(at_.lowest(c)[k]) + at_.local[q * Dim + k];
  }

  double cosine(std::int64_t q, std::int64_t other) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) sum += at_.normal[q * Dim + k] * at_.normal[other * Dim + k];
    return sum;
  }

  /// Assigns the points without an owner to the nearest vertex of their family, at most two cells
  /// away along each axis, whose normal is similar (`least_normal_cosine`).
  void assign() {
    std::vector<std::pair<std::int64_t, std::int64_t>> sorted;  // key of the cell, vertex
    for (std::int64_t f = 0; f < families_.families; ++f) {
      sorted.clear();
      for (std::size_t v = 0; v < vertices_.family.size(); ++v) {
        if (vertices_.family[v] != f) continue;
        Lattice cell{0, 0, 0};
        for (int k = 0; k < Dim; ++k)
          cell[k] = static_cast<std::int64_t>(std::floor(vertices_.position[v * Dim + k]));
        sorted.push_back({pack(cell), static_cast<std::int64_t>(v)});
      }
      std::sort(sorted.begin(), sorted.end());
      for (std::int64_t c = families_.first_cell[f]; c < families_.end_cell[f]; ++c)
        for (std::int64_t q = at_.start[c]; q < at_.start[c + 1]; ++q)
          if (vertices_.owner[slot(f, q)] < 0) vertices_.owner[slot(f, q)] = nearest(sorted, c, q);
    }
  }

  std::int64_t nearest(const std::vector<std::pair<std::int64_t, std::int64_t>>& sorted,
                       std::int64_t c, std::int64_t q) const {
    double position[Dim], least = std::numeric_limits<double>::infinity();
    std::int64_t best = -1;
    position_of(c, q, position);
    Lattice own{0, 0, 0};
    for (int k = 0; k < Dim; ++k) own[k] = static_cast<std::int64_t>(std::floor(position[k]));
    for (std::int64_t radius = 1; radius <= 2; ++radius) {
      const std::int64_t layers = Dim == 3 ? radius : 0;
      for (std::int64_t k = -layers; k <= layers; ++k)
        for (std::int64_t j = -radius; j <= radius; ++j) {
          const std::int64_t begin = pack({own[0] - radius, own[1] + j, own[2] + k});
          for (auto at = std::lower_bound(sorted.begin(), sorted.end(),
                                          std::make_pair(begin, std::int64_t{-1}));
               at != sorted.end() && at->first <= begin + 2 * radius; ++at) {
            double squared_distance = 0.0;
            for (int d = 0; d < Dim; ++d) {
              const double offset = vertices_.position[at->second * Dim + d] - position[d];
              squared_distance += offset * offset;
            }
            if (squared_distance >= least ||
                cosine(q, vertices_.point[at->second]) < least_normal_cosine)
              continue;
            least = squared_distance, best = at->second;
          }
        }
      if (least < 1.0) break;  // vertices in farther cells are farther away
    }
    return best;
  }

  /// Adds vertices for points without a nearby vertex, each for the points within one cell.
  void add_remaining(std::int64_t f) {
    for (std::int64_t c = families_.first_cell[f]; c < families_.end_cell[f]; ++c)
      for (std::int64_t q = at_.start[c]; q < at_.start[c + 1]; ++q) {
        if (vertices_.owner[slot(f, q)] >= 0) continue;
        double position[Dim], other[Dim];
        position_of(c, q, position);
        const auto number = static_cast<std::int64_t>(vertices_.family.size());
        add_vertex(f, position, q);
        for (std::int64_t d = c; d < families_.end_cell[f]; ++d)
          for (std::int64_t p = at_.start[d]; p < at_.start[d + 1]; ++p) {
            position_of(d, p, other);
            double largest_offset = 0.0;
            for (int k = 0; k < Dim; ++k)
              largest_offset = std::max(largest_offset, std::abs(other[k] - position[k]));
            if (vertices_.owner[slot(f, p)] < 0 && largest_offset <= 1.0 &&
                cosine(p, q) >= least_normal_cosine)
              vertices_.owner[slot(f, p)] = number;
          }
      }
  }

  /// Removes the vertices without points and numbers the others by family.
  void remove_empty() {
    const auto count = static_cast<std::int64_t>(vertices_.family.size());
    std::vector<char> used(count, 0);
    for (const std::int64_t v : vertices_.owner) used[v] = 1;
    std::vector<std::int64_t> order, number(count, -1);
    for (std::int64_t v = 0; v < count; ++v)
      if (used[v]) order.push_back(v);
    std::stable_sort(order.begin(), order.end(), [&](std::int64_t a, std::int64_t b) {
      return vertices_.family[a] < vertices_.family[b];
    });
    Vertices<Dim> kept;
    for (const std::int64_t v : order) {
      number[v] = static_cast<std::int64_t>(kept.family.size());
      kept.family.push_back(vertices_.family[v]);
      kept.point.push_back(vertices_.point[v]);
      const auto position = vertices_.position.begin() + v * Dim;
      kept.position.insert(kept.position.end(), position, position + Dim);
    }
    for (const std::int64_t v : vertices_.owner) kept.owner.push_back(number[v]);
    vertices_ = std::move(kept);
  }

  const CellsInContact<Dim>& at_;
  const Families& families_;
  std::vector<std::vector<Candidate<Dim>>> candidates_;
  Vertices<Dim> vertices_;
};

/// Multipliers, and the nodes on which the means over their patches depend, in ragged rows.
struct Means {
  std::vector<double> area;              // (multipliers): of the patches
  std::vector<double> penalty;           // (multipliers): harmonic mean over the points
  std::vector<std::int64_t> node_start;  // (multipliers + 1)
  std::vector<std::int32_t> node;        // sorted within a multiplier
  std::vector<double> row;               // (entries, Dim): integral of N times the direction
};

/// Integrates over the patch of each multiplier. A slot is one direction of one quadrature point:
/// `owner` (slots) is its multiplier, `point` (slots) its point, `direction` (slots, Dim) and
/// `penalty` (slots) its own; `cell_of` (points), `weight` (points) and the shape functions `value`
/// (points, 2^Dim) belong to the points, `node` (cells, 2^Dim) are the cells' corners.
template <int Dim>
Means integrate_means(std::int64_t multipliers, std::int64_t slots, const std::int64_t* owner,
                      const std::int64_t* point, const std::int64_t* cell_of,
                      const std::int32_t* node, const double* weight, const double* direction,
                      const double* penalty, const double* value) {
  constexpr int corners = 1 << Dim;
  constexpr double coefficient_tolerance = 1e-12;
  std::vector<std::int64_t> first(multipliers + 1, 0), slot_of(slots);
  for (std::int64_t s = 0; s < slots; ++s) ++first[owner[s] + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::int64_t> fill(first.begin(), first.end() - 1);
  for (std::int64_t s = 0; s < slots; ++s) slot_of[fill[owner[s]]++] = s;

  Means means;
  means.area.assign(multipliers, 0.0), means.penalty.assign(multipliers, 0.0);
  means.node_start.assign(1, 0);
  std::vector<std::int32_t> nodes;
  std::vector<double> rows;
  for (std::int64_t m = 0; m < multipliers; ++m) {
    nodes.clear();
    for (std::int64_t i = first[m]; i < first[m + 1]; ++i) {
      const std::int32_t* corner = node + corners * cell_of[point[slot_of[i]]];
      if (i > first[m] && cell_of[point[slot_of[i]]] == cell_of[point[slot_of[i - 1]]]) continue;
      nodes.insert(nodes.end(), corner, corner + corners);
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    rows.assign(nodes.size() * Dim, 0.0);
    for (std::int64_t i = first[m]; i < first[m + 1]; ++i) {
      const std::int64_t s = slot_of[i], q = point[s];
      means.area[m] += weight[q];
      means.penalty[m] += weight[q] / penalty[s];
      const std::int32_t* corner = node + corners * cell_of[q];
      for (int a = 0; a < corners; ++a) {
        const auto at = std::lower_bound(nodes.begin(), nodes.end(), corner[a]) - nodes.begin();
        for (int k = 0; k < Dim; ++k)
          rows[at * Dim + k] += weight[q] * value[q * corners + a] * direction[s * Dim + k];
      }
    }
    if (means.area[m] > 0.0) means.penalty[m] = means.area[m] / means.penalty[m];
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      double largest = 0.0;
      for (int k = 0; k < Dim; ++k) largest = std::max(largest, std::abs(rows[a * Dim + k]));
      if (largest <= coefficient_tolerance * means.area[m]) continue;
      means.node.push_back(nodes[a]);
      means.row.insert(means.row.end(), rows.begin() + a * Dim, rows.begin() + (a + 1) * Dim);
    }
    means.node_start.push_back(static_cast<std::int64_t>(means.node.size()));
  }
  return means;
}

}  // namespace tilth::boundary
