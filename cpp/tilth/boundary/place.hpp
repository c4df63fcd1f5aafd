// SPDX-License-Identifier: BSD-3-Clause
// Places on the active grid that are no material points: the cell that each acts on, its shape
// functions, and sums over them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "../grid.hpp"
#include "../parallel.hpp"

namespace tilth::boundary {

/// Fills the key of each place's cell, and the place from the cell's lowest node in cells (n, Dim).
/// The cell is the one the place lies in; where this is none of the sorted `cell_keys`, the nearest
/// of those around it; of cells as near, such as two that share the face a place lies on, the one
/// whose centre is nearer. Its own where there is none.
template <int Dim>
void cells_of_places(std::int64_t places, const double* place, const double* origin,
                     const double* cell_size, std::int64_t cells, const std::int64_t* cell_keys,
                     std::int64_t* key, double* local) {
  const auto known = [&](std::int64_t wanted) {
    return std::binary_search(cell_keys, cell_keys + cells, wanted);
  };
#pragma omp parallel for schedule(static) if (8 * places >= parallel_from)
  for (std::int64_t q = 0; q < places; ++q) {
    double scaled[Dim];
    Lattice own{0, 0, 0};
    for (int k = 0; k < Dim; ++k) {
      scaled[k] = (place[q * Dim + k] - origin[k]) / cell_size[k];
      own[k] = static_cast<std::int64_t>(std::floor(scaled[k]));
    }
    Lattice best = own;
    if (!known(pack(own))) {
      double least = std::numeric_limits<double>::infinity();
      for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
          for (int k = Dim == 3 ? -1 : 0; k <= (Dim == 3 ? 1 : 0); ++k) {
            const Lattice cell{own[0] + i, own[1] + j, own[2] + k};
            if (!known(pack(cell))) continue;
            double outside = 0.0, from_centre = 0.0;
            for (int d = 0; d < Dim; ++d) {
              const double off = std::fabs(scaled[d] - (static_cast<double>(cell[d]) + 0.5));
              from_centre += off * off;
              outside += std::max(off - 0.5, 0.0) * std::max(off - 0.5, 0.0);
            }
            const double distance = std::sqrt(outside) + 1e-6 * std::sqrt(from_centre);
            if (distance < least) least = distance, best = cell;
          }
    }
    key[q] = pack(best);
    for (int k = 0; k < Dim; ++k) local[q * Dim + k] = scaled[k] - static_cast<double>(best[k]);
  }
}

/// A cell's shape functions (n, 2^Dim) at places (n, Dim) from its lowest node, in cells; and,
/// unless `gradient` is null, their gradients [1/length] (n, 2^Dim, Dim). Corners are x fastest.
template <int Dim>
void shape_functions(std::int64_t places, const double* local, const double* cell_size,
                     double* value, double* gradient) {
  constexpr int corners = 1 << Dim;
#pragma omp parallel for schedule(static) if (places >= parallel_from)
  for (std::int64_t q = 0; q < places; ++q)
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
        double slope = ((c >> k) & 1 ? 1.0 : -1.0) / cell_size[k];
        for (int j = 0; j < Dim; ++j)
          if (j != k) slope *= hat[j];
        gradient[(q * corners + c) * Dim + k] = slope;
      }
    }
}

/// Places grouped by cell: those of cell c are `start[c]` to `start[c + 1]`, `node` (cells, n) its
/// corners, `value` (places, n) the shape functions.
struct PlacesOfCells {
  std::int64_t cells;
  int nodes;
  const std::int64_t* start;
  const std::int32_t* node;
  const double* value;
};

/// Fills `vector` (places, components) with sum_a N_a nodal_a, `nodal` (nodes, components).
inline void interpolate(const PlacesOfCells& at, int components, const double* nodal,
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
inline void scatter(const PlacesOfCells& at, int components, const double* vector, double* nodal) {
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
