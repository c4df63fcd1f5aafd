// SPDX-License-Identifier: BSD-3-Clause
// Displacement gradient of the step at the points of one body; in axisymmetry with the hoop strain
// u_r / r at [2][2].
#pragma once

#include <cstdint>

#include "../parallel.hpp"
#include "basis_values.hpp"

namespace tilth::kernel {

/// Displacement gradient of one point; `u` are the displacements of its nodes.
template <class K, int Capacity>
void displacement_gradient(int n, const double u[K::dim][Capacity], const double* value,
                           const double* gradient, const double* position, double h[3][3]) {
  for (int i = 0; i < K::dim; ++i)
    for (int j = 0; j < K::dim; ++j) {
      double sum = 0.0;
#pragma omp simd reduction(+ : sum)
      for (int a = 0; a < n; ++a) sum += u[i][a] * gradient[j * n + a];
      h[i][j] = sum;
    }
  if constexpr (K::hoop) {
    double radial = 0.0;
    for (int a = 0; a < n; ++a) radial += u[0][a] * value[a];
    h[2][2] = radial / position[0];
  }
}

/// Calls `body(group, point, h)` for all points, shared among the threads of the team that calls
/// it; does not wait for the others.
template <class K, class Body>
void for_displacement_gradients_of_team(const Stencil& stencil, const double* displacement,
                                        const double* position, Body&& body) {
  constexpr int dim = K::dim;
#pragma omp for schedule(static) nowait
  for (std::int64_t g = 0; g < stencil.groups; ++g) {
    with_node_count<dim>(stencil.nodes_of(g), [&]<int N>() {
      constexpr int capacity = N > 0 ? N : maximum_nodes;
      const int n = N > 0 ? N : stencil.nodes_of(g);
      const std::int32_t* node = stencil.node + stencil.node_start[g];
      double u[dim][capacity];
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < dim; ++i) u[i][a] = displacement[dim * std::int64_t{node[a]} + i];
      GroupBasis<dim, N, K::hoop, true> basis(stencil, g);
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        double h[3][3] = {};
        displacement_gradient<K, capacity>(n, u, basis.value, basis.gradient, position + dim * p,
                                           h);
        body(g, p, h);
      }
    });
  }
}

/// The same with a team of its own.
template <class K, class Body>
void for_displacement_gradients(const Stencil& stencil, const double* displacement,
                                const double* position, Body&& body) {
#pragma omp parallel if (stencil.start[stencil.groups] >= parallel_from)
  for_displacement_gradients_of_team<K>(stencil, displacement, position, body);
}

}  // namespace tilth::kernel
