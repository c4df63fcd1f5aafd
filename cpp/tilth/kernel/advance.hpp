// SPDX-License-Identifier: BSD-3-Clause
// Update of the points of one body after a converged step: deformation gradient, Cauchy stress, and
// the half lengths of GIMP domains by the chosen rule (docs/theory/domains.md).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "../grid.hpp"
#include "../grid_lines.hpp"
#include "../parallel.hpp"
#include "../tensor.hpp"
#include "gradient.hpp"
#include "point_stress.hpp"
#include "response.hpp"

namespace tilth::kernel {

/// Arrays of the points of one body when a step has converged.
struct ConvergedArrays {
  const double* position;        // (n, dim) at the start of the step
  const double* response;        // (n, response_size) of the final displacement
  const double* plastic_before;  // (n, 2) equivalent plastic strain, dissipation density
  const double* plastic_after;   // (n, 2)
  double* last_gradient;         // (n, dim, dim) displacement gradient of the step
  double* deformation_gradient;  // (n, 3, 3)
  double* cauchy;                // (n, 6)
  double* elastic_share;         // (n) of the last deviatoric strain
  double forgotten_strain;       // over which the share before it is forgotten
  const bool* kept;              // (n) torn-off points that keep their shape; null if none can
};

/// Share of the last deviatoric strain that was elastic; `plastic` is the step's increment of
/// equivalent plastic strain, sqrt(2/3) of the tensor's norm, `before` the share before the step,
/// which is forgotten over the strain `forgotten`: a step in which next to nothing moves does not
/// say whether the soil flows.
inline double elastic_share(const double h[3][3], double plastic, double before, double forgotten) {
  const double mean = (h[0][0] + h[1][1] + h[2][2]) / 3.0;
  double square = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double strain = 0.5 * (h[i][j] + h[j][i]) - (i == j ? mean : 0.0);
      square += strain * strain;
    }
  const double size = std::max(std::sqrt(square), std::numeric_limits<double>::min());
  const double share = std::max(0.0, 1.0 - std::sqrt(1.5) * std::max(plastic, 0.0) / size);
  return share + (before - share) * std::exp(-size / forgotten);
}

/// F <- dF F; sigma = tau / det F in six components; displacement gradient and elastic share of the
/// step.
template <class K>
void advance(const Stencil& stencil, const double* displacement, const ConvergedArrays& arrays) {
  constexpr int dim = K::dim;
  const auto* response = reinterpret_cast<const Response<K>*>(arrays.response);
  for_displacement_gradients<K>(stencil, displacement, arrays.position,
                                [&](std::int64_t /*group*/, std::int64_t p, const double g[3][3]) {
                                  const bool kept = arrays.kept != nullptr && arrays.kept[p];
                                  double h[3][3] = {};
                                  for (int i = 0; i < 3 && !kept; ++i) std::copy_n(g[i], 3, h[i]);
                                  double before[3][3], f[3][3], inverse[3][3];
                                  double* gradient = arrays.deformation_gradient + 9 * p;
                                  for (int i = 0; i < 3; ++i)
                                    for (int j = 0; j < 3; ++j) before[i][j] = gradient[3 * i + j];
                                  for (int i = 0; i < 3; ++i)
                                    for (int j = 0; j < 3; ++j) {
                                      f[i][j] = before[i][j] + h[i][0] * before[0][j] +
                                                h[i][1] * before[1][j] + h[i][2] * before[2][j];
                                      gradient[3 * i + j] = f[i][j];
                                    }
                                  for (int i = 0; i < dim; ++i)
                                    for (int j = 0; j < dim; ++j)
                                      arrays.last_gradient[dim * (dim * p + i) + j] = h[i][j];
                                  const double determinant = invert(f, inverse);
                                  const Response<K>& r = response[p];
                                  double axis[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
                                  for (int i = 0; i < dim; ++i)
                                    for (int a = 0; a < dim; ++a) axis[i][a] = r.axis[i][a];
                                  compose(r.kirchhoff, axis, arrays.cauchy + 6 * p);
                                  for (int k = 0; k < 6; ++k)
                                    arrays.cauchy[6 * p + k] /= determinant;
                                  arrays.elastic_share[p] = elastic_share(
                                      h, arrays.plastic_after[2 * p] - arrays.plastic_before[2 * p],
                                      arrays.elastic_share[p], arrays.forgotten_strain);
                                });
}

/// Fills `volume` with det F times the initial one.
inline void current_volumes(std::int64_t points, const double* deformation_gradient,
                            const double* initial_volume, double* volume) {
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    const double* f = deformation_gradient + 9 * p;
    volume[p] = initial_volume[p] *
                (f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) +
                 f[2] * (f[3] * f[7] - f[4] * f[6]));
  }
}

/// Rule by which a GIMP domain's half lengths follow the deformation gradient.
enum class DomainRule { determinant, deformation_gradient, right_stretch, left_stretch };

inline DomainRule domain_rule(const std::string& name) {
  if (name == "determinant") return DomainRule::determinant;
  if (name == "deformation_gradient") return DomainRule::deformation_gradient;
  if (name == "right_stretch") return DomainRule::right_stretch;
  if (name == "left_stretch") return DomainRule::left_stretch;
  throw std::invalid_argument("unknown domain rule '" + name + "'");
}

