// SPDX-License-Identifier: BSD-3-Clause
// What F-bar adds to the stiffness (docs/theory/f_bar.md, "Tangent"). With g and A the derivatives
// of ln J and ln J0 of a point, e the excess pressure, n the number of stretched directions, and
//   m_p = sum_r D_pr / n - d,   m'_r = sum_p D_pr / n - d,   d = sum_pr D_pr / n^2,
// the derivative of (tau - e 1) : grad + e A is
// - the tangent of the standard method for D_pr - m_p - m'_r - d and tau - e (`through_point`),
// - M (x) A + A (x) (M' + d A - e A), with M = sum_p m_p g_p and M' = sum_r m'_r g_r,
// - e times the second derivatives of the cells' J0 over J0.
// In axisymmetry A = T + U, of the in-plane part and of the hoop stretch, and A (x) A becomes
// T (x) T + U (x) U in the term with e.
#pragma once

#include "f_bar.hpp"
#include "local_matrix.hpp"
#include "response.hpp"

namespace tilth::kernel {

/// m, m' and d above.
template <class K>
struct VolumetricModuli {
  double row[3] = {}, column[3] = {}, both = 0.0;

  explicit VolumetricModuli(const Response<K>& s) {
    constexpr int n = f_bar_directions<K>;
    constexpr double part = 1.0 / n;
    for (int p = 0; p < n; ++p)
      for (int r = 0; r < n; ++r) {
        row[p] += part * s.tangent[p][r];
        column[r] += part * s.tangent[p][r];
      }
    for (int p = 0; p < n; ++p) both += part * row[p];
    for (int p = 0; p < n; ++p) {
      row[p] -= both;
      column[p] -= both;
    }
  }
};

/// The response whose standard tangent is the part that acts through the point's own gradient.
template <class K>
Response<K> through_point(const Response<K>& s, const VolumetricModuli<K>& moduli, double excess) {
  Response<K> own = s;
  for (int p = 0; p < f_bar_directions<K>; ++p) {
    own.kirchhoff[p] -= excess;
    for (int r = 0; r < f_bar_directions<K>; ++r)
      own.tangent[p][r] -= moduli.row[p] + moduli.column[r] + moduli.both;
  }
  return own;
}

/// Number of products of the terms that act through the cells.
template <class K>
inline constexpr int f_bar_products = 2 * K::dim + (K::hoop ? 1 : 0);

/// The terms of one group that act through its cells. Where a group has one cell, all its points
/// have the same A, and the products are those of their sums. `symmetric`: M = M'. N nodes, 0 for
/// a number known at run time.
template <class K, int N>
class CellTerms {
 public:
  static constexpr int dim = K::dim;
  static constexpr int capacity = ProductSum<dim * dim, N>::nodes;

  CellTerms(const Centres& centres, std::int64_t group, int nodes, bool symmetric)
      : single(centres.cells_of(group) == 1),
        centres_(centres),
        cells_(centres, group),
        group_(group),
        nodes_(nodes),
        symmetric_(symmetric) {
    for (int c = 0; c < cells_.count; ++c) weight_[c] = 0.0;
    if (single) start(0);
  }

  CellTerms(const CellTerms&) = delete;
  CellTerms& operator=(const CellTerms&) = delete;

  const bool single;  // whether the group has one cell

  /// Adds a point, the `index`th of the group, to the sums or its products, for which there is
  /// room, to `products`; `current` are its gradients (dim, capacity) and `hoop_per_value` is the
  /// hoop strain per radial displacement.
  void add(const Response<K>& s, const VolumetricModuli<K>& moduli, double excess, double volume,
           std::int64_t index, const double (*current)[capacity], const double* value,
           double hoop_per_value, ProductSum<dim * dim, N>& products) {
    if (single) {
      weight_[0] += volume * excess;
    } else {
      start(index);
      for (int c = 0; c < cells_.count; ++c) weight_[c] += volume * excess * factors_.in_plane[c];
    }
    sum_both_ += volume * moduli.both;
    sum_excess_ += volume * excess;
    add_gradients(s, moduli.row, volume, current, value, hoop_per_value, row_);
    if (!symmetric_)
      add_gradients(s, moduli.column, volume, current, value, hoop_per_value, column_);
    if (!single) append_products(products);
  }

  /// Adds the products of the sums.
  void finish(ProductSum<dim * dim, N>& products) const {
    if (!single) return;
    products.reserve(f_bar_products<K>);
    append_products(products);
  }

