// SPDX-License-Identifier: BSD-3-Clause
// The penalty of the implicit boundary method (docs/theory/implicit_boundaries.md).
#pragma once

#include <cstdint>

#include "../parallel.hpp"

namespace tilth::boundary {

/// Fills `penalty` (points, Dim, Dim) [stress/length]: `square` times Pi Q Pi, with the projector
/// Pi (points, Dim, Dim) and the acoustic tensor Q of the `moduli` (points, 2), constrained and
/// shear, across the unit `normal` (points, Dim).
template <int Dim>
void boundary_penalty(std::int64_t points, const double* normal, const double* projector,
                      const double* moduli, const double* square, double* penalty) {
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t q = 0; q < points; ++q) {
    const double *n = normal + q * Dim, *pi = projector + q * Dim * Dim;
    const double shear = moduli[2 * q + 1], more = moduli[2 * q] - shear;
    double half[Dim][Dim];  // Q Pi
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j) {
        double along = 0.0;
        for (int k = 0; k < Dim; ++k) along += n[k] * pi[k * Dim + j];
        half[i][j] = shear * pi[i * Dim + j] + more * n[i] * along;
      }
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j) {
        double sum = 0.0;
        for (int k = 0; k < Dim; ++k) sum += pi[i * Dim + k] * half[k][j];
        penalty[(q * Dim + i) * Dim + j] = square[q] * sum;
      }
  }
}

}  // namespace tilth::boundary
