// SPDX-License-Identifier: BSD-3-Clause
// Result of the stress update at a point, from which internal force and stiffness are computed.
// All quantities are in the principal axes n_p of the trial left Cauchy-Green tensor, in which an
// isotropic material's tangent has 21 entries instead of 81 (docs/theory/mechanics.md, "Tangent").
#pragma once

#include "../kind.hpp"

namespace tilth::kernel {

/// Part for axisymmetry only.
template <bool Hoop, class T>
struct HoopResponse {
  T hoop_inverse;  // 1 / hoop stretch of the step
};
template <class T>
struct HoopResponse<false, T> {};

/// `T` is double, as stored for the points, or Lanes for several points at once.
template <class K, class T = double>
struct Response : HoopResponse<K::hoop, T> {
  static constexpr int pairs = K::dim == 3 ? 3 : 1;  // (0,1), (1,2), (2,0)

  T to_current[K::dim][K::dim];  // [p][J]: gradient at the start of the step -> current, along n_p
  T axis[K::dim][K::dim];        // [i][p]: component i of n_p
  T kirchhoff[3];                // principal Kirchhoff stress [stress]
  T tangent[3][3];               // d kirchhoff[a] / d trial logarithmic strain[b] [stress]
  T beta[K::dim];                // principal values of the trial left Cauchy-Green tensor
  T shear[pairs];                // (tau_a - tau_b) / (beta_a - beta_b) [stress]

  static constexpr int pair(int a, int b) {
    return K::dim == 3 ? (a + b == 1 ? 0 : a + b == 3 ? 1 : 2) : 0;
  }
};

template <class K>
inline constexpr int response_size = sizeof(Response<K>) / sizeof(double);

}  // namespace tilth::kernel
