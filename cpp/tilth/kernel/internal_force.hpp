// SPDX-License-Identifier: BSD-3-Clause
// Internal force of the points of one body in the previously converged configuration,
//   f_a = sum_p V0_p tau_p dF_p^-T grad S_a   (+ hoop: V0 tau_zz S_a / r to the radial component),
// added to `force` (nodes, dim). (Coombs et al. 2020, CMAME 358, 112622; docs/theory/mechanics.md)
// With F-bar the excess e of the mean stress over that of the cells before the step acts through
// the cells' volumes (docs/theory/f_bar.md, "Force"):
//   f_a = sum_p V_p [(tau_p - e_p 1) dF_p^-T grad S_a + e_p d ln J0_p / du_a].
#pragma once

#include <algorithm>
#include <optional>

#include "basis_values.hpp"
#include "f_bar.hpp"
#include "response.hpp"

namespace tilth::kernel {

/// See internal_force() below.
template <class K, bool FBar>
void add_internal_force(const Stencil& stencil, const double* volume, const double* position,
                        const double* response_array, const Centres* centres, double* force) {
  constexpr int dim = K::dim;
  const auto* response = reinterpret_cast<const Response<K>*>(response_array);
  for_each_by_colour(stencil, [&](std::int64_t g) {
    with_node_count<dim>(stencil.nodes_of(g), [&]<int N>() {
      constexpr int capacity = N > 0 ? N : maximum_nodes;
      const int n = N > 0 ? N : stencil.nodes_of(g);
      double local[dim][capacity];
      for (int i = 0; i < dim; ++i)
        for (int a = 0; a < n; ++a) local[i][a] = 0.0;
      const std::int64_t start = stencil.start[g];
      if (start == stencil.start[g + 1]) return;
      std::optional<GroupCells<dim>> cells;
      CellFactors factors, through;  // of a point; of the excess of all
      double sum = 0.0;              // of the excess times volume
      if constexpr (FBar) {
        cells.emplace(*centres, g);
        for (int c = 0; c < cells->count; ++c) through.in_plane[c] = through.hoop[c] = 0.0;
      }
      const auto add_through = [&](std::int64_t p, double force_times_length) {
        find_factors<K>(*centres, *cells, centres->first_share(g, p - start), factors);
        for (int c = 0; c < cells->count; ++c) {
          through.in_plane[c] += force_times_length * factors.in_plane[c];
          if constexpr (K::hoop) through.hoop[c] += force_times_length * factors.hoop[c];
        }
      };
      GroupBasis<dim, N, K::hoop, true> basis(stencil, g);
      for (std::int64_t p = start; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        const Response<K>& r = response[p];
        double excess = 0.0;
        if constexpr (FBar) {
          excess = excess_pressure(r, centres->pressure[p]);
          sum += volume[p] * excess;
          // in a group of one cell all points have the same factors
          if (cells->count > 1) add_through(p, volume[p] * excess);
        }
        for (int i = 0; i < dim; ++i)
          for (int j = 0; j < dim; ++j) {
            double stress = 0.0;
            for (int q = 0; q < dim; ++q)
              stress += r.axis[i][q] * (r.kirchhoff[q] - excess) * r.to_current[q][j];
            stress *= volume[p];
#pragma omp simd
            for (int a = 0; a < n; ++a) local[i][a] += stress * basis.gradient[j * n + a];
          }
        if constexpr (K::hoop) {
          const double hoop =
              volume[p] * (r.kirchhoff[2] - excess) * r.hoop_inverse / position[dim * p];
          for (int a = 0; a < n; ++a) local[0][a] += hoop * basis.value[a];
        }
      }
      if constexpr (FBar) {
        if (cells->count == 1) add_through(start, sum);
        add_traces<dim, capacity>(*centres, *cells, through.in_plane, local);
        if constexpr (K::hoop) add_hoop_gradients(*centres, *cells, through.hoop, local[0]);
      }
      const std::int32_t* node = stencil.node + stencil.node_start[g];
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < dim; ++i) force[dim * std::int64_t{node[a]} + i] += local[i][a];
    });
  });
}

/// `volume`: V0 of each point, with F-bar V0 J / J_bar at the start of the step.
template <class K>
void internal_force(const Stencil& stencil, const double* volume, const double* position,
                    const double* response, const Centres* centres, double* force) {
  const auto add =
      centres != nullptr ? &add_internal_force<K, true> : &add_internal_force<K, false>;
  add(stencil, volume, position, response, centres, force);
}

}  // namespace tilth::kernel
