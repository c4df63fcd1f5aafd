// SPDX-License-Identifier: BSD-3-Clause
// Small symmetric tensors: component order, spectral decomposition, exponential.
//
// Symmetric tensors are stored with six tensor components (no factor two on shear) in the order
// xx yy zz xy yz xz. Plane strain keeps xx yy zz xy; axisymmetry reads x as r, y as the axis and
// zz as the hoop component.
#pragma once

#include <cmath>

#include "annotation.hpp"
#include "lanes.hpp"

namespace tilth {

inline constexpr int row_of_component[6] = {0, 1, 2, 0, 1, 0};
inline constexpr int column_of_component[6] = {0, 1, 2, 1, 2, 2};

/// Spectral decomposition A = sum_a value[a] n_a (x) n_a of a symmetric 3x3 tensor;
/// `vector[i][a]` is component i of the unit vector n_a. T is double or Lanes.
template <class T>
struct Spectrum {
  T value[3];
  T vector[3][3];
};

/// One Jacobi rotation that annihilates a[p][q] where `active` (Golub & Van Loan, Matrix
/// Computations, 8.5.2); elsewhere values and vectors stay as they are, to the bit.
template <class T, class Condition>
TILTH_FUNCTION void jacobi_rotation(T a[3][3], T v[3][3], int p, int q, int size,
                                    const Condition& active) {
  const T off = a[p][q];
  const T theta = (a[q][q] - a[p][p]) / (2.0 * off);
  const T size_of_t = 1.0 / (magnitude(theta) + square_root(1.0 + theta * theta));
  const T t =
      select(active & (magnitude(off) > 0.0), select(theta >= 0.0, size_of_t, -size_of_t), 0.0);
  const T c = 1.0 / square_root(1.0 + t * t);
  const T s = t * c;
  a[p][p] -= t * off;
  a[q][q] += t * off;
  a[p][q] = a[q][p] = 0.0;
  for (int i = 0; i < size; ++i) {
    if (i != p && i != q) {
      const T ip = a[i][p];
      const T iq = a[i][q];
      a[i][p] = a[p][i] = c * ip - s * iq;
      a[i][q] = a[q][i] = s * ip + c * iq;
    }
    const T vp = v[i][p];
    const T vq = v[i][q];
    v[i][p] = c * vp - s * vq;
    v[i][q] = s * vp + c * vq;
  }
}

/// Spectral decomposition by cyclic Jacobi rotations. `InPlane`: xz and yz vanish (plane
/// strain, axisymmetry); one rotation is then exact and the third axis is unchanged.
template <bool InPlane, class T>
TILTH_FUNCTION Spectrum<T> spectrum(const T component[6]) {
  T a[3][3] = {{component[0], component[3], component[5]},
               {component[3], component[1], component[4]},
               {component[5], component[4], component[2]}};
  Spectrum<T> result;
  T(*v)[3] = result.vector;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) v[i][j] = i == j ? 1.0 : 0.0;
  auto active = magnitude(a[0][0]) >= 0.0;  // false for NaN
  if constexpr (InPlane) {
    jacobi_rotation(a, v, 0, 1, 2, active);
  } else {
    constexpr int maximum_sweeps = 12;  // converges quadratically: 3 to 5 are needed
    for (int sweep = 0; sweep < maximum_sweeps; ++sweep) {
      const T off = a[0][1] * a[0][1] + a[1][2] * a[1][2] + a[0][2] * a[0][2];
      const T diagonal = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
      active = active & (off > 1e-34 * diagonal);
      if (!any(active)) break;
      jacobi_rotation(a, v, 0, 1, 3, active);
      jacobi_rotation(a, v, 0, 2, 3, active);
      jacobi_rotation(a, v, 1, 2, 3, active);
    }
  }
  for (int i = 0; i < 3; ++i) result.value[i] = a[i][i];
  return result;
}

/// Symmetric tensor sum_a value[a] n_a (x) n_a in six components.
template <class T>
TILTH_FUNCTION void compose(const T value[3], const T vector[3][3], T component[6]) {
  for (int k = 0; k < 6; ++k) {
    const int i = row_of_component[k];
    const int j = column_of_component[k];
    T sum = 0.0;
    for (int a = 0; a < 3; ++a) sum += value[a] * vector[i][a] * vector[j][a];
    component[k] = sum;
  }
}

/// (x - y) / (exp(2x) - exp(2y)), given beta_x - 1 = expm1(2x) and likewise for y; accurate also
/// where the two are close or equal (limit 1 / (2 beta)).
template <class T>
TILTH_FUNCTION T logarithm_divided_difference(const T& x, const T& y, const T& beta_x_minus_one,
                                              const T& beta_y_minus_one) {
  const T difference = beta_x_minus_one - beta_y_minus_one;
  const T beta_y = 1.0 + beta_y_minus_one;
  const T z = difference / beta_y;
  const T series = 0.5 / beta_y * (1.0 - z * (0.5 - z * (1.0 / 3.0 - 0.25 * z)));
  return select(magnitude(z) > 1e-4, (x - y) / difference, series);
}

}  // namespace tilth
