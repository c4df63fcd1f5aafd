// SPDX-License-Identifier: BSD-3-Clause
// Consistent stiffness of the points of one body, the derivative of internal_force.hpp, added to
// a node-block matrix whose pattern is fixed over the step.
//
// With g_p the current gradient along the principal axis n_p and l the velocity gradient, the
// spatial tangent a (stress part less the geometric tau_il delta_jk) has in principal axes only
//   a_pprr = D_pr - delta_pr tau_p,   a_pqpq = s_pq beta_q,   a_pqqp = s_pq beta_p - tau_p,
// with s_pq = (tau_p - tau_q) / (beta_p - beta_q). (docs/theory/mechanics.md, "Tangent")
// Each principal direction of a point is one outer product: the gradients g_q times the tangent's
// column. Those of a group are added at once, as a product of small dense matrices, to the local
// matrix of its cluster (local_matrix.hpp, assembly.hpp). Where D is symmetric, the blocks below
// the diagonal are those above it, transposed, and are not computed. F-bar's terms are in
// f_bar_tangent.hpp.
#pragma once

#include <cmath>
#include <optional>

#include "assembly.hpp"
#include "basis_values.hpp"
#include "f_bar_tangent.hpp"
#include "response.hpp"

namespace tilth::kernel {

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
template <int Dim>
using PerDirection = typename DirectionsOf<Dim>::Vector;

/// Factors of the gradients g_r in the columns q of a point's tangent, each a block (i, k).
template <int Dim>
struct TangentColumns;
template <>
struct TangentColumns<2> {
  WideLanes both[2];  // [r]: the blocks of q = 0 and q = 1
};
template <>
struct TangentColumns<3> {
  WideLanes eight[3][3];  // [q][r]: all components but the last
  HalfLanes last[3][3];   // [q][r]: the last one and three zeros
};

/// Fills a block with its rows i, each with one entry per direction k.
inline void join_rows(const PerDirection<2> row[2], HalfLanes& block) {
  block = HalfLanes{row[0][0], row[0][1], row[1][0], row[1][1]};
}
inline void join_rows(const PerDirection<3> row[3], WideLanes& eight, HalfLanes& last) {
  eight = join(HalfLanes{row[0][0], row[0][1], row[0][2], row[1][0]},
               HalfLanes{row[1][1], row[1][2], row[2][0], row[2][1]});
  last = HalfLanes{row[2][2], 0.0, 0.0, 0.0};
}

template <class K>
void principal_tangent(const Response<K>& s, double volume, TangentColumns<K::dim>& columns) {
  constexpr int dim = K::dim;
  PerDirection<dim> along[dim] = {};  // [p][k]: component k of n_p
  for (int p = 0; p < dim; ++p)
    for (int k = 0; k < dim; ++k) along[p][k] = s.axis[k][p];
  [[maybe_unused]] HalfLanes block[dim][dim];
  for (int q = 0; q < dim; ++q) {
    double direct[dim], crossed[dim], normal[dim];
    for (int p = 0; p < dim; ++p) {
      const double own = p == q ? s.kirchhoff[q] : 0.0;
      const double shear = p == q ? 0.0 : volume * s.shear[Response<K>::pair(p, q)];
      normal[p] = volume * (s.tangent[q][p] - own);
      direct[p] = p == q ? normal[q] : shear * s.beta[q];
      crossed[p] = shear * s.beta[p] - volume * s.kirchhoff[p];
    }
    PerDirection<dim> straight[dim], row[dim];
    for (int p = 0; p < dim; ++p) straight[p] = direct[p] * along[p];
    for (int r = 0; r < dim; ++r) {
      const PerDirection<dim> first = normal[r] * along[r], second = crossed[r] * along[q];
      for (int i = 0; i < dim; ++i) {
        if (r != q) {
          row[i] = s.axis[i][q] * first + s.axis[i][r] * second;
          continue;
        }
        row[i] = s.axis[i][0] * straight[0];
        for (int p = 1; p < dim; ++p) row[i] += s.axis[i][p] * straight[p];
      }
      if constexpr (dim == 2)
        join_rows(row, block[q][r]);
      else
        join_rows(row, columns.eight[q][r], columns.last[q][r]);
    }
  }
  if constexpr (dim == 2)
    for (int r = 0; r < dim; ++r) columns.both[r] = join(block[0][r], block[1][r]);
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

/// Appends the products of a point: for each principal direction its nodes' gradients and the
/// tangent's column times gradients. Returns the number of the first.
template <class K, int N>
int append_point(const Response<K>& s, double volume, int n, const double* gradient,
                 ProductSum<K::dim * K::dim, N>& products) {
  constexpr int dim = K::dim;
  const int first = products.append(dim);
  auto* current = products.left(first);
  for (int q = 0; q < dim; ++q)
    for (int b = 0; b < n; ++b) {
      double sum = 0.0;
      for (int j = 0; j < dim; ++j) sum += s.to_current[q][j] * gradient[j * n + b];
      current[q][b] = sum;
    }
  TangentColumns<dim> columns;
  principal_tangent<K>(s, volume, columns);
  const auto times_gradient = [&](const auto& factor, int b) {
    auto sum = factor[0] * current[0][b];
    for (int r = 1; r < dim; ++r) sum += factor[r] * current[r][b];
    return sum;
  };
  if constexpr (dim == 2) {
    for (int b = 0; b < n; ++b) {
      const WideLanes column = times_gradient(columns.both, b);
      store_half<0>(column, products.right(first, b));
      store_half<1>(column, products.right(first + 1, b));
    }
  } else {
    for (int q = 0; q < dim; ++q)
      for (int b = 0; b < n; ++b) {
        double* column = products.right(first + q, b);
        *reinterpret_cast<UnalignedWide*>(column) = times_gradient(columns.eight[q], b);
        *reinterpret_cast<UnalignedHalf*>(column + 8) = times_gradient(columns.last[q], b);
      }
  }
  return first;
}

/// Number of products of the hoop stress and strain of a point.
template <class K>
inline constexpr int hoop_products = K::hoop ? K::dim + 1 : 0;

/// Appends the products of the hoop stress and strain of a point (axisymmetry): stress in the plane
/// by hoop strain, hoop stress by all strains. `current` are the point's gradients.
template <class K, int N, int Columns>
void append_hoop(const Response<K>& s, double volume, double radius, int n,
                 const double (*current)[Columns], const double* value,
                 ProductSum<K::dim * K::dim, N>& products) {
  constexpr int dim = K::dim;
  const double per_value = s.hoop_inverse / radius;
  const int first = products.append(hoop_products<K>);
  products.clear(first);
  auto* left = products.left(first);
  const double own = (s.tangent[2][2] - s.kirchhoff[2]) * per_value;
  for (int a = 0; a < n; ++a) {
    for (int i = 0; i < dim; ++i) {
      left[i][a] = 0.0;  // d tau_i / d hoop
      for (int r = 0; r < dim; ++r) left[i][a] += s.axis[i][r] * s.tangent[r][2] * current[r][a];
      products.right(first + i, a)[dim * i] = volume * per_value * value[a];
    }
    left[dim][a] = volume * per_value * value[a];
    double* by_hoop = products.right(first + dim, a);
    for (int k = 0; k < dim; ++k)  // d tau_hoop / d l
      for (int r = 0; r < dim; ++r) by_hoop[k] += s.tangent[2][r] * s.axis[k][r] * current[r][a];
    by_hoop[0] += own * value[a];
  }
}

/// What the stiffness of one body depends on; see add_stiffness() below.
template <class K>
struct PointArrays {
  const double* volume;
  const double* position;
  const Response<K>* response;
  const Centres* centres;
};

/// Adds the stiffness of a group of N nodes (0 for a number known at run time), whose nodes have
/// these places in the local matrix. `overwrite`: see ProductSum.
template <class K, bool FBar, int N>
void add_group(const Stencil& stencil, const PointArrays<K>& points, std::int64_t group,
               const std::uint8_t* place, bool overwrite, LocalMatrix<K::dim * K::dim>& local) {
  constexpr int dim = K::dim;
  const int n = N > 0 ? N : stencil.nodes_of(group);
  const std::int64_t start = stencil.start[group];
  ProductSum<dim * dim, N> products(n, place, local, overwrite);
  std::optional<CellTerms<K, N>> terms;
  if constexpr (FBar) terms.emplace(*points.centres, group, n, local.symmetric);
  static_assert(dim + hoop_products<K> + f_bar_products<K> <= ProductSum<dim * dim, N>::capacity);
  int room = dim + hoop_products<K>;  // for the products of a point
  if constexpr (FBar) room += terms->single ? 0 : f_bar_products<K>;
  GroupBasis<dim, N, K::hoop, true> basis(stencil, group);
  for (std::int64_t p = start; p < stencil.start[group + 1]; ++p) {
    basis.advance();
    products.reserve(room);
    const Response<K>& s = points.response[p];
    const double volume = points.volume[p];
    const auto append = [&](const Response<K>& of_point) {
      const int first = append_point<K, N>(of_point, volume, n, basis.gradient, products);
      if constexpr (K::hoop)
        append_hoop<K, N>(of_point, volume, points.position[dim * p], n, products.left(first),
                          basis.value, products);
      return first;
    };
    if constexpr (FBar) {
      const double excess = excess_pressure(s, points.centres->pressure[p]);
      const VolumetricModuli<K> moduli(s);
      const int first = append(through_point(s, moduli, excess));
      double per_value = 0.0;
      if constexpr (K::hoop) per_value = s.hoop_inverse / points.position[dim * p];
      terms->add(s, moduli, excess, volume, p - start, products.left(first), basis.value, per_value,
                 products);
    } else {
      append(s);
    }
  }
  if constexpr (FBar) terms->finish(products);
  products.finish();
  if constexpr (FBar) terms->add_second_derivatives(place, local);
}

/// Returns whether all `blocks` are inside of the matrix and all nodes inside of `boxes`; those of
/// other clusters are not added.
/// `volume`: V0 of each point, with F-bar V0 J / J_bar at the start of the step.
template <class K, bool FBar>
bool add_stiffness(const Stencil& stencil, const Boxes& boxes, const BlockPositions& blocks,
                   const PointArrays<K>& points, double* matrix) {
  constexpr int dim = K::dim;
  return add_groups<dim, dim * dim>(
      stencil, boxes, blocks, [&](std::int64_t p) { return is_symmetric(points.response[p]); },
      [&]<int N>(std::int64_t group, const std::uint8_t* place, bool overwrite,
                 LocalMatrix<dim * dim>& local) {
        add_group<K, FBar, N>(stencil, points, group, place, overwrite, local);
      },
      matrix);
}

/// See add_stiffness() above.
template <class K>
bool stiffness(const Stencil& stencil, const Boxes& boxes, const BlockPositions& blocks,
               const PointArrays<K>& points, double* matrix) {
  const auto add = points.centres != nullptr ? &add_stiffness<K, true> : &add_stiffness<K, false>;
  return add(stencil, boxes, blocks, points, matrix);
}

}  // namespace tilth::kernel
