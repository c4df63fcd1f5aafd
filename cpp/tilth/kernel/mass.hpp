// SPDX-License-Identifier: BSD-3-Clause
// Consistent mass M_ab = sum_p m_p S_ap S_bp of the points of one body: one number for each block
// of the node-block matrix, for it is the same in all directions.
#pragma once

#include <algorithm>

#include "basis_values.hpp"
#include "local_matrix.hpp"

namespace tilth::kernel {

/// Adds the mass of the points to `matrix` (blocks). Returns whether all `blocks` are inside of it;
/// those of other groups are not added.
template <int Dim>
bool add_mass(const Stencil& stencil, const BlockPositions& blocks, const double* mass,
              double* matrix) {
  Found outside;
  for_each_by_colour(stencil, [&](std::int64_t g) {
    with_node_count<Dim>(stencil.nodes_of(g), [&]<int N>() {
      const int n = N > 0 ? N : stencil.nodes_of(g);
      const NodeRuns runs(n, stencil.node + stencil.node_start[g]);
      if (!prefetch_blocks<1>(g, n, runs, blocks, matrix)) return outside.set();
      double local[N > 0 ? N * N : maximum_nodes * maximum_nodes];
      std::fill_n(local, n * n, 0.0);
      GroupBasis<Dim, N, true, false> basis(stencil, g);
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        for (int a = 0; a < n; ++a) {
          const double weighted = mass[p] * basis.value[a];
          for (int b = 0; b < n; ++b) local[a * n + b] += weighted * basis.value[b];
        }
      }
      scatter_blocks<1>(n, runs, blocks.position + blocks.start[g], local, matrix);
    });
  });
  return !outside;
}

}  // namespace tilth::kernel
