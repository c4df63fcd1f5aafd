// SPDX-License-Identifier: BSD-3-Clause
// Internal force of the points of one body in the previously converged configuration,
//   f_a = sum_p V0_p tau_p dF_p^-T grad S_a   (+ hoop: V0 tau_zz S_a / r to the radial component),
// added to `force` (nodes, dim). (Coombs et al. 2020, CMAME 358, 112622; docs/theory/mechanics.md)
#pragma once

#include "basis_values.hpp"
#include "response.hpp"

namespace tilth::kernel {

template <class K>
void internal_force(const Stencil& stencil, const double* initial_volume, const double* position,
                    const double* response_array, double* force) {
  constexpr int dim = K::dim;
  const auto* response = reinterpret_cast<const Response<K>*>(response_array);
  for_each_by_colour(stencil, [&](std::int64_t g) {
    with_node_count<dim>(stencil.nodes_of(g), [&]<int N>() {
      const int n = N > 0 ? N : stencil.nodes_of(g);
      double local[dim][N > 0 ? N : maximum_nodes];
      for (int i = 0; i < dim; ++i)
        for (int a = 0; a < n; ++a) local[i][a] = 0.0;
      GroupBasis<dim, N, K::hoop, true> basis(stencil, g);
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        const Response<K>& r = response[p];
        for (int i = 0; i < dim; ++i)
          for (int j = 0; j < dim; ++j) {
            double stress = 0.0;
            for (int q = 0; q < dim; ++q)
              stress += r.axis[i][q] * r.kirchhoff[q] * r.to_current[q][j];
            stress *= initial_volume[p];
#pragma omp simd
            for (int a = 0; a < n; ++a) local[i][a] += stress * basis.gradient[j * n + a];
          }
        if constexpr (K::hoop) {
          const double hoop =
              initial_volume[p] * r.kirchhoff[2] * r.hoop_inverse / position[dim * p];
          for (int a = 0; a < n; ++a) local[0][a] += hoop * basis.value[a];
        }
      }
      const std::int32_t* node = stencil.node + stencil.node_start[g];
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < dim; ++i) force[dim * std::int64_t{node[a]} + i] += local[i][a];
    });
  });
}

/// Adds sum_p S_a vector_p to `nodal` (nodes, components): external forces, masses, volumes.
template <int Dim>
void scatter(const Stencil& stencil, int components, const double* vector, double* nodal) {
  for_each_by_colour(stencil, [&](std::int64_t g) {
    const int n = stencil.nodes_of(g);
    const std::int32_t* node = stencil.node + stencil.node_start[g];
    GroupBasis<Dim, 0, true, false> basis(stencil, g);
    for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
      basis.advance();
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < components; ++i)
          nodal[components * std::int64_t{node[a]} + i] +=
              basis.value[a] * vector[components * p + i];
    }
  });
}

/// Interpolates nodal vectors (nodes, components) to the points with the points' basis.
template <int Dim>
void interpolate(const Stencil& stencil, int components, const double* nodal, double* vector) {
  for_groups(stencil, [&](std::int64_t g) {
    const int n = stencil.nodes_of(g);
    const std::int32_t* node = stencil.node + stencil.node_start[g];
    GroupBasis<Dim, 0, true, false> basis(stencil, g);
    for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
      basis.advance();
      for (int i = 0; i < components; ++i) {
        double sum = 0.0;
        for (int a = 0; a < n; ++a)
          sum += basis.value[a] * nodal[components * std::int64_t{node[a]} + i];
        vector[components * p + i] = sum;
      }
    }
  });
}

}  // namespace tilth::kernel
