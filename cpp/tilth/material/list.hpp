// SPDX-License-Identifier: BSD-3-Clause
// The list of materials: dispatch, bindings and contract tests follow from it.
#pragma once

#include <stdexcept>
#include <string>
#include <tuple>

#include "hencky_elastic.hpp"
#include "von_mises.hpp"

namespace tilth::material {

using List = std::tuple<HenckyElastic, VonMises>;

template <Law... Material>
constexpr bool are_laws(std::tuple<Material...>*) {
  return true;
}
static_assert(are_laws(static_cast<List*>(nullptr)));

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

/// Calls `function(number of parameters)` of the material of that name.
template <class Function>
void with_parameter_count(const std::string& name, Function&& function) {
  std::apply(
      [&](auto... each) {
        ((name == decltype(each)::name ? (function(decltype(each)::parameter_names.size()), 0) : 0),
         ...);
      },
      List{});
}

}  // namespace tilth::material
