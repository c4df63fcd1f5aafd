// SPDX-License-Identifier: BSD-3-Clause
// Basis values S [-] and gradients G [1/length] of a point at its group's nodes. What a stencil
// keeps of each point is, one after the other,
// - where the nodes fill a box, the factors of the product over the directions: for each direction
//   the values of its nodes, then their slopes. Products are cheaper than what reading them would
//   take: with trilinear functions 96 bytes a point instead of 256;
// - of a list of nodes the values S[node], then the gradients G[direction][node].
#pragma once

#include "view.hpp"

namespace tilth::kernel {

/// Nodes in each direction of a square or cube of N nodes; 0 where N does not tell.
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
      const double rest = y[j] * z[k], rest_y = y[ny + j] * z[k];
      const double rest_z = Dim == 3 ? y[j] * z[nz + k] : 0.0;
      for (int i = 0; i < nx; ++i, ++a) {
        if constexpr (Values) value[a] = x[i] * rest;
        if constexpr (Gradients) {
          gradient[a] = x[nx + i] * rest;
          gradient[n + a] = x[i] * rest_y;
          if constexpr (Dim == 3) gradient[2 * n + a] = x[i] * rest_z;
        }
      }
    }
}

/// The basis of the points of one group, point after point. N nodes, 0 for a number known at run
/// time.
template <int Dim, int N, bool Values, bool Gradients>
class GroupBasis {
 public:
  GroupBasis(const Stencil& stencil, std::int64_t group)
      : count_(stencil.count == nullptr ? nullptr : stencil.count + 3 * group),
        next_(stencil.value + stencil.value_start[group]),
        nodes_(N > 0 ? N : stencil.nodes_of(group)) {
    if (count_ == nullptr) return;
    numbers_ = 0;
    for (int k = 0; k < Dim; ++k) numbers_ += 2 * count_[k];
  }

  GroupBasis(const GroupBasis&) = delete;
  GroupBasis& operator=(const GroupBasis&) = delete;

  /// Goes to the next point of the group; the first call to the first one.
  void advance() {
    if (count_ == nullptr) {
      value = next_;
      gradient = next_ + nodes_;
      next_ += (1 + Dim) * nodes_;
      return;
    }
    multiply_factors<Dim, N, Values, Gradients>(count_, next_, own_value_, own_gradient_);
    next_ += numbers_;
  }

 private:
  static constexpr int capacity = N > 0 ? N : maximum_nodes;
  alignas(32) double own_value_[Values ? capacity : 1];
  alignas(32) double own_gradient_[Gradients ? Dim * capacity : 1];
  const std::int32_t* count_;
  const double* next_;
  int nodes_;
  std::int64_t numbers_ = 0;

 public:
  const double* value = own_value_;        // [node]
  const double* gradient = own_gradient_;  // [direction][node]
};

}  // namespace tilth::kernel
