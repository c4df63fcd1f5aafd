// SPDX-License-Identifier: BSD-3-Clause
// Product of small dense matrices, the innermost loop of the stiffness, in tiles that stay in the
// vector registers.
#pragma once

#include <utility>

#include "../lanes.hpp"

namespace tilth::kernel {

/// Columns of a row whose length is a whole number of vector registers.
constexpr int padded_columns(int columns) { return (columns + 3) / 4 * 4; }

using WideLanes = double __attribute__((vector_size(64)));

/// Four and eight numbers at any address.
using UnalignedHalf = double __attribute__((vector_size(32), aligned(8), may_alias));
using UnalignedWide = double __attribute__((vector_size(64), aligned(8), may_alias));

#ifdef __AVX512F__
inline constexpr bool wide_registers = true;  // of eight numbers, and 32 of them
#else
inline constexpr bool wide_registers = false;
#endif

inline WideLanes join(const HalfLanes& low, const HalfLanes& high) {
  return WideLanes{low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]};
}

/// Stores the lower (0) or the upper half (1).
template <int Half>
void store_half(const WideLanes& x, double* to) {
  *reinterpret_cast<UnalignedHalf*>(to) =
      UnalignedHalf{x[4 * Half], x[4 * Half + 1], x[4 * Half + 2], x[4 * Half + 3]};
}

/// Rows of a tile for products of n rows, 0 for a number known at run time.
constexpr int tile_rows(int n) { return n > 0 && n % 4 == 0 ? 4 : 3; }

/// Largest number of registers in a row of a tile, with room for the factors.
constexpr int tile_width(int rows) { return (wide_registers ? 24 : 12) / rows; }

/// Calls body<0>() to body<Count - 1>(): the indices of registers must be constants.
template <int Count, class Body>
[[gnu::always_inline]] inline void unrolled(const Body& body) {
  [&]<int... I>(std::integer_sequence<int, I...>) __attribute__((always_inline)) {
    (body.template operator()<I>(), ...);
  }(std::make_integer_sequence<int, Count>{});
}

/// Adds sum_t left[t][row + a] right[t][column + c], c in [0, 4 Width), to to[a][column + c], or
/// sets it if `overwrite`.
template <int Rows, int Width, int Left, int Right>
void tile_product(int terms, const double (*left)[Left], const double (*right)[Right], int row,
                  int column, double* const (&to)[Rows], bool overwrite) {
  constexpr int wide = wide_registers ? Width / 2 : 0, half = Width - 2 * wide;
  constexpr int of_wide = Rows * wide, of_half = Rows * half;
  const auto wide_at = [&](int i) {
    return reinterpret_cast<UnalignedWide*>(to[i / wide] + column) + i % wide;
  };
  const auto half_at = [&](int i) {
    return reinterpret_cast<UnalignedHalf*>(to[i / half] + column + 8 * wide) + i % half;
  };
  WideLanes first[of_wide > 0 ? of_wide : 1];
  HalfLanes rest[of_half > 0 ? of_half : 1];
  unrolled<of_wide>([&]<int I>() { first[I] = overwrite ? WideLanes{} : WideLanes(*wide_at(I)); });
  unrolled<of_half>([&]<int I>() { rest[I] = overwrite ? HalfLanes{} : HalfLanes(*half_at(I)); });
  for (int t = 0; t < terms; ++t) {
    const double* factor = right[t] + column;
    unrolled<of_wide>([&]<int I>() {
      first[I] +=
          left[t][row + I / wide] * reinterpret_cast<const UnalignedWide*>(factor)[I % wide];
    });
    unrolled<of_half>([&]<int I>() {
      rest[I] += left[t][row + I / half] *
                 reinterpret_cast<const UnalignedHalf*>(factor + 8 * wide)[I % half];
    });
  }
  unrolled<of_wide>([&]<int I>() { *wide_at(I) = first[I]; });
  unrolled<of_half>([&]<int I>() { *half_at(I) = rest[I]; });
}

/// tile_product for the columns [column, end), a multiple of four.
template <int Rows, int Width = tile_width(Rows), int Left, int Right>
void row_product(int terms, const double (*left)[Left], const double (*right)[Right], int row,
                 int column, int end, double* const (&to)[Rows], bool overwrite) {
  for (; end - column >= 4 * Width; column += 4 * Width)
    tile_product<Rows, Width>(terms, left, right, row, column, to, overwrite);
  if constexpr (Width > 1)
    if (column < end)
      row_product<Rows, Width - 1>(terms, left, right, row, column, end, to, overwrite);
}

}  // namespace tilth::kernel
