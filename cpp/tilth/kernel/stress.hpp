// SPDX-License-Identifier: BSD-3-Clause
// Stress update of the points of one body for a trial nodal displacement of the step:
// displacement gradient -> trial elastic strain -> return mapping in principal logarithmic strains.
// (Simo 1992; Charlton, Coombs & Augarde 2017; docs/theory/mechanics.md)
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "../tensor.hpp"
#include "f_bar.hpp"
#include "response.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// exp(2 eps) - 1 of the elastic logarithmic strain, six components per point.
template <class K>
void elastic_deformation(std::int64_t points, const double* strain, double* deformation) {
#pragma omp parallel for schedule(static) if (stress_work * points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    Spectrum s = spectrum<K::in_plane>(strain + 6 * p);
    for (double& value : s.value) value = std::expm1(2.0 * value);
    compose(s.value, s.vector, deformation + 6 * p);
  }
}

/// State of the points at the start of the step and what the trial displacement makes of it.
struct StressArrays {
  const double* position;             // (n, dim), for the radius
  const double* elastic_deformation;  // (n, 6) exp(2 eps) - 1 at the start of the step
  const double* plastic_before;       // (n, 2) equivalent plastic strain, dissipation density
  const double* state_before;         // (n, state_width) internal variables of the material
  double* increment;                  // (n, 3, 3) deformation gradient of the step
  double* strain;                     // (n, 6) elastic logarithmic strain
  double* plastic;                    // (n, 2)
  double* state;                      // (n, state_width)
  double* response;                   // (n, response_size)
  std::int64_t state_width;           // columns of the state arrays, at least state_count
};

enum class PointStatus : std::int64_t { good = 0, inverted = 1, return_mapping = 2 };

/// Trial left Cauchy-Green tensor less the identity: c + X + X^T + X H^T with X = H (1 + c), where
/// c = b - 1 at the start of the step and H the displacement gradient; exact for small strains.
TILTH_FUNCTION void trial_deformation(const double h[3][3], const double before[6],
                                      double after[6]) {
  const double b[3][3] = {{1.0 + before[0], before[3], before[5]},
                          {before[3], 1.0 + before[1], before[4]},
                          {before[5], before[4], 1.0 + before[2]}};
  double x[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) x[i][j] = h[i][0] * b[0][j] + h[i][1] * b[1][j] + h[i][2] * b[2][j];
  for (int k = 0; k < 6; ++k) {
    const int i = row_of_component[k];
    const int j = column_of_component[k];
    after[k] =
        before[k] + x[i][j] + x[j][i] + x[i][0] * h[j][0] + x[i][1] * h[j][1] + x[i][2] * h[j][2];
  }
}

/// Inverse of F = 1 + H; returns det F.
TILTH_FUNCTION double invert(const double f[3][3], double inverse[3][3]) {
  double cofactor[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      cofactor[i][j] = f[i1][j1] * f[i2][j2] - f[i1][j2] * f[i2][j1];
    }
  const double determinant =
      f[0][0] * cofactor[0][0] + f[0][1] * cofactor[0][1] + f[0][2] * cofactor[0][2];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) inverse[i][j] = cofactor[j][i] / determinant;
  return determinant;
}

/// (tau_a - tau_b) / (beta_a - beta_b); near equal principal strains the limit
/// (d tau_a/d eps_a - d tau_a/d eps_b) / (2 beta), whose error is quadratic in the gap.
TILTH_FUNCTION double shear_stiffness(const double tau[3], const double tangent[3][3],
                                      const double strain[3], const double beta_minus_one[3], int a,
                                      int b) {
  const double gap = strain[a] - strain[b];
  const double scale = std::fabs(strain[0]) + std::fabs(strain[1]) + std::fabs(strain[2]);
  const double slope = std::fabs(gap) > 1e-5 * scale
                           ? (tau[a] - tau[b]) / gap
                           : 0.5 * (tangent[a][a] - tangent[a][b] + tangent[b][b] - tangent[b][a]);
  return slope *
         logarithm_divided_difference(strain[a], strain[b], beta_minus_one[a], beta_minus_one[b]);
}

