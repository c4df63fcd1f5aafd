// SPDX-License-Identifier: BSD-3-Clause
// Stress update of the points of one body for a trial nodal displacement of the step:
// displacement gradient -> trial elastic strain -> return mapping in principal logarithmic strains.
// (Simo 1992; Charlton, Coombs & Augarde 2017; docs/theory/mechanics.md)
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "f_bar.hpp"
#include "point.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// exp(2 eps) - 1 of the elastic logarithmic strain, six components per point.
template <class K>
void elastic_deformation(std::int64_t points, const double* strain, double* deformation) {
#pragma omp parallel for schedule(static) if (stress_work * points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    Spectrum<double> s = spectrum<K::in_plane>(strain + 6 * p);
    for (double& value : s.value) value = std::expm1(2.0 * value);
    compose(s.value, s.vector, deformation + 6 * p);
  }
}

/// Result of a stress update: the lowest-numbered point that failed, or -1.
struct Failure {
  std::int64_t point = -1;
  PointStatus status = PointStatus::good;
};

/// Displacement gradient of the step at a point; `u` are the displacements of its nodes.
template <class K, int Capacity>
void displacement_gradient(int n, const double u[K::dim][Capacity], const double* value,
                           const double* gradient, const double* position, double h[3][3]) {
  for (int i = 0; i < K::dim; ++i)
    for (int j = 0; j < K::dim; ++j) {
      double sum = 0.0;
#pragma omp simd reduction(+ : sum)
      for (int a = 0; a < n; ++a) sum += u[i][a] * gradient[j * n + a];
      h[i][j] = sum;
    }
  if constexpr (K::hoop) {
    double radial = 0.0;
    for (int a = 0; a < n; ++a) radial += u[0][a] * value[a];
    h[2][2] = radial / position[0];
  }
}

template <class K, class Material>
Failure stress_update(const Stencil& stencil, const Material& material, const double* displacement,
                      const StressArrays& arrays, const Centres* centres) {
  constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  constexpr int dim = K::dim;
  std::int64_t worst = none;  // point * 4 + status
#pragma omp parallel reduction(min : worst) if (stress_work * stencil.work() >= parallel_from)
  {
    Batch batch;
    const auto fail = [&worst](std::int64_t p, PointStatus status) {
      const std::int64_t code = 4 * p + static_cast<std::int64_t>(status);
      worst = code < worst ? code : worst;
    };
#pragma omp for schedule(static) nowait
    for (std::int64_t g = 0; g < stencil.groups; ++g) {
      with_node_count<dim>(stencil.nodes_of(g), [&]<int N>() {
        constexpr int capacity = N > 0 ? N : maximum_nodes;
        const int n = N > 0 ? N : stencil.nodes_of(g);
        const std::int32_t* node = stencil.node + stencil.node_start[g];
        double u[dim][capacity];
        for (int a = 0; a < n; ++a)
          for (int i = 0; i < dim; ++i) u[i][a] = displacement[dim * std::int64_t{node[a]} + i];
        std::int64_t offset = stencil.value_start[g];
        for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p, offset += n) {
          double h[3][3] = {};
          displacement_gradient<K, capacity>(n, u, stencil.value + offset,
                                             stencil.gradient + dim * offset,
                                             arrays.position + dim * p, h);
          double stretch = 0.0;
          if (centres != nullptr) {
            const double* shares = centres->share + centres->share_start[g] +
                                   (p - stencil.start[g]) * centres->cells_of(g);
            stretch = volumetric_stretch<K>(*centres, g, shares, h, p);
          }
          if (!(stretch > -1.0)) {
            fail(p, PointStatus::inverted);
            continue;
          }
          batch.add(p, h, stretch);
          if (batch.size == lane_count)
            update_batch<K>(material, batch, arrays, centres != nullptr, fail);
        }
      });
    }
    update_batch<K>(material, batch, arrays, centres != nullptr, fail);
  }
  if (worst == none) return {};
  return {worst / 4, static_cast<PointStatus>(worst % 4)};
}

}  // namespace tilth::kernel
