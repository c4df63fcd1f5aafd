// SPDX-License-Identifier: BSD-3-Clause
// Which places of a boundary touch the soil: those inside the ellipsoid around a material point's
// box that goes through the box's corners; and, for points that no place of the boundary reaches
// so, those whose foot along the normal is in the box or no more than half the box's width away
// from it. Boxes that tile a body reach exactly to its faces, however the body is turned; points
// that stand for the cut parts of a body may lie almost a whole spacing from its face.
#pragma once

#include <algorithm>
#include <array>
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

/// Boxes along the grid's axes: half their sides, (points, Dim).
template <int Dim>
struct Boxes {
  const double* half;

  /// Component k of a place in units of half the sides.
  double along(std::int64_t p, int k, const double* offset) const {
    return offset[k] / half[Dim * p + k];
  }

  /// Square of the distance in units of the box.
  double measure(std::int64_t p, const double* offset) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k)
      sum += offset[k] * offset[k] / (half[Dim * p + k] * half[Dim * p + k]);
    return sum;
  }

  /// Half the width along an axis of the ellipsoid that the sides touch.
  double half_width(std::int64_t p, int axis) const { return half[Dim * p + axis]; }

  /// Half the width across a boundary.
  double width(std::int64_t p, const double* normal) const {
    double sum = 0.0;
    for (int k = 0; k < Dim; ++k) sum += half[Dim * p + k] * std::fabs(normal[k]);
    return sum;
  }

  bool holds(std::int64_t p, const double* offset) const {
    for (int k = 0; k < Dim; ++k)
      if (std::fabs(offset[k]) > half[Dim * p + k] * (1.0 + 1e-9)) return false;
    return true;
  }
};

/// Parallelepipeds: half their edges, (points, Dim, Dim) with an edge in each row, and the inverse
/// of the matrices with an edge in each column.
template <int Dim>
struct Parallelepipeds {
  const double* edge;
  const double* inverse;

  /// Component k of a place in units of the half edges.
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

  bool holds(std::int64_t p, const double* offset) const {
    for (int k = 0; k < Dim; ++k)
      if (std::fabs(along(p, k, offset)) > 1.0 + 1e-9) return false;
    return true;
  }
};

/// Whether a domain at `offset` from a place stands on it: within its sides along the boundary, in
/// the plane within the ellipse that its sides touch, so that a row of boxes covers as much of a
/// boundary as it is long, however the row is turned.
template <int Dim, class Extent>
bool facing(const Extent& extent, std::int64_t p, const double* offset, const double* normal) {
  double height = 0.0, foot[Dim];
  for (int k = 0; k < Dim; ++k) height += offset[k] * normal[k];
  for (int k = 0; k < Dim; ++k) foot[k] = offset[k] - height * normal[k];
  return Dim == 2 ? extent.measure(p, foot) <= 1.0 + 2e-9 : extent.holds(p, foot);
}

/// Whether a domain at `offset` from a place is beside it: within its sides along the boundary, and
/// at most twice its half width away from the boundary.
template <int Dim, class Extent>
bool beside(const Extent& extent, std::int64_t p, const double* offset, const double* normal) {
  double height = 0.0;
  for (int k = 0; k < Dim; ++k) height += offset[k] * normal[k];
  return std::fabs(height) <= 2.0 * extent.width(p, normal) * (1.0 + 1e-9) &&
         facing<Dim>(extent, p, offset, normal);
}

/// Calls `visit(p, offset, measure)` for the points at most `around` cells around a place that are
/// no further from it along each axis than `within`: `measure` is the square of the distance in
/// units of the point's domain.
template <int Dim, class Extent, class Visit>
void for_points_around(const PointsByCell& sorted, const double* place, const double* within,
                       const double* position, const Extent& extent, const std::int64_t* around,
                       const double* origin, const double* cell_size, Visit&& visit) {
  Lattice own{0, 0, 0}, low{0, 0, 0}, high{0, 0, 0};
  for (int axis = 0; axis < Dim; ++axis) {
    const double x = (place[axis] - origin[axis]) / cell_size[axis];
    const double reach = within[axis] / cell_size[axis] * (1.0 + 1e-6);
    own[axis] = static_cast<std::int64_t>(std::floor(x));
    const double inside = x - static_cast<double>(own[axis]);
    const auto below = static_cast<std::int64_t>(std::floor(inside - reach - 1e-6));
    const auto above = static_cast<std::int64_t>(std::floor(inside + reach + 1e-6));
    low[axis] = std::max(-around[axis], below);
    high[axis] = std::min(around[axis], above);
  }
  for (std::int64_t k = low[2]; k <= high[2]; ++k)
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      // the cells of a row along x have consecutive keys
      const auto begin = std::lower_bound(sorted.key.begin(), sorted.key.end(),
                                          pack({own[0] + low[0], own[1] + j, own[2] + k}));
      const std::int64_t last = pack({own[0] + high[0], own[1] + j, own[2] + k});
      for (auto i = begin - sorted.key.begin();
           i < static_cast<std::ptrdiff_t>(sorted.key.size()) && sorted.key[i] <= last; ++i) {
        const std::int64_t p = sorted.order[i];
        double offset[Dim];
        bool far = false;
        for (int axis = 0; axis < Dim; ++axis) {
          offset[axis] = place[axis] - position[Dim * p + axis];
          far = far || std::fabs(offset[axis]) > within[axis] * (1.0 + 1e-6);
        }
        if (!far) visit(p, offset, extent.measure(p, offset));
      }
    }
}

