// SPDX-License-Identifier: BSD-3-Clause
// Blocks between two nodal fields of R and C components from a matrix D of each point,
//   block_ab[i][j] = sum_p sum_kl S_pa[k] D_p[i][k][j][l] S_pb[l],   S = (value, gradient),
// such as those of soil and water in its pores: D is the derivative of the point's values and
// fluxes of the row's field (point_integrals.hpp) by value and gradient of the column's.
// Each part k of a point is one outer product: S_a[k] times the sum over l. Parts that are zero are
// left out, of which coupled fields have many. Their sums are made as those of the stiffness.
#pragma once

#include <algorithm>

#include "assembly.hpp"
#include "basis_values.hpp"

namespace tilth::kernel {

/// Matrices D of points, (points, R, 1 + Dim, C, 1 + Dim).
template <int Dim, int R, int C>
struct PointMatrices {
  static constexpr int parts = 1 + Dim;  // value, and gradient in each direction
  static constexpr int entries = R * C;  // of a block
  static constexpr int size = R * parts * C * parts;

  const double* data;

  const double* of(std::int64_t point) const { return data + size * point; }

  bool is_symmetric(std::int64_t point) const {
    if constexpr (R != C) return false;
    const double* d = of(point);
    for (int row = 1; row < R * parts; ++row)
      for (int column = 0; column < row; ++column)
        if (d[row * C * parts + column] != d[column * C * parts + row]) return false;
    return true;
  }
};

/// Appends the product of part k of a point with this matrix; `part` has its basis, [l][node].
template <int Dim, int R, int C, int N>
void append_part(const double* matrix, int k, int n, const double* const (&part)[1 + Dim],
                 ProductSum<R * C, N>& products) {
  constexpr int parts = 1 + Dim, entries = R * C, lanes = ProductSum<entries, N>::lanes;
  alignas(32) double factor[parts][lanes] = {};  // [l]: a block (i, j), then zeros
  bool other = false;
  for (int i = 0; i < R; ++i)
    for (int j = 0; j < C; ++j)
      for (int l = 0; l < parts; ++l) {
        const double number = matrix[((i * parts + k) * C + j) * parts + l];
        factor[l][i * C + j] = number;
        other |= number != 0.0;
      }
  if (!other) return;
  const int t = products.append(1);
  std::copy_n(part[k], n, *products.left(t));
  if constexpr (entries == 1) {
    double row[N > 0 ? N : maximum_nodes];
    for (int b = 0; b < n; ++b) {
      row[b] = factor[0][0] * part[0][b];
      for (int l = 1; l < parts; ++l) row[b] += factor[l][0] * part[l][b];
    }
    for (int b = 0; b < n; ++b) *products.right(t, b) = row[b];
  } else {
    for (int b = 0; b < n; ++b) {
      double* block = products.right(t, b);
      for (int first = 0; first < lanes; first += 4) {
        HalfLanes sum = part[0][b] * *reinterpret_cast<const UnalignedHalf*>(factor[0] + first);
        for (int l = 1; l < parts; ++l)
          sum += part[l][b] * *reinterpret_cast<const UnalignedHalf*>(factor[l] + first);
        *reinterpret_cast<UnalignedHalf*>(block + first) = sum;
      }
    }
  }
}

/// Adds the blocks to `matrix` (blocks, R, C). Returns whether all `blocks` are inside of it and
/// all nodes inside of `boxes`; those of other clusters are not added.
template <int Dim, int R, int C>
bool add_point_blocks(const Stencil& stencil, const Boxes& boxes, const BlockPositions& blocks,
                      const double* point_matrices, double* matrix) {
  constexpr int parts = 1 + Dim, entries = R * C;
  const PointMatrices<Dim, R, C> matrices{point_matrices};
  const auto add_group = [&]<int N>(std::int64_t g, const std::uint8_t* place, bool overwrite,
                                    LocalMatrix<entries>& local) {
    const int n = N > 0 ? N : stencil.nodes_of(g);
    static_assert(parts <= ProductSum<entries, N>::capacity);
    ProductSum<entries, N> products(n, place, local, overwrite);
    GroupBasis<Dim, N, true, true> basis(stencil, g);
    for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
      basis.advance();
      products.reserve(parts);
      const double* part[parts] = {basis.value};
      for (int l = 1; l < parts; ++l) part[l] = basis.gradient + (l - 1) * n;
      for (int k = 0; k < parts; ++k)
        append_part<Dim, R, C, N>(matrices.of(p), k, n, part, products);
    }
    products.finish();
  };
  return add_groups<Dim, entries>(
      stencil, boxes, blocks, [&](std::int64_t p) { return matrices.is_symmetric(p); }, add_group,
      matrix);
}

}  // namespace tilth::kernel
