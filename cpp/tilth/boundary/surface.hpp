// SPDX-License-Identifier: BSD-3-Clause
// Surface form of the implicit boundary method (docs/theory/implicit_boundaries.md): the force
//   f_a = integral of N_a [traction + P (sum_b N_b u_b - value)] over the boundary,
// gathered for all quadrature points that act on the same nodes.
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

/// Fills matrix (elements, n, n, Dim, Dim) and force (elements, n, Dim) of elements of n nodes.
/// Quadrature points `start[e]` to `start[e + 1]` belong to element e and have basis values
/// shape (points, n), penalty P times weight (points, Dim, Dim), and the weighted force at zero
/// displacement (points, Dim).
template <int Dim>
void surface_elements(std::int64_t elements, const std::int64_t* start, int n, const double* shape,
                      const double* penalty, const double* constant, double* matrix,
                      double* force) {
  constexpr int entries = Dim * Dim;
#pragma omp parallel for schedule(static) if (16 * elements >= parallel_from)
  for (std::int64_t e = 0; e < elements; ++e) {
    double* m = matrix + e * n * n * entries;
    double* f = force + e * n * Dim;
    for (std::int64_t i = 0; i < n * n * entries; ++i) m[i] = 0.0;
    for (std::int64_t i = 0; i < n * Dim; ++i) f[i] = 0.0;
    for (std::int64_t q = start[e]; q < start[e + 1]; ++q) {
      const double* N = shape + q * n;
      const double* P = penalty + q * entries;
      for (int a = 0; a < n; ++a) {
        for (int k = 0; k < Dim; ++k) f[a * Dim + k] += N[a] * constant[q * Dim + k];
        for (int b = a; b < n; ++b) {
          const double product = N[a] * N[b];
          double* block = m + (a * n + b) * entries;
          for (int k = 0; k < entries; ++k) block[k] += product * P[k];
        }
      }
    }
    for (int a = 0; a < n; ++a)  // N_a N_b = N_b N_a
      for (int b = 0; b < a; ++b)
        for (int k = 0; k < entries; ++k)
          m[(a * n + b) * entries + k] = m[(b * n + a) * entries + k];
  }
}

}  // namespace tilth::boundary
