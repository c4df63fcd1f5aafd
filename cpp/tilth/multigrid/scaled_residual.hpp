// SPDX-License-Identifier: BSD-3-Clause
// Residual scaled by the inverses of the diagonal blocks, for the smoother.
#pragma once

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "diagonal_blocks.hpp"

namespace tilth::multigrid {

/// Calls `use(first, count, z)` with the components z[Components][widest] of inverse * (base - A x)
/// for the nodes of each strip, zero for nodes that share a block, and then `add(i, v, z)` with
/// each component of these nodes. `base` may be null, for zero, and so may `x`.
template <int Components, class Use, class Add>
void for_scaled_residual(Level<Components>& level,
                         const std::type_identity_t<Field<Components>>* base,
                         const Field<Components>* x, Use use, Add add) {
  const auto strip = [&](std::int32_t first, std::int32_t count, const auto& product) {
    float residual[Components][widest],
        scaled[Components][widest] = {};  // lanes beyond `count` are ignored
    for (int i = 0; i < Components; ++i)
      for (int k = 0; k < widest; ++k)
        residual[i][k] = (base ? (*base)[i][first + k] : 0.0f) - product[i][k];
    for (int i = 0; i < Components; ++i)
      for (int j = 0; j < Components; ++j) {
        const float* inverse = level.inverse[i * Components + j] + first;
        for (int k = 0; k < widest; ++k) scaled[i][k] += inverse[k] * residual[j][k];
      }
    if (std::memchr(level.has_own_block.data() + first, 0,
                    count))  // needed below for shared blocks
      for (int i = 0; i < Components; ++i) store(residual[i], count, level.residual[i] + first);
    use(first, count, scaled);
  };
  if (x) {
    level.strips.for_product(*x, strip);
  } else {
    const float zero[Components][widest] = {};
#pragma omp parallel for schedule(static) if (level.threaded())
    for (std::int32_t first = 0; first < level.nodes(); first += widest)
      strip(first, std::min(widest, level.nodes() - first), zero);
  }
  constexpr int column = maximum_block_nodes * Components;
  const auto groups = static_cast<std::int64_t>(level.shared_start.size()) - 1;
#pragma omp parallel for schedule(static) if (level.threaded() && groups > 0)
  for (std::int64_t g = 0; g < groups; ++g) {
    alignas(64) float scaled[column] = {};
    const float* inverse =
        level.shared_inverse.data() + level.shared_start[g] * Components * column;
    for (std::int64_t k = level.shared_start[g]; k < level.shared_start[g + 1]; ++k)
      for (int j = 0; j < Components; ++j, inverse += column) {
        const float residual = level.residual[j][level.shared_node[k]];
#pragma omp simd
        for (int i = 0; i < column; ++i) scaled[i] += inverse[i] * residual;
      }
    const float* part = scaled;
    for (std::int64_t k = level.shared_start[g]; k < level.shared_start[g + 1];
         ++k, part += Components)
      for (int i = 0; i < Components; ++i) add(i, level.shared_node[k], part[i]);
  }
}

}  // namespace tilth::multigrid
