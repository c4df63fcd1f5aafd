// SPDX-License-Identifier: BSD-3-Clause
// Chebyshev smoother on the operator scaled by the inverses of its diagonal blocks (Saad 2003,
// algorithm 12.1; Adams et al. 2003), and the bound of that operator's eigenvalues.
#pragma once

#include <algorithm>
#include <cmath>

#include "level.hpp"

namespace tilth::multigrid {

inline constexpr int degree = 3;
inline constexpr float smoothed_share = 0.08f;  // least eigenvalue damped, over the largest
inline constexpr float safety = 1.1f;           // on the largest eigenvalue that was found

/// out <- inverse of the node's diagonal block times `in`.
template <int Dim>
void scale(const Level<Dim>& level, std::int32_t v, const float* in, float* out) {
  const float* inverse = level.inverse.data() + std::int64_t{v} * Dim * Dim;
  for (int i = 0; i < Dim; ++i) {
    out[i] = 0.0f;
    for (int j = 0; j < Dim; ++j) out[i] += inverse[i * Dim + j] * in[j];
  }
}

/// Inverts the diagonal blocks on the free unknowns; an unknown without stiffness becomes held.
template <int Dim>
void invert_diagonal(Level<Dim>& level) {
#pragma omp parallel for schedule(static) if (level.threaded())
  for (std::int32_t v = 0; v < level.nodes(); ++v) {
    float* mask = level.mask.data() + std::int64_t{v} * Dim;
    double block[Dim][2 * Dim] = {};  // beside the unit matrix, by Gauss and Jordan
    for (int i = 0; i < Dim; ++i) {
      if (!(level.at(v, level.diagonal[v], i, i) > 0.0f)) mask[i] = 0.0f;
      block[i][Dim + i] = 1.0;
    }
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j)
        block[i][j] = mask[i] * mask[j] != 0.0f ? level.at(v, level.diagonal[v], i, j) : i == j;
    for (int k = 0; k < Dim; ++k) {
      int pivot = k;
      for (int i = k + 1; i < Dim; ++i)
        if (std::abs(block[i][k]) > std::abs(block[pivot][k])) pivot = i;
      std::swap(block[k], block[pivot]);
      const double by = block[k][k];
      for (double& number : block[k]) number = by != 0.0 ? number / by : 0.0;
      for (int i = 0; i < Dim; ++i) {
        if (i == k) continue;
        const double times = block[i][k];
        for (int j = 0; j < 2 * Dim; ++j) block[i][j] -= times * block[k][j];
      }
    }
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j)
        level.inverse[(std::int64_t{v} * Dim + i) * Dim + j] =
            mask[i] * mask[j] != 0.0f ? static_cast<float>(block[i][Dim + j]) : 0.0f;
  }
}

/// Bounds the eigenvalues by power iterations, from what the last call ended with.
template <int Dim>
void bound_eigenvalues(Level<Dim>& level, int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    level.for_product(level.eigenvector.data(), [&](std::int32_t v, const float* product) {
      scale(level, v, product, level.other.data() + std::int64_t{v} * Dim);
    });
    double size = 0.0, before = 0.0;  // in a fixed order: not threaded
    for (std::int64_t i = 0; i < level.unknowns(); ++i) {
      size += double{level.other[i]} * level.other[i];
      before += double{level.eigenvector[i]} * level.eigenvector[i];
    }
    if (!(size > 0.0)) return;
    level.largest = safety * static_cast<float>(std::sqrt(size / before));
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
    const auto update = [&](std::int32_t v, const float* product) {
      const std::int64_t at = std::int64_t{v} * Dim;
      float residual[Dim], scaled[Dim];
      for (int i = 0; i < Dim; ++i) residual[i] = level.right[at + i] - product[i];
      scale(level, v, residual, scaled);
      for (int i = 0; i < Dim; ++i) {
        const float change = (step == 0 ? 0.0f : keep * level.change[at + i]) + add * scaled[i];
        level.change[at + i] = change;
        level.other[at + i] = (step == 0 && from_zero ? 0.0f : old[at + i]) + change;
      }
    };
    if (step == 0 && from_zero) {
      const float zero[Dim] = {};
#pragma omp parallel for schedule(static) if (level.threaded())
      for (std::int32_t v = 0; v < level.nodes(); ++v) update(v, zero);
    } else {
      level.for_product(old, update);
    }
    if (step > 0) rho = next;
    std::swap(level.solution, level.other);
  }
}

}  // namespace tilth::multigrid
