// SPDX-License-Identifier: BSD-3-Clause
// Double-precision vector operations of the Krylov methods; results are identical for any number of
// threads.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "../indices.hpp"
#include "../parallel.hpp"

namespace tilth::multigrid {

/// product <- A x for node blocks (entries, Components, Components) and each of some vectors, zero
/// for constrained unknowns. Returns whether all columns are those of nodes.
template <int Components, std::size_t Count>
bool block_product(std::int64_t nodes, const std::int64_t* row_start, const std::int32_t* column,
                   const double* blocks, const bool* constrained,
                   std::array<const double*, Count> x, std::array<double*, Count> product) {
  constexpr std::int64_t rows_at_once = 32;  // whose columns are in the cache when they are used
  bool outside = false;
#pragma omp parallel for schedule(static) \
    reduction(|| : outside) if (row_start[nodes] >= 8 * parallel_from)
  for (std::int64_t first = 0; first < nodes; first += rows_at_once) {
    const std::int64_t end = std::min(first + rows_at_once, nodes);
    if (!all_below(column + row_start[first], row_start[end] - row_start[first], nodes)) {
      outside = true;
      continue;
    }
    for (std::int64_t v = first; v < end; ++v) {
      double sum[Count][Components] = {};
      for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e) {
        const double* block = blocks + e * Components * Components;
        for (std::size_t k = 0; k < Count; ++k) {
          const double* other = x[k] + std::int64_t{column[e]} * Components;
          for (int i = 0; i < Components; ++i)
            for (int j = 0; j < Components; ++j) sum[k][i] += block[i * Components + j] * other[j];
        }
      }
      for (std::size_t k = 0; k < Count; ++k)
        for (int i = 0; i < Components; ++i)
          product[k][v * Components + i] = constrained[v * Components + i] ? 0.0 : sum[k][i];
    }
  }
  return !outside;
}

/// Calls `add(begin, end)` for pieces of a fixed length and adds their `Count` sums in order.
template <int Count, class Add>
std::array<double, Count> sum_in_pieces(std::int64_t n, Add add) {
  constexpr std::int64_t piece = 4096;
  const std::int64_t pieces = (n + piece - 1) / piece;
  std::vector<std::array<double, Count>> sums(pieces);
#pragma omp parallel for schedule(static) if (n >= 8 * parallel_from)
  for (std::int64_t p = 0; p < pieces; ++p) {
    sums[p] = add(p * piece, std::min(n, (p + 1) * piece));
  }
  std::array<double, Count> total{};
  for (const auto& own : sums)
    for (int k = 0; k < Count; ++k) total[k] += own[k];
  return total;
}

inline double inner(std::int64_t n, const double* a, const double* b) {
  return sum_in_pieces<1>(n, [=](std::int64_t begin, std::int64_t end) {
    double sum = 0.0;
#pragma omp simd reduction(+ : sum)
    for (std::int64_t i = begin; i < end; ++i) sum += a[i] * b[i];
    return std::array{sum};
  })[0];
}

/// a . b and a . c in one pass.
inline std::array<double, 2> two_inner(std::int64_t n, const double* a, const double* b,
                                       const double* c) {
  return sum_in_pieces<2>(n, [=](std::int64_t begin, std::int64_t end) {
    double with_b = 0.0, with_c = 0.0;
#pragma omp simd reduction(+ : with_b, with_c)
    for (std::int64_t i = begin; i < end; ++i) with_b += a[i] * b[i], with_c += a[i] * c[i];
    return std::array{with_b, with_c};
  });
}

/// y <- a x + b y.
inline void combine(std::int64_t n, double a, const double* x, double b, double* y) {
#pragma omp parallel for simd schedule(static) if (n >= 8 * parallel_from)
  for (std::int64_t i = 0; i < n; ++i) y[i] = a * x[i] + b * y[i];
}

/// A step of conjugate gradients: x <- x + length p, r <- r - length q; returns r . r.
inline double advance(std::int64_t n, double length, const double* p, const double* q, double* x,
                      double* r) {
  return sum_in_pieces<1>(n, [=](std::int64_t begin, std::int64_t end) {
    double sum = 0.0;
#pragma omp simd reduction(+ : sum)
    for (std::int64_t i = begin; i < end; ++i) {
      x[i] += length * p[i];
      r[i] -= length * q[i];
      sum += r[i] * r[i];
    }
    return std::array{sum};
  })[0];
}

/// A v . A v, u . A v and v . A u; none if a column is not that of a node.
template <int Components>
std::optional<std::array<double, 3>> asymmetry(std::int64_t nodes, const std::int64_t* row_start,
                                               const std::int32_t* column, const double* blocks,
                                               const bool* constrained, const double* u,
                                               const double* v) {
  const std::int64_t n = nodes * Components;
  std::vector<double> of_u(n), of_v(n);
  if (!block_product<Components, 2>(nodes, row_start, column, blocks, constrained, {u, v},
                                    {of_u.data(), of_v.data()}))
    return std::nullopt;
  const auto [size, u_of_v] = two_inner(n, of_v.data(), of_v.data(), u);
  return std::array{size, u_of_v, inner(n, of_u.data(), v)};
}

}  // namespace tilth::multigrid
