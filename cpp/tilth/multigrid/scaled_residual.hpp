// SPDX-License-Identifier: BSD-3-Clause
// What the smoother needs of the matrix: the residual, scaled by the inverses of diagonal blocks.
#pragma once

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "diagonal.hpp"

namespace tilth::multigrid {

/// Calls `use(first, count, z)` with the components z[Dim][widest] of inverse * (base - A x) for
/// the nodes of each strip, zero on nodes that share a block, and then `add(i, v, z)` with each
/// component of those. `base` may be null, for zero, and so may `x`.
template <int Dim, class Use, class Add>
void for_scaled_residual(Level<Dim>& level, const std::type_identity_t<Field<Dim>>* base,
                         const Field<Dim>* x, Use use, Add add) {
  const auto strip = [&](std::int32_t first, std::int32_t count, const auto& product) {
    float rest[Dim][widest], scaled[Dim][widest] = {};  // lanes beyond `count` are ignored
    for (int i = 0; i < Dim; ++i)
      for (int k = 0; k < widest; ++k)
        rest[i][k] = (base ? (*base)[i][first + k] : 0.0f) - product[i][k];
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j) {
        const float* inverse = level.inverse[i * Dim + j] + first;
        for (int k = 0; k < widest; ++k) scaled[i][k] += inverse[k] * rest[j][k];
      }
    if (std::memchr(level.alone.data() + first, 0, count))  // those that share need it below
      for (int i = 0; i < Dim; ++i) store(rest[i], count, level.residual[i] + first);
    use(first, count, scaled);
  };
  if (x) {
    level.strips.for_product(*x, strip);
  } else {
    const float zero[Dim][widest] = {};
#pragma omp parallel for schedule(static) if (level.threaded())
    for (std::int32_t first = 0; first < level.nodes(); first += widest)
      strip(first, std::min(widest, level.nodes() - first), zero);
  }
  constexpr int column = most_in_a_block * Dim;
  const auto groups = static_cast<std::int64_t>(level.shared_start.size()) - 1;
#pragma omp parallel for schedule(static) if (level.threaded() && groups > 0)
  for (std::int64_t g = 0; g < groups; ++g) {
    alignas(64) float scaled[column] = {};
    const float* inverse = level.shared_inverse.data() + level.shared_start[g] * Dim * column;
    for (std::int64_t k = level.shared_start[g]; k < level.shared_start[g + 1]; ++k)
      for (int j = 0; j < Dim; ++j, inverse += column) {
        const float rest = level.residual[j][level.shared_node[k]];
#pragma omp simd
        for (int i = 0; i < column; ++i) scaled[i] += inverse[i] * rest;
      }
    const float* part = scaled;
    for (std::int64_t k = level.shared_start[g]; k < level.shared_start[g + 1]; ++k, part += Dim)
      for (int i = 0; i < Dim; ++i) add(i, level.shared_node[k], part[i]);
  }
}

}  // namespace tilth::multigrid
