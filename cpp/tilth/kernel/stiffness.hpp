// SPDX-License-Identifier: BSD-3-Clause
// Consistent stiffness of the points of one body, the derivative of internal_force.hpp, added to
// a node-block matrix whose pattern is fixed over the step.
//
// With g_p the current gradient along the principal axis n_p and l the velocity gradient, the
// spatial tangent a (stress part less the geometric tau_il delta_jk) has in principal axes only
//   a_pprr = D_pr - delta_pr tau_p,   a_pqpq = s_pq beta_q,   a_pqqp = s_pq beta_p - tau_p,
// with s_pq = (tau_p - tau_q) / (beta_p - beta_q). (docs/theory/mechanics.md, "Tangent")
#pragma once

#include "f_bar.hpp"
#include "response.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Where the blocks of a group stand in the matrix: for each row node and each run of consecutive
/// column nodes, the position of the run's first block.
struct BlockPositions {
  const std::int64_t* start;     // (groups) offset into `position`
  const std::int32_t* position;  // (row nodes x runs) per group
};

/// transform[q][i][k][r]: row i, column k of the factor of g_r in the tangent's column q.
template <class K>
void principal_tangent(const Response<K>& s, double volume,
                       double transform[K::dim][K::dim][K::dim][K::dim]) {
  constexpr int dim = K::dim;
  for (int q = 0; q < dim; ++q) {
    double direct[dim], crossed[dim], normal[dim];
    for (int p = 0; p < dim; ++p) {
      normal[p] = s.tangent[q][p] - (p == q ? s.kirchhoff[q] : 0.0);
      const double shear = p == q ? 0.0 : s.shear[Response<K>::pair(p, q)];
      direct[p] = p == q ? normal[q] : shear * s.beta[q];
      crossed[p] = p == q ? 0.0 : shear * s.beta[p] - s.kirchhoff[p];
    }
    for (int i = 0; i < dim; ++i)
      for (int k = 0; k < dim; ++k)
        for (int r = 0; r < dim; ++r) {
          double sum = 0.0;
          if (r == q) {
            for (int p = 0; p < dim; ++p) sum += s.axis[i][p] * s.axis[k][p] * direct[p];
          } else {
            sum =
                s.axis[i][q] * s.axis[k][r] * normal[r] + s.axis[i][r] * s.axis[k][q] * crossed[r];
          }
          transform[q][i][k][r] = volume * sum;
        }
  }
}

/// Adds one group's dense matrix block[a][i][k][b] to the rows of its nodes.
template <int Dim>
void scatter_blocks(int n, const std::int32_t* node, const std::int32_t* position,
                    const double* block, double* matrix) {
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++position) {
      double* entry = matrix + std::int64_t{*position} * Dim * Dim;
      int end = b + 1;
      while (end < n && node[end] == node[end - 1] + 1) ++end;
      for (; b < end; ++b, entry += Dim * Dim)
        for (int ik = 0; ik < Dim * Dim; ++ik) entry[ik] += block[(a * Dim * Dim + ik) * n + b];
    }
  }
}

/// Part of F-bar's tangent that is not a point's own: V q (x) (d ln J0 - d ln J), added to
/// column[q][i][k][b] and, in axisymmetry, to the hoop's rows. With n stretched directions,
///   q_p = sum_r D_pr / n - tau_p  (de Souza Neto et al. 1996, in principal axes).
template <class K, int Capacity>
void add_f_bar(const Response<K>& s, double volume, int n, const double current[K::dim][Capacity],
               const double* value, double hoop_per_value, double difference[K::dim][Capacity],
               double column[K::dim][K::dim][K::dim][Capacity], double* local) {
  constexpr int dim = K::dim;
  double by_volume[3];
  for (int p = 0; p < 3; ++p) {
    double sum = 0.0;
    for (int r = 0; r < f_bar_directions<K>; ++r) sum += s.tangent[p][r];
    by_volume[p] = volume * (sum / f_bar_directions<K> - s.kirchhoff[p]);
  }
  for (int k = 0; k < dim; ++k)
    for (int q = 0; q < dim; ++q)
      for (int b = 0; b < n; ++b) difference[k][b] -= s.axis[k][q] * current[q][b];
  if constexpr (K::hoop)
    for (int b = 0; b < n; ++b) difference[0][b] -= hoop_per_value * value[b];
  for (int q = 0; q < dim; ++q)
    for (int i = 0; i < dim; ++i)
      for (int k = 0; k < dim; ++k) {
        const double factor = s.axis[i][q] * by_volume[q];
#pragma omp simd
        for (int b = 0; b < n; ++b) column[q][i][k][b] += factor * difference[k][b];
      }
  if constexpr (K::hoop)
    for (int a = 0; a < n; ++a)
      for (int k = 0; k < dim; ++k) {
        double* row = local + (a * dim * dim + k) * n;
        const double factor = hoop_per_value * value[a] * by_volume[2];
        for (int b = 0; b < n; ++b) row[b] += factor * difference[k][b];
      }
}