  /// Adds the second derivatives of the determinant, over it: trace_ai trace_bk - trace_ak
  /// trace_bi. The nodes of the group have these places.
  void add_second_derivatives(const std::uint8_t* place, LocalMatrix<dim * dim>& local) const {
    constexpr int corners = 1 << dim;
    for (int c = 0; c < cells_.count; ++c) {
      if (weight_[c] == 0.0) continue;
      const double* trace = centres_.trace + std::int64_t{cells_.cell[c]} * corners * dim;
      const std::int32_t* node = cells_.node[c];
      for (int a = 0; a < corners; ++a)
        for (int b = symmetric_ ? a : 0; b < corners; ++b) {
          double* block = local.block(place[node[a]], place[node[b]]);
          for (int i = 0; i < dim; ++i)
            for (int k = 0; k < dim; ++k)
              block[i * dim + k] += weight_[c] * (trace[a * dim + i] * trace[b * dim + k] -
                                                  trace[a * dim + k] * trace[b * dim + i]);
        }
    }
  }

 private:
  const Centres& centres_;
  const GroupCells<dim> cells_;
  const std::int64_t group_;
  const int nodes_;
  const bool symmetric_;
  CellFactors factors_;           // of the last point
  double weight_[maximum_nodes];  // of each cell's second derivatives
  double sum_both_, sum_excess_;
  alignas(32) double in_plane_[dim][capacity], hoop_[K::hoop ? capacity : 1];  // T and U
  alignas(32) double row_[dim][capacity], column_[dim][capacity];              // M and M'

  int n() const { return N > 0 ? N : nodes_; }

  /// Finds T and U of a point, and begins new sums.
  void start(std::int64_t index) {
    find_factors<K>(centres_, cells_, centres_.first_share(group_, index), factors_);
    sum_both_ = sum_excess_ = 0.0;
    for (auto* vector : {in_plane_, row_, column_})
      for (int i = 0; i < dim; ++i)
        for (int a = 0; a < n(); ++a) vector[i][a] = 0.0;
    add_traces<dim, capacity>(centres_, cells_, factors_.in_plane, in_plane_);
    if constexpr (K::hoop) {
      for (int a = 0; a < n(); ++a) hoop_[a] = 0.0;
      add_hoop_gradients(centres_, cells_, factors_.hoop, hoop_);
    }
  }

  /// Adds volume times sum_p modulus_p g_p to `sum`.
  void add_gradients(const Response<K>& s, const double modulus[3], double volume,
                     const double (*current)[capacity], const double* value, double hoop_per_value,
                     double sum[dim][capacity]) const {
    for (int i = 0; i < dim; ++i) {
      double factor[dim];
      for (int p = 0; p < dim; ++p) factor[p] = volume * modulus[p] * s.axis[i][p];
#pragma omp simd
      for (int a = 0; a < n(); ++a)
        for (int p = 0; p < dim; ++p) sum[i][a] += factor[p] * current[p][a];
    }
    if constexpr (K::hoop)
      for (int a = 0; a < n(); ++a) sum[0][a] += volume * modulus[2] * hoop_per_value * value[a];
  }

  /// Appends T (x) (M' + d A - e T) and M (x) A, in axisymmetry also U (x) (M' + d A - e U).
  void append_products(ProductSum<dim * dim, N>& products) const {
    const auto* column = symmetric_ ? row_ : column_;
    const int first = products.append(f_bar_products<K>);
    products.clear(first);
    auto* left = products.left(first);
    for (int i = 0; i < dim; ++i) {
      std::copy_n(in_plane_[i], n(), left[i]);
      std::copy_n(row_[i], n(), left[dim + i]);
    }
    if constexpr (K::hoop) std::copy_n(hoop_, n(), left[2 * dim]);
    for (int b = 0; b < n(); ++b)
      for (int k = 0; k < dim; ++k) {
        double all = in_plane_[k][b], by_hoop = 0.0;
        if constexpr (K::hoop) {
          all += k == 0 ? hoop_[b] : 0.0;
          by_hoop = k == 0 ? sum_excess_ * hoop_[b] : 0.0;
        }
        const double both = column[k][b] + sum_both_ * all;
        for (int i = 0; i < dim; ++i) {
          products.right(first + i, b)[i * dim + k] = both - sum_excess_ * in_plane_[k][b];
          products.right(first + dim + i, b)[i * dim + k] = all;
        }
        if constexpr (K::hoop) products.right(first + 2 * dim, b)[k] = both - by_hoop;
      }
  }
};

}  // namespace tilth::kernel
