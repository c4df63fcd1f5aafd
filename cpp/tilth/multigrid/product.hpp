// SPDX-License-Identifier: BSD-3-Clause
// Double-precision products and sums of the Krylov methods, with the same bits for any number of
// threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "../parallel.hpp"

namespace tilth::multigrid {

/// product <- A x for node blocks (entries, Dim, Dim), zero for held unknowns.
template <int Dim>
void block_product(std::int64_t nodes, const std::int64_t* row_start, const std::int32_t* column,
                   const double* blocks, const bool* held, const double* x, double* product) {
#pragma omp parallel for schedule(static) if (row_start[nodes] >= 8 * parallel_from)
  for (std::int64_t v = 0; v < nodes; ++v) {
    double sum[Dim] = {};
    for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e) {
      const double* block = blocks + e * Dim * Dim;
      const double* other = x + std::int64_t{column[e]} * Dim;
      for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) sum[i] += block[i * Dim + j] * other[j];
    }
    for (int i = 0; i < Dim; ++i) product[v * Dim + i] = held[v * Dim + i] ? 0.0 : sum[i];
  }
}

/// Inner product: pieces of a fixed length, their sums added in order.
inline double inner(std::int64_t n, const double* a, const double* b) {
  constexpr std::int64_t piece = 4096;
  const std::int64_t pieces = (n + piece - 1) / piece;
  std::vector<double> sums(pieces, 0.0);
#pragma omp parallel for schedule(static) if (n >= 8 * parallel_from)
  for (std::int64_t p = 0; p < pieces; ++p) {
    double sum = 0.0;
#pragma omp simd reduction(+ : sum)
    for (std::int64_t i = p * piece; i < std::min(n, (p + 1) * piece); ++i) sum += a[i] * b[i];
    sums[p] = sum;
  }
  double total = 0.0;
  for (const double sum : sums) total += sum;
  return total;
}

}  // namespace tilth::multigrid
