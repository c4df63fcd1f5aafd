// SPDX-License-Identifier: BSD-3-Clause
// The list of materials: dispatch, bindings and contract tests follow from it.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>

#include "hencky_elastic.hpp"
#include "von_mises.hpp"

namespace tilth::material {

using List = std::tuple<HenckyElastic, VonMises>;

/// Springs, ghost stabilisation and round-off are scaled with Young's modulus.
template <class... Material>
constexpr bool young_modulus_comes_first(std::tuple<Material...>*) {
  return ((std::string_view(Material::parameter_names[0]) == "young_modulus") && ...);
}
static_assert(young_modulus_comes_first(static_cast<List*>(nullptr)));

/// Calls `function(Material::from(parameters))` for the material of that name, once per batch of
/// points, never per point.
template <class Function>
void with_material(const std::string& name, const double* parameters, Function&& function) {
  bool found = false;
  std::apply(
      [&](auto... each) {
        ((name == decltype(each)::name
              ? (found = true, function(decltype(each)::from(parameters)), 0)
              : 0),
         ...);
      },
      List{});
  if (!found) throw std::invalid_argument("unknown material '" + name + "'");
}

}  // namespace tilth::material
