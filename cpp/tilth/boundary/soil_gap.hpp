// SPDX-License-Identifier: BSD-3-Clause
// Gap between a rigid surface and the soil: where lines along the surface's normals enter the union
// of the material points' domains. A line is taken to be slightly thick, so that it does not slip
// through a crack between two domains: each domain is wider across the line than it is, and as long
// along it (docs/theory/contact.md).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "../grid.hpp"
#include "../parallel.hpp"
#include "soil_contact.hpp"

namespace tilth::boundary {

/// The part of a line in a domain: distances along the line from its begin [length], and half the
/// domain's width along the line. `begin` > `end` where the line misses the domain.
struct LinePart {
  double begin = 1.0, end = -1.0, half_width = 0.0;

  /// Extends the part to a crossing.
  void add(double at) {
    const bool first = begin > end;
    begin = first ? at : std::min(begin, at);
    end = first ? at : std::max(end, at);
  }
};

/// Clips a part of a line to |start + s slope| <= limit; returns whether something is left. `slope`
/// is a component of a unit vector.
inline bool clip_to_slab(double start, double slope, double limit, double& from, double& to) {
  if (std::fabs(slope) < 1e-12) return std::fabs(start) <= limit;
  const double one = (-limit - start) / slope, other = (limit - start) / slope;
  from = std::max(from, std::min(one, other)), to = std::min(to, std::max(one, other));
  return from < to;
}

/// Returns the part of a line in the domain p. `offset` is from the domain's centre to the line's
/// begin, `middle` the distance along the line at which it passes the centre. The domain is `wide`
/// times as wide across the line as it is.
template <int Dim>
LinePart part_in_domain(const Boxes<Dim>& box, std::int64_t p, const double* offset,
                        const double* normal, double middle, double wide) {
  constexpr double infinite = std::numeric_limits<double>::max();
  double from = -infinite, to = infinite;
  for (int k = 0; k < Dim; ++k)
    if (!clip_to_slab(offset[k], normal[k], wide * box.half[Dim * p + k], from, to)) return {};
  return {middle + (from - middle) / wide, middle + (to - middle) / wide, box.width(p, normal)};
}

/// Domains by their corners relative to the points, (points, 2^Dim, Dim), x fastest:
/// quadrilaterals, or hexahedra whose faces consist of four triangles around their centre.
template <int Dim>
struct CorneredDomains {
  const double* corner;
};

/// Adds where a line crosses the segment between two points, given by their distances across and
/// along the line from its begin.
inline void cross_segment(const double* a, const double* b, LinePart& part) {
  if ((a[0] < 0.0) == (b[0] < 0.0)) return;
  part.add(a[1] + a[0] / (a[0] - b[0]) * (b[1] - a[1]));
}

/// A place seen along a line: its projection along the line on a coordinate plane, scaled by a
/// factor that is the same for all places, and its distance along the line from the line's begin.
struct Projected {
  double x, y, along;
};

/// Returns twice the signed area of the triangle between the origin and two projections.
inline double area(const Projected& a, const Projected& b) { return a.x * b.y - a.y * b.x; }

/// Adds where a line, projected on the origin, crosses a triangle.
inline void cross_triangle(const Projected& a, const Projected& b, const Projected& c,
                           LinePart& part) {
  const double u = area(b, c), v = area(c, a), w = area(a, b);
  if (!((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0))) return;
  const double sum = u + v + w;
  if (sum == 0.0) return;
  part.add((u * a.along + v * b.along + w * c.along) / sum);
}

inline LinePart part_in_domain(const CorneredDomains<2>& domains, std::int64_t p,
                               const double* offset, const double* normal, double, double wide) {
  const double* corner = domains.corner + 8 * p;
  LinePart part;
  double turned[4][2];  // across and along the line from its begin, of the widened domain
  for (int c = 0; c < 4; ++c) {
    const double* x = corner + 2 * c;
    const double along = x[0] * normal[0] + x[1] * normal[1];
    part.half_width = std::max(part.half_width, std::fabs(along));
    turned[c][0] = wide * (x[1] * normal[0] - x[0] * normal[1]) -
                   (offset[1] * normal[0] - offset[0] * normal[1]);
    turned[c][1] = along - (offset[0] * normal[0] + offset[1] * normal[1]);
  }
  constexpr int next[4] = {1, 3, 0, 2};
  for (int c = 0; c < 4; ++c) cross_segment(turned[c], turned[next[c]], part);
  return part;
}

inline LinePart part_in_domain(const CorneredDomains<3>& domains, std::int64_t p,
                               const double* offset, const double* normal, double, double wide) {
  const double* corner = domains.corner + 24 * p;
  int axis = 0;  // across the plane on which is projected
  for (int k = 1; k < 3; ++k)
    if (std::fabs(normal[k]) > std::fabs(normal[axis])) axis = k;
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const auto seen = [&](const double* x) {
    return Projected{x[i] * normal[axis] - x[axis] * normal[i],
                     x[j] * normal[axis] - x[axis] * normal[j],
                     x[0] * normal[0] + x[1] * normal[1] + x[2] * normal[2]};
  };
  const Projected begin = seen(offset);
  constexpr double infinite = std::numeric_limits<double>::infinity();
  double low[2] = {infinite, infinite}, high[2] = {-infinite, -infinite};
  LinePart part;
  Projected at[8];  // from the line's begin, of the widened domain
  for (int c = 0; c < 8; ++c) {
    const Projected x = seen(corner + 3 * c);
    part.half_width = std::max(part.half_width, std::fabs(x.along));
    at[c] = {wide * x.x - begin.x, wide * x.y - begin.y, x.along - begin.along};
    low[0] = std::min(low[0], at[c].x), high[0] = std::max(high[0], at[c].x);
    low[1] = std::min(low[1], at[c].y), high[1] = std::max(high[1], at[c].y);
  }
  if (low[0] > 0.0 || high[0] < 0.0 || low[1] > 0.0 || high[1] < 0.0) return part;
  for (int k = 0; k < 3; ++k) {
    const int one = 1 << ((k + 1) % 3), other = 1 << ((k + 2) % 3);
    for (int side = 0; side < 2; ++side) {
      const int first = side << k;
      const int ring[4] = {first, first | one, first | one | other, first | other};
      Projected centre{0.0, 0.0, 0.0};
      for (const int c : ring)
        centre.x += 0.25 * at[c].x, centre.y += 0.25 * at[c].y, centre.along += 0.25 * at[c].along;
      for (int c = 0; c < 4; ++c) cross_triangle(centre, at[ring[c]], at[ring[(c + 1) % 4]], part);
    }
  }
  return part;
}

/// The material points sorted by cell, for searches along lines.
template <int Dim>
struct DomainSearch {
  PointsByCell sorted;
  Lattice low{0, 0, 0}, high{0, 0, 0};  // cells with points lie between these
  double within[Dim] = {};              // bounds of the domains' extents along the axes [length]
  double radius = 0.0;                  // and of their distance from the centre
  double wide;                          // factor of the domains' widths across lines
  const double* centre;
  const GridLines& grid;

