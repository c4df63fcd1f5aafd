// SPDX-License-Identifier: BSD-3-Clause
// Forces on points that depend on the step's displacement of the point and on its gradient, such as
// those of water (docs/theory/water.md): the step's deformation at the points, and the derivative
// of sum_p S_ap f_p.
#pragma once

#include "basis_values.hpp"
#include "gradient.hpp"
#include "local_matrix.hpp"
#include "point_stress.hpp"

namespace tilth::kernel {

/// Fills the determinants (points) and the inverses (points, 3, 3) of the step's deformation
/// gradient 1 + H; in axisymmetry H has the hoop strain. An inverse is not defined where the
/// determinant is 0.
template <class K>
void step_inverses(const Stencil& stencil, const double* displacement, const double* position,
                   double* determinant, double* inverse) {
  for_displacement_gradients<K>(stencil, displacement, position,
                                [&](std::int64_t /*group*/, std::int64_t p, const double h[3][3]) {
                                  double f[3][3], inverted[3][3];
                                  for (int i = 0; i < 3; ++i)
                                    for (int j = 0; j < 3; ++j) f[i][j] = (i == j) + h[i][j];
                                  determinant[p] = invert(f, inverted);
                                  std::copy_n(&inverted[0][0], 9, inverse + 9 * p);
                                });
}

/// Adds sum_p S_ap (by_displacement_p[i][k] S_bp + sum_j by_gradient_p[i][k][j] G_bp[j]) to the
/// blocks of the matrix. Returns whether all blocks are inside of it; those of other groups are not
/// added.
template <int Dim>
bool add_force_derivative(const Stencil& stencil, const BlockPositions& blocks,
                          const double* by_displacement, const double* by_gradient,
                          double* matrix) {
  constexpr int entries = Dim * Dim;
  Found outside;
  for_each_by_colour(stencil, [&](std::int64_t g) {
    with_node_count<Dim>(stencil.nodes_of(g), [&]<int N>() {
      const int n = N > 0 ? N : stencil.nodes_of(g);
      if (stencil.start[g] == stencil.start[g + 1]) return;
      const std::int32_t* block = blocks.position + blocks.start[g];
      const NodeRuns runs(n, stencil.node + stencil.node_start[g]);
      if (!prefetch_blocks<entries>(g, n, runs, blocks, matrix)) return outside.set();
      constexpr int capacity = N > 0 ? N : maximum_nodes;
      double local[capacity * capacity * entries], factor[capacity * entries];
      std::fill_n(local, n * entries * n, 0.0);
      GroupBasis<Dim, N, true, true> basis(stencil, g);
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        for (int b = 0; b < n; ++b)
          for (int ik = 0; ik < entries; ++ik) {
            double sum = by_displacement[entries * p + ik] * basis.value[b];
            for (int j = 0; j < Dim; ++j)
              sum += by_gradient[Dim * (entries * p + ik) + j] * basis.gradient[j * n + b];
            factor[b * entries + ik] = sum;
          }
        for (int a = 0; a < n; ++a)
          for (int e = 0; e < n * entries; ++e)
            local[a * n * entries + e] += basis.value[a] * factor[e];
      }
      scatter_blocks<entries>(n, runs, block, local, matrix);
    });
  });
  return !outside;
}

}  // namespace tilth::kernel
