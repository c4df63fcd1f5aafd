// SPDX-License-Identifier: BSD-3-Clause
// Symmetric tensors in the order of Abaqus.
#pragma once

#include <cmath>
#include <utility>

namespace tilth::abaqus {

/// A symmetric tensor, of NDI direct components and NSHR shear components in the order 12, 13, 23.
class Tensor {
 public:
  Tensor() = default;

  /// factor: on the shear components, 1/2 for engineering strains.
  Tensor(const double* components, double factor, int ndi, int nshr) {
    for (int i = 0; i < ndi; ++i) t_[i][i] = components[i];
    for (int k = 0; k < nshr; ++k)
      t_[row[k]][column[k]] = t_[column[k]][row[k]] = factor * components[ndi + k];
  }

  double operator()(int i, int j) const { return t_[i][j]; }

  /// Writes the components; arguments as of the constructor.
  void store(double* components, double factor, int ndi, int nshr) const {
    for (int i = 0; i < ndi; ++i) components[i] = t_[i][i];
    for (int k = 0; k < nshr; ++k) components[ndi + k] = t_[row[k]][column[k]] / factor;
  }

  /// Returns R t R^T, where R(i, j) is r[i + 3 j] as in Fortran.
  Tensor rotated(const double* r) const {
    Tensor found;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l) found.t_[i][j] += r[i + 3 * k] * t_[k][l] * r[j + 3 * l];
    return found;
  }

  /// Finds the principal values, largest first, and directions[k] of value k, by Jacobi's rotations
  /// (Golub and Van Loan, Matrix Computations, 8.5).
  void principal(double values[3], double directions[3][3]) const {
    double a[3][3], v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) a[i][j] = t_[i][j];
    for (int sweep = 0; sweep < most_sweeps; ++sweep)
      for (int k = 0; k < 3; ++k) rotate(a, v, row[k], column[k]);
    int order[3] = {0, 1, 2};
    for (int k : {0, 1, 0})
      if (a[order[k]][order[k]] < a[order[k + 1]][order[k + 1]]) std::swap(order[k], order[k + 1]);
    for (int k = 0; k < 3; ++k) {
      values[k] = a[order[k]][order[k]];
      for (int i = 0; i < 3; ++i) directions[k][i] = v[i][order[k]];
    }
  }

 private:
  static constexpr int row[3] = {0, 0, 1}, column[3] = {1, 2, 2};
  static constexpr int most_sweeps = 8;  // they converge quadratically, after two or three

  double t_[3][3] = {};

  /// Makes a[p][q] vanish; the columns of v become the directions.
  static void rotate(double a[3][3], double v[3][3], int p, int q) {
    if (a[p][q] == 0.0) return;
    const double ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    const double tangent =
        std::copysign(1.0, ratio) / (std::fabs(ratio) + std::sqrt(1.0 + ratio * ratio));
    const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent), sine = tangent * cosine;
    const auto turn = [&](double& x, double& y) {
      const double before = x;
      x = cosine * before - sine * y;
      y = sine * before + cosine * y;
    };
    for (int k = 0; k < 3; ++k) turn(a[k][p], a[k][q]);
    for (int k = 0; k < 3; ++k) turn(a[p][k], a[q][k]);
    for (int k = 0; k < 3; ++k) turn(v[k][p], v[k][q]);
    a[p][q] = a[q][p] = 0.0;
  }
};

}  // namespace tilth::abaqus
