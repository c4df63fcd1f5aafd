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

/// Springs, ghost stabilisation and implicit boundaries are scaled with the elastic moduli.
template <class... Material>
constexpr bool elastic_moduli_come_first(std::tuple<Material...>*) {
  return ((std::string_view(Material::parameter_names[0]) == "young_modulus" &&
           std::string_view(Material::parameter_names[1]) == "poisson_ratio") &&
          ...);
}
static_assert(elastic_moduli_come_first(static_cast<List*>(nullptr)));

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
