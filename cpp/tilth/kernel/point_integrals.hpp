// SPDX-License-Identifier: BSD-3-Clause
// Sums over the points of one body of quantities times basis values S or gradients G, and nodal
// fields and their gradients at the points.
#pragma once

#include "basis_values.hpp"

namespace tilth::kernel {

/// Adds sum_p S_ap vector_p to `nodal` (nodes, components): external forces, masses, volumes.
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

/// Adds sum_p flux_p G_ap, `flux` (points, Components, Dim), to `nodal` (nodes, Components).
template <int Dim, int Components>
void scatter_gradient(const Stencil& stencil, const double* flux, double* nodal) {
  for_each_by_colour(stencil, [&](std::int64_t g) {
    with_node_count<Dim>(stencil.nodes_of(g), [&]<int N>() {
      constexpr int capacity = N > 0 ? N : maximum_nodes;
      const int n = N > 0 ? N : stencil.nodes_of(g);
      const std::int32_t* node = stencil.node + stencil.node_start[g];
      double local[Components][capacity];
      for (int i = 0; i < Components; ++i)
        for (int a = 0; a < n; ++a) local[i][a] = 0.0;
      GroupBasis<Dim, N, false, true> basis(stencil, g);
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        for (int i = 0; i < Components; ++i)
          for (int l = 0; l < Dim; ++l) {
            const double along = flux[(Components * p + i) * Dim + l];
#pragma omp simd
            for (int a = 0; a < n; ++a) local[i][a] += along * basis.gradient[l * n + a];
          }
      }
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < Components; ++i)
          nodal[Components * std::int64_t{node[a]} + i] += local[i][a];
    });
  });
}

/// Fills `gradient` (points, Components, Dim) of a nodal field (nodes, Components).
template <int Dim, int Components>
void interpolate_gradient(const Stencil& stencil, const double* nodal, double* gradient) {
  for_groups(stencil, [&](std::int64_t g) {
    with_node_count<Dim>(stencil.nodes_of(g), [&]<int N>() {
      constexpr int capacity = N > 0 ? N : maximum_nodes;
      const int n = N > 0 ? N : stencil.nodes_of(g);
      const std::int32_t* node = stencil.node + stencil.node_start[g];
      double own[Components][capacity];
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < Components; ++i)
          own[i][a] = nodal[Components * std::int64_t{node[a]} + i];
      GroupBasis<Dim, N, false, true> basis(stencil, g);
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        for (int i = 0; i < Components; ++i)
          for (int l = 0; l < Dim; ++l) {
            double sum = 0.0;
#pragma omp simd reduction(+ : sum)
            for (int a = 0; a < n; ++a) sum += own[i][a] * basis.gradient[l * n + a];
            gradient[(Components * p + i) * Dim + l] = sum;
          }
      }
    });
  });
}

}  // namespace tilth::kernel
