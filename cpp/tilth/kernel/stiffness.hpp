// SPDX-License-Identifier: BSD-3-Clause
// Consistent stiffness of the points of one body, the derivative of internal_force.hpp, added to
// a node-block matrix whose pattern is fixed over the step.
//
// With g_p the current gradient along the principal axis n_p and l the velocity gradient, the
// spatial tangent a (stress part less the geometric tau_il delta_jk) has in principal axes only
//   a_pprr = D_pr - delta_pr tau_p,   a_pqpq = s_pq beta_q,   a_pqqp = s_pq beta_p - tau_p,
// with s_pq = (tau_p - tau_q) / (beta_p - beta_q). (docs/theory/mechanics.md, "Tangent")
// Several points of a group are added at once, as one product of small dense matrices
// (dense_product.hpp). Where D is symmetric, and not in axisymmetry, the blocks below the diagonal
// in (i, k) are those above it, transposed, and are not computed. F-bar's terms are in
// f_bar_tangent.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "basis_values.hpp"
#include "dense_product.hpp"
#include "f_bar_tangent.hpp"
#include "response.hpp"

namespace tilth::kernel {

/// Positions of the blocks of a group in the matrix: for each row node and each run of consecutive
/// column nodes, the position of the run's first block.
struct BlockPositions {
  const std::int64_t* start;     // (groups) offset into `position`
  const std::int32_t* position;  // (row nodes x runs) per group
  std::int64_t entries;          // of `position`
  std::int64_t blocks;           // of the matrix
};

/// A number for each direction, in one vector register; in 3D the fourth entry is unused.
template <int Dim>
struct DirectionsOf;
template <>
struct DirectionsOf<2> {
  using Vector = double __attribute__((vector_size(16)));
};
template <>
struct DirectionsOf<3> {
  using Vector = HalfLanes;
};
template <class K>
using PerDirection = typename DirectionsOf<K::dim>::Vector;

/// transform[q][i][r][k]: row i, column k of the factor of g_r in the tangent's column q.
template <class K>
void principal_tangent(const Response<K>& s, double volume,
                       PerDirection<K> transform[K::dim][K::dim][K::dim]) {
  constexpr int dim = K::dim;
  PerDirection<K> along[dim] = {};  // [p][k]: component k of n_p
  for (int p = 0; p < dim; ++p)
    for (int k = 0; k < dim; ++k) along[p][k] = s.axis[k][p];
  for (int q = 0; q < dim; ++q) {
    double direct[dim], crossed[dim], normal[dim];
    for (int p = 0; p < dim; ++p) {
      const double own = p == q ? s.kirchhoff[q] : 0.0;
      const double shear = p == q ? 0.0 : volume * s.shear[Response<K>::pair(p, q)];
      normal[p] = volume * (s.tangent[q][p] - own);
      direct[p] = p == q ? normal[q] : shear * s.beta[q];
      crossed[p] = shear * s.beta[p] - volume * s.kirchhoff[p];
    }
    PerDirection<K> straight[dim];
    for (int p = 0; p < dim; ++p) straight[p] = direct[p] * along[p];
    for (int i = 0; i < dim; ++i) {
      transform[q][i][q] = s.axis[i][0] * straight[0];
      for (int p = 1; p < dim; ++p) transform[q][i][q] += s.axis[i][p] * straight[p];
    }
    for (int r = 0; r < dim; ++r) {
      if (r == q) continue;
      const PerDirection<K> first = normal[r] * along[r], second = crossed[r] * along[q];
      for (int i = 0; i < dim; ++i)
        transform[q][i][r] = s.axis[i][q] * first + s.axis[i][r] * second;
    }
  }
}

/// Whether the point's tangent is symmetric to round-off.
template <class K>
bool is_symmetric(const Response<K>& s) {
  constexpr double round_off = 1e-14;
  const double size = round_off * (std::fabs(s.tangent[0][0]) + std::fabs(s.tangent[1][1]) +
                                   std::fabs(s.tangent[2][2]));
  return std::fabs(s.tangent[0][1] - s.tangent[1][0]) <= size &&
         std::fabs(s.tangent[1][2] - s.tangent[2][1]) <= size &&
         std::fabs(s.tangent[2][0] - s.tangent[0][2]) <= size;
}

/// Adds one group's dense matrix block[a][i][k][b] to the rows of its nodes. A symmetric one is
/// read at i <= k only.
template <int Dim, bool Symmetric = false>
void scatter_blocks(int n, const std::int32_t* node, const std::int32_t* position,
                    const double* block, double* matrix) {
  constexpr int entries = Dim * Dim;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++position) {
      double* entry = matrix + std::int64_t{*position} * entries;
      int end = b + 1;
      while (end < n && node[end] == node[end - 1] + 1) ++end;
      for (; b < end; ++b, entry += entries) {
        const auto at = [&](int ik) {
          const int i = ik / Dim, k = ik % Dim;
          const bool mirrored = Symmetric && k < i;
          return mirrored ? block[((b * Dim + k) * Dim + i) * n + a]
                          : block[(a * entries + ik) * n + b];
        };
        int ik = 0;
        for (; ik + 4 <= entries; ik += 4) {
          HalfLanes sum;
          std::memcpy(&sum, entry + ik, sizeof sum);
          sum += HalfLanes{at(ik), at(ik + 1), at(ik + 2), at(ik + 3)};
          std::memcpy(entry + ik, &sum, sizeof sum);
        }
        for (; ik < entries; ++ik) entry[ik] += at(ik);
      }
    }
  }
}

