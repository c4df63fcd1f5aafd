// SPDX-License-Identifier: BSD-3-Clause
// Cuts segments (2D) and triangles (3D) at the lines or planes of the grid: each piece lies in one
// cell.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "../grid_lines.hpp"

namespace tilth::boundary {

template <int Dim>
using Point = std::array<double, Dim>;

/// A segment, or a convex polygon in space.
template <int Dim>
using Shape = std::vector<Point<Dim>>;

/// Pieces: their corners, flat, and the facet that each was cut from.
struct Pieces {
  std::vector<double> corner;
  std::vector<std::int64_t> facet;
};

/// Distance from a grid line, in cells, up to which a corner lies on the line.
inline constexpr double line_tolerance = 1e-12;
/// The same distance relative to the coordinates, whose round-off is larger far from the origin.
inline constexpr double relative_line_tolerance = 4.0 * std::numeric_limits<double>::epsilon();

/// Appends to `low` and `high` the parts of a shape on either side of x[axis] = `line`.
template <int Dim>
void split(const Shape<Dim>& shape, int axis, double line, double tolerance, Shape<Dim>& low,
           Shape<Dim>& high) {
  const std::size_t corners = shape.size();
  const std::size_t edges = Dim == 2 ? 1 : corners;  // a segment is not closed
  for (std::size_t i = 0; i < corners; ++i) {
    const Point<Dim>& start = shape[i];
    const double start_distance = start[axis] - line;
    if (start_distance <= tolerance) low.push_back(start);
    if (start_distance >= -tolerance) high.push_back(start);
    if (i >= edges) continue;
    const Point<Dim>& end = shape[(i + 1) % corners];
    const double end_distance = end[axis] - line;
    if (std::min(start_distance, end_distance) >= -tolerance ||
        std::max(start_distance, end_distance) <= tolerance)
      continue;
    Point<Dim> crossing;
    for (int k = 0; k < Dim; ++k)
      crossing[k] =
          start[k] + start_distance / (start_distance - end_distance) * (end[k] - start[k]);
    crossing[axis] = line;
    low.push_back(crossing);
    high.push_back(crossing);
  }
}

/// Cuts a shape at the grid lines of `axis` and of the later axes and adds its pieces as simplices.
template <int Dim>
void cut_shape(const Shape<Dim>& shape, int axis, const GridLines& grid, std::int64_t facet,
               Pieces& pieces) {
  if (static_cast<int>(shape.size()) < Dim) return;
  if (axis == Dim) {
    for (std::size_t i = 1; i + 1 < std::max<std::size_t>(shape.size(), 3); ++i) {
      const std::array<std::size_t, 3> corners{0, i, i + 1};
      for (int c = 0; c < Dim; ++c)
        pieces.corner.insert(pieces.corner.end(), shape[corners[c]].begin(),
                             shape[corners[c]].end());
      pieces.facet.push_back(facet);
    }
    return;
  }
  double least = shape[0][axis], greatest = shape[0][axis];
  for (const auto& corner : shape) {
    least = std::min(least, corner[axis]);
    greatest = std::max(greatest, corner[axis]);
  }
  const Axis& lines = grid[axis];
  const double largest = std::max({std::abs(least), std::abs(greatest), std::abs(lines.origin)});
  const double tolerance = std::max(line_tolerance * lines.size, relative_line_tolerance * largest);
  auto number = static_cast<std::int64_t>(std::floor(lines.in_cells(least + tolerance))) + 1;
  Shape<Dim> remainder = shape;
  for (; lines.at(number) < greatest - tolerance; ++number) {
    Shape<Dim> low, high;
    split<Dim>(remainder, axis, lines.at(number), tolerance, low, high);
    cut_shape<Dim>(low, axis + 1, grid, facet, pieces);
    remainder = std::move(high);
  }
  cut_shape<Dim>(remainder, axis + 1, grid, facet, pieces);
}

/// Returns the pieces of facets with the corners `corner` (facets, Dim, Dim).
template <int Dim>
Pieces cut_simplices(std::int64_t facets, const double* corner, const GridLines& grid) {
  Pieces pieces;
  for (std::int64_t f = 0; f < facets; ++f) {
    Shape<Dim> shape(Dim);
    for (int c = 0; c < Dim; ++c)
      for (int k = 0; k < Dim; ++k) shape[c][k] = corner[(f * Dim + c) * Dim + k];
    cut_shape<Dim>(shape, 0, grid, f, pieces);
  }
  return pieces;
}

}  // namespace tilth::boundary
