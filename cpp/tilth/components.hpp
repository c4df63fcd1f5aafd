// SPDX-License-Identifier: BSD-3-Clause
// The number of unknowns of a node as a compile-time constant. It is the dimension of space for a
// displacement and 1 for a scalar field, such as a hydraulic head.
#pragma once

#include <stdexcept>
#include <type_traits>

namespace tilth {

template <int Count>
using Components = std::integral_constant<int, Count>;

/// Returns `function(Components<count>{})`.
template <class Function>
auto with_components(int count, Function&& function) {
  if (count == 1) return function(Components<1>{});
  if (count == 2) return function(Components<2>{});
  if (count == 3) return function(Components<3>{});
  throw std::invalid_argument("a node has 1, 2 or 3 unknowns");
}

}  // namespace tilth
