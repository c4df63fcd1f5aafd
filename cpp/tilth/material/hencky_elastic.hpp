// SPDX-License-Identifier: BSD-3-Clause
// Hencky elasticity: Kirchhoff stress linear in the elastic logarithmic strain.
//   tau = K tr(eps) 1 + 2 G dev(eps)          (Anand 1979; de Souza Neto et al. 2008, sec. 14.3)
#pragma once

#include "../annotation.hpp"

namespace tilth::material {

/// Bulk and shear modulus of isotropic Hencky elasticity, shared by the elasto-plastic models.
struct ElasticModuli {
  double bulk;
  double shear;

  TILTH_FUNCTION static ElasticModuli from(double young_modulus, double poisson_ratio) {
    return {young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio)),
            young_modulus / (2.0 * (1.0 + poisson_ratio))};
  }

  /// Principal Kirchhoff stress of the principal elastic logarithmic strain.
  TILTH_FUNCTION void stress(const double strain[3], double tau[3]) const {
    const double volumetric = strain[0] + strain[1] + strain[2];
    for (int a = 0; a < 3; ++a)
      tau[a] = bulk * volumetric + 2.0 * shear * (strain[a] - volumetric / 3.0);
  }

  /// Strain energy per unit initial volume [stress].
  TILTH_FUNCTION double energy(const double strain[3]) const {
    const double volumetric = strain[0] + strain[1] + strain[2];
    double deviatoric = 0.0;
    for (int a = 0; a < 3; ++a) {
      const double e = strain[a] - volumetric / 3.0;
      deviatoric += e * e;
    }
    return 0.5 * bulk * volumetric * volumetric + shear * deviatoric;
  }
};

/// Material protocol (docs/howto/add_a_material.md): everything happens in principal axes.
struct HenckyElastic {
  static constexpr const char* name = "hencky_elastic";
  static constexpr int parameter_count = 2;
  static constexpr const char* parameter_names[parameter_count] = {"young_modulus",
                                                                   "poisson_ratio"};
  static constexpr int state_count = 0;

  ElasticModuli moduli;

  TILTH_FUNCTION static HenckyElastic from(const double* parameter) {
    return {ElasticModuli::from(parameter[0], parameter[1])};
  }

  /// Trial principal logarithmic strain -> principal Kirchhoff stress `tau`, elastic strain, and
  /// `tangent[a][b]` = d tau_a / d trial_b. Returns true on success.
  TILTH_FUNCTION bool update(const double trial[3], double /*plastic_strain*/,
                             const double* /*state_before*/, double* /*state*/, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    moduli.stress(trial, tau);
    const double lambda = moduli.bulk - 2.0 / 3.0 * moduli.shear;
    for (int a = 0; a < 3; ++a) {
      elastic[a] = trial[a];
      for (int b = 0; b < 3; ++b) tangent[a][b] = lambda + (a == b ? 2.0 * moduli.shear : 0.0);
    }
    return true;
  }
};

}  // namespace tilth::material
