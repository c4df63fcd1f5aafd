// SPDX-License-Identifier: BSD-3-Clause
// Surface form of the implicit boundary method (docs/theory/implicit_boundaries.md): the force
//   f_a = integral of N_a [traction + P (sum_b N_b u_b - value)] over the boundary,
// gathered for all quadrature points that act on the same nodes.
#pragma once

#include <cstdint>

#include "../parallel.hpp"

namespace tilth::boundary {

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
        for (int b = 0; b < n; ++b) {
          const double product = N[a] * N[b];
          double* block = m + (a * n + b) * entries;
          for (int k = 0; k < entries; ++k) block[k] += product * P[k];
        }
      }
    }
  }
}

}  // namespace tilth::boundary
