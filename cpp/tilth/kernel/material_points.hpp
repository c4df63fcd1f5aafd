// SPDX-License-Identifier: BSD-3-Clause
// Evaluation of constitutive laws at the points of one body, without a displacement of the grid.
// Strains are elastic left Cauchy-Green tensors less the identity, six components per point.
#pragma once

#include <cmath>
#include <cstdint>

#include "../parallel.hpp"
#include "../tensor.hpp"
#include "point_stress.hpp"

namespace tilth::kernel {

/// Fills bulk, shear and Young's modulus (n,).
template <class K>
void elastic_moduli(std::int64_t points, const material::PointLaw& law, const double* deformation,
                    const double* state, std::int64_t state_width, double* bulk, double* shear,
                    double* young) {
  const bool constant = law.constant_moduli();
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    double strain[3] = {};
    if (!constant) {
      const Spectrum<double> s = spectrum<K::in_plane>(deformation + 6 * p);
      for (int a = 0; a < 3; ++a) strain[a] = 0.5 * std::log1p(s.value[a]);
    }
    const auto m = law.moduli(p, strain, state + state_width * p);
    bulk[p] = m.bulk;
    shear[p] = m.shear;
    young[p] = 9.0 * m.bulk * m.shear / (3.0 * m.bulk + m.shear);
  }
}

/// Fills the stored energy per initial volume (n,).
template <class K>
void stored_energy(std::int64_t points, const material::PointLaw& law, const double* deformation,
                   const double* state, std::int64_t state_width, double* energy) {
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    Spectrum<double> s = spectrum<K::in_plane>(deformation + 6 * p);
    for (double& value : s.value) value = 0.5 * std::log1p(value);
    energy[p] = law.energy(p, s.value, state + state_width * p);
  }
}

/// Fills the elastic deformation of given Kirchhoff stresses (n, 6); returns the first point for
/// which the law has none, -1 if all have one.
template <class K>
std::int64_t elastic_deformation_of(std::int64_t points, const material::PointLaw& law,
                                    const double* kirchhoff, const double* state,
                                    std::int64_t state_width, double* deformation) {
  for (std::int64_t p = 0; p < points; ++p) {
    const Spectrum<double> s = spectrum<K::in_plane>(kirchhoff + 6 * p);
    double strain[3];
    if (!law.elastic_strain(p, s.value, state + state_width * p, strain)) return p;
    for (double& value : strain) value = std::expm1(2.0 * value);
    compose(strain, s.vector, deformation + 6 * p);
  }
  return -1;
}

/// Fills the state variables of points with given Kirchhoff stresses (n, 6); returns the first
/// point whose law cannot have its stress, -1 if all can.
template <class K>
std::int64_t initial_state(std::int64_t points, const material::PointLaw& law,
                           const double* kirchhoff, double* state, std::int64_t state_width) {
  for (std::int64_t p = 0; p < points; ++p) {
    const Spectrum<double> s = spectrum<K::in_plane>(kirchhoff + 6 * p);
    if (!law.initial_state(p, s.value, state + state_width * p)) return p;
  }
  return -1;
}

/// Return mapping with the elastic deformation of the points as trial state.
/// `arrays.elastic_before` is that deformation; fills elastic, plastic, state and the Kirchhoff
/// stress (n, 6), and admissible (n,): whether the law found a solution.
template <class K>
void return_to_law(std::int64_t points, const material::PointLaw& law, const StressArrays& arrays,
                   double* kirchhoff, bool* admissible) {
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t first = 0; first < points; first += lane_count) {
    Batch batch{};
    const double no_displacement[3][3] = {};
    for (std::int64_t p = first; p < points && p < first + lane_count; ++p)
      batch.add(p, no_displacement, 0.0);
    batch.fill();
    Lanes before[6];
    gather_lanes(arrays.elastic_before, 6, batch, before);
    const Spectrum<Lanes> s = spectrum<K::in_plane>(before);
    Lanes trial[3], tau[3], tangent[3][3];
    for (int a = 0; a < 3; ++a) trial[a] = 0.5 * log_one_plus(s.value[a]);
    const Mask all = Lanes(1.0) > 0.0;
    const Returned returned = update_material(law, batch, all, trial, arrays, tau, tangent);
    Lanes accumulated[2];
    gather_lanes(arrays.plastic_before, 2, batch, accumulated);
    add_plastic_strain(trial, returned, accumulated);
    if (returned.any_yields) {
      Lanes elastic[6];
      compose(returned.deformation, s.vector, elastic);
      for (int k = 0; k < 6; ++k) before[k] = select(returned.yields, elastic[k], before[k]);
    }
    Lanes stress[6];
    compose(tau, s.vector, stress);
    scatter_lanes(before, 6, batch, arrays.elastic);
    scatter_lanes(accumulated, 2, batch, arrays.plastic);
    scatter_lanes(stress, 6, batch, kirchhoff);
    for (int lane = 0; lane < batch.size; ++lane)
      admissible[batch.point[lane]] = !(returned.failed >> lane & 1u);
  }
}

}  // namespace tilth::kernel
