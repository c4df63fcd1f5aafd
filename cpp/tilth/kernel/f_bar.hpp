// SPDX-License-Identifier: BSD-3-Clause
// F-bar: the volumetric part of a step's deformation gradient is that of the mean gradient of the
// material in the cell (de Souza Neto et al. 1996; Coombs et al. 2018; docs/theory/f_bar.md). With
// the Jacobians J at the point and J0 of the cells,
//   dF_bar = (J0 / J)^(1/n) dF,   n = 2 in plane strain (in-plane part only), 3 otherwise.
// A point whose domain intersects several cells takes the mean of their J0, weighted by its shares;
// in axisymmetry J0 is the product of such means of the in-plane part and of the hoop stretch.
// Force and tangent are the derivatives of a potential: internal_force.hpp, f_bar_tangent.hpp.
#pragma once

#include <cmath>
#include <cstdint>

#include "../annotation.hpp"
#include "../parallel.hpp"
#include "response.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Cells of one body's points, and their F-bar quantities in the current iteration. `hoop_share`,
/// `hoop_gradient` and `hoop_change` are used in axisymmetry only.
struct Centres {
  const std::int32_t* count;       // (groups, 3) nodes per direction
  const std::int64_t* cell_start;  // (groups + 1)
  const std::int32_t* cell;        // cells of each group, x fastest
  const std::int32_t*
      corner_node;  // (cells of groups, 2^dim) indices of their nodes in the group's
                    // list; null where this is a box, which `count` describes
  const std::int64_t* share_start;      // (groups + 1)
  const double* share;                  // per point one for each cell of its group; sum 1
  const double* hoop_share;             // of the point's radius; sum 1
  const double* volume_change;          // (cells) J0 - 1; of the in-plane part in axisymmetry
  const double* trace;                  // (cells, 2^dim, dim) derivative of ln J0
  const double* hoop_gradient;          // (cells, 2^dim) hoop strain per radial displacement
  const double* hoop_change;            // (cells) hoop stretch - 1
  const double* pressure;               // (n) Kirchhoff pressure of the cells before the step
  const double* jacobian_ratio_before;  // (n) det F / det F_bar at the start of the step
  double* jacobian_ratio;               // (n) the same for the trial displacement
  double* jacobian;                     // (n) J0 of the point

  int cells_of(std::int64_t group) const {
    return static_cast<int>(cell_start[group + 1] - cell_start[group]);
  }

  /// Position in the shares of a point's first one; `index` is that of the point in its group.
  std::int64_t first_share(std::int64_t group, std::int64_t index) const {
    return share_start[group] + index * cells_of(group);
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

/// Arrays of the cells: data of their mean gradients, and the results for a trial displacement.
struct CentreArrays {
  const std::int32_t* node;     // (cells, 2^dim)
  const double* gradient;       // (cells, 2^dim, dim)
  const double* hoop_gradient;  // see Centres
  double* volume_change;
  double* trace;
  double* hoop_change;
};

/// Fills `volume_change`, `trace` and `hoop_change` for a nodal displacement (nodes, dim).
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
    arrays.volume_change[cell] = jacobian_minus_one(h);
    double inverse[3][3];  // of 1 + h; infinite where it is singular; see `volume_change`
    for (int i = 0; i < 3; ++i) h[i][i] += 1.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
        inverse[i][j] =
            (h[a][c] * h[b][d] - h[a][d] * h[b][c]) / (1.0 + arrays.volume_change[cell]);
      }
    double* trace = arrays.trace + std::int64_t{corners} * dim * cell;
    for (int a = 0; a < corners; ++a)
      for (int k = 0; k < dim; ++k) {
        double sum = 0.0;
        for (int j = 0; j < dim; ++j) sum += gradient[a * dim + j] * inverse[j][k];
        trace[a * dim + k] = sum;
      }
    if constexpr (K::hoop) {
      double hoop = 0.0;
      for (int a = 0; a < corners; ++a)
        hoop +=
            displacement[std::int64_t{node[a]} * dim] * arrays.hoop_gradient[corners * cell + a];
      arrays.hoop_change[cell] = hoop;
    }
  }
}

/// Mean of `change` over the cells of a group.
inline double mean_change(const Centres& centres, std::int64_t group, const double* shares,
                          const double* change) {
  double mean = 0.0;
  const std::int32_t* cell = centres.cell + centres.cell_start[group];
  for (int c = 0; c < centres.cells_of(group); ++c) mean += shares[c] * change[cell[c]];
  return mean;
}

/// Ratio of the stretch of dF_bar to that of dF at point p, less 1; `first` is the position of the
/// point's first share. Fills `jacobian_ratio` and `jacobian`; returns -1 where a Jacobian is not
/// positive.
template <class K>
double volumetric_stretch(const Centres& centres, std::int64_t group, std::int64_t first,
                          const double h[3][3], std::int64_t p) {
  double of_cells = mean_change(centres, group, centres.share + first, centres.volume_change);
  const double at_point = jacobian_minus_one(h);
  if (!(of_cells > -1.0) || !(at_point > -1.0)) return -1.0;
  if constexpr (K::hoop) {
    const double hoop =
        mean_change(centres, group, centres.hoop_share + first, centres.hoop_change);
    if (!(hoop > -1.0)) return -1.0;
    of_cells += hoop + of_cells * hoop;
  }
  centres.jacobian_ratio[p] =
      centres.jacobian_ratio_before[p] * (1.0 + at_point) / (1.0 + of_cells);
  centres.jacobian[p] = 1.0 + of_cells;
  const double excess = (of_cells - at_point) / (1.0 + at_point);  // J0 / J - 1
  if constexpr (f_bar_directions<K> == 2) return excess / (1.0 + std::sqrt(1.0 + excess));
  const double root = std::cbrt(1.0 + excess);
  return excess / (1.0 + root + root * root);
}