/// Prefetches the blocks of a group, which are scattered over the matrix. Returns whether all are
/// inside of it.
template <int Dim>
bool prefetch_blocks(std::int64_t group, int n, const std::int32_t* node,
                     const BlockPositions& blocks, const double* matrix) {
  constexpr int line = 8;  // numbers of a cache line
  const std::int64_t first = blocks.start[group];
  if (first < 0 || first > blocks.entries) return false;
  const std::int32_t* position = blocks.position + first;
  const std::int32_t* last = blocks.position + blocks.entries;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++position) {
      const int begin = b++;
      while (b < n && node[b] == node[b - 1] + 1) ++b;
      if (position == last || *position < 0 || *position > blocks.blocks - (b - begin))
        return false;
      const double* entry = matrix + std::int64_t{*position} * Dim * Dim;
      for (int e = 0; e < (b - begin) * Dim * Dim; e += line) __builtin_prefetch(entry + e, 1);
      __builtin_prefetch(entry + (b - begin) * Dim * Dim - 1, 1);
    }
  return true;
}

/// Adds the contribution of the hoop stress and strain of a point to the stiffness (axisymmetry);
/// `current` are the point's gradients, (dim, Capacity).
template <class K, int Capacity>
void add_hoop(const Response<K>& s, double volume, double radius, int n,
              const double (*current)[Capacity], const double* value, double* local) {
  constexpr int dim = K::dim;
  const double per_value = s.hoop_inverse / radius;
  double by_hoop[dim] = {}, hoop_by[dim][dim] = {};  // d tau_i / d hoop; d tau_hoop / d l
  for (int r = 0; r < dim; ++r)
    for (int k = 0; k < dim; ++k) hoop_by[r][k] = s.tangent[2][r] * s.axis[k][r];
  for (int a = 0; a < n; ++a) {
    for (int i = 0; i < dim; ++i) {
      by_hoop[i] = 0.0;
      for (int r = 0; r < dim; ++r) by_hoop[i] += s.axis[i][r] * s.tangent[r][2] * current[r][a];
    }
    const double hoop = volume * per_value * value[a];
    for (int b = 0; b < n; ++b) {
      const double radial = volume * per_value * value[b];
      for (int i = 0; i < dim; ++i) local[(a * dim + i) * dim * n + b] += by_hoop[i] * radial;
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

/// The two factors of a group's stiffness: for each point and principal direction q a row of
/// `current`, the nodes' gradients, and one of `column`[i][k], the tangent's column times
/// gradients. N nodes, 0 for a number known at run time.
template <class K, int N>
struct Factors {
  static constexpr int dim = K::dim;
  static constexpr int capacity = padded_columns(N > 0 ? N : maximum_nodes);
  static constexpr int bytes_of_point = 8 * dim * dim * dim * capacity;
  static constexpr int points_at_once = std::clamp(24576 / bytes_of_point, 1, 16);  // stay in L1

  alignas(32) double current[points_at_once * dim][capacity];
  alignas(32) double column[dim][dim][points_at_once * dim][capacity];

  /// Sets the entries of `current` beyond the last node to zero.
  void clear_padding(int n) {
    for (auto& row : current) std::fill(row + n, row + padded_columns(n), 0.0);
  }

  /// Fills the rows of the point in this slot; those of i > k only if not `symmetric`.
  void fill(int slot, const Response<K>& s, double volume, int n, const double* gradient,
            bool symmetric) {
    double (*rows)[capacity] = current + slot * dim;
    for (int q = 0; q < dim; ++q)
      for (int b = 0; b < n; ++b) {
        double sum = 0.0;
        for (int j = 0; j < dim; ++j) sum += s.to_current[q][j] * gradient[j * n + b];
        rows[q][b] = sum;
      }
    PerDirection<K> transform[dim][dim][dim];
    principal_tangent<K>(s, volume, transform);
    const int width = N > 0 ? capacity : padded_columns(n);
    for (int i = 0; i < dim; ++i)
      for (int k = symmetric ? i : 0; k < dim; ++k)
        for (int q = 0; q < dim; ++q) {
          double* entry = column[i][k][slot * dim + q];
#pragma omp simd
          for (int b = 0; b < width; ++b) {
            double sum = 0.0;
            for (int r = 0; r < dim; ++r) sum += transform[q][i][r][k] * rows[r][b];
            entry[b] = sum;
          }
        }
  }
};

/// See stiffness() below.
template <class K, bool FBar>
bool add_stiffness(const Stencil& stencil, const BlockPositions& blocks, const double* volume,
                   const double* position, const double* response_array, const Centres* centres,
                   double* matrix) {
  constexpr int dim = K::dim;
  const auto* response = reinterpret_cast<const Response<K>*>(response_array);
  Found outside;
  for_each_by_colour(stencil, [&](std::int64_t g) {
    with_node_count<dim>(stencil.nodes_of(g), [&]<int N>() {
      constexpr int capacity = Factors<K, N>::capacity;
      const int n = N > 0 ? N : stencil.nodes_of(g);
      const std::int64_t start = stencil.start[g], end = stencil.start[g + 1];
      if (start == end) return;
      const bool symmetric =
          !K::hoop && std::all_of(response + start, response + end, is_symmetric<K>);
      const std::int32_t* node = stencil.node + stencil.node_start[g];
      const std::int32_t* block = blocks.position + blocks.start[g];
      if (!prefetch_blocks<dim>(g, n, node, blocks, matrix)) return outside.set();
      double local[(N > 0 ? N * N : maximum_nodes * maximum_nodes) * dim * dim];
      Factors<K, N> factors;
      if (n < capacity) factors.clear_padding(n);
      std::optional<CellTerms<K, N>> terms;
      bool only_products = !K::hoop;
      if constexpr (FBar) {
        terms.emplace(*centres, g, n, symmetric);
        only_products = only_products && terms->single;
      }
      if (!only_products) std::fill_n(local, n * dim * dim * n, 0.0);
      GroupBasis<dim, N, K::hoop, true> basis(stencil, g);
      for (std::int64_t first = start; first < end; first += factors.points_at_once) {
        const int points =
            static_cast<int>(std::min<std::int64_t>(factors.points_at_once, end - first));
        for (int slot = 0; slot < points; ++slot) {
          const std::int64_t p = first + slot;
          basis.advance();
          const auto* current = factors.current + slot * dim;
          const auto add = [&](const Response<K>& s) {
            factors.fill(slot, s, volume[p], n, basis.gradient, symmetric);
            if constexpr (K::hoop)
              add_hoop<K, capacity>(s, volume[p], position[dim * p], n, current, basis.value,
                                    local);
          };
          const Response<K>& s = response[p];
          if constexpr (FBar) {
            const double excess = excess_pressure(s, centres->pressure[p]);
            const VolumetricModuli<K> moduli(s);
            add(through_point(s, moduli, excess));
            double per_value = 0.0;
            if constexpr (K::hoop) per_value = s.hoop_inverse / position[dim * p];
            terms->add(s, moduli, excess, volume[p], p - start, current, basis.value, per_value,
                       local);
          } else {
            add(s);
          }
        }
        for (int i = 0; i < dim; ++i)
          for (int k = symmetric ? i : 0; k < dim; ++k)
            product<capacity>(
                n, points * dim, factors.current, factors.column[i][k],
                {local + (i * dim + k) * n, dim * dim * n, only_products && first == start});
      }
      if constexpr (FBar) terms->finish(local);
      const auto scatter = symmetric ? &scatter_blocks<dim, true> : &scatter_blocks<dim, false>;
      scatter(n, node, block, local, matrix);
    });
  });
  return !outside;
}

/// Returns whether all `blocks` are inside of the matrix; those of other groups are not added.
/// `volume`: V0 of each point, with F-bar V0 J / J_bar at the start of the step.
template <class K>
bool stiffness(const Stencil& stencil, const BlockPositions& blocks, const double* volume,
               const double* position, const double* response, const Centres* centres,
               double* matrix) {
  const auto add = centres != nullptr ? &add_stiffness<K, true> : &add_stiffness<K, false>;
  return add(stencil, blocks, volume, position, response, centres, matrix);
}

}  // namespace tilth::kernel
