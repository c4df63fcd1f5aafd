// SPDX-License-Identifier: BSD-3-Clause
// Tresca plasticity: undrained clay with shear strength s_u, tau_1 - tau_3 <= 2 s_u; Mohr-Coulomb
// without friction (de Souza Neto et al. 2008, sec. 8.1; docs/materials/tresca.md).
#pragma once

#include <array>

#include "mohr_coulomb.hpp"

namespace tilth::material {

struct Tresca : HenckyElasticity {
  static constexpr const char* name = "tresca";
  static constexpr std::array parameter_names{"young_modulus", "poisson_ratio",
                                              "undrained_shear_strength"};
  static constexpr auto state_variables = no_state;
  static constexpr bool symmetric_tangent = true;

  double undrained_shear_strength;  // [stress]

  TILTH_FUNCTION static Tresca from(const double* parameter) {
    return {HenckyElasticity::from(parameter[0], parameter[1]), parameter[2]};
  }

  TILTH_FUNCTION bool update(const double trial[3], double /*plastic_strain*/,
                             const double* /*state_before*/, double* /*state*/, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    respond(trial, tau, elastic, tangent);
    const SortedAxes axes(tau);
    double sorted[3], slope[3][3];
    axes.sort(tau, sorted);
    const Strength strength{undrained_shear_strength, 0.0, 0.0, 1.0, 0.0, no_tension_cut_off, 0.0};
    MohrCoulombReturn returned(*this, sorted, 0.0, strength);
    if (returned.elastic()) return true;
    if (!returned.solve(-1)) return false;
    returned.tangent(slope);
    axes.restore(returned.tau, tau);
    axes.restore(slope, tangent);
    return elastic_strain(tau, nullptr, elastic);
  }
};

}  // namespace tilth::material
