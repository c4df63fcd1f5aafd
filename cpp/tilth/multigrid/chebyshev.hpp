// SPDX-License-Identifier: BSD-3-Clause
// Chebyshev smoother on the operator scaled by the inverses of its diagonal blocks (Saad 2003,
// algorithm 12.1; Adams et al. 2003), and the bound of that operator's eigenvalues.
#pragma once

#include <algorithm>
#include <cmath>

#include "scaled_residual.hpp"

namespace tilth::multigrid {

inline constexpr int degree = 5;
inline constexpr float smoothed_share = 0.025f;  // least eigenvalue damped, over the largest
inline constexpr float safety = 1.1f;            // factor on the estimated largest eigenvalue

/// Bounds the eigenvalues by power iterations that start from the last call's vector. The largest
/// entry responds to a mode of few nodes sooner than the norm does.
template <int Components>
void bound_eigenvalues(Level<Components>& level, int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    for_scaled_residual(
        level, nullptr, &level.eigenvector,
        [&](std::int32_t first, std::int32_t count, const auto& scaled) {
          for (int i = 0; i < Components; ++i) store(scaled[i], count, level.other[i] + first);
        },
        [&](int i, std::int32_t v, float scaled) { level.other[i][v] = scaled; });
    double size = 0.0, before = 0.0;  // not threaded, for a fixed order of summation
    float greatest = 0.0f, greatest_before = 0.0f;
    for (int i = 0; i < Components; ++i) {
      const float *now = level.other[i], *last = level.eigenvector[i];
#pragma omp simd reduction(+ : size, before) reduction(max : greatest, greatest_before)
      for (std::int32_t v = 0; v < level.nodes(); ++v) {
        size += double{now[v]} * now[v];
        before += double{last[v]} * last[v];
        greatest = std::max(greatest, std::abs(now[v]));
        greatest_before = std::max(greatest_before, std::abs(last[v]));
      }
    }
    if (!(size > 0.0)) return;
    level.largest =
        safety * std::max(static_cast<float>(std::sqrt(size / before)), greatest / greatest_before);
    const auto factor = static_cast<float>(1.0 / std::sqrt(size));
    for (int i = 0; i < Components; ++i)
      for (std::int32_t v = 0; v < level.nodes(); ++v)
        level.eigenvector[i][v] = factor * level.other[i][v];
  }
}

/// Improves `solution` for the right side `right`; from zero where `from_zero`.
template <int Components>
void smooth(Level<Components>& level, bool from_zero) {
  const float centre = 0.5f * level.largest * (1.0f + smoothed_share);
  const float radius = 0.5f * level.largest * (1.0f - smoothed_share);
  const float ratio = centre / radius;
  float rho = 1.0f / ratio;
  for (int step = 0; step < degree; ++step) {
    const float next = 1.0f / (2.0f * ratio - rho);
    const float keep = step == 0 ? 0.0f : next * rho;
    const float add = step == 0 ? 1.0f / centre : 2.0f * next / radius;
    const bool zero = step == 0 && from_zero;
    for_scaled_residual(
        level, &level.right, zero ? nullptr : &level.solution,
        [&](std::int32_t first, std::int32_t count, const auto& scaled) {
          for (int i = 0; i < Components; ++i) {
            const float *correction = level.correction[i] + first, *old = level.solution[i] + first;
            float next_correction[widest], improved[widest];
            for (int k = 0; k < widest; ++k) {
              next_correction[k] = keep * correction[k] + add * scaled[i][k];
              improved[k] = (zero ? 0.0f : old[k]) + next_correction[k];
            }
            store(next_correction, count, level.correction[i] + first);
            store(improved, count, level.other[i] + first);
          }
        },
        [&](int i, std::int32_t v, float scaled) {
          level.correction[i][v] += add * scaled;
          level.other[i][v] += add * scaled;
        });
    std::swap(level.solution, level.other);
    if (step > 0) rho = next;
  }
}

}  // namespace tilth::multigrid