/// Whether a place has others of the `known` ones on all sides within `radius` cells: they pull it
/// hardly more to one side than to the other.
template <int Dim>
bool is_surrounded(const PointsByCell& known, const double* place, const double* places,
                   const double* origin, const double* cell_size, double radius) {
  Lattice low{0, 0, 0}, high{0, 0, 0};
  for (int k = 0; k < Dim; ++k) {
    const double x = (place[k] - origin[k]) / cell_size[k];
    low[k] = static_cast<std::int64_t>(std::floor(x - radius));
    high[k] = static_cast<std::int64_t>(std::floor(x + radius));
  }
  double pull[Dim] = {};
  int count = 0;
  for (std::int64_t k = low[2]; k <= high[2]; ++k)
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      const std::int64_t last = pack({high[0], j, k});
      auto at = std::lower_bound(known.key.begin(), known.key.end(), pack({low[0], j, k})) -
                known.key.begin();
      for (; at < static_cast<std::ptrdiff_t>(known.key.size()) && known.key[at] <= last; ++at) {
        const double* other = places + Dim * known.order[at];
        double way[Dim], square = 0.0;
        for (int d = 0; d < Dim; ++d) {
          way[d] = (other[d] - place[d]) / cell_size[d];
          square += way[d] * way[d];
        }
        if (square > radius * radius || square == 0.0) continue;
        const double length = std::sqrt(square);
        for (int d = 0; d < Dim; ++d) pull[d] += way[d] / length;
        ++count;
      }
    }
  double size = 0.0;
  for (int d = 0; d < Dim; ++d) size += pull[d] * pull[d];
  return count > 1 && std::sqrt(size) <= 0.5 * count;
}

/// Places that are touched, and their numbers by cell.
struct TouchedPlaces {
  std::vector<double> place;
  PointsByCell by_cell;
};

/// Of the places `begin` to `end` those with a `nearest` point.
template <int Dim>
TouchedPlaces touched_places(std::int64_t begin, std::int64_t end, const double* place,
                             const std::int64_t* nearest, const double* origin,
                             const double* cell_size) {
  TouchedPlaces touched;
  for (std::int64_t q = begin; q < end; ++q)
    if (nearest[q] >= 0)
      touched.place.insert(touched.place.end(), place + Dim * q, place + Dim * (q + 1));
  const auto count = static_cast<std::int64_t>(touched.place.size() / Dim);
  touched.by_cell = sort_by_cell<Dim>(count, touched.place.data(), origin, cell_size);
  return touched;
}

/// Lengths along the axes that no half width of an ellipsoid through a box's corners exceeds.
template <int Dim, class Extent>
std::array<double, Dim> longest_half_widths(std::int64_t points, const Extent& extent) {
  std::array<double, Dim> longest{};
  for (std::int64_t p = 0; p < points; ++p)
    for (int k = 0; k < Dim; ++k) longest[k] = std::max(longest[k], extent.half_width(p, k));
  for (double& each : longest) each *= std::sqrt(Dim * (1.0 + 1e-9));
  return longest;
}

