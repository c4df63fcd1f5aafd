// SPDX-License-Identifier: BSD-3-Clause
// F-bar: the volumetric part of a step's deformation gradient is that at the centre of the material
// in the cell (de Souza Neto et al. 1996; Coombs et al. 2018; docs/theory/f_bar.md). With the
// Jacobians J at the point and J0 at the centre,
//   dF_bar = (J0 / J)^(1/n) dF,   n = 2 in plane strain (in-plane part only), 3 otherwise.
// A point whose domain intersects several cells takes the mean of their J0, weighted by its shares.
// The consistent tangent is finished in stiffness.hpp (`add_f_bar`).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "../annotation.hpp"
#include "../grid.hpp"
#include "../parallel.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Cells of one body's points, and their F-bar quantities in the current iteration.
struct Centres {
  const std::int32_t* count;       // (groups, 3) nodes per direction
  const std::int64_t* cell_start;  // (groups + 1)
  const std::int32_t* cell;        // cells of each group, x fastest
  const std::int32_t*
      corner_node;  // (cells of groups, 2^dim) indices of their nodes in the group's
                    // list; null where this is a box, which `count` describes
  const std::int64_t* share_start;      // (groups + 1)
  const double* share;                  // per point one for each cell of its group; sum 1
  const double* volume_change;          // (cells) J0 - 1
  const double* trace;                  // (cells, 2^dim, dim) derivative of ln J0
  const double* jacobian_ratio_before;  // (n) det F / det F_bar at the start of the step
  double* jacobian_ratio;               // (n) the same for the trial displacement
  double* jacobian;                     // (n) J0 of the point

  int cells_of(std::int64_t group) const {
    return static_cast<int>(cell_start[group + 1] - cell_start[group]);
  }
};

/// Directions whose stretch F-bar scales.
template <class K>
inline constexpr int f_bar_directions = K::dim == 2 && !K::hoop ? 2 : 3;

/// det(1 + h) - 1 without loss of digits for a small displacement gradient.
TILTH_FUNCTION double jacobian_minus_one(const double h[3][3]) {
  const double minors = h[0][0] * h[1][1] - h[0][1] * h[1][0] + h[1][1] * h[2][2] -
                        h[1][2] * h[2][1] + h[0][0] * h[2][2] - h[0][2] * h[2][0];
  const double determinant = h[0][0] * (h[1][1] * h[2][2] - h[1][2] * h[2][1]) -
                             h[0][1] * (h[1][0] * h[2][2] - h[1][2] * h[2][0]) +
                             h[0][2] * (h[1][0] * h[2][1] - h[1][1] * h[2][0]);
  return h[0][0] + h[1][1] + h[2][2] + minors + determinant;
}

/// Arrays of the cells: data of their centres, and the results for a trial displacement.
struct CentreArrays {
  const std::int32_t* node;  // (cells, 2^dim)
  const double* value;       // (cells, 2^dim) shape functions
  const double* gradient;    // (cells, 2^dim, dim)
  const double* radius;      // (cells), in axisymmetry
  double* volume_change;     // see Centres
  double* trace;
};

/// Fills `volume_change` and `trace` for a nodal displacement (nodes, dim).
template <class K>
void update_centres(std::int64_t cells, const CentreArrays& arrays, const double* displacement) {
  constexpr int dim = K::dim, corners = 1 << dim;
#pragma omp parallel for schedule(static) if (8 * cells >= parallel_from)
  for (std::int64_t cell = 0; cell < cells; ++cell) {
    const std::int32_t* node = arrays.node + corners * cell;
    const double* gradient = arrays.gradient + std::int64_t{corners} * dim * cell;
    double h[3][3] = {};
    for (int a = 0; a < corners; ++a)
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          h[i][j] += displacement[std::int64_t{node[a]} * dim + i] * gradient[a * dim + j];
    const double in_plane = jacobian_minus_one(h);
    double inverse[3][3];  // of 1 + h; infinite where it is singular; see `volume_change`
    for (int i = 0; i < 3; ++i) h[i][i] += 1.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
        inverse[i][j] = (h[a][c] * h[b][d] - h[a][d] * h[b][c]) / (1.0 + in_plane);
      }
    double* trace = arrays.trace + std::int64_t{corners} * dim * cell;
    for (int a = 0; a < corners; ++a)
      for (int k = 0; k < dim; ++k) {
        double sum = 0.0;
        for (int j = 0; j < dim; ++j) sum += gradient[a * dim + j] * inverse[j][k];
        trace[a * dim + k] = sum;
      }
    arrays.volume_change[cell] = in_plane;
    if constexpr (K::hoop) {
      const double* value = arrays.value + corners * cell;
      double hoop = 0.0;
      for (int a = 0; a < corners; ++a)
        hoop += displacement[std::int64_t{node[a]} * dim] * value[a] / arrays.radius[cell];
      arrays.volume_change[cell] += hoop + in_plane * hoop;
      for (int a = 0; a < corners; ++a)
        trace[a * dim] += value[a] / (arrays.radius[cell] * (1.0 + hoop));
    }
  }
}

