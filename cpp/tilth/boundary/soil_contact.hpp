// SPDX-License-Identifier: BSD-3-Clause
// Which quadrature points of a boundary are in contact with soil. A quadrature point is in contact
// with a material point if it lies in the ellipsoid through the corners of the material point's
// box. Where this finds none, it is in contact if its projection along the normal lies in the box
// or at most half the box's width from it. Boxes that tile a body end exactly at its faces, also if
// the body is rotated; material points of the cut parts of a body may lie almost a spacing from its
// face.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../caught.hpp"
#include "../grid.hpp"
#include "../grid_lines.hpp"
#include "../parallel.hpp"
#include "nearby_layers.hpp"

namespace tilth::boundary {

/// Points sorted by cell: point `order[i]` lies in cell `key[i]`, and cell `cell[c]` begins at
/// `first[c]`: to look for it among the cells is quicker than among the points.
struct PointsByCell {
  std::vector<std::int64_t> key, order, cell, first;

  /// Returns the first place in `order` whose cell has this or a larger key.
  std::int64_t place_of(std::int64_t wanted) const {
    return first[std::lower_bound(cell.begin(), cell.end(), wanted) - cell.begin()];
  }
};

template <int Dim>
std::int64_t cell_of(const double* position, const GridLines& grid) {
  Lattice index{0, 0, 0};
  for (int k = 0; k < Dim; ++k)
    index[k] = static_cast<std::int64_t>(std::floor(grid[k].in_cells(position[k])));
  return pack(index);
}

template <int Dim>
PointsByCell sort_by_cell(std::int64_t points, const double* position, const GridLines& grid) {
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs(points);
  for (std::int64_t p = 0; p < points; ++p) pairs[p] = {cell_of<Dim>(position + Dim * p, grid), p};
  if (!std::is_sorted(pairs.begin(), pairs.end())) std::sort(pairs.begin(), pairs.end());
  PointsByCell result;
  result.key.reserve(points), result.order.reserve(points);
  for (const auto& [key, p] : pairs) {
    if (result.key.empty() || key != result.key.back())
      result.cell.push_back(key), result.first.push_back(std::ssize(result.key));
    result.key.push_back(key), result.order.push_back(p);
  }
  result.first.push_back(points);
  return result;
}

/// Boxes along the grid's axes, by half of their sides, (points, Dim).
template <int Dim>
struct Boxes {
  const double* half;

  /// Returns component k of an offset from the centre in units of half the sides.
  double along(std::int64_t p, int k, const double* offset) const {
    return offset[k] / half[Dim * p + k];
  }

  /// Returns the square of the distance from the centre in units of the box.
  double measure(std::int64_t p, const double* offset) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k)
      sum += offset[k] * offset[k] / (half[Dim * p + k] * half[Dim * p + k]);
    return sum;
  }

  /// Returns half the width of the inscribed ellipsoid along an axis.
  double half_width(std::int64_t p, int axis) const { return half[Dim * p + axis]; }

  /// Returns half the width of the box along a normal.
  double width(std::int64_t p, const double* normal) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) sum += half[Dim * p + k] * std::fabs(normal[k]);
    return sum;
  }

  bool contains(std::int64_t p, const double* offset) const {
    for (int k = 0; k < Dim; ++k)
      if (std::fabs(offset[k]) > half[Dim * p + k] * (1.0 + 1e-9)) return false;
    return true;
  }
};

/// Parallelepipeds, by half of their edges, (points, Dim, Dim) with an edge in each row, and the
/// inverses of the matrices with an edge in each column. The functions are those of `Boxes`.
template <int Dim>
struct Parallelepipeds {
  const double* edge;
  const double* inverse;

  /// Returns component k of an offset from the centre in units of the half edges.
  double along(std::int64_t p, int k, const double* offset) const {
    const double* row = inverse + Dim * (Dim * p + k);
    double sum = 0.0;
    for (int i = 0; i < Dim; ++i) sum += row[i] * offset[i];
    return sum;
  }

  double measure(std::int64_t p, const double* offset) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) sum += along(p, k, offset) * along(p, k, offset);
    return sum;
  }

  double half_width(std::int64_t p, int axis) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) {
      const double along_axis = edge[Dim * (Dim * p + k) + axis];
      sum += along_axis * along_axis;
    }
    return std::sqrt(sum);
  }

  double width(std::int64_t p, const double* normal) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) {
      double across = 0.0;
      for (int i = 0; i < Dim; ++i) across += edge[Dim * (Dim * p + k) + i] * normal[i];
      sum += std::fabs(across);
    }
    return sum;
  }

  bool contains(std::int64_t p, const double* offset) const {
    for (int k = 0; k < Dim; ++k)
      if (std::fabs(along(p, k, offset)) > 1.0 + 1e-9) return false;
    return true;
  }
};

