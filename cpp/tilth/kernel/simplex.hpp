// SPDX-License-Identifier: BSD-3-Clause
// Triangles and tetrahedra, cut along the lines or planes of the grid, by which the parts of a
// domain in each cell are found exactly. Coordinates are lengths in units of one cell (LocalLines).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "../grid_lines.hpp"
#include "cell_shares.hpp"

namespace tilth::kernel {

/// Vertices of a triangle or a tetrahedron.
template <int Dim>
using Simplex = std::array<std::array<double, Dim>, Dim + 1>;

/// Calls `below(part)` and `above(part)` for parts of a simplex on both sides of the plane
/// x[axis] = at: one edge that crosses the plane is cut in two, and so both halves of the simplex.
template <int Dim, class Below, class Above>
void split(const Simplex<Dim>& simplex, int axis, double at, Below&& below, Above&& above) {
  int under = -1, over = -1;
  for (int v = 0; v <= Dim; ++v) {
    if (simplex[v][axis] < at) under = v;
    if (simplex[v][axis] > at) over = v;
  }
  if (over < 0) return below(simplex);
  if (under < 0) return above(simplex);
  const auto &from = simplex[under], &to = simplex[over];
  const double t = (at - from[axis]) / (to[axis] - from[axis]);
  std::array<double, Dim> middle;
  for (int k = 0; k < Dim; ++k) middle[k] = from[k] + t * (to[k] - from[k]);
  middle[axis] = at;
  Simplex<Dim> half = simplex;
  half[over] = middle;
  split<Dim>(half, axis, at, below, above);
  half = simplex;
  half[under] = middle;
  split<Dim>(half, axis, at, below, above);
}

/// The lines of the grid from the corner of a cell on, in units of this cell's size.
struct LocalLines {
  const GridLines& grid;
  const Lattice& low;  // the cell

  /// Coordinate of the i-th line from the corner.
  double line(int direction, std::int64_t i) const {
    const Axis& axis = grid[direction];
    if (!axis.graded()) return static_cast<double>(i);
    return (axis.distance(low[direction] + i) - axis.distance(low[direction])) /
           axis.width(low[direction]);
  }

  /// Size of the i-th cell.
  double width(int direction, std::int64_t i) const {
    const Axis& axis = grid[direction];
    return axis.graded() ? axis.width(low[direction] + i) / axis.width(low[direction]) : 1.0;
  }

  /// The cell that contains a coordinate, not negative on a graded axis.
  std::int64_t cell(int direction, double x) const {
    if (!grid[direction].graded()) return static_cast<std::int64_t>(std::floor(x));
    std::int64_t i = 0;
    while (x >= line(direction, i + 1)) ++i;
    return i;
  }
};

/// Calls `visit(part, cell)` for parts of a simplex that each lie in one cell.
template <int Dim, class Visit>
void divide_among_cells(const Simplex<Dim>& simplex, const LocalLines& lines,
                        std::array<std::int64_t, Dim>& cell, Visit&& visit, int axis = 0) {
  if (axis == Dim) return visit(simplex, cell);
  double low = simplex[0][axis], high = low;
  for (const auto& vertex : simplex) {
    low = std::min(low, vertex[axis]);
    high = std::max(high, vertex[axis]);
  }
  const std::int64_t first = lines.cell(axis, low);
  const double next = lines.line(axis, first + 1);
  const auto below = [&](const Simplex<Dim>& part) {
    cell[axis] = first;
    divide_among_cells<Dim>(part, lines, cell, visit, axis + 1);
  };
  if (high <= next) return below(simplex);
  split<Dim>(simplex, axis, next, below, [&](const Simplex<Dim>& part) {
    divide_among_cells<Dim>(part, lines, cell, visit, axis);
  });
}

/// Volume of a simplex, negative if its vertices are in the other order.
template <int Dim>
double volume_of(const Simplex<Dim>& s) {
  double edge[Dim][Dim];
  for (int v = 0; v < Dim; ++v)
    for (int k = 0; k < Dim; ++k) edge[v][k] = s[v + 1][k] - s[0][k];
  if constexpr (Dim == 2) {
    return 0.5 * (edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0]);
  } else {
    return (edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) -
            edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0]) +
            edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0])) /
           6.0;
  }
}

/// Adds the integrals over a simplex of the functions of `moments_of` to `moment`; their
/// coordinates are those in `cell`.
template <int Dim>
void add_moments(const Simplex<Dim>& s, const LocalLines& lines,
                 const std::array<std::int64_t, Dim>& cell, double* moment) {
  const double volume = volume_of<Dim>(s);
  double sum[Dim] = {}, x[Dim + 1][Dim];
  for (int v = 0; v <= Dim; ++v)
    for (int k = 0; k < Dim; ++k) {
      x[v][k] = (s[v][k] - lines.line(k, cell[k])) / lines.width(k, cell[k]);
      sum[k] += x[v][k];
    }
  moment[0] += volume;
  for (int k = 0; k < Dim; ++k) moment[1 + k] += volume * sum[k] / (Dim + 1);
  if constexpr (Dim == 3)
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      double products = sum[i] * sum[j];
      for (int v = 0; v <= Dim; ++v) products += x[v][i] * x[v][j];
      moment[4 + k] += volume * products / 20.0;
    }
}

/// Calls `visit(simplex)` for the triangles or tetrahedra of a domain with these corners: one for
/// each order of the directions, along which it goes from the first corner to the last.
template <int Dim, class Visit>
void for_simplices(const std::array<double, Dim>* corner, Visit&& visit) {
  int order[Dim];
  for (int k = 0; k < Dim; ++k) order[k] = k;
  do {
    Simplex<Dim> simplex;
    int at = 0, inversions = 0;
    simplex[0] = corner[0];
    for (int k = 0; k < Dim; ++k) {
      at |= 1 << order[k];
      simplex[k + 1] = corner[at];
      for (int j = 0; j < k; ++j) inversions += order[j] > order[k];
    }
    if (inversions % 2 == 1) std::swap(simplex[0], simplex[1]);
    visit(simplex);
  } while (std::next_permutation(order, order + Dim));
}

}  // namespace tilth::kernel