  /// `half_length`: half the sides of the domains' bounding boxes. `widening`: share by which a
  /// domain is wider across a line than it is.
  DomainSearch(std::int64_t points, const double* point, const double* half_length,
               const GridLines& lines, double widening)
      : sorted(sort_by_cell<Dim>(points, point, lines)),
        wide(1.0 + widening),
        centre(point),
        grid(lines) {
    if (points > 0) low = high = unpack(sorted.key.front());
    for (const std::int64_t key : sorted.key) {
      const Lattice cell = unpack(key);
      for (int k = 0; k < 3; ++k)
        low[k] = std::min(low[k], cell[k]), high[k] = std::max(high[k], cell[k]);
    }
    for (std::int64_t p = 0; p < points; ++p)
      for (int k = 0; k < Dim; ++k) within[k] = std::max(within[k], half_length[Dim * p + k]);
    for (const double each : within) radius += each * each;
    radius = std::sqrt(radius);
    for (double& each : within) each += widening * radius;
    radius *= wide;
  }

  /// Returns the cell along an axis of a coordinate, at most one cell outside of those with points.
  std::int64_t cell(int axis, double coordinate) const {
    const double x = std::floor(grid[axis].in_cells(coordinate));
    return static_cast<std::int64_t>(
        std::clamp(x, static_cast<double>(low[axis] - 1), static_cast<double>(high[axis] + 1)));
  }
};

/// Calls `visit(p, part)` for the domains that a line meets between the distances `from` and `to`.
template <int Dim, class Domains, class Visit>
void for_domains_on_line(const DomainSearch<Dim>& search, const double* position,
                         const double* normal, double from, double to, const Domains& domains,
                         Visit&& visit) {
  const auto& [sorted, lowest, highest, within, radius, wide, centre, grid] = search;
  constexpr double round_off = 1e-9;  // in cells
  const auto cells = [&](int axis, double begin, double end, std::int64_t& low,
                         std::int64_t& high) {
    const double one = position[axis] + begin * normal[axis];
    const double other = position[axis] + end * normal[axis];
    const double margin = within[axis] + round_off * grid[axis].size;
    low = std::max(lowest[axis], search.cell(axis, std::min(one, other) - margin));
    high = std::min(highest[axis], search.cell(axis, std::max(one, other) + margin));
  };
  Lattice low{0, 0, 0}, high{0, 0, 0};
  for (int k = 1; k < Dim; ++k) cells(k, from, to, low[k], high[k]);
  for (std::int64_t k = low[2]; k <= high[2]; ++k)
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      // the part of the line beside this row of cells along x
      double begin = from, end = to;
      const std::int64_t row[3] = {0, j, k};
      bool beside = true;
      for (int d = 1; d < Dim && beside; ++d) {
        const double half = 0.5 * grid[d].width(row[d]), middle = grid[d].at(row[d]) + half;
        beside = clip_to_slab(position[d] - middle, normal[d],
                              half + round_off * grid[d].size + within[d], begin, end);
      }
      if (!beside) continue;
      cells(0, begin, end, low[0], high[0]);
      if (low[0] > high[0]) continue;
      const auto at = std::lower_bound(sorted.key.begin(), sorted.key.end(), pack({low[0], j, k}));
      const std::int64_t last_key = pack({high[0], j, k});
      for (auto i = at - sorted.key.begin();
           i < static_cast<std::ptrdiff_t>(sorted.key.size()) && sorted.key[i] <= last_key; ++i) {
        const std::int64_t p = sorted.order[i];
        double offset[Dim], middle = 0.0;
        for (int d = 0; d < Dim; ++d) {
          offset[d] = position[d] - centre[Dim * p + d];
          middle -= offset[d] * normal[d];
        }
        double squared = 0.0;
        for (int d = 0; d < Dim; ++d) {
          const double across = offset[d] + middle * normal[d];
          squared += across * across;
        }
        if (squared > radius * radius) continue;
        const LinePart part = part_in_domain(domains, p, offset, normal, middle, wide);
        if (part.begin < part.end) visit(p, part);
      }
    }
}

