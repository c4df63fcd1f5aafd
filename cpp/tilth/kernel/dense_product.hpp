// SPDX-License-Identifier: BSD-3-Clause
// Product of small dense matrices, the innermost loop of the stiffness, in tiles that stay in the
// vector registers.
#pragma once

#include <algorithm>
#include <cstring>

#include "../lanes.hpp"

namespace tilth::kernel {

/// Columns of a row whose length is a whole number of vector registers.
constexpr int padded_columns(int columns) { return (columns + 3) / 4 * 4; }

/// Destination of a product: to[a * stride + b], overwritten if `overwrite`, else added to.
struct Target {
  double* to;
  int stride;
  bool overwrite;
};

/// sum_t left[t][a] right[t][b] for a in [row, row + 4) and b in [column, column + 4 Width), both
/// below n. Rows have `Capacity` columns, aligned, of which those from n to the next multiple of 4
/// are padding. Narrow tiles have two sums, of the even and of the odd terms, so that consecutive
/// additions are independent.
template <int Capacity, int Width>
void tile_product(int n, int terms, const double (*left)[Capacity], const double (*right)[Capacity],
                  int row, int column, const Target& out) {
  constexpr int sums = Width == 1 ? 2 : 1;
  HalfLanes sum[sums][4][Width] = {};
  const auto add = [&](int t, int into) {
    for (int a = 0; a < 4; ++a)
      for (int v = 0; v < Width; ++v)
        sum[into][a][v] +=
            left[t][row + a] * *reinterpret_cast<const HalfLanes*>(right[t] + column + 4 * v);
  };
  int t = 0;
  for (; t + sums <= terms; t += sums)
    for (int into = 0; into < sums; ++into) add(t + into, into);
  if (t < terms) add(t, 0);
  const int rows = std::min(4, n - row);
  for (int a = 0; a < rows; ++a)
    for (int v = 0; v < Width; ++v) {
      double* to = out.to + (row + a) * out.stride + column + 4 * v;
      HalfLanes total = sum[0][a][v];
      if constexpr (sums == 2) total += sum[1][a][v];
      if (n - column >= 4 * (v + 1)) {
        HalfLanes before = {};
        if (!out.overwrite) std::memcpy(&before, to, sizeof before);
        total += before;
        std::memcpy(to, &total, sizeof total);
      } else {
        for (int b = 0; b < n - column - 4 * v; ++b)
          to[b] = out.overwrite ? total[b] : to[b] + total[b];
      }
    }
}

/// sum_t left[t][a] right[t][b], a and b below n.
template <int Capacity>
void product(int n, int terms, const double (*left)[Capacity], const double (*right)[Capacity],
             const Target& out) {
  for (int row = 0; row < n; row += 4)
    for (int column = 0; column < n; column += 8) {
      if (n - column > 4)
        tile_product<Capacity, 2>(n, terms, left, right, row, column, out);
      else
        tile_product<Capacity, 1>(n, terms, left, right, row, column, out);
    }
}

}  // namespace tilth::kernel
