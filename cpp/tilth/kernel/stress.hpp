// SPDX-License-Identifier: BSD-3-Clause
// Stress update of the points of one body for a trial nodal displacement of the step:
// displacement gradient -> trial elastic strain -> return mapping in principal logarithmic strains.
// (Simo 1992; Charlton, Coombs & Augarde 2017; docs/theory/mechanics.md)
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "f_bar.hpp"
#include "gradient.hpp"
#include "point_stress.hpp"

namespace tilth::kernel {

/// A function of symmetric tensors, six components per point: `function` of the principal values.
template <class K, class Function>
void map_principal_values(std::int64_t points, const double* tensor, double* result,
                          Function function) {
#pragma omp parallel for schedule(static) if (stress_work * points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    Spectrum<double> s = spectrum<K::in_plane>(tensor + 6 * p);
    for (double& value : s.value) value = function(value);
    compose(s.value, s.vector, result + 6 * p);
  }
}

/// Result of a stress update: the lowest-numbered point that failed, or -1.
struct Failure {
  std::int64_t point = -1;
  PointStatus status = PointStatus::good;
};

template <class K>
Failure stress_update(const Stencil& stencil, const material::PointLaw& law,
                      const double* displacement, const StressArrays& arrays,
                      const Centres* centres) {
  constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::int64_t worst = none;  // point * 4 + status
#pragma omp parallel reduction(min : worst) if (stress_work * stencil.work() >= parallel_from)
  {
    Batch batch;
    const auto fail = [&worst](std::int64_t p, PointStatus status) {
      const std::int64_t code = 4 * p + static_cast<std::int64_t>(status);
      worst = code < worst ? code : worst;
    };
    for_displacement_gradients_of_team<K>(
        stencil, displacement, arrays.position,
        [&](std::int64_t g, std::int64_t p, const double h[3][3]) {
          const bool torn_off = arrays.torn_off != nullptr && arrays.torn_off[p];
          bool kept = torn_off && keeps_shape(h);
          double stretch = 0.0;
          if (centres != nullptr && !kept) {
            stretch = volumetric_stretch<K>(*centres, g,
                                            centres->first_share(g, p - stencil.start[g]), h, p);
            kept = torn_off && !(stretch > -1.0);
          }
          if (arrays.kept != nullptr) arrays.kept[p] = kept;
          if (kept) {
            constexpr double none[3][3] = {};
            if (centres != nullptr) keep_volume(*centres, p);
            batch.add(p, none, 0.0);
          } else {
            if (!(stretch > -1.0)) return fail(p, PointStatus::inverted);
            batch.add(p, h, stretch);
          }
          if (batch.size == lane_count)
            update_batch<K>(law, batch, arrays, centres != nullptr, fail);
        });
    update_batch<K>(law, batch, arrays, centres != nullptr, fail);
  }
  if (worst == none) return {};
  return {worst / 4, static_cast<PointStatus>(worst % 4)};
}

}  // namespace tilth::kernel