/// Fills `jacobian_ratio` and `jacobian` of a point that keeps its shape in the step.
inline void keep_volume(const Centres& centres, std::int64_t p) {
  centres.jacobian_ratio[p] = centres.jacobian_ratio_before[p];
  centres.jacobian[p] = 1.0;
}

/// Replaces the displacement gradient by that of dF_bar.
template <class K, class T>
void stretch_gradient(const T& stretch_minus_one, T h[3][3]) {
  for (int i = 0; i < f_bar_directions<K>; ++i)
    for (int j = 0; j < f_bar_directions<K>; ++j)
      h[i][j] += stretch_minus_one * (h[i][j] + (i == j ? 1.0 : 0.0));
}

/// Mean Kirchhoff stress of the directions that F-bar scales, less that of the cells before the
/// step: the part that acts through the cells.
template <class K>
double excess_pressure(const Response<K>& s, double pressure) {
  double sum = 0.0;
  for (int a = 0; a < f_bar_directions<K>; ++a) sum += s.kirchhoff[a];
  constexpr double part = 1.0 / f_bar_directions<K>;
  return part * sum - pressure;
}

/// The cells of one group.
template <int Dim>
struct GroupCells {
  static constexpr int corners = 1 << Dim;

  int count;
  const std::int32_t* cell;
  std::int32_t node[maximum_nodes][corners];  // indices of their corners in the group's list

  GroupCells(const Centres& centres, std::int64_t group)
      : count(centres.cells_of(group)), cell(centres.cell + centres.cell_start[group]) {
    if (centres.corner_node != nullptr) {
      const std::int32_t* own = centres.corner_node + centres.cell_start[group] * corners;
      for (int c = 0; c < count; ++c)
        for (int corner = 0; corner < corners; ++corner)
          node[c][corner] = own[c * corners + corner];
      return;
    }
    const std::int32_t* across = centres.count + 3 * group;
    int c = 0;
    for (int k = 0; k < (Dim == 3 ? across[2] - 1 : 1); ++k)
      for (int j = 0; j < across[1] - 1; ++j)
        for (int i = 0; i < across[0] - 1; ++i, ++c)
          for (int corner = 0; corner < corners; ++corner) {
            const int x = i + (corner & 1), y = j + ((corner >> 1) & 1), z = k + (corner >> 2);
            node[c][corner] = x + across[0] * (y + across[1] * z);
          }
  }
};

/// Derivative of a point's ln J0 = ln(in-plane part) + ln(hoop stretch) by those of its cells,
///   d ln J0 = sum_c in_plane_c trace_c + hoop_c hoop_gradient_c.
struct CellFactors {
  double in_plane[maximum_nodes];
  double hoop[maximum_nodes];
};

/// Fills `factors`; `first`: see volumetric_stretch.
template <class K>
void find_factors(const Centres& centres, const GroupCells<K::dim>& cells, std::int64_t first,
                  CellFactors& factors) {
  double sum = 0.0, hoop = 1.0;
  for (int c = 0; c < cells.count; ++c) {
    factors.in_plane[c] = centres.share[first + c] * (1.0 + centres.volume_change[cells.cell[c]]);
    sum += factors.in_plane[c];
    if constexpr (K::hoop)
      hoop += centres.hoop_share[first + c] * centres.hoop_change[cells.cell[c]];
  }
  const double over_sum = 1.0 / sum, over_hoop = 1.0 / hoop;
  for (int c = 0; c < cells.count; ++c) {
    factors.in_plane[c] *= over_sum;
    if constexpr (K::hoop) factors.hoop[c] = centres.hoop_share[first + c] * over_hoop;
  }
}

/// Adds sum_c factor_c trace_c to sum[k][b], b the nodes of the group.
template <int Dim, int Capacity>
void add_traces(const Centres& centres, const GroupCells<Dim>& cells, const double* factor,
                double sum[Dim][Capacity]) {
  constexpr int corners = 1 << Dim;
  for (int c = 0; c < cells.count; ++c) {
    if (factor[c] == 0.0) continue;
    const double* trace = centres.trace + std::int64_t{cells.cell[c]} * corners * Dim;
    for (int corner = 0; corner < corners; ++corner)
      for (int d = 0; d < Dim; ++d)
        sum[d][cells.node[c][corner]] += factor[c] * trace[corner * Dim + d];
  }
}

/// Adds sum_c factor_c hoop_gradient_c to sum[b], b the nodes of the group.
template <int Dim>
void add_hoop_gradients(const Centres& centres, const GroupCells<Dim>& cells, const double* factor,
                        double* sum) {
  constexpr int corners = 1 << Dim;
  for (int c = 0; c < cells.count; ++c) {
    const double* gradient = centres.hoop_gradient + std::int64_t{cells.cell[c]} * corners;
    for (int corner = 0; corner < corners; ++corner)
      sum[cells.node[c][corner]] += factor[c] * gradient[corner];
  }
}

}  // namespace tilth::kernel
