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

/// Fills the key of each point's cell and the point's local coordinates (points, Dim), in cells
/// from the cell's lowest node. The cell is the one that contains the point if it is among the
/// sorted `cell_keys`, otherwise the nearest of its neighbours among them. Of two equally near
/// cells, for example with a common face on which the point lies, the one with the nearer centre is
/// taken. A point without such a cell is assigned to the cell that contains it.
template <int Dim>
void locate_in_cells(std::int64_t points, const double* position, const GridLines& grid,
                     std::int64_t cells, const std::int64_t* cell_keys, std::int64_t* key,
                     double* local) {
  const auto has_soil = [&](std::int64_t key) {
    return std::binary_search(cell_keys, cell_keys + cells, key);
  };
#pragma omp parallel for schedule(static) if (8 * points >= parallel_from)
  for (std::int64_t q = 0; q < points; ++q) {
    double scaled[Dim];
    Lattice lattice{0, 0, 0};
    for (int k = 0; k < Dim; ++k) {
      scaled[k] = grid[k].in_cells(position[q * Dim + k]);
      lattice[k] = static_cast<std::int64_t>(std::floor(scaled[k]));
    }
    Lattice best = lattice;
    if (!has_soil(pack(lattice))) {
      double least = std::numeric_limits<double>::infinity();
      for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
          for (int k = Dim == 3 ? -1 : 0; k <= (Dim == 3 ? 1 : 0); ++k) {
            const Lattice cell{lattice[0] + i, lattice[1] + j, lattice[2] + k};
            if (!has_soil(pack(cell))) continue;
            double outside = 0.0, from_centre = 0.0;
            for (int d = 0; d < Dim; ++d) {
              const double from_middle =
                  std::fabs(scaled[d] - (static_cast<double>(cell[d]) + 0.5));
              from_centre += from_middle * from_middle;
              outside += std::max(from_middle - 0.5, 0.0) * std::max(from_middle - 0.5, 0.0);
            }
            const double distance = std::sqrt(outside) + 1e-6 * std::sqrt(from_centre);
            if (distance < least) least = distance, best = cell;
          }
    }
    key[q] = pack(best);
    for (int k = 0; k < Dim; ++k)
      local[q * Dim + k] =
          grid[k].in_cells_like(best[k], position[q * Dim + k]) - static_cast<double>(best[k]);
  }
}

/// Fills a cell's shape functions (points, 2^Dim) at local coordinates (points, Dim), in cells from
/// its lowest node, and, unless `gradient` is null, their gradients [1/length] (points, 2^Dim,
/// Dim). Corners are numbered with x fastest; `size` (points, Dim) is that of the points' cells.
template <int Dim>
void shape_functions(std::int64_t points, const double* local, const double* size, double* value,
                     double* gradient) {
  constexpr int corners = 1 << Dim;
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t q = 0; q < points; ++q)
    for (int c = 0; c < corners; ++c) {
      double hat[Dim], product = 1.0;
      for (int k = 0; k < Dim; ++k) {
        const double x = local[q * Dim + k];
        hat[k] = (c >> k) & 1 ? x : 1.0 - x;
        product *= hat[k];
      }
      value[q * corners + c] = product;
      if (gradient == nullptr) continue;
      for (int k = 0; k < Dim; ++k) {
        double derivative = ((c >> k) & 1 ? 1.0 : -1.0) / size[q * Dim + k];
        for (int j = 0; j < Dim; ++j)
          if (j != k) derivative *= hat[j];
        gradient[(q * corners + c) * Dim + k] = derivative;
      }
    }
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