/// Diagonal of the square root U of a symmetric positive definite tensor in six components (Hoger
/// and Carlson 1984). With the invariants of U, i1^2 = I + 2 i2, i2^2 = II + 2 i1 i3 and i3^2 =
/// III; their quartic for i1 is convex above its largest root, to which Newton's method descends.
template <bool InPlane>
void square_root_diagonal(const double c[6], double root[3]) {
  const double in_plane = c[0] * c[1] - c[3] * c[3];
  if constexpr (InPlane) {
    const double determinant = std::sqrt(in_plane);
    const double trace = std::sqrt(c[0] + c[1] + 2.0 * determinant);
    for (int i = 0; i < 2; ++i) root[i] = (c[i] + determinant) / trace;
    root[2] = std::sqrt(c[2]);
  } else {
    const double first = c[0] + c[1] + c[2];
    const double second = in_plane + c[1] * c[2] - c[4] * c[4] + c[0] * c[2] - c[5] * c[5];
    const double i3 =
        std::sqrt(c[0] * (c[1] * c[2] - c[4] * c[4]) - c[3] * (c[3] * c[2] - c[4] * c[5]) +
                  c[5] * (c[3] * c[4] - c[1] * c[5]));
    double i1 = std::sqrt(3.0 * first), i2 = 0.0;  // no less than the root
    constexpr int maximum_iterations =
        60;  // quadratic near the root, halving its distance far from it
    for (int iteration = 0; iteration < maximum_iterations; ++iteration) {
      i2 = 0.5 * (i1 * i1 - first);
      const double correction = (i2 * i2 - second - 2.0 * i1 * i3) / (2.0 * (i1 * i2 - i3));
      i1 -= correction;
      if (!(correction > 1e-15 * i1)) break;
    }
    i2 = 0.5 * (i1 * i1 - first);
    const double square[3] = {c[0] * c[0] + c[3] * c[3] + c[5] * c[5],
                              c[1] * c[1] + c[3] * c[3] + c[4] * c[4],
                              c[2] * c[2] + c[4] * c[4] + c[5] * c[5]};
    for (int i = 0; i < 3; ++i)
      root[i] = (i1 * i3 + (i1 * i1 - i2) * c[i] - square[i]) / (i1 * i2 - i3);
  }
}

/// half <- initial half length times the stretch from F by the rule.
template <class K>
void stretch_domains(std::int64_t points, DomainRule rule, const double* deformation_gradient,
                     const double* initial_half, double* half) {
  constexpr int dim = K::dim;
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    const double* f = deformation_gradient + 9 * p;
    double stretch[3];
    if (rule == DomainRule::determinant) {
      double a[3][3], inverse[3][3];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) a[i][j] = f[3 * i + j];
      if (dim == 2) a[2][2] = 1.0;  // the in-plane area, also in axisymmetry
      const double all = std::pow(invert(a, inverse), 1.0 / dim);
      for (double& s : stretch) s = all;
    } else if (rule == DomainRule::deformation_gradient) {
      for (int i = 0; i < 3; ++i) stretch[i] = f[4 * i];
    } else {
      double c[6];
      for (int k = 0; k < 6; ++k) {
        const int i = row_of_component[k], j = column_of_component[k];
        c[k] = 0.0;
        for (int m = 0; m < 3; ++m)
          c[k] += rule == DomainRule::right_stretch ? f[3 * m + i] * f[3 * m + j]
                                                    : f[3 * i + m] * f[3 * j + m];
      }
      square_root_diagonal<K::in_plane>(c, stretch);
    }
    for (int i = 0; i < dim; ++i) half[dim * p + i] = initial_half[dim * p + i] * stretch[i];
  }
}

/// Rule `corners` (after Coombs et al. 2020, CMAME 358, 112622): the centres of the domain's faces
/// move with the grid's finite-element field; the new half length is half the distance of opposite
/// faces. Rigid rotation (to second order in the step's angle) and simple shear do not change the
/// domain; a stretch acts along the grid's axes, independent of earlier rotations. Positions are
/// those at the start of the step.
template <int Dim>
void move_domain_faces(std::int64_t points, const double* position, std::int64_t nodes,
                       const std::int64_t* node_keys, const double* displacement,
                       const GridLines& grid, double* half) {
#pragma omp parallel for schedule(static) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    double increment[Dim];
    for (int axis = 0; axis < Dim; ++axis) {
      double moved[2];
      for (int side = 0; side < 2; ++side) {
        Lattice first{0, 0, 0};
        double s[3] = {0.0, 0.0, 0.0};
        for (int k = 0; k < Dim; ++k) {
          // faces stay just inside the domain, so that only active nodes are used
          const double offset =
              k == axis ? (side == 0 ? -1.0 : 1.0) * half[Dim * p + k] * (1.0 - 1e-9) : 0.0;
          const double x = grid[k].in_cells(position[Dim * p + k] + offset);
          first[k] = static_cast<std::int64_t>(std::floor(x));
          s[k] = x - static_cast<double>(first[k]);
        }
        moved[side] = 0.0;
        for (int corner = 0; corner < (1 << Dim); ++corner) {
          Lattice node = first;
          double weight = 1.0;
          for (int k = 0; k < Dim; ++k) {
            const int up = (corner >> k) & 1;
            node[k] += up;
            weight *= up ? s[k] : 1.0 - s[k];
          }
          const std::int64_t key = pack(node);
          const auto* found = std::lower_bound(node_keys, node_keys + nodes, key);
          if (found != node_keys + nodes && *found == key)
            moved[side] += weight * displacement[Dim * (found - node_keys) + axis];
        }
      }
      increment[axis] = 0.5 * (moved[1] - moved[0]);
    }
    for (int axis = 0; axis < Dim; ++axis) half[Dim * p + axis] += increment[axis];
  }
}

}  // namespace tilth::kernel
