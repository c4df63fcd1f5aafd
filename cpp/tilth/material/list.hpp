// SPDX-License-Identifier: BSD-3-Clause
// The list of materials: dispatch, bindings and contract tests follow from it.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>

#include "drucker_prager.hpp"
#include "hencky_elastic.hpp"
#include "modified_cam_clay.hpp"
#include "mohr_coulomb.hpp"
#include "point_law.hpp"
#include "separating.hpp"
#include "tresca.hpp"
#include "undrained.hpp"
#include "von_mises.hpp"

namespace tilth::material {

using List =
    std::tuple<HenckyElastic, VonMises, Tresca, MohrCoulomb, DruckerPrager, ModifiedCamClay,
               Undrained<HenckyElastic>, Undrained<MohrCoulomb>, Undrained<DruckerPrager>,
               Undrained<ModifiedCamClay>, Separating<MohrCoulomb>, Separating<DruckerPrager>>;

/// Calls `function.template operator()<M>()` for each law of the list.
template <class Function>
void for_each_law(Function&& function) {
  std::apply([&](auto... each) { (function.template operator()<decltype(each)>(), ...); }, List{});
}

/// Calls `function.template operator()<M>()` for the law of that name.
template <class Function>
void with_law(const std::string& name, Function&& function) {
  bool found = false;
  for_each_law([&]<Law M>() {
    if (name != M::name) return;
    found = true;
    function.template operator()<M>();
  });
  if (!found) throw std::invalid_argument("unknown material '" + name + "'");
}

}  // namespace tilth::material
