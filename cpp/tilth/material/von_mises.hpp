// SPDX-License-Identifier: BSD-3-Clause
// Von Mises plasticity with linear isotropic hardening; radial return in principal axes
// (Simo & Hughes 1998, box 3.2; de Souza Neto et al. 2008, sec. 7.3).
//   f = ||s|| - sqrt(2/3) (yield_stress + hardening_modulus * plastic_strain) <= 0
#pragma once

#include <array>
#include <cmath>

#include "law.hpp"

namespace tilth::material {

struct VonMises : HenckyElasticity {
  static constexpr const char* name = "von_mises";
  static constexpr std::array parameter_names{"young_modulus", "poisson_ratio", "yield_stress",
                                              "hardening_modulus"};
  static constexpr auto state_variables = no_state;
  static constexpr bool symmetric_tangent = true;

  double yield_stress;       // uniaxial
  double hardening_modulus;  // d(uniaxial yield stress) / d(equivalent plastic strain)

  TILTH_FUNCTION static VonMises from(const double* parameter) {
    return {HenckyElasticity::from(parameter[0], parameter[1]), parameter[2], parameter[3]};
  }

  TILTH_FUNCTION bool update(const double trial[3], double plastic_strain,
                             const double* /*state_before*/, double* /*state*/, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    const double twice_shear = 2.0 * shear;
    const double volumetric = trial[0] + trial[1] + trial[2];
    double direction[3];
    double squared = 0.0;
    for (int a = 0; a < 3; ++a) {
      direction[a] = trial[a] - volumetric / 3.0;
      squared += direction[a] * direction[a];
    }
    const double trial_norm = std::sqrt(squared);  // ||dev(trial strain)||
    const double radius =
        std::sqrt(2.0 / 3.0) * (yield_stress + hardening_modulus * plastic_strain);
    const double excess = twice_shear * trial_norm - radius;

    double multiplier = 0.0;  // plastic multiplier = ||plastic strain increment||
    double deviatoric = 1.0;  // factor on the deviatoric trial stress
    double radial = 0.0;      // loss of stiffness along the flow direction
    if (excess > 0.0) {
      const double slope = twice_shear + 2.0 / 3.0 * hardening_modulus;
      multiplier = excess / slope;
      deviatoric = 1.0 - multiplier / trial_norm;
      radial = twice_shear / slope - multiplier / trial_norm;
      for (int a = 0; a < 3; ++a) direction[a] /= trial_norm;
    }
    for (int a = 0; a < 3; ++a) {
      elastic[a] = trial[a] - multiplier * direction[a];
      for (int b = 0; b < 3; ++b) {
        const double projector = (a == b ? 1.0 : 0.0) - 1.0 / 3.0;
        tangent[a][b] =
            bulk + twice_shear * (deviatoric * projector - radial * direction[a] * direction[b]);
      }
    }
    stress(elastic, tau);
    return true;
  }
};

}  // namespace tilth::material
