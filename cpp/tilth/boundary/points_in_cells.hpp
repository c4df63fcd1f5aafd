// SPDX-License-Identifier: BSD-3-Clause
// Quadrature points in cells of the active grid: the cell of each, its shape functions,
// interpolation of nodal values and integration to the nodes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "../grid.hpp"
#include "../grid_lines.hpp"
#include "../parallel.hpp"

namespace tilth::boundary {

/// The sorted keys of cells with soil on a grid.
struct CellsWithSoil {
  const GridLines& grid;
  std::int64_t count;
  const std::int64_t* key;

  bool has(std::int64_t sought) const { return std::binary_search(key, key + count, sought); }
};

/// Returns the cell of a position (Dim) and fills its local coordinates (Dim), in cells from the
/// cell's lowest node. The cell is the one that contains the position if it has soil, otherwise the
/// nearest of its neighbours with soil. Of two equally near cells, for example with a common face
/// on which the position lies, the one with the nearer centre is taken. A position without such a
/// cell is assigned to the cell that contains it. `shift` is what the overlay of the
/// soil adds to keys.
template <int Dim>
Lattice find_cell(const double* position, const CellsWithSoil& cells, std::int64_t shift,
                  double* local) {
  double scaled[Dim];
  Lattice lattice{0, 0, 0};
  for (int k = 0; k < Dim; ++k) {
    scaled[k] = cells.grid[k].in_cells(position[k]);
    lattice[k] = static_cast<std::int64_t>(std::floor(scaled[k]));
  }
  Lattice best = lattice;
  if (!cells.has(pack(lattice) + shift)) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = Dim == 3 ? -1 : 0; k <= (Dim == 3 ? 1 : 0); ++k) {
          const Lattice cell{lattice[0] + i, lattice[1] + j, lattice[2] + k};
          if (!cells.has(pack(cell) + shift)) continue;
          double outside = 0.0, from_centre = 0.0;
          for (int d = 0; d < Dim; ++d) {
            const double from_middle = std::fabs(scaled[d] - (static_cast<double>(cell[d]) + 0.5));
            from_centre += from_middle * from_middle;
            outside += std::max(from_middle - 0.5, 0.0) * std::max(from_middle - 0.5, 0.0);
          }
          const double distance = std::sqrt(outside) + 1e-6 * std::sqrt(from_centre);
          if (distance < least) least = distance, best = cell;
        }
  }
  for (int k = 0; k < Dim; ++k)
    local[k] = cells.grid[k].in_cells_like(best[k], position[k]) - static_cast<double>(best[k]);
  return best;
}

/// Fills the key of each point's cell and its local coordinates in it (points, Dim), see
/// `find_cell`.
template <int Dim>
void locate_in_cells(std::int64_t points, const double* position, const CellsWithSoil& cells,
                     std::int64_t* key, double* local) {
#pragma omp parallel for schedule(static) if (8 * points >= parallel_from)
  for (std::int64_t q = 0; q < points; ++q)
    key[q] = pack(find_cell<Dim>(position + q * Dim, cells, 0, local + q * Dim));
}

/// Fills a cell's shape functions (2^Dim) at local coordinates (Dim), in cells from its lowest
/// node, and, unless `gradient` is null, their gradients [1/length] (2^Dim, Dim). Corners are
/// numbered with x fastest; `size` (Dim) is that of the cell.
template <int Dim>
void shape_functions_at(const double* local, const double* size, double* value, double* gradient) {
  for (int c = 0; c < 1 << Dim; ++c) {
    double hat[Dim], product = 1.0;
    for (int k = 0; k < Dim; ++k) {
      hat[k] = (c >> k) & 1 ? local[k] : 1.0 - local[k];
      product *= hat[k];
    }
    value[c] = product;
    if (gradient == nullptr) continue;
    for (int k = 0; k < Dim; ++k) {
      double derivative = ((c >> k) & 1 ? 1.0 : -1.0) / size[k];
      for (int j = 0; j < Dim; ++j)
        if (j != k) derivative *= hat[j];
      gradient[c * Dim + k] = derivative;
    }
  }
}

/// The same at many points: `local` and `size` (points, Dim), `value` (points, 2^Dim), `gradient`
/// (points, 2^Dim, Dim).
template <int Dim>
void shape_functions(std::int64_t points, const double* local, const double* size, double* value,
                     double* gradient) {
  constexpr int corners = 1 << Dim;
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t q = 0; q < points; ++q)
    shape_functions_at<Dim>(local + q * Dim, size == nullptr ? nullptr : size + q * Dim,
                            value + q * corners,
                            gradient == nullptr ? nullptr : gradient + q * corners * Dim);
}

/// Points ordered by cell: cell c has the points `start[c]` to `start[c + 1]` and the corners
/// `node` (cells, nodes); `value` (points, nodes) are the shape functions.
struct PointsInCells {
  std::int64_t cells;
  int nodes;
  const std::int64_t* start;
  const std::int32_t* node;
  const double* value;
};

/// Fills `vector` (points, components) with sum_a N_a nodal_a, `nodal` (nodes, components).
inline void interpolate(const PointsInCells& at, int components, const double* nodal,
                        double* vector) {
#pragma omp parallel for schedule(static) if (at.start[at.cells] >= parallel_from)
  for (std::int64_t c = 0; c < at.cells; ++c)
    for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q)
      for (int k = 0; k < components; ++k) {
        double sum = 0.0;
        for (int a = 0; a < at.nodes; ++a)
          sum += at.value[q * at.nodes + a] *
                 nodal[components * std::int64_t{at.node[c * at.nodes + a]} + k];
        vector[q * components + k] = sum;
      }
}

/// Adds sum_q N_qa vector_q to `nodal` (nodes, components).
inline void scatter(const PointsInCells& at, int components, const double* vector, double* nodal) {
  for (std::int64_t c = 0; c < at.cells; ++c)
    for (int a = 0; a < at.nodes; ++a)
      for (int k = 0; k < components; ++k) {
        double sum = 0.0;
        for (std::int64_t q = at.start[c]; q < at.start[c + 1]; ++q)
          sum += at.value[q * at.nodes + a] * vector[q * components + k];
        nodal[components * std::int64_t{at.node[c * at.nodes + a]} + k] += sum;
      }
}

}  // namespace tilth::boundary
