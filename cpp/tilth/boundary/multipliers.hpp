// SPDX-License-Identifier: BSD-3-Clause
// The multiplier space of implicit boundaries: constants on the parts of a boundary that are
// nearest to its vertices, and the means of the grid's displacement over them.
#pragma once

#include "../grid.hpp"
#include "vertices.hpp"

namespace tilth::boundary {

/// Chooses vertices and gives each direction of each point to the nearest vertex of its family.
template <int Dim>
class MultiplierSpace {
 public:
  MultiplierSpace(const TouchedCells<Dim>& at, const Families& families, const bool* constrained)
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

    const HeldDirections<Dim> prescribed(nodes, constrained);
    HeldDirections<Dim> all(nodes, nullptr);
    std::vector<HeldDirections<Dim>> own(families.families, HeldDirections<Dim>(nodes, nullptr));
    choose(prescribed, all, own, [](std::int64_t, std::int64_t) { return true; }, false);
    assign();
    // where others hold all edges nearby, a family needs vertices all the same
    choose(
        prescribed, all, own,
        [&](std::int64_t f, std::int64_t q) { return vertices_.owner[slot(f, q)] < 0; }, true);
    assign();
    for (std::int64_t f = 0; f < families.families; ++f) gather_rest(f);
    drop_idle();
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

  /// Takes the candidates whose nodes are free in the direction, those with the fewest cut edges
  /// at their nodes first, if `wanted(family, nearest point)`; `alone`: whatever others hold.
  template <class Wanted>
  void choose(const HeldDirections<Dim>& prescribed, HeldDirections<Dim>& all,
              std::vector<HeldDirections<Dim>>& own, Wanted wanted, bool alone) {
    std::vector<std::pair<std::int64_t, std::int64_t>> order;  // family, candidate
    for (std::int64_t f = 0; f < families_.families; ++f)
      for (std::size_t i = 0; i < candidates_[f].size(); ++i)
        if (wanted(f, candidates_[f][i].point)) order.push_back({f, static_cast<std::int64_t>(i)});
    const auto key = [&](const auto& entry) {
      const auto& c = candidates_[entry.first][entry.second];
      return std::make_tuple(c.rank[0], c.rank[1], c.low, c.high, entry.first);
    };
    std::sort(order.begin(), order.end(),
              [&](const auto& a, const auto& b) { return key(a) < key(b); });
    for (const auto& [f, i] : order) {
      const auto& candidate = candidates_[f][i];
      const double* way = direction(f, candidate.point);
      if (!alone && std::max(prescribed.part(candidate.low, way),
                             prescribed.part(candidate.high, way)) > hardly_free)
        continue;
      const auto& before = alone ? own[f] : all;
      if (std::max(before.part(candidate.low, way), before.part(candidate.high, way)) > shared)
        continue;
      for (auto* constrained : {&all, &own[f]}) {
        constrained->hold(candidate.low, way);
        if (candidate.high != candidate.low) constrained->hold(candidate.high, way);
      }
      add_vertex(f, candidate.place, candidate.point);
    }
  }

  void add_vertex(std::int64_t f, const double* place, std::int64_t point) {
    vertices_.family.push_back(f);
    vertices_.place.insert(vertices_.place.end(), place, place + Dim);
    vertices_.point.push_back(point);
  }

  void place_of(std::int64_t c, std::int64_t q, double* place) const {
    const std::int64_t* lowest = at_.lattice + 3 * std::int64_t{at_.node[c << Dim]};
    for (int k = 0; k < Dim; ++k)
      place[k] = static_cast<double>(lowest[k]) + at_.local[q * Dim + k];
  }

