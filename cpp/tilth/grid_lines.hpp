// SPDX-License-Identifier: BSD-3-Clause
// Lines of the grid along each direction, at equal distances or listed (graded grids): coordinates
// in cells, and back. Beyond the first and the last listed line the cells next to it go on.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace tilth {

/// Part of an axis, from `low` to `high`.
struct Interval {
  double low, high;
};

/// One direction of the grid.
struct Axis {
  double origin;                 // position of the line with the lattice index 0 [length]
  double size;                   // of its cells, of the smallest one if they differ [length]
  const double* line = nullptr;  // (lines) distances from the origin, ascending from 0
  std::int64_t lines = 0;        // 0 along a uniform axis

  bool graded() const { return lines > 0; }

  /// Size of a cell, by the index of its lower line.
  double width(std::int64_t cell) const {
    return graded() ? line[listed(cell) + 1] - line[listed(cell)] : size;
  }

  double largest_width() const {
    double largest = size;
    for (std::int64_t i = 1; i < lines; ++i) largest = std::max(largest, line[i] - line[i - 1]);
    return largest;
  }

  /// Distance of a line from the origin.
  double distance(std::int64_t index) const {
    if (!graded()) return static_cast<double>(index) * size;
    const std::int64_t cell = listed(index);
    return line[cell] + static_cast<double>(index - cell) * (line[cell + 1] - line[cell]);
  }

  /// Position of a line.
  double at(std::int64_t index) const { return origin + distance(index); }

  /// A position in cells: the index of the line below plus a share of the cell.
  double in_cells(double position) const {
    if (!graded()) return (position - origin) / size;
    return in_cells_like(std::upper_bound(line, line + lines, position - origin) - line - 1,
                         position);
  }

  /// The same if all cells had the size of this one.
  double in_cells_like(std::int64_t cell, double position) const {
    if (!graded()) return (position - origin) / size;
    return static_cast<double>(cell) + (position - origin - distance(cell)) / width(cell);
  }

  /// The ends, in cells, of what is up to `half` [length] away from a position.
  Interval around(double position, double half) const {
    if (graded()) return {in_cells(position - half), in_cells(position + half)};
    const double x = in_cells(position), l = half / size;
    return {x - l, x + l};
  }

 private:
  /// The listed cell that is nearest to a cell.
  std::int64_t listed(std::int64_t cell) const {
    return std::clamp<std::int64_t>(cell, 0, lines - 2);
  }
};

/// The lines of the grid along all directions.
struct GridLines {
  std::array<Axis, 3> axis;

  const Axis& operator[](int direction) const { return axis[direction]; }
};

}  // namespace tilth
