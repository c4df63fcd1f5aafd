// SPDX-License-Identifier: BSD-3-Clause
// Chebyshev smoother on the operator scaled by the inverses of its diagonal blocks (Saad 2003,
// algorithm 12.1; Adams et al. 2003), and the bound of that operator's eigenvalues.
#pragma once

#include <algorithm>
#include <cmath>

#include "diagonal.hpp"

namespace tilth::multigrid {

inline constexpr int degree = 3;
inline constexpr float smoothed_share = 0.08f;  // least eigenvalue damped, over the largest
inline constexpr float safety = 1.1f;           // on the largest eigenvalue that was found

/// Bounds the eigenvalues by power iterations, from what the last call ended with. A mode of few
/// nodes shows in the largest entry before it shows in the norm.
template <int Dim>
void bound_eigenvalues(Level<Dim>& level, int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    for_scaled_residual(level, nullptr, level.eigenvector.data(),
                        [&](std::int32_t v, const float* scaled) {
                          for (std::int64_t at = std::int64_t{v} * Dim, i = 0; i < Dim; ++i)
                            level.other[at + i] = -scaled[i];
                        });
    double size = 0.0, before = 0.0;  // in a fixed order: not threaded
    float most = 0.0f, most_before = 0.0f;
    for (std::int64_t i = 0; i < level.unknowns(); ++i) {
      size += double{level.other[i]} * level.other[i];
      before += double{level.eigenvector[i]} * level.eigenvector[i];
      most = std::max(most, std::abs(level.other[i]));
      most_before = std::max(most_before, std::abs(level.eigenvector[i]));
    }
    if (!(size > 0.0)) return;
    level.largest =
        safety * std::max(static_cast<float>(std::sqrt(size / before)), most / most_before);
    const auto factor = static_cast<float>(1.0 / std::sqrt(size));
    for (std::int64_t i = 0; i < level.unknowns(); ++i)
      level.eigenvector[i] = factor * level.other[i];
  }
}

/// Improves `solution` for the right side `right`; from zero where `from_zero`.
template <int Dim>
void smooth(Level<Dim>& level, bool from_zero) {
  const float centre = 0.5f * level.largest * (1.0f + smoothed_share);
  const float radius = 0.5f * level.largest * (1.0f - smoothed_share);
  const float ratio = centre / radius;
  float rho = 1.0f / ratio;
  for (int step = 0; step < degree; ++step) {
    const float next = 1.0f / (2.0f * ratio - rho);
    const float keep = step == 0 ? 0.0f : next * rho;
    const float add = step == 0 ? 1.0f / centre : 2.0f * next / radius;
    const float* old = level.solution.data();
    const bool zero = step == 0 && from_zero;
    for_scaled_residual(
        level, level.right.data(), zero ? nullptr : old, [&](std::int32_t v, const float* scaled) {
          for (std::int64_t at = std::int64_t{v} * Dim, i = 0; i < Dim; ++i) {
            const float before = step == 0 ? 0.0f : keep * level.change[at + i];
            level.change[at + i] = before + add * scaled[i];
            level.other[at + i] = (zero ? 0.0f : old[at + i]) + level.change[at + i];
          }
        });
    if (step > 0) rho = next;
    std::swap(level.solution, level.other);
  }
}

}  // namespace tilth::multigrid