/// Ratio of the stretch of dF_bar to that of dF at point p, less 1; `shares` are those of the
/// point. Fills `jacobian_ratio` and `jacobian`; returns -1 where a Jacobian is not positive.
template <class K>
double volumetric_stretch(const Centres& centres, std::int64_t group, const double* shares,
                          const double h[3][3], std::int64_t p) {
  double at_centre = 0.0;
  const std::int32_t* cell = centres.cell + centres.cell_start[group];
  for (int c = 0; c < centres.cells_of(group); ++c)
    at_centre += shares[c] * centres.volume_change[cell[c]];
  const double at_point = jacobian_minus_one(h);
  if (!(at_centre > -1.0) || !(at_point > -1.0)) return -1.0;
  centres.jacobian_ratio[p] =
      centres.jacobian_ratio_before[p] * (1.0 + at_point) / (1.0 + at_centre);
  centres.jacobian[p] = 1.0 + at_centre;
  const double excess = (at_centre - at_point) / (1.0 + at_point);  // J0 / J - 1
  if constexpr (f_bar_directions<K> == 2) return excess / (1.0 + std::sqrt(1.0 + excess));
  const double root = std::cbrt(1.0 + excess);
  return excess / (1.0 + root + root * root);
}

/// Replaces the displacement gradient by that of dF_bar.
template <class K, class T>
void stretch_gradient(const T& stretch_minus_one, T h[3][3]) {
  for (int i = 0; i < f_bar_directions<K>; ++i)
    for (int j = 0; j < f_bar_directions<K>; ++j)
      h[i][j] += stretch_minus_one * (h[i][j] + (i == j ? 1.0 : 0.0));
}

/// Adds sum_e (share J0_e / J0) d ln J0_e to difference[k][b], b the nodes of the group.
template <int Dim, int Capacity>
void add_centre_trace(const Centres& centres, std::int64_t group, const double* shares,
                      std::int64_t p, double difference[Dim][Capacity]) {
  const std::int32_t* count = centres.count + 3 * group;
  const std::int32_t* cell = centres.cell + centres.cell_start[group];
  if (centres.corner_node != nullptr) {
    const std::int32_t* node = centres.corner_node + centres.cell_start[group] * (1 << Dim);
    for (int c = 0; c < centres.cells_of(group); ++c, node += 1 << Dim) {
      if (shares[c] == 0.0) continue;
      const double factor =
          shares[c] * (1.0 + centres.volume_change[cell[c]]) / centres.jacobian[p];
      const double* trace = centres.trace + std::int64_t{cell[c]} * (1 << Dim) * Dim;
      for (int corner = 0; corner < (1 << Dim); ++corner)
        for (int d = 0; d < Dim; ++d)
          difference[d][node[corner]] += factor * trace[corner * Dim + d];
    }
    return;
  }
  int c = 0;
  for (int k = 0; k < (Dim == 3 ? count[2] - 1 : 1); ++k)
    for (int j = 0; j < count[1] - 1; ++j)
      for (int i = 0; i < count[0] - 1; ++i, ++c) {
        if (shares[c] == 0.0) continue;
        const double factor =
            shares[c] * (1.0 + centres.volume_change[cell[c]]) / centres.jacobian[p];
        const double* trace = centres.trace + std::int64_t{cell[c]} * (1 << Dim) * Dim;
        for (int corner = 0; corner < (1 << Dim); ++corner) {
          const int x = i + (corner & 1), y = j + ((corner >> 1) & 1), z = k + (corner >> 2);
          const int node = x + count[0] * (y + count[1] * z);
          for (int d = 0; d < Dim; ++d) difference[d][node] += factor * trace[corner * Dim + d];
        }
      }
}

/// Fills `cell` and `share` (see Centres) and adds weight and weight times the centroid of each
/// point's part to `moment` (cells, 1 + Dim). `first` and `count` are those of the stencil. Returns
/// whether the sorted `cell_keys` have every cell of the groups.
template <int Dim>
bool share_among_cells(const Stencil& stencil, const std::int64_t* first, const std::int32_t* count,
                       const double* position, const double* half_length, const double* weight,
                       const double* origin, const double* cell_size, std::int64_t cells,
                       const std::int64_t* cell_keys, const std::int64_t* cell_start,
                       std::int32_t* cell, const std::int64_t* share_start, double* share,
                       double* moment) {
  Found missing;
  for_each_by_colour(stencil, [&](std::int64_t g) {
    const std::int64_t* f = first + 3 * g;
    const int across[3] = {count[3 * g] - 1, count[3 * g + 1] - 1,
                           Dim == 3 ? count[3 * g + 2] - 1 : 1};
    const int of_group = across[0] * across[1] * across[2];
    int c = 0;
    for (int k = 0; k < across[2]; ++k)
      for (int j = 0; j < across[1]; ++j)
        for (int i = 0; i < across[0]; ++i, ++c) {
          const int shift[3] = {i, j, k};
          const auto key = pack({f[0] + i, f[1] + j, f[2] + k});
          const auto number = std::lower_bound(cell_keys, cell_keys + cells, key) - cell_keys;
          if (number == cells || cell_keys[number] != key) {
            missing.set();
            continue;
          }
          cell[cell_start[g] + c] = static_cast<std::int32_t>(number);
          double* sum = moment + (1 + Dim) * number;
          for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
            double part = 1.0, centroid[Dim];
            for (int axis = 0; axis < Dim; ++axis) {
              const double x = (position[Dim * p + axis] - origin[axis]) / cell_size[axis];
              centroid[axis] = x;
              if (across[axis] == 1) continue;
              const double l = half_length[Dim * p + axis] / cell_size[axis];
              const double low = static_cast<double>(f[axis] + shift[axis]);
              const double from = std::max(x - l, low), to = std::min(x + l, low + 1.0);
              part *= std::max(0.0, to - from) / (2.0 * l);
              centroid[axis] = 0.5 * (from + to);
            }
            share[share_start[g] + (p - stencil.start[g]) * of_group + c] = part;
            const double w = weight[p] * part;
            sum[0] += w;
            for (int axis = 0; axis < Dim; ++axis) sum[1 + axis] += w * centroid[axis];
          }
        }
  });
  return !missing;
}

}  // namespace tilth::kernel
