// SPDX-License-Identifier: BSD-3-Clause
// Generalised interpolation material point method: the hat functions averaged over the point's
// box-shaped domain (Bardenhagen & Kober 2004, eq. 26; contiguous-particle form).
//   S = (H(s + l) - H(s - l)) / (2 l),  S' = (N(s + l) - N(s - l)) / (2 l),
// with N the hat function and H its antiderivative: no case distinction by overlap is needed. The
// cells below and above the node may differ in size.
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

  TILTH_FUNCTION static double extent(double half_length) {
    return half_length * (1.0 - relative_overlap);
  }

  TILTH_FUNCTION static Support support(double low, double high) {
    const double first = std::floor(low);
    return {first, static_cast<int>(std::floor(high) - first) + 2};
  }

  /// Cuts the domain to the part between the first and the last node of its support.
  TILTH_FUNCTION static void cut(double first, double last, double& x, double& half_length) {
    const double lower = x - half_length > first ? x - half_length : first;
    const double upper = x + half_length < last ? x + half_length : last;
    x = 0.5 * (lower + upper);
    half_length = 0.5 * (upper - lower);
  }

  /// Hat function of a node, `t` from it in units of the cell on that side.
  TILTH_FUNCTION static double hat(double t) {
    const double h = 1.0 - std::fabs(t);
    return h > 0.0 ? h : 0.0;
  }

  TILTH_FUNCTION static double hat_antiderivative(double t, double below, double above) {
    t = t < -1.0 ? -1.0 : (t > 1.0 ? 1.0 : t);
    return t < 0.0 ? below * (0.5 * (1.0 + t) * (1.0 + t))
                   : 0.5 * (below + above) - above * (0.5 * (1.0 - t) * (1.0 - t));
  }

  /// Value and derivative of the node at distance `s` = x - node, between cells of the sizes
  /// `below` and `above`.
  TILTH_FUNCTION static void evaluate(double s, double half_length, double below, double above,
                                      double& value, double& derivative) {
    const double low = s - half_length, high = s + half_length;
    const double lower = low / (low < 0.0 ? below : above);
    const double upper = high / (high < 0.0 ? below : above);
    const double scale = 0.5 / half_length;
    value =
        (hat_antiderivative(upper, below, above) - hat_antiderivative(lower, below, above)) * scale;
    derivative = (hat(upper) - hat(lower)) * scale;
  }
};

}  // namespace tilth::basis
