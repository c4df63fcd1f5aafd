// SPDX-License-Identifier: BSD-3-Clause
// Constitutive laws with checked parameters and state variables.
#pragma once

#include <cmath>
#include <string>

#include "../material/list.hpp"
#include "checks.hpp"

namespace tilth::bind {

/// Calls `function(law)` for the material of that name. Refuses parameters of another number, that
/// are not finite or give moduli that are not positive, and state arrays of less than `width`
/// columns.
template <class Function>
void with_checked_law(const std::string& name, const ConstDoubles& parameters, std::int64_t width,
                      Function&& function) {
  const auto check = [&](auto law) {
    using Law = decltype(law);
    require(width >= static_cast<std::int64_t>(Law::state_variables.size()), "state",
            "has less columns than the law has state variables");
    if constexpr (Law::constant_moduli) {
      const auto moduli = law.moduli(nullptr, nullptr);
      const bool positive = moduli.bulk > 0.0 && moduli.shear > 0.0 && std::isfinite(moduli.bulk) &&
                            std::isfinite(moduli.shear);
      require(positive, "parameters", "give a bulk or shear modulus that is not positive");
    }
    function(law);
  };
  const double* numbers = parameters.data();
  material::with_parameter_count(name, [&](std::size_t count) {
    require_size(parameters, static_cast<std::int64_t>(count), "parameters");
  });
  require_finite(parameters, "parameters");
  material::with_material(name, numbers, check);
}

}  // namespace tilth::bind
