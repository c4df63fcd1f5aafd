// SPDX-License-Identifier: BSD-3-Clause
// Standard MPM: the finite-element hat functions of the background grid at the material point
// (Sulsky, Chen & Schreyer 1994).
#pragma once

#include <cmath>

#include "../annotation.hpp"

namespace tilth::basis {

/// Nodes that support a point in one direction: first, first + 1, ..., first + count - 1.
struct Support {
  double first;
  int count;
};

/// Basis protocol (docs/howto/add_a_basis.md): one direction at a time, lengths in cells, the
/// position measured from the grid's origin.
struct Linear {
  static constexpr const char* name = "linear";
  static constexpr bool has_domain = false;
  static constexpr bool is_hat = true;  // local coordinates determine values and slopes
  static constexpr int maximum_count = 2;

  TILTH_FUNCTION static Support support(double x, double /*half_length*/) {
    return {std::floor(x), 2};
  }

  /// Cuts the domain to the cells of the support.
  TILTH_FUNCTION static void cut(double /*first*/, int /*count*/, double& /*x*/,
                                 double& /*half_length*/) {}

  /// Value and derivative of the node at distance `s` = x - node.
  TILTH_FUNCTION static void evaluate(double s, double /*half_length*/, double& value,
                                      double& derivative) {
    value = 1.0 - std::fabs(s);
    derivative = s < 0.0 ? 1.0 : -1.0;
  }
};

}  // namespace tilth::basis
