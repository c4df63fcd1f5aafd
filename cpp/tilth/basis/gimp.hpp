// SPDX-License-Identifier: BSD-3-Clause
// Generalised interpolation material point method: the hat functions averaged over the point's
// box-shaped domain (Bardenhagen & Kober 2004, eq. 26; contiguous-particle form).
//   S = (H(s + l) - H(s - l)) / (2 l),  S' = (N(s + l) - N(s - l)) / (2 l),
// with N the hat function and H its antiderivative: no case distinction by overlap is needed.
#pragma once

#include <cmath>

#include "linear.hpp"

namespace tilth::basis {

struct Gimp {
  static constexpr const char* name = "gimp";
  static constexpr bool has_domain = true;
  static constexpr bool is_hat = false;
  static constexpr int maximum_count = 3;  // half lengths are capped at half a cell

  /// Overlaps below this share of the half length do not count as support: they arise from the
  /// tolerance of the equilibrium, and their nodes would have almost no stiffness. The domain is
  /// cut there, so that the basis remains a partition of unity.
  static constexpr double relative_overlap = 1.4901161193847656e-08;

  TILTH_FUNCTION static Support support(double x, double half_length) {
    const double extent = half_length * (1.0 - relative_overlap);
    const double first = std::floor(x - extent);
    return {first, static_cast<int>(std::floor(x + extent) - first) + 2};
  }

  TILTH_FUNCTION static void cut(double first, int count, double& x, double& half_length) {
    const double last = first + count - 1;
    const double lower = x - half_length > first ? x - half_length : first;
    const double upper = x + half_length < last ? x + half_length : last;
    x = 0.5 * (lower + upper);
    half_length = 0.5 * (upper - lower);
  }

  TILTH_FUNCTION static double hat(double s) {
    const double t = 1.0 - std::fabs(s);
    return t > 0.0 ? t : 0.0;
  }

  TILTH_FUNCTION static double hat_antiderivative(double s) {
    const double t = s < -1.0 ? -1.0 : (s > 1.0 ? 1.0 : s);
    return t < 0.0 ? 0.5 * (1.0 + t) * (1.0 + t) : 1.0 - 0.5 * (1.0 - t) * (1.0 - t);
  }

  TILTH_FUNCTION static void evaluate(double s, double half_length, double& value,
                                      double& derivative) {
    const double lower = s - half_length;
    const double upper = s + half_length;
    const double scale = 0.5 / half_length;
    value = (hat_antiderivative(upper) - hat_antiderivative(lower)) * scale;
    derivative = (hat(upper) - hat(lower)) * scale;
  }
};

}  // namespace tilth::basis
