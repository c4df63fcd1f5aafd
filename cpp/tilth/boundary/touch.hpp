// SPDX-License-Identifier: BSD-3-Clause
// Which places of a boundary touch the soil: those inside the ellipsoid around a material point's
// box that goes through the box's corners; and, for points that no place of the boundary reaches
// so, those whose foot along the normal is in the box or no more than half the box's width away
// from it. Boxes that tile a body reach exactly to its faces, however the body is turned; points
// that stand for the cut parts of a body may lie almost a whole spacing from its face. A box may be
// any parallelogram or parallelepiped, given by half its edges.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../grid.hpp"
#include "../parallel.hpp"

namespace tilth::boundary {

/// Points sorted by the cell they lie in: point `order[i]` lies in cell `key[i]`.
struct PointsByCell {
  std::vector<std::int64_t> key;
  std::vector<std::int64_t> order;
};

template <int Dim>
std::int64_t cell_of(const double* place, const double* origin, const double* cell_size) {
  Lattice index{0, 0, 0};
  for (int k = 0; k < Dim; ++k)
    index[k] = static_cast<std::int64_t>(std::floor((place[k] - origin[k]) / cell_size[k]));
  return pack(index);
}

template <int Dim>
PointsByCell sort_by_cell(std::int64_t points, const double* position, const double* origin,
                          const double* cell_size) {
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs(points);
  for (std::int64_t p = 0; p < points; ++p)
    pairs[p] = {cell_of<Dim>(position + Dim * p, origin, cell_size), p};
  if (!std::is_sorted(pairs.begin(), pairs.end())) std::sort(pairs.begin(), pairs.end());
  PointsByCell result;
  result.key.resize(points);
  result.order.resize(points);
  for (std::int64_t i = 0; i < points; ++i) {
    result.key[i] = pairs[i].first;
    result.order[i] = pairs[i].second;
  }
  return result;
}

/// A point's box: half of each edge, a row each, and the inverse, which turns an offset from the
/// point into coordinates that are -1 and 1 on the box's faces.
template <int Dim>
struct Box {
  double edge[Dim][Dim], inverse[Dim][Dim];

  explicit Box(const double* edges) {
    for (int i = 0; i < Dim; ++i)
      for (int k = 0; k < Dim; ++k) edge[i][k] = edges[Dim * i + k];
    double cofactor[Dim][Dim], determinant = 0.0;
    if constexpr (Dim == 2) {
      cofactor[0][0] = edge[1][1];
      cofactor[0][1] = -edge[1][0];
      cofactor[1][0] = -edge[0][1];
      cofactor[1][1] = edge[0][0];
    } else {
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
          const int a = (i + 1) % 3, b = (i + 2) % 3, d = (k + 1) % 3, e = (k + 2) % 3;
          cofactor[i][k] = edge[a][d] * edge[b][e] - edge[a][e] * edge[b][d];
        }
    }
    for (int k = 0; k < Dim; ++k) determinant += edge[0][k] * cofactor[0][k];
    for (int i = 0; i < Dim; ++i)
      for (int k = 0; k < Dim; ++k) inverse[i][k] = cofactor[i][k] / determinant;
  }

  double coordinate(int i, const double* offset) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) sum += inverse[i][k] * offset[k];
    return sum;
  }
};

/// Whether the box at `offset` from a place is beside it: within its sides along the boundary, and
/// at most twice its half width away from the boundary.
template <int Dim>
bool beside(const double* offset, const Box<Dim>& box, const double* normal) {
  double height = 0.0, width = 0.0, along[Dim];
  for (int k = 0; k < Dim; ++k) height += offset[k] * normal[k];
  for (int i = 0; i < Dim; ++i) {
    double part = 0.0;
    for (int k = 0; k < Dim; ++k) part += box.edge[i][k] * normal[k];
    width += std::fabs(part);
  }
  if (std::fabs(height) > 2.0 * width * (1.0 + 1e-9)) return false;
  for (int k = 0; k < Dim; ++k) along[k] = offset[k] - height * normal[k];
  for (int i = 0; i < Dim; ++i)
    if (std::fabs(box.coordinate(i, along)) > 1.0 + 1e-9) return false;
  return true;
}

