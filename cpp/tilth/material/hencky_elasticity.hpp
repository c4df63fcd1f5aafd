// SPDX-License-Identifier: BSD-3-Clause
// Hencky elasticity: Kirchhoff stress linear in the elastic logarithmic strain.
//   tau = K tr(eps) 1 + 2 G dev(eps)          (Anand 1979; de Souza Neto et al. 2008, sec. 14.3)
#pragma once

#include <cmath>

#include "../annotation.hpp"

namespace tilth::material {

/// Tangent bulk and shear modulus of an isotropic law at a state [stress].
struct ElasticModuli {
  double bulk;
  double shear;
};

/// The elastic part of the laws that have constant moduli: they inherit from it.
struct HenckyElasticity {
  double bulk;   // [stress]
  double shear;  // [stress]

  TILTH_FUNCTION static HenckyElasticity from(double young_modulus, double poisson_ratio) {
    return {young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio)),
            young_modulus / (2.0 * (1.0 + poisson_ratio))};
  }

  TILTH_FUNCTION bool valid() const {
    return bulk > 0.0 && shear > 0.0 && std::isfinite(bulk) && std::isfinite(shear);
  }

  /// Laws without state variables start with any stress.
  TILTH_FUNCTION bool initial_state(const double* /*tau*/, double* /*state*/) const { return true; }

  /// Principal Kirchhoff stress of the principal elastic logarithmic strain.
  TILTH_FUNCTION void stress(const double strain[3], double tau[3]) const {
    const double volumetric = strain[0] + strain[1] + strain[2];
    for (int a = 0; a < 3; ++a)
      tau[a] = bulk * volumetric + 2.0 * shear * (strain[a] - volumetric / 3.0);
  }

  /// Its inverse; returns true: every stress has an elastic strain.
  TILTH_FUNCTION bool elastic_strain(const double tau[3], const double* /*state*/,
                                     double strain[3]) const {
    const double mean = (tau[0] + tau[1] + tau[2]) / 3.0;
    for (int a = 0; a < 3; ++a) strain[a] = mean / (3.0 * bulk) + (tau[a] - mean) / (2.0 * shear);
    return true;
  }

  /// Stored energy per unit initial volume [stress].
  TILTH_FUNCTION double energy(const double strain[3], const double* /*state*/) const {
    const double volumetric = strain[0] + strain[1] + strain[2];
    double deviatoric = 0.0;
    for (int a = 0; a < 3; ++a) {
      const double e = strain[a] - volumetric / 3.0;
      deviatoric += e * e;
    }
    return 0.5 * bulk * volumetric * volumetric + shear * deviatoric;
  }

  /// Stress of the trial strain, taken as elastic, with its tangent.
  TILTH_FUNCTION void respond(const double trial[3], double tau[3], double elastic[3],
                              double tangent[3][3]) const {
    stress(trial, tau);
    const double lambda = bulk - 2.0 / 3.0 * shear;
    for (int a = 0; a < 3; ++a) {
      elastic[a] = trial[a];
      for (int b = 0; b < 3; ++b) tangent[a][b] = lambda + (a == b ? 2.0 * shear : 0.0);
    }
  }

  TILTH_FUNCTION ElasticModuli moduli(const double* /*strain*/, const double* /*state*/) const {
    return {bulk, shear};
  }
};

}  // namespace tilth::material