/// Returns whether the projection of `offset`, from a domain's centre, onto the boundary lies in
/// the domain; in the plane in the ellipse that is inscribed in the domain, so that a row of boxes
/// at any angle is in contact with as much of a boundary as it is long.
template <int Dim, class Extent>
bool facing(const Extent& extent, std::int64_t p, const double* offset, const double* normal) {
  double height = 0.0, foot[Dim];
  for (int k = 0; k < Dim; ++k) height += offset[k] * normal[k];
  for (int k = 0; k < Dim; ++k) foot[k] = offset[k] - height * normal[k];
  return Dim == 2 ? extent.measure(p, foot) <= 1.0 + 2e-9 : extent.contains(p, foot);
}

/// Returns whether a domain is adjacent to the boundary at `offset` from its centre: `facing`, and
/// at most twice its half width away along the normal.
template <int Dim, class Extent>
bool adjacent(const Extent& extent, std::int64_t p, const double* offset, const double* normal) {
  double height = 0.0;
  for (int k = 0; k < Dim; ++k) height += offset[k] * normal[k];
  return std::fabs(height) <= 2.0 * extent.width(p, normal) * (1.0 + 1e-9) &&
         facing<Dim>(extent, p, offset, normal);
}

/// Calls `visit(p, offset, measure)` for the material points in the `nearby` layers of a position
/// that are at most `within` [length] away from it along each axis: `measure` is the square of the
/// distance in units of the material point's domain.
template <int Dim, class Extent, class Visit>
void for_points_around(const PointsByCell& sorted, const double* position, const double* within,
                       const double* centre, const Extent& extent, const NearbyLayers& nearby,
                       const GridLines& grid, Visit&& visit) {
  Lattice low{0, 0, 0}, high{0, 0, 0};
  for (int axis = 0; axis < Dim; ++axis) {
    const auto reach = grid[axis].around(position[axis], within[axis] * (1.0 + 1e-6));
    const auto own = static_cast<std::int64_t>(std::floor(grid[axis].in_cells(position[axis])));
    const auto below = static_cast<std::int64_t>(std::floor(reach.low - 1e-6));
    const auto above = static_cast<std::int64_t>(std::floor(reach.high + 1e-6));
    const auto layers = nearby.of(axis, own);
    low[axis] = std::max(layers.low, below);
    high[axis] = std::min(layers.high, above);
  }
  for (std::int64_t k = low[2]; k <= high[2]; ++k)
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      // the cells of a row along x have consecutive keys
      const std::int64_t last = pack({high[0], j, k});
      for (auto i = sorted.place_of(pack({low[0], j, k}));
           i < static_cast<std::ptrdiff_t>(sorted.key.size()) && sorted.key[i] <= last; ++i) {
        const std::int64_t p = sorted.order[i];
        double offset[Dim];
        bool too_far = false;
        for (int axis = 0; axis < Dim; ++axis) {
          offset[axis] = position[axis] - centre[Dim * p + axis];
          too_far = too_far || std::fabs(offset[axis]) > within[axis] * (1.0 + 1e-6);
        }
        if (!too_far) visit(p, offset, extent.measure(p, offset));
      }
    }
}

/// Returns whether a position has `neighbours` on all sides within `radius` cells: the mean of the
/// unit vectors towards them is at most 1/2 long.
template <int Dim>
bool is_surrounded(const PointsByCell& neighbours, const double* position, const double* points,
                   const GridLines& grid, double radius) {
  Lattice low{0, 0, 0}, high{0, 0, 0};
  double cell_size[Dim];
  for (int k = 0; k < Dim; ++k) {
    const auto own = static_cast<std::int64_t>(std::floor(grid[k].in_cells(position[k])));
    cell_size[k] = grid[k].width(own);
    const auto reach = grid[k].around(position[k], radius * cell_size[k]);
    low[k] = static_cast<std::int64_t>(std::floor(reach.low));
    high[k] = static_cast<std::int64_t>(std::floor(reach.high));
  }
  double sum[Dim] = {};
  int count = 0;
  for (std::int64_t k = low[2]; k <= high[2]; ++k)
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      const std::int64_t last = pack({high[0], j, k});
      auto at = neighbours.place_of(pack({low[0], j, k}));
      for (; at < static_cast<std::ptrdiff_t>(neighbours.key.size()) && neighbours.key[at] <= last;
           ++at) {
        const double* other = points + Dim * neighbours.order[at];
        double vector[Dim], square = 0.0;
        for (int d = 0; d < Dim; ++d) {
          vector[d] = (other[d] - position[d]) / cell_size[d];
          square += vector[d] * vector[d];
        }
        if (square > radius * radius || square == 0.0) continue;
        const double length = std::sqrt(square);
        for (int d = 0; d < Dim; ++d) sum[d] += vector[d] / length;
        ++count;
      }
    }
  double size = 0.0;
  for (int d = 0; d < Dim; ++d) size += sum[d] * sum[d];
  return count > 1 && std::sqrt(size) <= 0.5 * count;
}

