// SPDX-License-Identifier: BSD-3-Clause
// Soil whose grains separate: a law with an apex that remembers the volume gained there as a void,
// which must close before the soil bears pressure again (docs/materials/separation.md).
//   trial* = trial + void / 3,  then the law;  at the apex void = tr(trial*) - tr(elastic), else 0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "law.hpp"
#include "undrained.hpp"

namespace tilth::material {

/// "separating_" before the name of a law.
template <class M>
inline constexpr auto separating_name = prefixed<M>("separating_");

template <Law M>
struct Separating {
  static constexpr const char* name = separating_name<M>.data();
  static constexpr auto parameter_names = M::parameter_names;
  static constexpr auto state_variables =
      appended(M::state_variables, StateVariable{"void_strain", "-"});
  static constexpr bool symmetric_tangent = M::symmetric_tangent;
  static constexpr std::size_t gap = M::state_variables.size();

  M grains;

  TILTH_FUNCTION static Separating from(const double* parameter) { return {M::from(parameter)}; }

  TILTH_FUNCTION bool valid() const { return grains.valid(); }

  TILTH_FUNCTION bool initial_state(const double* tau, double* state) const {
    state[gap] = 0.0;
    return grains.initial_state(tau, state);
  }

  TILTH_FUNCTION bool update(const double trial[3], double plastic_strain,
                             const double* state_before, double* state, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    const double shift = state_before[gap] / 3.0;
    const double shifted[3] = {trial[0] + shift, trial[1] + shift, trial[2] + shift};
    if (!grains.update(shifted, plastic_strain, state_before, state, tau, elastic, tangent))
      return false;
    const double apex = grains.apex(plastic_strain);
    double gained = 0.0, distance = 0.0, size = std::fabs(apex);
    for (int a = 0; a < 3; ++a) {
      gained += shifted[a] - elastic[a];
      distance = std::max(distance, std::fabs(tau[a] - apex));
      size = std::max(size, 2.0 * grains.shear * std::fabs(shifted[a]));
    }
    state[gap] = distance <= round_off * size ? std::max(gained, 0.0) : 0.0;
    return true;
  }

  TILTH_FUNCTION double opened(const double* state) const { return state[gap]; }

  TILTH_FUNCTION bool elastic_strain(const double tau[3], const double* state,
                                     double strain[3]) const {
    return grains.elastic_strain(tau, state, strain);
  }

  TILTH_FUNCTION double energy(const double strain[3], const double* state) const {
    return grains.energy(strain, state);
  }

  TILTH_FUNCTION ElasticModuli moduli(const double* strain, const double* state) const {
    return grains.moduli(strain, state);
  }

 private:
  static constexpr double round_off = 1e-10;  // of the apex, relative to the trial stress
};

}  // namespace tilth::material
