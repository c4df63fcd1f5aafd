// SPDX-License-Identifier: BSD-3-Clause
// Hencky elasticity as a constitutive law.
#pragma once

#include <array>

#include "law.hpp"

namespace tilth::material {

struct HenckyElastic : HenckyElasticity {
  static constexpr const char* name = "hencky_elastic";
  static constexpr std::array parameter_names{"young_modulus", "poisson_ratio"};
  static constexpr auto state_variables = no_state;
  static constexpr bool symmetric_tangent = true;

  TILTH_FUNCTION static HenckyElastic from(const double* parameter) {
    return {HenckyElasticity::from(parameter[0], parameter[1])};
  }

  TILTH_FUNCTION bool update(const double trial[3], double /*plastic_strain*/,
                             const double* /*state_before*/, double* /*state*/, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    respond(trial, tau, elastic, tangent);
    return true;
  }
};

}  // namespace tilth::material
