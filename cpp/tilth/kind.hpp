// SPDX-License-Identifier: BSD-3-Clause
// The three kinds of analysis as compile-time constants.
#pragma once

#include <stdexcept>
#include <string>

namespace tilth {

template <int Dim, bool Hoop>
struct Kind {
  static constexpr int dim = Dim;     // directions of the grid, components of the displacement
  static constexpr bool hoop = Hoop;  // axisymmetry: circumferential strain u_r / r
  static constexpr bool in_plane = Dim == 2;
};

using PlaneStrain = Kind<2, false>;
using Axisymmetric = Kind<2, true>;
using Solid = Kind<3, false>;

/// Calls `function(kind)` for "plane_strain", "axisymmetric" or "3d".
template <class Function>
void with_kind(const std::string& name, Function&& function) {
  if (name == "plane_strain") return function(PlaneStrain{});
  if (name == "axisymmetric") return function(Axisymmetric{});
  if (name == "3d") return function(Solid{});
  throw std::invalid_argument("unknown analysis kind '" + name + "'");
}

/// Calls `function(kind)` with a kind of analysis of that dimension, for functions of the
/// dimension only.
template <class Function>
void with_dimension(int dim, Function&& function) {
  if (dim == 2) return function(PlaneStrain{});
  if (dim == 3) return function(Solid{});
  throw std::invalid_argument("dimension must be 2 or 3");
}

}  // namespace tilth