/// Quadrature points in contact with soil: their positions, and their numbers by cell.
struct PointsInContact {
  std::vector<double> position;
  PointsByCell by_cell;
};

/// Returns those of the quadrature points `begin` to `end` that have a `nearest` material point.
template <int Dim>
PointsInContact points_in_contact(std::int64_t begin, std::int64_t end, const double* position,
                                  const std::int64_t* nearest, const GridLines& grid) {
  PointsInContact in_contact;
  for (std::int64_t q = begin; q < end; ++q)
    if (nearest[q] >= 0)
      in_contact.position.insert(in_contact.position.end(), position + Dim * q,
                                 position + Dim * (q + 1));
  const auto count = static_cast<std::int64_t>(in_contact.position.size() / Dim);
  in_contact.by_cell = sort_by_cell<Dim>(count, in_contact.position.data(), grid);
  return in_contact;
}

/// Returns upper bounds of the half widths of the ellipsoids through the domains' corners [length].
template <int Dim, class Extent>
std::array<double, Dim> longest_half_widths(std::int64_t points, const Extent& extent) {
  std::array<double, Dim> longest{};
  for (std::int64_t p = 0; p < points; ++p)
    for (int k = 0; k < Dim; ++k) longest[k] = std::max(longest[k], extent.half_width(p, k));
  for (double& each : longest) each *= std::sqrt(Dim * (1.0 + 1e-9));
  return longest;
}

/// Fills `nearest` with the number of the material point in contact with each quadrature point, the
/// nearest one in units of its domain, or -1 without contact. The search extends over the `nearby`
/// layers. Boundary b has the quadrature points `start[b]` to `start[b + 1]`. Where no
/// quadrature point in a cell lies in an ellipsoid, or a gap remains between those that do, the
/// contact is with the adjacent domains (`adjacent`).
template <int Dim, class Extent>
void find_contact(std::int64_t boundaries, const std::int64_t* start, const double* position,
                  const double* normal, const PointsByCell& sorted, const double* centre,
                  const Extent& extent, const NearbyLayers& nearby, const GridLines& grid,
                  std::int64_t* nearest) {
  constexpr double limit = Dim * (1.0 + 1e-9), infinite = 1e300;
  const auto within = longest_half_widths<Dim>(sorted.order.size(), extent);
  for (std::int64_t b = 0; b < boundaries; ++b) {
    const std::int64_t begin = start[b], end = start[b + 1];
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q) {
      double least = infinite;
      nearest[q] = -1;
      for_points_around<Dim>(sorted, position + Dim * q, within.data(), centre, extent, nearby,
                             grid, [&](std::int64_t p, const double* offset, double measure) {
                               if (measure > limit || measure >= least) return;
                               if (!facing<Dim>(extent, p, offset, normal + Dim * q)) return;
                               least = measure;
                               nearest[q] = p;
                             });
    }
    const PointsInContact in_contact = points_in_contact<Dim>(begin, end, position, nearest, grid);
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q) {
      if (nearest[q] >= 0) continue;
      const std::int64_t key = cell_of<Dim>(position + Dim * q, grid);
      const auto& neighbours = in_contact.by_cell;
      if (std::binary_search(neighbours.cell.begin(), neighbours.cell.end(), key) &&
          !is_surrounded<Dim>(neighbours, position + Dim * q, in_contact.position.data(), grid,
                              1.0))
        continue;
      double least = infinite;
      for_points_around<Dim>(sorted, position + Dim * q, nearby.farthest.data(), centre, extent,
                             nearby, grid,
                             [&](std::int64_t p, const double* offset, double measure) {
                               if (measure >= least) return;
                               if (!adjacent<Dim>(extent, p, offset, normal + Dim * q)) return;
                               least = measure;
                               nearest[q] = p;
                             });
    }
  }
}