/// Updates one point; `h` is the displacement gradient of the step (hoop part at [2][2]), of which
/// the strain takes the one stretched by 1 + `stretch_minus_one` (F-bar; 0 without).
template <class K, class Material>
PointStatus update_point(const Material& material, double h[3][3], double stretch_minus_one,
                         std::int64_t p, const StressArrays& arrays) {
  double f[3][3], inverse[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) f[i][j] = h[i][j] + (i == j ? 1.0 : 0.0);
  const double determinant = invert(f, inverse);
  if (!(determinant > 0.0) || !(f[2][2] > 0.0 || K::dim == 3)) return PointStatus::inverted;

  if (stretch_minus_one != 0.0) stretch_gradient<K>(stretch_minus_one, h);
  double trial_b[6];
  trial_deformation(h, arrays.elastic_deformation + 6 * p, trial_b);
  const Spectrum s = spectrum<K::in_plane>(trial_b);
  double trial[3];
  for (int a = 0; a < 3; ++a) {
    if (!(s.value[a] > -1.0)) return PointStatus::inverted;
    trial[a] = 0.5 * std::log1p(s.value[a]);
  }

  auto& response = reinterpret_cast<Response<K>*>(arrays.response)[p];
  double elastic[3];
  if (!material.update(
          trial, arrays.plastic_before[2 * p], arrays.state_before + arrays.state_width * p,
          arrays.state + arrays.state_width * p, response.kirchhoff, elastic, response.tangent))
    return PointStatus::return_mapping;

  const double plastic[3] = {trial[0] - elastic[0], trial[1] - elastic[1], trial[2] - elastic[2]};
  const double mean = (plastic[0] + plastic[1] + plastic[2]) / 3.0;
  double squared = 0.0, work = 0.0;
  for (int a = 0; a < 3; ++a) {
    squared += (plastic[a] - mean) * (plastic[a] - mean);
    work += response.kirchhoff[a] * plastic[a];
  }
  arrays.plastic[2 * p] = arrays.plastic_before[2 * p] + std::sqrt(2.0 / 3.0 * squared);
  arrays.plastic[2 * p + 1] = arrays.plastic_before[2 * p + 1] + work;
  compose(elastic, s.vector, arrays.strain + 6 * p);

  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) arrays.increment[9 * p + 3 * i + j] = f[i][j];
  for (int a = 0; a < K::dim; ++a) {
    response.beta[a] = 1.0 + s.value[a];
    for (int i = 0; i < K::dim; ++i) response.axis[i][a] = s.vector[i][a];
    for (int j = 0; j < K::dim; ++j) {
      double sum = 0.0;
      for (int i = 0; i < K::dim; ++i) sum += s.vector[i][a] * inverse[j][i];
      response.to_current[a][j] = sum;
    }
  }
  for (int a = 0; a < Response<K>::pairs; ++a) {
    const int b = (a + 1) % 3;
    response.shear[Response<K>::pair(a, b)] =
        shear_stiffness(response.kirchhoff, response.tangent, trial, s.value, a, b);
  }
  response.hoop_inverse = inverse[2][2];
  return PointStatus::good;
}

/// Result of a stress update: the lowest-numbered point that failed, or -1.
struct Failure {
  std::int64_t point = -1;
  PointStatus status = PointStatus::good;
};

template <class K, class Material>
Failure stress_update(const Stencil& stencil, const Material& material, const double* displacement,
                      const StressArrays& arrays, const Centres* centres) {
  constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  constexpr int dim = K::dim;
  std::int64_t worst = none;  // point * 4 + status
#pragma omp parallel for schedule(static) \
    reduction(min : worst) if (stress_work * stencil.start[stencil.groups] >= parallel_from)
  for (std::int64_t g = 0; g < stencil.groups; ++g) {
    with_node_count<dim>(stencil.nodes_of(g), [&]<int N>() {
      const int n = N > 0 ? N : stencil.nodes_of(g);
      const std::int32_t* node = stencil.node + stencil.node_start[g];
      double u[dim][N > 0 ? N : maximum_nodes];
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < dim; ++i) u[i][a] = displacement[dim * std::int64_t{node[a]} + i];
      std::int64_t offset = stencil.value_start[g];
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p, offset += n) {
        const double* gradient = stencil.gradient + dim * offset;
        double h[3][3] = {};
        for (int i = 0; i < dim; ++i)
          for (int j = 0; j < dim; ++j) {
            double sum = 0.0;
#pragma omp simd reduction(+ : sum)
            for (int a = 0; a < n; ++a) sum += u[i][a] * gradient[j * n + a];
            h[i][j] = sum;
          }
        if constexpr (K::hoop) {
          const double* value = stencil.value + offset;
          double radial = 0.0;
          for (int a = 0; a < n; ++a) radial += u[0][a] * value[a];
          h[2][2] = radial / arrays.position[dim * p];
        }
        double stretch = 0.0;
        PointStatus status = PointStatus::inverted;
        if (centres != nullptr) {
          const double* shares = centres->share + centres->share_start[g] +
                                 (p - stencil.start[g]) * centres->cells_of(g);
          stretch = volumetric_stretch<K>(*centres, g, shares, h, p);
        }
        if (stretch > -1.0) status = update_point<K>(material, h, stretch, p, arrays);
        if (status != PointStatus::good) {
          const std::int64_t code = 4 * p + static_cast<std::int64_t>(status);
          worst = code < worst ? code : worst;
        }
      }
    });
  }
  if (worst == none) return {};
  return {worst / 4, static_cast<PointStatus>(worst % 4)};
}

}  // namespace tilth::kernel
