// SPDX-License-Identifier: BSD-3-Clause
// Extrapolation of the points' last displacement fields to the nodes (analysis/predictor.py).
#pragma once

#include "basis_values.hpp"

namespace tilth::kernel {

/// Adds to `sum` (nodes, 1 + Dim) the points' weights S_a V, and these times the displacement
/// u + G (x_a - x) that the field of each point, `displacement` u (n, Dim) and `gradient` G
/// (n, Dim, Dim), has at the node.
template <int Dim>
void add_predictions(const Stencil& stencil, const double* node_position, const double* position,
                     const double* displacement, const double* gradient, const double* volume,
                     double* sum) {
  for_each_by_colour(stencil, [&](std::int64_t g) {
    const int n = stencil.nodes_of(g);
    const std::int32_t* node = stencil.node + stencil.node_start[g];
    double local[maximum_nodes][1 + Dim] = {};
    GroupBasis<Dim, 0, true, false> basis(stencil, g);
    for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
      basis.advance();
      const double* G = gradient + p * Dim * Dim;
      for (int a = 0; a < n; ++a) {
        const double* x = node_position + Dim * std::int64_t{node[a]};
        const double weight = basis.value[a] * volume[p];
        local[a][0] += weight;
        for (int i = 0; i < Dim; ++i) {
          double u = displacement[Dim * p + i];
          for (int j = 0; j < Dim; ++j) u += G[i * Dim + j] * (x[j] - position[Dim * p + j]);
          local[a][1 + i] += weight * u;
        }
      }
    }
    for (int a = 0; a < n; ++a)
      for (int i = 0; i <= Dim; ++i) sum[(1 + Dim) * std::int64_t{node[a]} + i] += local[a][i];
  });
}

}  // namespace tilth::kernel
