// SPDX-License-Identifier: BSD-3-Clause
// Stress update of points whose displacement gradients are given, as in element tests: the update
// is that of points in the grid (point_stress.hpp). The tangent is the spatial one of stiffness.hpp
// without its geometric part, so that the Kirchhoff stress changes by
//   d tau_pq = sum_r D_pr l_rr (p = q),  s_pq (beta_q l_pq + beta_p l_qp) (p != q)
// in principal axes, with l = dH (1 + H)^-1 (docs/theory/mechanics.md, "Tangent").
#pragma once

#include <cstdint>
#include <limits>

#include "../parallel.hpp"
#include "point_stress.hpp"
#include "stress.hpp"

namespace tilth::kernel {

/// Axes n_p [i][p] and map to current gradients [p][J] of a response in three dimensions.
template <class K>
void full_axes(const Response<K>& s, double axis[3][3], double to_current[3][3]) {
  for (int i = 0; i < 3; ++i)
    for (int p = 0; p < 3; ++p) axis[i][p] = to_current[i][p] = i == p ? 1.0 : 0.0;
  for (int i = 0; i < K::dim; ++i)
    for (int p = 0; p < K::dim; ++p) {
      axis[i][p] = s.axis[i][p];
      to_current[i][p] = s.to_current[i][p];
    }
  if constexpr (K::hoop) to_current[2][2] = s.hoop_inverse;
}

/// Kirchhoff stress (6) of a response, and its derivative with respect to the displacement gradient
/// of the step, row by row (6, 9). In the plane, shear out of it has no derivative.
template <class K>
void kirchhoff_tangent(const Response<K>& s, double kirchhoff[6], double* tangent) {
  double axis[3][3], to_current[3][3];
  full_axes<K>(s, axis, to_current);
  compose(s.kirchhoff, axis, kirchhoff);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double l[3][3], change[3][3] = {};  // in principal axes
      for (int p = 0; p < 3; ++p)
        for (int q = 0; q < 3; ++q) l[p][q] = axis[i][p] * to_current[q][j];
      for (int p = 0; p < 3; ++p)
        for (int r = 0; r < 3; ++r) change[p][p] += s.tangent[p][r] * l[r][r];
      for (int n = 0; n < Response<K>::pairs; ++n) {
        const int p = n, q = (n + 1) % 3;
        change[p][q] = change[q][p] =
            s.shear[Response<K>::pair(p, q)] * (s.beta[q] * l[p][q] + s.beta[p] * l[q][p]);
      }
      for (int k = 0; k < 6; ++k) {
        double sum = 0.0;
        for (int p = 0; p < 3; ++p)
          for (int q = 0; q < 3; ++q)
            sum += axis[row_of_component[k]][p] * axis[column_of_component[k]][q] * change[p][q];
        tangent[9 * k + 3 * i + j] = sum;
      }
    }
}

/// Updates points for displacement gradients (n, 3, 3) of the step; fills the state and response of
/// `arrays`, the Kirchhoff stress (n, 6) and its derivative (n, 6, 9).
template <class K>
Failure update_of_gradients(std::int64_t points, const material::PointLaw& law,
                            const double* gradient, const StressArrays& arrays, double* kirchhoff,
                            double* tangent) {
  constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::int64_t worst = none;  // point * 4 + status
#pragma omp parallel for schedule(static) \
    reduction(min : worst) if (stress_work * points >= parallel_from)
  for (std::int64_t first = 0; first < points; first += lane_count) {
    Batch batch{};
    const auto fail = [&worst](std::int64_t p, PointStatus status) {
      const std::int64_t code = 4 * p + static_cast<std::int64_t>(status);
      worst = code < worst ? code : worst;
    };
    const std::int64_t last = first + lane_count < points ? first + lane_count : points;
    for (std::int64_t p = first; p < last; ++p) {
      double h[3][3];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) h[i][j] = gradient[9 * p + 3 * i + j];
      batch.add(p, h, 0.0);
    }
    update_batch<K>(law, batch, arrays, false, fail);
    for (std::int64_t p = first; p < last; ++p) {
      const auto& response =
          *reinterpret_cast<const Response<K>*>(arrays.response + response_size<K> * p);
      kirchhoff_tangent<K>(response, kirchhoff + 6 * p, tangent + 54 * p);
    }
  }
  if (worst == none) return {};
  return {worst / 4, static_cast<PointStatus>(worst % 4)};
}

}  // namespace tilth::kernel