/// Returns which quadrature points are in the interior of the contact area: all points of their
/// cell and of the neighbouring cells are in contact, and the boundary extends to all sides, which
/// holds if the mean position of all these points is close to that of the cell's points.
template <int Dim>
std::vector<char> find_interior(std::int64_t points, const double* position,
                                const std::int64_t* nearest, const GridLines& grid) {
  struct Cell {
    std::int64_t key, first, count;
    bool complete;
    double sum[Dim];
  };
  constexpr double close = 0.25;  // in cells
  const PointsByCell sorted = sort_by_cell<Dim>(points, position, grid);
  std::vector<Cell> cells;
  for (std::int64_t i = 0; i < points; ++i) {
    if (cells.empty() || cells.back().key != sorted.key[i])
      cells.push_back({sorted.key[i], i, 0, true, {}});
    Cell& cell = cells.back();
    const std::int64_t q = sorted.order[i];
    ++cell.count, cell.complete = cell.complete && nearest[q] >= 0;
    for (int d = 0; d < Dim; ++d) cell.sum[d] += grid[d].in_cells(position[Dim * q + d]);
  }
  std::vector<char> interior(points, 0);
  for (const Cell& cell : cells) {
    const Lattice own = unpack(cell.key);
    double sum[Dim] = {}, squared_distance = 0.0;
    std::int64_t count = 0;
    bool all = true;
    for (std::int64_t k = Dim == 3 ? -1 : 0; k <= (Dim == 3 ? 1 : 0); ++k)
      for (std::int64_t j = -1; j <= 1; ++j) {
        const std::int64_t last = pack({own[0] + 1, own[1] + j, own[2] + k});
        auto at =
            std::lower_bound(cells.begin(), cells.end(), pack({own[0] - 1, own[1] + j, own[2] + k}),
                             [](const Cell& a, std::int64_t key) { return a.key < key; });
        for (; at != cells.end() && at->key <= last; ++at) {
          all = all && at->complete, count += at->count;
          for (int d = 0; d < Dim; ++d) sum[d] += at->sum[d];
        }
      }
    for (int d = 0; d < Dim; ++d) {
      const double offset = sum[d] / count - cell.sum[d] / cell.count;
      squared_distance += offset * offset;
    }
    all = all && count > cell.count && squared_distance <= close * close;
    for (std::int64_t i = cell.first; i < cell.first + cell.count; ++i)
      interior[sorted.order[i]] = all;
  }
  return interior;
}

/// Returns the part of a line from `offset` (from a domain's centre) along `edge`, both (Dim), that
/// is in contact with the domain: begin and end in units of the edge, 0 to 1; begin > end for none.
template <int Dim, class Extent>
std::pair<double, double> contact_interval(const Extent& extent, std::int64_t p,
                                           const double* offset, const double* edge,
                                           const double* normal) {
  double from = 0.0, to = 1.0;
  const auto clip = [&](const double* start, const double* vector, double limit) {
    double half[Dim], end[Dim];  // the square of the distance is quadratic along the line
    for (int k = 0; k < Dim; ++k)
      half[k] = start[k] + 0.5 * vector[k], end[k] = start[k] + vector[k];
    const double at_start = extent.measure(p, start), at_end = extent.measure(p, end);
    const double a = 2.0 * (at_start + at_end - 2.0 * extent.measure(p, half));
    const double b = at_end - at_start - a, c = at_start - limit, root = b * b - 4.0 * a * c;
    if (a <= 1e-12 * (at_start + at_end)) {  // the line has no length along the domain
      if (c > 0.0) to = -1.0;
    } else if (root < 0.0) {
      to = -1.0;
    } else {
      from = std::max(from, (-b - std::sqrt(root)) / (2.0 * a));
      to = std::min(to, (-b + std::sqrt(root)) / (2.0 * a));
    }
  };
  double foot[Dim], along[Dim], height = 0.0, rise = 0.0;
  for (int k = 0; k < Dim; ++k) height += offset[k] * normal[k], rise += edge[k] * normal[k];
  for (int k = 0; k < Dim; ++k)
    foot[k] = offset[k] - height * normal[k], along[k] = edge[k] - rise * normal[k];
  clip(offset, edge, Dim * (1.0 + 1e-9));
  if constexpr (Dim == 2) {  // as in `facing`
    clip(foot, along, 1.0 + 2e-9);
  } else {
    for (int k = 0; k < Dim; ++k) {
      const double start = extent.along(p, k, foot), vector = extent.along(p, k, along);
      if (std::fabs(vector) < 1e-12) {
        if (std::fabs(start) > 1.0 + 1e-9) to = -1.0;
        continue;
      }
      const double one = (-1.0 - 1e-9 - start) / vector, other = (1.0 + 1e-9 - start) / vector;
      from = std::max(from, std::min(one, other)), to = std::min(to, std::max(one, other));
    }
  }
  return {from, to};
}

