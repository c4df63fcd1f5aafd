// SPDX-License-Identifier: BSD-3-Clause
// Concept of a constitutive law (docs/howto/add_a_material.md). Laws are isotropic and work in
// principal axes, with logarithmic strain and Kirchhoff stress, tension positive.
#pragma once

#include <array>
#include <concepts>

#include "hencky_elasticity.hpp"

namespace tilth::material {

/// A quantity that a law stores at each point, in addition to elastic and plastic strain.
struct StateVariable {
  const char* name;  // full name, as in results and as a tracked quantity
  const char* unit;  // "stress" or "-"
};

/// For laws without further state variables.
inline constexpr std::array<StateVariable, 0> no_state{};

/// - `name`, `parameter_names`: as in the case file; `from` takes the parameters in this order.
/// - `state_variables`: names and units; `initial_state` fills their values at the start, at which
///   the point has the given principal Kirchhoff stress; false if the law cannot have this stress.
/// - `symmetric_tangent`: whether each step's stress has a potential (associated flow).
/// - `valid`: whether the parameters give positive, finite moduli.
/// - `update`: trial strain -> stress, elastic strain and tangent[a][b] = d tau_a / d trial_b, and
///   all state variables; false if it finds no solution.
/// - `energy`, `moduli`: stored energy per initial volume and tangent elastic moduli at a state.
/// - `elastic_strain`: of a given stress; false if no elastic strain has this stress.
template <class M>
concept Law =
    requires(const M law, const double* in, double* out, double (*tangent)[3], double number) {
      { M::name } -> std::convertible_to<const char*>;
      { M::parameter_names[0] } -> std::convertible_to<const char*>;
      { M::state_variables.size() } -> std::convertible_to<std::size_t>;
      { M::symmetric_tangent } -> std::convertible_to<bool>;
      { M::from(in) } -> std::same_as<M>;
      { law.valid() } -> std::same_as<bool>;
      { law.initial_state(in, out) } -> std::same_as<bool>;
      { law.update(in, number, in, out, out, out, tangent) } -> std::same_as<bool>;
      { law.energy(in, in) } -> std::same_as<double>;
      { law.moduli(in, in) } -> std::same_as<ElasticModuli>;
      { law.elastic_strain(in, in, out) } -> std::same_as<bool>;
    };

}  // namespace tilth::material
