// SPDX-License-Identifier: BSD-3-Clause
// Drucker-Prager plasticity, non-associated, with a cut-off of the mean stress p (tension
// positive); the return mapping is explicit (de Souza Neto et al. 2008, sec. 8.3;
// docs/materials/drucker_prager.md).
//   f = sqrt(J2) + friction_slope p - strength <= 0,  p <= cut-off <= strength / friction_slope
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "law.hpp"

namespace tilth::material {

struct DruckerPrager : HenckyElasticity {
  static constexpr const char* name = "drucker_prager";
  static constexpr std::array parameter_names{"young_modulus",  "poisson_ratio", "friction_slope",
                                              "dilation_slope", "cone_strength", "tension_cut_off"};
  static constexpr auto state_variables = no_state;
  static constexpr bool symmetric_tangent = false;

  double friction_slope;   // of the cone in the plane (p, sqrt(J2))
  double dilation_slope;   // of the plastic potential
  double cone_strength;    // sqrt(J2) at p = 0 [stress]
  double tension_cut_off;  // greatest mean stress [stress]

  TILTH_FUNCTION static DruckerPrager from(const double* parameter) {
    DruckerPrager law{HenckyElasticity::from(parameter[0], parameter[1]), parameter[2],
                      parameter[3], parameter[4], parameter[5]};
    if (law.cone_strength < law.tension_cut_off * law.friction_slope)
      law.tension_cut_off = law.cone_strength / law.friction_slope;
    return law;
  }

  /// Stress on all axes at the end of the cone.
  TILTH_FUNCTION double apex(double /*plastic_strain*/) const { return tension_cut_off; }

  TILTH_FUNCTION bool update(const double trial[3], double /*plastic_strain*/,
                             const double* /*state_before*/, double* /*state*/, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    respond(trial, tau, elastic, tangent);
    const double mean_trial = (tau[0] + tau[1] + tau[2]) / 3.0;
    double direction[3], squared = 0.0;  // of the deviator, of length sqrt(2)
    for (int a = 0; a < 3; ++a) {
      direction[a] = tau[a] - mean_trial;
      squared += 0.5 * direction[a] * direction[a];
    }
    const double root_trial = std::sqrt(squared);  // sqrt(J2)
    const double size = std::max({root_trial, std::fabs(mean_trial), cone_strength});
    const double excess = root_trial + friction_slope * mean_trial - cone_strength;
    constexpr double round_off = 1e-13;
    if (excess <= round_off * size && mean_trial - tension_cut_off <= round_off * size) return true;

    // d(mean, root) / d(mean_trial, root_trial)
    double mean = mean_trial, root = root_trial, slope[2][2] = {{1.0, 0.0}, {0.0, 1.0}};
    const double stiffness = shear + bulk * friction_slope * dilation_slope;
    const double multiplier = excess > 0.0 ? excess / stiffness : 0.0;
    const double mean_on_cone = mean_trial - bulk * dilation_slope * multiplier;
    if (mean_on_cone <= tension_cut_off && multiplier * shear <= root_trial) {
      mean = mean_on_cone;
      root = root_trial - shear * multiplier;
      slope[0][0] -= bulk * dilation_slope * friction_slope / stiffness;
      slope[0][1] -= bulk * dilation_slope / stiffness;
      slope[1][0] -= shear * friction_slope / stiffness;
      slope[1][1] -= shear / stiffness;
    } else {
      mean = tension_cut_off;
      slope[0][0] = 0.0;
      double greatest = cone_strength - friction_slope * tension_cut_off;
      if (greatest <= round_off * cone_strength) greatest = 0.0;  // the apex
      if (root_trial > greatest || greatest == 0.0) {             // where cone and cut-off meet
        root = greatest;
        slope[1][1] = 0.0;
      }
    }
    double ratio = root / root_trial;
    if (root_trial == 0.0) ratio = slope[1][1] == 0.0 ? 0.0 : 1.0;
    for (int a = 0; a < 3; ++a) {
      tau[a] = mean + ratio * direction[a];
      if (root_trial > 0.0) direction[a] /= root_trial;
    }
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const double deviator = (a == b ? 1.0 : 0.0) - 1.0 / 3.0;
        tangent[a][b] =
            bulk * (slope[0][0] + slope[1][0] * direction[a]) +
            shear * direction[b] * (slope[0][1] + (slope[1][1] - ratio) * direction[a]) +
            2.0 * shear * ratio * deviator;
      }
    return elastic_strain(tau, nullptr, elastic);
  }
};

}  // namespace tilth::material