/// Returns the integral of 1 - slope * s over the union of intervals of s, which it sorts.
inline double integrate_union(std::vector<std::pair<double, double>>& intervals, double slope) {
  std::sort(intervals.begin(), intervals.end());
  double sum = 0.0, covered_to = -1e300;
  for (const auto& interval : intervals) {
    const double from = std::max(interval.first, covered_to), to = interval.second;
    if (to <= from) continue;
    sum += (to - from) * (1.0 - 0.5 * slope * (from + to));
    covered_to = to;
  }
  return sum;
}

/// Fills `fraction` with the fraction of each quadrature point's tributary area that is in contact
/// with domains, 0 to 1; 1 in the interior of the contact area. The tributary `part` (n, Dim, Dim)
/// is a segment, or in space the quadrangle c + s a + t b - s t (a + b) / 3 between a corner, the
/// middles of two sides and the centroid of a triangle: its rows are the vector from the point to a
/// corner and the edges from there. `nearest` is the result of `find_contact`; a point without
/// contact whose tributary area is partly in contact is assigned the domain there.
template <int Dim, class Extent>
void contact_fractions(std::int64_t boundaries, const std::int64_t* start, const double* position,
                       const double* normal, const double* part, const PointsByCell& sorted,
                       const double* centre, const Extent& extent, const NearbyLayers& nearby,
                       const GridLines& grid, std::int64_t* nearest, double* fraction) {
  constexpr int lines = Dim == 2 ? 1 : 4;  // in space, along the middles of strips of the part
  constexpr double infinite = 1e300, negligible = 0.1, complete = 1.0 - 1e-6;
  constexpr double spacing = Dim == 2 ? 0.3 : 0.5;  // of a boundary's quadrature points, in cells
  const auto within = longest_half_widths<Dim>(sorted.order.size(), extent);
  for (std::int64_t b = 0; b < boundaries; ++b) {
    const std::int64_t begin = start[b], end = start[b + 1];
    const std::vector<char> interior =
        find_interior<Dim>(end - begin, position + Dim * begin, nearest + begin, grid);
    const PointsInContact in_contact = points_in_contact<Dim>(begin, end, position, nearest, grid);
    Caught caught;
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q)
      caught.run([&] {
        const double* own = position + Dim * q;
        fraction[q] = nearest[q] >= 0 ? 1.0 : 0.0;
        if (interior[q - begin]) return;
        if (nearest[q] >= 0 &&
            is_surrounded<Dim>(in_contact.by_cell, own, in_contact.position.data(), grid, spacing))
          return;
        const double* corner = part + Dim * Dim * q;
        const double* edge = corner + Dim;
        double sum = 0.0, least = infinite;
        std::int64_t closest = -1;
        std::vector<std::pair<double, double>> intervals;
        for (int line = 0; line < lines; ++line) {
          const double t = (line + 0.5) / lines;
          double vector[Dim], middle[Dim], limit[Dim];
          for (int k = 0; k < Dim; ++k) {
            vector[k] = edge[k], middle[k] = own[k] + corner[k];
            if constexpr (Dim == 3)
              vector[k] -= t * (edge[k] + edge[Dim + k]) / 3.0, middle[k] += t * edge[Dim + k];
            middle[k] += 0.5 * vector[k];
            limit[k] = within[k] + 0.5 * std::fabs(vector[k]);
          }
          intervals.clear();
          for_points_around<Dim>(sorted, middle, limit, centre, extent, nearby, grid,
                                 [&](std::int64_t p, const double* offset, double measure) {
                                   double begin_of[Dim];
                                   for (int k = 0; k < Dim; ++k)
                                     begin_of[k] = offset[k] - 0.5 * vector[k];
                                   const auto interval = contact_interval<Dim>(
                                       extent, p, begin_of, vector, normal + Dim * q);
                                   if (!(interval.first <= interval.second)) return;
                                   intervals.push_back(interval);
                                   if (measure < least) least = measure, closest = p;
                                 });
          if constexpr (Dim == 2) {
            sum += integrate_union(intervals, 0.0);
          } else {  // area of a strip of the quadrangle, that of the whole is 2/3
            const double base = 1.0 - t / 3.0;
            sum += 1.5 / lines * base * integrate_union(intervals, 1.0 / (3.0 * base));
          }
        }
        if (sum <= negligible) return;  // contact with an adjacent domain is complete
        fraction[q] = sum < complete ? sum : 1.0;
        if (nearest[q] < 0) nearest[q] = closest;
      });
    caught.rethrow();
  }
}

}  // namespace tilth::boundary
