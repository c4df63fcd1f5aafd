// SPDX-License-Identifier: BSD-3-Clause
// Smoothing of the volumetric strains of yielding points towards their cells' mean (f_bar.py).
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "../parallel.hpp"
#include "f_bar.hpp"

namespace tilth::kernel {

/// Volumetric logarithmic strain of the elastic left Cauchy-Green tensor less the identity.
inline void volumetric_strains(std::int64_t points, const double* deformation, double* strain) {
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    const double* c = deformation + 6 * p;
    const double tensor[3][3] = {{c[0], c[3], c[5]}, {c[3], c[1], c[4]}, {c[5], c[4], c[2]}};
    strain[p] = 0.5 * std::log1p(jacobian_minus_one(tensor));
  }
}

/// Fills `increment` with `fraction` times (mean of the point's cells - strain), where the mean of
/// a cell is weighted by share, volume and `fraction`. `group_start` (groups + 1) are the groups'
/// points.
inline void smooth_strains(std::int64_t groups, const std::int64_t* group_start,
                           const Centres& centres, std::int64_t cells, const double* strain,
                           const double* volume, const double* fraction, double* increment) {
  std::vector<double> total(cells, 0.0), mean(cells, 0.0);
  for (std::int64_t g = 0; g < groups; ++g) {
    const std::int32_t* cell = centres.cell + centres.cell_start[g];
    const double* share = centres.share + centres.share_start[g];
    const int n = centres.cells_of(g);
    for (std::int64_t p = group_start[g]; p < group_start[g + 1]; ++p, share += n)
      for (int c = 0; c < n; ++c) {
        const double weight = share[c] * volume[p] * fraction[p];
        total[cell[c]] += weight;
        mean[cell[c]] += weight * strain[p];
      }
  }
  for (std::int64_t c = 0; c < cells; ++c) mean[c] /= total[c] > 0.0 ? total[c] : 1.0;
#pragma omp parallel for schedule(static) if (group_start[groups] >= parallel_from)
  for (std::int64_t g = 0; g < groups; ++g) {
    const std::int32_t* cell = centres.cell + centres.cell_start[g];
    const double* share = centres.share + centres.share_start[g];
    const int n = centres.cells_of(g);
    for (std::int64_t p = group_start[g]; p < group_start[g + 1]; ++p, share += n) {
      double target = 0.0;
      for (int c = 0; c < n; ++c) target += share[c] * mean[cell[c]];
      increment[p] = fraction[p] > 0.0 ? fraction[p] * (target - strain[p]) : 0.0;
    }
  }
}

}  // namespace tilth::kernel
