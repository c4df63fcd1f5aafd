// SPDX-License-Identifier: BSD-3-Clause
// The list of bases: dispatch, bindings and contract tests follow from it.
#pragma once

#include <stdexcept>
#include <string>
#include <tuple>

#include "corners.hpp"
#include "gimp.hpp"
#include "linear.hpp"

namespace tilth::basis {

/// Products of one-dimensional functions, whose supports are boxes of nodes.
using List = std::tuple<Linear, Gimp>;

/// Bases whose points' domains have corners (kernel/corners.hpp).
using CornerList = std::tuple<Cpdi1, Cpdi2>;

/// Calls `function(Basis{})` for the basis of that name, once per batch of points.
template <class Function>
void with_basis(const std::string& name, Function&& function) {
  bool found = false;
  std::apply(
      [&](auto... each) {
        ((name == decltype(each)::name ? (found = true, function(each), 0) : 0), ...);
      },
      List{});
  if (!found) throw std::invalid_argument("unknown basis '" + name + "'");
}

}  // namespace tilth::basis
