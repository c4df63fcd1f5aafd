// SPDX-License-Identifier: BSD-3-Clause
// Constitutive laws with checked parameters and state variables.
#pragma once

#include <memory>
#include <string>

#include "../material/list.hpp"
#include "checks.hpp"

namespace tilth::bind {

/// Returns the law of that name for `points` points whose state arrays have `width` columns.
/// `parameters` are (m,) for all points or (points, m). Refuses parameters of another shape, that
/// are not finite or give moduli that are not positive, and less columns than state variables.
inline std::unique_ptr<material::PointLaw> checked_law(const std::string& name,
                                                       const ConstDoubles& parameters,
                                                       std::int64_t points, std::int64_t width) {
  std::unique_ptr<material::PointLaw> result;
  material::with_law(name, [&]<material::Law M>() {
    constexpr auto count = static_cast<std::int64_t>(M::parameter_names.size());
    require(width >= static_cast<std::int64_t>(M::state_variables.size()), "state",
            "has less columns than the law has state variables");
    const bool each = parameters.ndim() == 2;
    if (each)
      require_table(parameters, points, count, "parameters");
    else
      require_size(parameters, count, "parameters");
    require_finite(parameters, "parameters");
    const std::int64_t rows = each ? points : 1;
    bool valid = true;
    for (std::int64_t i = 0; i < rows; ++i)
      valid = valid && M::from(parameters.data() + count * i).valid();
    require(valid, "parameters", "give a bulk or shear modulus that is not positive");
    result = std::make_unique<material::LawOf<M>>(parameters.data(), each ? count : 0);
  });
  return result;
}

}  // namespace tilth::bind
