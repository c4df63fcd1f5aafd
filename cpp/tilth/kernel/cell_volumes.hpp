// SPDX-License-Identifier: BSD-3-Clause
// Volume of material in the cells of the grid, from the share of each point's domain in each cell
// that it intersects. The volume of a standard point counts for the cell it lies in; a GIMP domain
// is cut at the grid lines.
#pragma once

#include <algorithm>
#include <cstdint>

#include "../grid.hpp"
#include "../grid_lines.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Adds volume, and volume times the points' `weight`, to `filled` (cells, 2); `cell_keys` are the
/// sorted keys of the cells' lowest nodes. Returns whether they contain every cell of the groups'
/// supports.
template <int Dim>
bool fill_cells(const Stencil& stencil, const std::int64_t* first, const std::int32_t* count,
                const double* position, const double* half_length, const double* volume,
                const double* weight, const GridLines& grid, std::int64_t cells,
                const std::int64_t* cell_keys, double* filled) {
  Found missing;
  for_each_by_colour(stencil, [&](std::int64_t g) {
    const std::int64_t* f = first + 3 * g;
    const int across[3] = {count[3 * g] - 1, count[3 * g + 1] - 1,
                           Dim == 3 ? count[3 * g + 2] - 1 : 1};
    for (int k = 0; k < across[2]; ++k)
      for (int j = 0; j < across[1]; ++j)
        for (int i = 0; i < across[0]; ++i) {
          const int shift[3] = {i, j, k};
          const auto key = pack({f[0] + i, f[1] + j, f[2] + k});
          const auto cell = std::lower_bound(cell_keys, cell_keys + cells, key) - cell_keys;
          if (cell == cells || cell_keys[cell] != key) {
            missing.set();
            continue;
          }
          double sum = 0.0, weighted = 0.0;
          for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
            double share = volume[p];
            for (int axis = 0; axis < Dim; ++axis) {
              if (across[axis] == 1) continue;
              const std::int64_t index = f[axis] + shift[axis];
              const double x = grid[axis].in_cells_like(index, position[Dim * p + axis]);
              const double l = half_length[Dim * p + axis] / grid[axis].width(index);
              const auto low = static_cast<double>(index);
              const double overlap = std::min(x + l, low + 1.0) - std::max(x - l, low);
              share *= std::max(0.0, overlap) / (2.0 * l);
            }
            sum += share;
            weighted += share * weight[p];
          }
          filled[2 * cell] += sum;
          filled[2 * cell + 1] += weighted;
        }
  });
  return !missing;
}

}  // namespace tilth::kernel
