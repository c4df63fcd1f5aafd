// SPDX-License-Identifier: BSD-3-Clause
// Convected particle domain interpolation: the shape function of a node is replaced, over a point's
// domain, by its interpolation between the domain's corners,
//   S_a = sum_c w_c N_a(x_c),   grad S_a = sum_c g_c N_a(x_c),
// with w_c and g_c the means of the corners' own (multilinear) functions and of their gradients
// over the domain. CPDI1: the domain is a parallelogram or parallelepiped carried by the
// deformation gradient (Sadeghirad, Brannon & Burghardt 2011, eqs. 17, 18). CPDI2: a quadrilateral
// or hexahedron whose corners move with the grid (Sadeghirad, Brannon & Guilkey 2013).
#pragma once

#include <cmath>

#include "../annotation.hpp"

namespace tilth::basis {

struct Cpdi1 {
  static constexpr const char* name = "cpdi1";
};

struct Cpdi2 {
  static constexpr const char* name = "cpdi2";
};

/// Corners are numbered x fastest: bit k of the number is its side in direction k.
template <int Dim>
inline constexpr int corners_of = 1 << Dim;

/// Multilinear functions of the corners and their derivatives at `xi` in [-1, 1]^Dim.
template <int Dim>
TILTH_FUNCTION void corner_functions(const double xi[Dim], double value[corners_of<Dim>],
                                     double slope[corners_of<Dim>][Dim]) {
  for (int c = 0; c < corners_of<Dim>; ++c) {
    double hat[Dim];
    for (int k = 0; k < Dim; ++k) hat[k] = 0.5 * (1.0 + ((c >> k) & 1 ? xi[k] : -xi[k]));
    value[c] = 1.0;
    for (int k = 0; k < Dim; ++k) {
      value[c] *= hat[k];
      slope[c][k] = (c >> k) & 1 ? 0.5 : -0.5;
      for (int j = 0; j < Dim; ++j)
        if (j != k) slope[c][k] *= hat[j];
    }
  }
}

/// Cofactors of d x / d xi for corners (2^Dim, Dim); returns the determinant.
template <int Dim>
TILTH_FUNCTION double cofactors(const double* corner, const double slope[corners_of<Dim>][Dim],
                                double cofactor[Dim][Dim]) {
  double j[Dim][Dim] = {};
  for (int c = 0; c < corners_of<Dim>; ++c)
    for (int i = 0; i < Dim; ++i)
      for (int k = 0; k < Dim; ++k) j[i][k] += corner[Dim * c + i] * slope[c][k];
  if constexpr (Dim == 2) {
    cofactor[0][0] = j[1][1];
    cofactor[0][1] = -j[1][0];
    cofactor[1][0] = -j[0][1];
    cofactor[1][1] = j[0][0];
    return j[0][0] * j[1][1] - j[0][1] * j[1][0];
  } else {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const int a = (i + 1) % 3, b = (i + 2) % 3, d = (k + 1) % 3, e = (k + 2) % 3;
        cofactor[i][k] = j[a][d] * j[b][e] - j[a][e] * j[b][d];
      }
    return j[0][0] * cofactor[0][0] + j[0][1] * cofactor[0][1] + j[0][2] * cofactor[0][2];
  }
}

/// Volume of a domain and the means of its corners' functions over it.
template <int Dim>
struct CornerWeights {
  double volume;
  double value[corners_of<Dim>];          // w_c [-]
  double gradient[corners_of<Dim>][Dim];  // g_c [1/length]
};

/// The integrands are polynomials of at most third degree in each direction, which two Gauss
/// points per direction integrate exactly.
template <int Dim>
TILTH_FUNCTION CornerWeights<Dim> corner_weights(const double* corner) {
  constexpr int corners = corners_of<Dim>;
  constexpr double gauss = 0.57735026918962576451;  // 1 / sqrt(3)
  CornerWeights<Dim> found{};
  for (int q = 0; q < corners; ++q) {
    double xi[Dim], value[corners], slope[corners][Dim], cofactor[Dim][Dim];
    for (int k = 0; k < Dim; ++k) xi[k] = (q >> k) & 1 ? gauss : -gauss;
    corner_functions<Dim>(xi, value, slope);
    const double determinant = cofactors<Dim>(corner, slope, cofactor);
    found.volume += determinant;
    for (int c = 0; c < corners; ++c) {
      found.value[c] += value[c] * determinant;
      for (int i = 0; i < Dim; ++i)
        for (int k = 0; k < Dim; ++k) found.gradient[c][i] += cofactor[i][k] * slope[c][k];
    }
  }
  for (int c = 0; c < corners; ++c) {
    found.value[c] /= found.volume;
    for (int i = 0; i < Dim; ++i) found.gradient[c][i] /= found.volume;
  }
  return found;
}

/// Smallest determinant of d x / d xi at the corners and Gauss points, over the domain's mean: not
/// positive where the domain is folded or inverted (in 2D exactly where it is not convex).
template <int Dim>
TILTH_FUNCTION double least_stretch(const double* corner) {
  constexpr int corners = corners_of<Dim>;
  double least = 0.0, sum = 0.0;
  for (int q = 0; q < 2 * corners; ++q) {
    const double at = q < corners ? 1.0 : 0.57735026918962576451;
    double xi[Dim], value[corners], slope[corners][Dim], cofactor[Dim][Dim];
    for (int k = 0; k < Dim; ++k) xi[k] = (q >> k) & 1 ? at : -at;
    corner_functions<Dim>(xi, value, slope);
    const double determinant = cofactors<Dim>(corner, slope, cofactor);
    least = q == 0 || determinant < least ? determinant : least;
    if (q >= corners) sum += determinant;
  }
  return sum > 0.0 ? least * corners / sum : -1.0;
}

}  // namespace tilth::basis