/// Calls `visit(p, offset, measure)` for all points one cell around a place: `measure` is the
/// square of the distance in units of the point's box.
template <int Dim, class Visit>
void for_points_around(const PointsByCell& sorted, const double* place, const double* position,
                       const std::vector<Box<Dim>>& box, const double* origin,
                       const double* cell_size, Visit&& visit) {
  const Lattice own = unpack(cell_of<Dim>(place, origin, cell_size));
  for (int k = Dim == 3 ? -1 : 0; k <= (Dim == 3 ? 1 : 0); ++k)
    for (int j = -1; j <= 1; ++j) {
      // the three cells of a row along x have consecutive keys
      const auto begin = std::lower_bound(sorted.key.begin(), sorted.key.end(),
                                          pack({own[0] - 1, own[1] + j, own[2] + k}));
      const std::int64_t last = pack({own[0] + 1, own[1] + j, own[2] + k});
      for (auto i = begin - sorted.key.begin();
           i < static_cast<std::ptrdiff_t>(sorted.key.size()) && sorted.key[i] <= last; ++i) {
        const std::int64_t p = sorted.order[i];
        double measure = 0.0, offset[Dim];
        for (int axis = 0; axis < Dim; ++axis)
          offset[axis] = place[axis] - position[Dim * p + axis];
        for (int axis = 0; axis < Dim; ++axis) {
          const double coordinate = box[p].coordinate(axis, offset);
          measure += coordinate * coordinate;
        }
        visit(p, offset, measure);
      }
    }
}

/// Number of the point nearest to each place, in units of its box, among those that it touches; -1
/// where it touches none. `half_edge` has the points' boxes, (points, Dim, Dim), a row for each
/// edge. Looks one cell around the place. Boundary b has the places from
/// `start[b]` to `start[b + 1]`; only in cells in which the ellipsoids reach none of its places
/// does it touch the points that it stands beside.
template <int Dim>
void touching_points(std::int64_t boundaries, const std::int64_t* start, const double* place,
                     const double* normal, std::int64_t points, const double* position,
                     const double* half_edge, const double* origin, const double* cell_size,
                     std::int64_t* nearest) {
  std::vector<Box<Dim>> box;
  box.reserve(points);
  for (std::int64_t p = 0; p < points; ++p) box.emplace_back(half_edge + Dim * Dim * p);
  const PointsByCell sorted = sort_by_cell<Dim>(points, position, origin, cell_size);
  constexpr double reach = Dim * (1.0 + 1e-9), far = 1e300;
  std::vector<std::int64_t> reached;  // keys of the cells
  for (std::int64_t b = 0; b < boundaries; ++b) {
    const std::int64_t begin = start[b], end = start[b + 1];
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q) {
      double least = far;
      nearest[q] = -1;
      for_points_around<Dim>(sorted, place + Dim * q, position, box, origin, cell_size,
                             [&](std::int64_t p, const double*, double measure) {
                               if (measure > reach || measure >= least) return;
                               least = measure;
                               nearest[q] = p;
                             });
    }
    reached.clear();
    for (std::int64_t q = begin; q < end; ++q)
      if (nearest[q] >= 0) reached.push_back(cell_of<Dim>(place + Dim * q, origin, cell_size));
    std::sort(reached.begin(), reached.end());
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q) {
      if (nearest[q] >= 0) continue;
      const std::int64_t key = cell_of<Dim>(place + Dim * q, origin, cell_size);
      if (std::binary_search(reached.begin(), reached.end(), key)) continue;
      double least = far;
      for_points_around<Dim>(sorted, place + Dim * q, position, box, origin, cell_size,
                             [&](std::int64_t p, const double* offset, double measure) {
                               if (measure >= least) return;
                               if (!beside<Dim>(offset, box[p], normal + Dim * q)) return;
                               least = measure;
                               nearest[q] = p;
                             });
    }
  }
}

}  // namespace tilth::boundary
