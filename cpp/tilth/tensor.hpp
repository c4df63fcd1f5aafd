// SPDX-License-Identifier: BSD-3-Clause
// Small symmetric tensors: component order, spectral decomposition, exponential.
//
// Symmetric tensors are stored with six tensor components (no factor two on shear) in the order
// xx yy zz xy yz xz. Plane strain keeps xx yy zz xy; axisymmetry reads x as r, y as the axis and
// zz as the hoop component.
#pragma once

#include <cmath>

#include "annotation.hpp"

namespace tilth {

inline constexpr int row_of_component[6] = {0, 1, 2, 0, 1, 0};
inline constexpr int column_of_component[6] = {0, 1, 2, 1, 2, 2};

/// Spectral decomposition A = sum_a value[a] n_a (x) n_a of a symmetric 3x3 tensor;
/// `vector[i][a]` is component i of the unit vector n_a.
struct Spectrum {
  double value[3];
  double vector[3][3];
};

/// One Jacobi rotation that annihilates a[p][q] (Golub & Van Loan, Matrix Computations, 8.5.2).
TILTH_FUNCTION void jacobi_rotation(double a[3][3], double v[3][3], int p, int q, int size) {
  const double off = a[p][q];
  if (off == 0.0) return;
  const double theta = (a[q][q] - a[p][p]) / (2.0 * off);
  const double t =
      (theta >= 0.0 ? 1.0 : -1.0) / (std::fabs(theta) + std::sqrt(1.0 + theta * theta));
  const double c = 1.0 / std::sqrt(1.0 + t * t);
  const double s = t * c;
  a[p][p] -= t * off;
  a[q][q] += t * off;
  a[p][q] = a[q][p] = 0.0;
  for (int i = 0; i < size; ++i) {
    if (i != p && i != q) {
      const double ip = a[i][p];
      const double iq = a[i][q];
      a[i][p] = a[p][i] = c * ip - s * iq;
      a[i][q] = a[q][i] = s * ip + c * iq;
    }
    const double vp = v[i][p];
    const double vq = v[i][q];
    v[i][p] = c * vp - s * vq;
    v[i][q] = s * vp + c * vq;
  }
}

/// Spectral decomposition by cyclic Jacobi rotations. `InPlane` says that xz and yz vanish
/// (plane strain, axisymmetry): one rotation is then exact and the third axis stays in place.
template <bool InPlane>
TILTH_FUNCTION Spectrum spectrum(const double component[6]) {
  double a[3][3] = {{component[0], component[3], component[5]},
                    {component[3], component[1], component[4]},
                    {component[5], component[4], component[2]}};
  Spectrum result{};
  double (*v)[3] = result.vector;
  v[0][0] = v[1][1] = v[2][2] = 1.0;
  if constexpr (InPlane) {
    jacobi_rotation(a, v, 0, 1, 2);
  } else {
    constexpr int maximum_sweeps = 12;  // converges quadratically: 3 to 5 are needed
    for (int sweep = 0; sweep < maximum_sweeps; ++sweep) {
      const double off = a[0][1] * a[0][1] + a[1][2] * a[1][2] + a[0][2] * a[0][2];
      const double diagonal = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
      if (off <= 1e-34 * diagonal) break;
      jacobi_rotation(a, v, 0, 1, 3);
      jacobi_rotation(a, v, 0, 2, 3);
      jacobi_rotation(a, v, 1, 2, 3);
    }
  }
  for (int i = 0; i < 3; ++i) result.value[i] = a[i][i];
  return result;
}

/// Symmetric tensor sum_a value[a] n_a (x) n_a in six components.
TILTH_FUNCTION void compose(const double value[3], const double vector[3][3], double component[6]) {
  for (int k = 0; k < 6; ++k) {
    const int i = row_of_component[k];
    const int j = column_of_component[k];
    double sum = 0.0;
    for (int a = 0; a < 3; ++a) sum += value[a] * vector[i][a] * vector[j][a];
    component[k] = sum;
  }
}

/// (x - y) / (exp(2x) - exp(2y)), given beta_x - 1 = expm1(2x) and likewise for y; no digits are
/// lost when the two are close or equal (limit 1 / (2 beta)).
TILTH_FUNCTION double logarithm_divided_difference(double x, double y, double beta_x_minus_one,
                                                   double beta_y_minus_one) {
  const double difference = beta_x_minus_one - beta_y_minus_one;
  const double beta_y = 1.0 + beta_y_minus_one;
  const double z = difference / beta_y;
  if (std::fabs(z) > 1e-4) return (x - y) / difference;
  return 0.5 / beta_y * (1.0 - z * (0.5 - z * (1.0 / 3.0 - 0.25 * z)));
}

}  // namespace tilth