/// Number of the point nearest to each place, in units of its domain, among those that it touches;
/// -1 where it touches none. Looks `around` cells (Dim) around the place. Boundary b has the places
/// from `start[b]` to `start[b + 1]`. Where the ellipsoids reach none of its places in a cell, or
/// leave a gap between places that they reach, it touches the points that it stands beside.
template <int Dim, class Extent>
void touching_points(std::int64_t boundaries, const std::int64_t* start, const double* place,
                     const double* normal, const PointsByCell& sorted, const double* position,
                     const Extent& extent, const std::int64_t* around, const double* origin,
                     const double* cell_size, std::int64_t* nearest) {
  constexpr double reach = Dim * (1.0 + 1e-9), far = 1e300;
  const auto within = longest_half_widths<Dim>(sorted.order.size(), extent);
  double all[Dim];
  for (int k = 0; k < Dim; ++k) all[k] = static_cast<double>(around[k] + 1) * cell_size[k];
  for (std::int64_t b = 0; b < boundaries; ++b) {
    const std::int64_t begin = start[b], end = start[b + 1];
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q) {
      double least = far;
      nearest[q] = -1;
      for_points_around<Dim>(sorted, place + Dim * q, within.data(), position, extent, around,
                             origin, cell_size,
                             [&](std::int64_t p, const double* offset, double measure) {
                               if (measure > reach || measure >= least) return;
                               if (!facing<Dim>(extent, p, offset, normal + Dim * q)) return;
                               least = measure;
                               nearest[q] = p;
                             });
    }
    const TouchedPlaces touched =
        touched_places<Dim>(begin, end, place, nearest, origin, cell_size);
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q) {
      if (nearest[q] >= 0) continue;
      const std::int64_t key = cell_of<Dim>(place + Dim * q, origin, cell_size);
      const auto& known = touched.by_cell;
      if (std::binary_search(known.key.begin(), known.key.end(), key) &&
          !is_surrounded<Dim>(known, place + Dim * q, touched.place.data(), origin, cell_size, 1.0))
        continue;
      double least = far;
      for_points_around<Dim>(sorted, place + Dim * q, all, position, extent, around, origin,
                             cell_size, [&](std::int64_t p, const double* offset, double measure) {
                               if (measure >= least) return;
                               if (!beside<Dim>(extent, p, offset, normal + Dim * q)) return;
                               least = measure;
                               nearest[q] = p;
                             });
    }
  }
}

/// Whether each of the places is touched, as are all in its cell and those around it, and the
/// boundary goes on to all sides: their mean is close to that of the cell.
template <int Dim>
std::vector<char> find_amid(std::int64_t places, const double* place, const std::int64_t* nearest,
                            const double* origin, const double* cell_size) {
  struct Cell {
    std::int64_t key, first, count;
    bool whole;
    double sum[Dim];
  };
  constexpr double close = 0.25;  // in cells
  const PointsByCell sorted = sort_by_cell<Dim>(places, place, origin, cell_size);
  std::vector<Cell> cells;
  for (std::int64_t i = 0; i < places; ++i) {
    if (cells.empty() || cells.back().key != sorted.key[i])
      cells.push_back({sorted.key[i], i, 0, true, {}});
    Cell& cell = cells.back();
    const std::int64_t q = sorted.order[i];
    ++cell.count, cell.whole = cell.whole && nearest[q] >= 0;
    for (int d = 0; d < Dim; ++d) cell.sum[d] += place[Dim * q + d] / cell_size[d];
  }
  std::vector<char> amid(places, 0);
  for (const Cell& cell : cells) {
    const Lattice own = unpack(cell.key);
    double sum[Dim] = {}, apart = 0.0;
    std::int64_t count = 0;
    bool all = true;
    for (std::int64_t k = Dim == 3 ? -1 : 0; k <= (Dim == 3 ? 1 : 0); ++k)
      for (std::int64_t j = -1; j <= 1; ++j) {
        const std::int64_t last = pack({own[0] + 1, own[1] + j, own[2] + k});
        auto at =
            std::lower_bound(cells.begin(), cells.end(), pack({own[0] - 1, own[1] + j, own[2] + k}),
                             [](const Cell& a, std::int64_t key) { return a.key < key; });
        for (; at != cells.end() && at->key <= last; ++at) {
          all = all && at->whole, count += at->count;
          for (int d = 0; d < Dim; ++d) sum[d] += at->sum[d];
        }
      }
    for (int d = 0; d < Dim; ++d) {
      const double way = sum[d] / count - cell.sum[d] / cell.count;
      apart += way * way;
    }
    all = all && count > cell.count && apart <= close * close;
    for (std::int64_t i = cell.first; i < cell.first + cell.count; ++i) amid[sorted.order[i]] = all;
  }
  return amid;
}

