// SPDX-License-Identifier: BSD-3-Clause
// Basis values S [-] and gradients G [1/length] of a point at its group's nodes. A stencil
// stores for each point, one after the other,
// - with the linear basis the local coordinates in the cell, 0 to 1 in each direction;
// - with other bases whose nodes fill a box the one-dimensional factors: for each direction the
//   values of its nodes, then their slopes;
// - with a list of nodes the values S[node], then the gradients G[direction][node].
// Computing products is faster than reading them from memory: in 3D the linear basis takes 24 bytes
// per point instead of 256.
#pragma once

#include <cstring>

#include "../lanes.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Nodes in each direction of a square or cube of N nodes; 0 where N does not determine it.
template <int Dim, int N>
constexpr int nodes_along() {
  for (int along = 2; along <= 4; ++along)
    if (N == (Dim == 2 ? along * along : along * along * along)) return along;
  return 0;
}

/// Products of the factors, x fastest; `value` is filled only if `Values`, `gradient` only if
/// `Gradients`.
template <int Dim, int N, bool Values, bool Gradients>
void multiply_factors(const std::int32_t* count, const double* factor, double* value,
                      double* gradient) {
  constexpr int fixed = nodes_along<Dim, N>();
  const int nx = fixed > 0 ? fixed : count[0], ny = fixed > 0 ? fixed : count[1];
  const int nz = Dim == 2 ? 1 : (fixed > 0 ? fixed : count[2]);
  const int n = nx * ny * nz;
  constexpr double one = 1.0;
  const double* x = factor;
  const double* y = x + 2 * nx;
  const double* z = Dim == 3 ? y + 2 * ny : &one;
  int a = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j) {
      const double yz = y[j] * z[k], slope_yz = y[ny + j] * z[k];
      const double y_slope_z = Dim == 3 ? y[j] * z[nz + k] : 0.0;
      for (int i = 0; i < nx; ++i, ++a) {
        if constexpr (Values) value[a] = x[i] * yz;
        if constexpr (Gradients) {
          gradient[a] = x[nx + i] * yz;
          gradient[n + a] = x[i] * slope_yz;
          if constexpr (Dim == 3) gradient[2 * n + a] = x[i] * y_slope_z;
        }
      }
    }
}

/// Products of the linear shape functions at local coordinates in the cell: four nodes, a layer of
/// the cell along z, at a time.
template <int Dim, bool Values, bool Gradients>
void multiply_hats(const double* local, const double* slope, double* value, double* gradient) {
  constexpr int n = 1 << Dim;
  const double x = local[0], y = local[1];
  const HalfLanes along_x = {1.0 - x, x, 1.0 - x, x}, along_y = {1.0 - y, 1.0 - y, y, y};
  const HalfLanes slope_x = {-slope[0], slope[0], -slope[0], slope[0]};
  const HalfLanes slope_y = {-slope[1], -slope[1], slope[1], slope[1]};
  const HalfLanes both = along_x * along_y, by_x = slope_x * along_y, by_y = along_x * slope_y;
  const auto store = [](const HalfLanes& four, double* to) { std::memcpy(to, &four, sizeof four); };
  for (int k = 0; k < n / 4; ++k) {
    const double z = Dim == 2 ? 1.0 : (k == 0 ? 1.0 - local[Dim - 1] : local[Dim - 1]);
    if constexpr (Values) store(both * z, value + 4 * k);
    if constexpr (Gradients) {
      store(by_x * z, gradient + 4 * k);
      store(by_y * z, gradient + n + 4 * k);
      if constexpr (Dim == 3)
        store(both * (k == 0 ? -slope[2] : slope[2]), gradient + 2 * n + 4 * k);
    }
  }
}

/// Iterates over the basis of the points of one group. N nodes, 0 for a number known at run
/// time.
template <int Dim, int N, bool Values, bool Gradients>
class GroupBasis {
 public:
  GroupBasis(const Stencil& stencil, std::int64_t group)
      : count_(stencil.count == nullptr ? nullptr : stencil.count + 3 * group),
        hat_slope_(stencil.hat_slope == nullptr ? nullptr
                                                : stencil.hat_slope + stencil.hat_slopes * group),
        next_(stencil.value + stencil.value_start[group]),
        nodes_(N > 0 ? N : stencil.nodes_of(group)) {
    if (count_ == nullptr || hat_slope_ != nullptr) return;
    for (int k = 0; k < Dim; ++k) numbers_ += 2 * count_[k];
  }

  GroupBasis(const GroupBasis&) = delete;
  GroupBasis& operator=(const GroupBasis&) = delete;

  /// Advances to the next point of the group; the first call selects the first point.
  void advance() {
    if (count_ == nullptr) {
      value = next_;
      gradient = next_ + nodes_;
      next_ += (1 + Dim) * nodes_;
      return;
    }
    if (hat_slope_ == nullptr) {
      multiply_factors<Dim, N, Values, Gradients>(count_, next_, own_value_, own_gradient_);
      next_ += numbers_;
      return;
    }
    if constexpr (N == 0 || N == 1 << Dim)  // other numbers of nodes have other bases
      multiply_hats<Dim, Values, Gradients>(next_, hat_slope_, own_value_, own_gradient_);
    next_ += Dim;
  }

 private:
  static constexpr int capacity = N > 0 ? N : maximum_nodes;
  alignas(32) double own_value_[Values ? capacity : 1];
  alignas(32) double own_gradient_[Gradients ? Dim * capacity : 1];
  const std::int32_t* count_;
  const double* hat_slope_;
  const double* next_;
  int nodes_;
  std::int64_t numbers_ = 0;

 public:
  const double* value = own_value_;        // [node]
  const double* gradient = own_gradient_;  // [direction][node]
};

}  // namespace tilth::kernel