  double cosine(std::int64_t q, std::int64_t other) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) sum += at_.normal[q * Dim + k] * at_.normal[other * Dim + k];
    return sum;
  }

  /// Gives the points without an owner to the nearest vertex of their family on the same side, not
  /// more than two cells away along any axis.
  void assign() {
    std::vector<std::pair<std::int64_t, std::int64_t>> sorted;  // key of the cell, vertex
    for (std::int64_t f = 0; f < families_.families; ++f) {
      sorted.clear();
      for (std::size_t v = 0; v < vertices_.family.size(); ++v) {
        if (vertices_.family[v] != f) continue;
        Lattice cell{0, 0, 0};
        for (int k = 0; k < Dim; ++k)
          cell[k] = static_cast<std::int64_t>(std::floor(vertices_.place[v * Dim + k]));
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
    double place[Dim], least = std::numeric_limits<double>::infinity();
    std::int64_t best = -1;
    place_of(c, q, place);
    Lattice own{0, 0, 0};
    for (int k = 0; k < Dim; ++k) own[k] = static_cast<std::int64_t>(std::floor(place[k]));
    for (std::int64_t reach = 1; reach <= 2; ++reach) {
      const std::int64_t layers = Dim == 3 ? reach : 0;
      for (std::int64_t k = -layers; k <= layers; ++k)
        for (std::int64_t j = -reach; j <= reach; ++j) {
          const std::int64_t begin = pack({own[0] - reach, own[1] + j, own[2] + k});
          for (auto at = std::lower_bound(sorted.begin(), sorted.end(),
                                          std::make_pair(begin, std::int64_t{-1}));
               at != sorted.end() && at->first <= begin + 2 * reach; ++at) {
            double apart = 0.0;
            for (int d = 0; d < Dim; ++d) {
              const double way = vertices_.place[at->second * Dim + d] - place[d];
              apart += way * way;
            }
            if (apart >= least || cosine(q, vertices_.point[at->second]) < same_side) continue;
            least = apart, best = at->second;
          }
        }
      if (least < 1.0) break;  // those in cells further away are further
    }
    return best;
  }

  /// Points that no vertex is near to are constrained together with those around them.
  void gather_rest(std::int64_t f) {
    for (std::int64_t c = families_.first_cell[f]; c < families_.end_cell[f]; ++c)
      for (std::int64_t q = at_.start[c]; q < at_.start[c + 1]; ++q) {
        if (vertices_.owner[slot(f, q)] >= 0) continue;
        double place[Dim], other[Dim];
        place_of(c, q, place);
        const auto number = static_cast<std::int64_t>(vertices_.family.size());
        add_vertex(f, place, q);
        for (std::int64_t d = c; d < families_.end_cell[f]; ++d)
          for (std::int64_t p = at_.start[d]; p < at_.start[d + 1]; ++p) {
            place_of(d, p, other);
            double apart = 0.0;
            for (int k = 0; k < Dim; ++k) apart = std::max(apart, std::abs(other[k] - place[k]));
            if (vertices_.owner[slot(f, p)] < 0 && apart <= 1.0 && cosine(p, q) >= same_side)
              vertices_.owner[slot(f, p)] = number;
          }
      }
  }

  /// Drops the vertices that own no point, and numbers the others family by family.
  void drop_idle() {
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
      const auto place = vertices_.place.begin() + v * Dim;
      kept.place.insert(kept.place.end(), place, place + Dim);
    }
    for (const std::int64_t v : vertices_.owner) kept.owner.push_back(number[v]);
    vertices_ = std::move(kept);
  }

  const TouchedCells<Dim>& at_;
  const Families& families_;
  std::vector<std::vector<Candidate<Dim>>> candidates_;
  Vertices<Dim> vertices_;
};

/// Multipliers, and the nodes that the means over them depend on, in ragged rows.
struct Means {
  std::vector<double> area, penalty;  // (multipliers): of the points; the harmonic mean of theirs
  std::vector<std::int64_t> node_start;  // (multipliers + 1)
  std::vector<std::int32_t> node;        // sorted within a multiplier
  std::vector<double> row;               // (entries, Dim): integral of N times the direction
};

/// Integrates over the points of each of `multipliers` owners. `point` (slots) numbers the
/// quadrature point of each slot, `cell_of` (points) its cell, `weight` (points), `direction`
/// (slots, Dim), `penalty` (slots) and `value` (points, 2^Dim) its shape functions.
template <int Dim>
Means integrate_means(std::int64_t multipliers, std::int64_t slots, const std::int64_t* owner,
                      const std::int64_t* point, const std::int64_t* cell_of,
                      const std::int32_t* node, const double* weight, const double* direction,
                      const double* penalty, const double* value) {
  constexpr int corners = 1 << Dim;
  constexpr double negligible = 1e-12;
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
      if (largest <= negligible * means.area[m]) continue;
      means.node.push_back(nodes[a]);
      means.row.insert(means.row.end(), rows.begin() + a * Dim, rows.begin() + (a + 1) * Dim);
    }
    means.node_start.push_back(static_cast<std::int64_t>(means.node.size()));
  }
  return means;
}

}  // namespace tilth::boundary