/// What part of a line from `offset` (from a domain's centre) along `edge`, both (Dim), touches the
/// domain: from and to in units of the edge, within 0 and 1; from > to where none.
template <int Dim, class Extent>
std::pair<double, double> touched_part(const Extent& extent, std::int64_t p, const double* offset,
                                       const double* edge, const double* normal) {
  double from = 0.0, to = 1.0;
  const auto stay_near = [&](const double* start, const double* way, double limit) {
    double half[Dim], end[Dim];  // the square of the distance is quadratic along the line
    for (int k = 0; k < Dim; ++k) half[k] = start[k] + 0.5 * way[k], end[k] = start[k] + way[k];
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
  stay_near(offset, edge, Dim * (1.0 + 1e-9));
  if constexpr (Dim == 2) {  // as in `facing`
    stay_near(foot, along, 1.0 + 2e-9);
  } else {
    for (int k = 0; k < Dim; ++k) {
      const double start = extent.along(p, k, foot), way = extent.along(p, k, along);
      if (std::fabs(way) < 1e-12) {
        if (std::fabs(start) > 1.0 + 1e-9) to = -1.0;
        continue;
      }
      const double one = (-1.0 - 1e-9 - start) / way, other = (1.0 + 1e-9 - start) / way;
      from = std::max(from, std::min(one, other)), to = std::min(to, std::max(one, other));
    }
  }
  return {from, to};
}

/// Integral of 1 - slope * s over the union of intervals of s, which are sorted on return.
inline double integrate_union(std::vector<std::pair<double, double>>& intervals, double slope) {
  std::sort(intervals.begin(), intervals.end());
  double sum = 0.0, reached = -1e300;
  for (const auto& interval : intervals) {
    const double from = std::max(interval.first, reached), to = interval.second;
    if (to <= from) continue;
    sum += (to - from) * (1.0 - 0.5 * slope * (from + to));
    reached = to;
  }
  return sum;
}

/// The share of each place's `part` that domains touch, between 0 and 1: 1 amid others that touch.
/// The part, (n, Dim, Dim): from the place to a corner, and the edges from there, of a segment, or
/// in space of the quadrangle between a corner, the middles of two sides and
/// the centroid, which is c + s a + t b - s t (a + b) / 3. `nearest` as `touching_points` found it;
/// a place that is not touched itself, and some of whose part is, gets the domain there.
template <int Dim, class Extent>
void covered_shares(std::int64_t boundaries, const std::int64_t* start, const double* place,
                    const double* normal, const double* part, const PointsByCell& sorted,
                    const double* position, const Extent& extent, const std::int64_t* around,
                    const double* origin, const double* cell_size, std::int64_t* nearest,
                    double* share) {
  constexpr int lines = Dim == 2 ? 1 : 4;  // in space, along the middles of strips of the part
  constexpr double far = 1e300, none = 0.1, whole = 1.0 - 1e-6;
  constexpr double beside = Dim == 2 ? 0.3 : 0.5;  // about a piece of a boundary, in cells
  const auto within = longest_half_widths<Dim>(sorted.order.size(), extent);
  for (std::int64_t b = 0; b < boundaries; ++b) {
    const std::int64_t begin = start[b], end = start[b + 1];
    const std::vector<char> amid =
        find_amid<Dim>(end - begin, place + Dim * begin, nearest + begin, origin, cell_size);
    const TouchedPlaces touched =
        touched_places<Dim>(begin, end, place, nearest, origin, cell_size);
#pragma omp parallel for schedule(static) if (8 * (end - begin) >= parallel_from)
    for (std::int64_t q = begin; q < end; ++q) {
      const double* own = place + Dim * q;
      share[q] = nearest[q] >= 0 ? 1.0 : 0.0;
      if (amid[q - begin]) continue;
      if (nearest[q] >= 0 &&
          is_surrounded<Dim>(touched.by_cell, own, touched.place.data(), origin, cell_size, beside))
        continue;
      const double* corner = part + Dim * Dim * q;
      const double* edge = corner + Dim;
      double sum = 0.0, least = far;
      std::int64_t closest = -1;
      std::vector<std::pair<double, double>> intervals;
      for (int line = 0; line < lines; ++line) {
        const double t = (line + 0.5) / lines;
        double way[Dim], middle[Dim], reach[Dim];
        for (int k = 0; k < Dim; ++k) {
          way[k] = edge[k], middle[k] = own[k] + corner[k];
          if constexpr (Dim == 3)
            way[k] -= t * (edge[k] + edge[Dim + k]) / 3.0, middle[k] += t * edge[Dim + k];
          middle[k] += 0.5 * way[k];
          reach[k] = within[k] + 0.5 * std::fabs(way[k]);
        }
        intervals.clear();
        for_points_around<Dim>(sorted, middle, reach, position, extent, around, origin, cell_size,
                               [&](std::int64_t p, const double* offset, double measure) {
                                 double begin_of[Dim];
                                 for (int k = 0; k < Dim; ++k)
                                   begin_of[k] = offset[k] - 0.5 * way[k];
                                 const auto interval =
                                     touched_part<Dim>(extent, p, begin_of, way, normal + Dim * q);
                                 if (interval.first > interval.second) return;
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
      if (sum <= none) continue;  // what a domain stands beside counts as a whole
      share[q] = sum < whole ? sum : 1.0;
      if (nearest[q] < 0) nearest[q] = closest;
    }
  }
}

}  // namespace tilth::boundary
