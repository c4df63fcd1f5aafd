// SPDX-License-Identifier: BSD-3-Clause
// Undrained analysis with effective strength: a law for the effective stress, and a pore fluid that
// resists every change of volume, plastic or elastic (Naylor 1974; docs/materials/undrained.md).
//   total stress = effective stress - u,  du = -K_f d(volumetric strain),  K_f = K_w / porosity
#pragma once

#include <algorithm>
#include <array>

#include "law.hpp"

namespace tilth::material {

/// A prefix before the name of a law.
template <class M, std::size_t P>
constexpr auto prefixed(const char (&prefix)[P]) {
  constexpr std::size_t length = [] {
    std::size_t n = 0;
    while (M::name[n] != 0) ++n;
    return n;
  }();
  std::array<char, P + length> result{};
  std::copy(prefix, prefix + P - 1, result.begin());
  std::copy(M::name, M::name + length, result.begin() + P - 1);
  return result;
}

/// "undrained_" before the name of a law.
template <class M>
inline constexpr auto undrained_name = prefixed<M>("undrained_");

template <class T, std::size_t N, class... Further>
constexpr auto appended(const std::array<T, N>& list, Further... further) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return std::array<T, N + sizeof...(further)>{list[I]..., further...};
  }(std::make_index_sequence<N>{});
}

template <Law M>
struct Undrained {
  static constexpr const char* name = undrained_name<M>.data();
  static constexpr auto parameter_names = appended(M::parameter_names, "pore_fluid_bulk_modulus");
  static constexpr auto state_variables =
      appended(M::state_variables, StateVariable{"excess_pore_pressure", "stress"},
               StateVariable{"elastic_volumetric_strain", "-"});
  static constexpr bool symmetric_tangent = M::symmetric_tangent;
  static constexpr std::size_t pore = M::state_variables.size();

  M effective;
  double fluid;  // bulk modulus of the pore fluid over porosity [stress]

  TILTH_FUNCTION static Undrained from(const double* parameter) {
    return {M::from(parameter), parameter[M::parameter_names.size()]};
  }

  TILTH_FUNCTION bool valid() const { return effective.valid() && fluid > 0.0; }

  /// The given stress is the effective one: no excess pore pressure at the start.
  TILTH_FUNCTION bool initial_state(const double* tau, double* state) const {
    double strain[3];
    if (!effective.initial_state(tau, state) || !effective.elastic_strain(tau, state, strain))
      return false;
    state[pore] = 0.0;
    state[pore + 1] = strain[0] + strain[1] + strain[2];
    return true;
  }

  TILTH_FUNCTION double pressure(const double* strain, const double* state) const {
    return state[pore] - fluid * (strain[0] + strain[1] + strain[2] - state[pore + 1]);
  }

  TILTH_FUNCTION bool update(const double trial[3], double plastic_strain,
                             const double* state_before, double* state, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    if (!effective.update(trial, plastic_strain, state_before, state, tau, elastic, tangent))
      return false;
    state[pore] = pressure(trial, state_before);
    state[pore + 1] = elastic[0] + elastic[1] + elastic[2];
    for (int a = 0; a < 3; ++a) {
      tau[a] -= state[pore];
      for (int b = 0; b < 3; ++b) tangent[a][b] += fluid;
    }
    return true;
  }

  TILTH_FUNCTION double pore_pressure(const double* state) const { return state[pore]; }

  TILTH_FUNCTION bool elastic_strain(const double tau[3], const double* state,
                                     double strain[3]) const {
    const double of_grains[3] = {tau[0] + state[pore], tau[1] + state[pore], tau[2] + state[pore]};
    return effective.elastic_strain(of_grains, state, strain);
  }

  TILTH_FUNCTION double energy(const double strain[3], const double* state) const {
    const double u = pressure(strain, state);
    return effective.energy(strain, state) + 0.5 * u * u / fluid;
  }

  TILTH_FUNCTION ElasticModuli moduli(const double* strain, const double* state) const {
    ElasticModuli m = effective.moduli(strain, state);
    m.bulk += fluid;
    return m;
  }
};

}  // namespace tilth::material
