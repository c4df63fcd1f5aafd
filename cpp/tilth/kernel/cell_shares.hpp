// SPDX-License-Identifier: BSD-3-Clause
// Shares of the material points' domains in the cells, and what F-bar's mean gradients need of the
// parts (docs/theory/f_bar.md). Boxes here; domains with corners in corners.hpp.
#pragma once

#include <algorithm>
#include <cstdint>

#include "../grid.hpp"
#include "../grid_lines.hpp"
#include "../parallel.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Numbers per cell whose sums over the parts give the means of the gradients of its multilinear
/// functions: of x the coordinates in the cell (0 to 1), 1, x, y; in 3D 1, x, y, z, yz, zx, xy.
template <int Dim>
inline constexpr int moments_of = Dim == 2 ? 3 : 7;

/// Those that give the mean of the functions themselves in 2D, and the radius: 1, x, y, xy, r.
inline constexpr int hoop_moments = 5;

/// Adds `weight` times the moments of a point, or of a box with this centroid, to `moment`.
template <int Dim>
void add_moments(const double x[Dim], double weight, double* moment) {
  moment[0] += weight;
  for (int k = 0; k < Dim; ++k) moment[1 + k] += weight * x[k];
  if constexpr (Dim == 3)
    for (int k = 0; k < 3; ++k) moment[4 + k] += weight * x[(k + 1) % 3] * x[(k + 2) % 3];
}

inline void add_hoop_moments(const double x[2], double radius, double weight, double* moment) {
  const double of[hoop_moments] = {1.0, x[0], x[1], x[0] * x[1], radius};
  for (int m = 0; m < hoop_moments; ++m) moment[m] += weight * of[m];
}

/// Results for the domains: `share` and `hoop_share` as in Centres (f_bar.hpp), and sums over the
/// parts in each cell, weighted by volume and, for the hoop, by volume over radius. Those of the
/// hoop are null unless the analysis is axisymmetric.
struct Shares {
  const std::int64_t* share_start;
  double* share;
  double* moment;       // (cells, moments_of<Dim>)
  double* hoop_share;   // each part's radius times its share over the point's radius
  double* hoop_moment;  // (cells, hoop_moments)
};

/// Fills `cell` (see Centres) and `shares`. `first` and `count` are those of the stencil. Returns
/// whether the sorted `cell_keys` have every cell of the groups.
template <int Dim>
bool share_among_cells(const Stencil& stencil, const std::int64_t* first, const std::int32_t* count,
                       const double* position, const double* half_length, const double* weight,
                       const GridLines& grid, std::int64_t cells, const std::int64_t* cell_keys,
                       const std::int64_t* cell_start, std::int32_t* cell, const Shares& shares) {
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
          for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
            double part = 1.0, centroid[Dim], from_point = 0.0;
            for (int axis = 0; axis < Dim; ++axis) {
              const std::int64_t index = f[axis] + shift[axis];
              const double x = grid[axis].in_cells_like(index, position[Dim * p + axis]);
              const auto low = static_cast<double>(index);
              centroid[axis] = x - low;
              if (across[axis] == 1) continue;
              const double l = half_length[Dim * p + axis] / grid[axis].width(index);
              const double from = std::max(x - l, low), to = std::min(x + l, low + 1.0);
              part *= std::max(0.0, to - from) / (2.0 * l);
              centroid[axis] = 0.5 * (from + to) - low;
              if (axis == 0) from_point = 0.5 * (from + to) - x;
            }
            const std::int64_t entry =
                shares.share_start[g] + (p - stencil.start[g]) * of_group + c;
            shares.share[entry] = part;
            add_moments<Dim>(centroid, weight[p] * part, shares.moment + moments_of<Dim> * number);
            if constexpr (Dim == 2) {
              if (shares.hoop_share == nullptr) continue;
              const double radius = position[Dim * p];
              const double of_part = radius + from_point * grid[0].width(f[0] + i);
              shares.hoop_share[entry] = part * (of_part / radius);
              add_hoop_moments(centroid, of_part, weight[p] * part / radius,
                               shares.hoop_moment + hoop_moments * number);
            }
          }
        }
  });
  return !missing;
}

}  // namespace tilth::kernel