template <class K>
void stiffness(const Stencil& stencil, const BlockPositions& blocks, const double* initial_volume,
               const double* position, const double* response_array, const Centres* centres,
               double* matrix) {
  constexpr int dim = K::dim;
  const auto* response = reinterpret_cast<const Response<K>*>(response_array);
  for_groups_by_colour(stencil, [&](std::int64_t g) {
    with_node_count<dim>(stencil.nodes_of(g), [&]<int N>() {
      constexpr int capacity = N > 0 ? N : maximum_nodes;
      const int n = N > 0 ? N : stencil.nodes_of(g);
      double local[capacity * dim * dim * capacity];
      for (int e = 0; e < n * dim * dim * n; ++e) local[e] = 0.0;
      std::int64_t offset = stencil.value_start[g];
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p, offset += n) {
        const Response<K>& s = response[p];
        const double* gradient = stencil.gradient + dim * offset;
        double current[dim][capacity];           // gradients along the principal axes
        double column[dim][dim][dim][capacity];  // [q][i][k][b]
        double transform[dim][dim][dim][dim];
        for (int q = 0; q < dim; ++q) {
#pragma omp simd
          for (int b = 0; b < n; ++b) {
            double sum = 0.0;
            for (int j = 0; j < dim; ++j) sum += s.to_current[q][j] * gradient[j * n + b];
            current[q][b] = sum;
          }
        }
        principal_tangent<K>(s, initial_volume[p], transform);
        for (int q = 0; q < dim; ++q)
          for (int i = 0; i < dim; ++i)
            for (int k = 0; k < dim; ++k) {
#pragma omp simd
              for (int b = 0; b < n; ++b) {
                double sum = 0.0;
                for (int r = 0; r < dim; ++r) sum += transform[q][i][k][r] * current[r][b];
                column[q][i][k][b] = sum;
              }
            }
        if (centres != nullptr) {
          const double* shares = centres->share + centres->share_start[g] +
                                 (p - stencil.start[g]) * centres->cells_of(g);
          double difference[dim][capacity] = {};
          add_centre_trace<dim, capacity>(*centres, g, shares, p, difference);
          const double per_value = K::hoop ? s.hoop_inverse / position[dim * p] : 0.0;
          add_f_bar<K, capacity>(s, initial_volume[p], n, current, stencil.value + offset,
                                 per_value, difference, column, local);
        }
        for (int a = 0; a < n; ++a)
          for (int i = 0; i < dim; ++i)
            for (int k = 0; k < dim; ++k) {
              double* row = local + ((a * dim + i) * dim + k) * n;
#pragma omp simd
              for (int b = 0; b < n; ++b) {
                double sum = row[b];
                for (int q = 0; q < dim; ++q) sum += current[q][a] * column[q][i][k][b];
                row[b] = sum;
              }
            }
        if constexpr (K::hoop) {
          const double* value = stencil.value + offset;
          const double per_value = s.hoop_inverse / position[dim * p];
          double by_hoop[dim] = {}, hoop_by[dim][dim] = {};  // d tau_i / d hoop; d tau_hoop / d l
          for (int r = 0; r < dim; ++r)
            for (int k = 0; k < dim; ++k) hoop_by[r][k] = s.tangent[2][r] * s.axis[k][r];
          for (int a = 0; a < n; ++a) {
            for (int i = 0; i < dim; ++i) {
              by_hoop[i] = 0.0;
              for (int r = 0; r < dim; ++r)
                by_hoop[i] += s.axis[i][r] * s.tangent[r][2] * current[r][a];
            }
            const double hoop = initial_volume[p] * per_value * value[a];
            for (int b = 0; b < n; ++b) {
              const double radial = initial_volume[p] * per_value * value[b];
              for (int i = 0; i < dim; ++i)
                local[(a * dim + i) * dim * n + b] += by_hoop[i] * radial;
              for (int k = 0; k < dim; ++k) {
                double sum = 0.0;
                for (int r = 0; r < dim; ++r) sum += hoop_by[r][k] * current[r][b];
                local[(a * dim * dim + k) * n + b] += hoop * sum;
              }
              local[a * dim * dim * n + b] +=
                  hoop * (s.tangent[2][2] - s.kirchhoff[2]) * per_value * value[b];
            }
          }
        }
      }
      scatter_blocks<dim>(n, stencil.node + stencil.node_start[g],
                          blocks.position + blocks.start[g], local, matrix);
    });
  });
}

}  // namespace tilth::kernel