/// Fills `gap` [length] and `owner` of each surface point: the least distance s along its line
/// x + s n, -behind < s < reach, at which the line enters soil, and the material point there. Where
/// there is none the owner is -1 and the gap infinite: negative if x is in soil that the line does
/// not leave between -behind and x, otherwise positive. Holes along the line narrower than half of
/// `behind` and half a domain's width are soil if the line begins in soil.
template <int Dim, class Domains>
void measure_gap(std::int64_t surface_points, const double* position, const double* normal,
                 const double* behind, double reach, const DomainSearch<Dim>& search,
                 const Domains& domains, double* gap, std::int64_t* owner) {
  constexpr double infinite = std::numeric_limits<double>::infinity(), equal = 1e-9;
#pragma omp parallel for schedule(static) if (8 * surface_points >= parallel_from)
  for (std::int64_t q = 0; q < surface_points; ++q) {
    const double start = -behind[q], closing = 0.5 * behind[q];
    const auto visit_all = [&](auto&& visit) {
      for_domains_on_line<Dim>(search, position + Dim * q, normal + Dim * q, start - closing, reach,
                               domains, visit);
    };
    const auto distance_from_line = [&](std::int64_t p) {
      const double *x = position + Dim * q, *n = normal + Dim * q, *c = search.centre + Dim * p;
      double along = 0.0, squared = 0.0;
      for (int k = 0; k < Dim; ++k) along += (c[k] - x[k]) * n[k];
      for (int k = 0; k < Dim; ++k) {
        const double across = c[k] - x[k] - along * n[k];
        squared += across * across;
      }
      return squared;
    };
    const auto joined = [&](const LinePart& part, double end) {
      return part.begin <= end + std::min(closing, part.half_width);
    };
    double end = -infinite, entry = infinite, least = infinite;  // `end` of the soil at the start
    std::int64_t found = -1;
    const auto try_entry = [&](std::int64_t p, const LinePart& part) {
      if (part.begin <= start || part.begin >= reach || joined(part, end)) return;
      const double tolerance = equal * part.half_width;
      if (part.begin > entry + tolerance) return;
      const double across = distance_from_line(p);
      if (part.begin < entry - tolerance || across < least) least = across, found = p;
      entry = std::min(entry, part.begin);
    };
    visit_all([&](std::int64_t p, const LinePart& part) {
      if (part.begin <= start)
        end = std::max(end, part.end);
      else
        try_entry(p, part);
    });
    if (end > start - closing) {  // the line may begin in soil: find where it leaves it
      for (double before = -infinite; end > before && end < reach;) {
        before = end;
        visit_all([&](std::int64_t, const LinePart& part) {
          if (joined(part, end)) end = std::max(end, part.end);
        });
      }
      entry = least = infinite, found = -1;
      visit_all(try_entry);
    }
    owner[q] = found;
    gap[q] = found >= 0 ? entry : (end > 0.0 ? -infinite : infinite);
  }
}

}  // namespace tilth::boundary
