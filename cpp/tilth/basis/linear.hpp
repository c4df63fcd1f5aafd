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

/// Basis protocol (docs/howto/add_a_basis.md): one direction at a time.
struct Linear {
  static constexpr const char* name = "linear";
  static constexpr bool has_domain = false;
  static constexpr bool is_hat = true;  // local coordinates determine values and slopes
  static constexpr int maximum_count = 2;

  /// Half of the part of a domain that counts for its support.
  TILTH_FUNCTION static double extent(double /*half_length*/) { return 0.0; }

  /// Support of the part of the axis from `low` to `high`, in cells from the grid's origin.
  TILTH_FUNCTION static Support support(double low, double /*high*/) {
    return {std::floor(low), 2};
  }
};

}  // namespace tilth::basis
