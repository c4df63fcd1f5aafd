// SPDX-License-Identifier: BSD-3-Clause
// Which cells lie behind boundaries, and by how much.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../grid.hpp"

namespace tilth::boundary {

/// Cells behind boundaries: sorted keys, and the share that is behind (cells, Dim).
struct Behind {
  std::vector<std::int64_t> key;
  std::vector<double> depth;
};

/// Looks at the cell of each place of the boundaries, and at that of the place half a cell further
/// behind. From 0 where half of the cell is in front to 1 where nothing of it is, times the square
/// of the normal's component along each axis; of several places the greatest.
template <int Dim>
Behind cells_behind(std::int64_t places, const double* place, const double* normal,
                    const double* origin, const double* cell_size) {
  struct Cell {
    std::int64_t key;
    double depth[Dim];
  };
  std::vector<Cell> cells;
  const auto join = [](Cell& cell, const Cell& other) {
    for (int k = 0; k < Dim; ++k) cell.depth[k] = std::max(cell.depth[k], other.depth[k]);
  };
  for (int further = 0; further < 2; ++further)
    for (std::int64_t q = 0; q < places; ++q) {
      const double *x = place + q * Dim, *n = normal + q * Dim;
      double half = 0.0, depth = 0.0;
      for (int k = 0; k < Dim; ++k) half += 0.5 * std::fabs(n[k]) * cell_size[k];
      Lattice index{0, 0, 0};
      for (int k = 0; k < Dim; ++k) {
        const double at = (x[k] - (further ? half * n[k] : 0.0) - origin[k]) / cell_size[k];
        index[k] = static_cast<std::int64_t>(std::floor(at));
        const double centre = origin[k] + (static_cast<double>(index[k]) + 0.5) * cell_size[k];
        depth += (x[k] - centre) * n[k];
      }
      depth = std::clamp(depth / half, 0.0, 1.0);
      Cell cell{pack(index), {}};
      for (int k = 0; k < Dim; ++k) cell.depth[k] = depth * n[k] * n[k];
      if (!cells.empty() && cells.back().key == cell.key)  // places stand cell by cell
        join(cells.back(), cell);
      else
        cells.push_back(cell);
    }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.key < b.key; });
  std::size_t kept = 0;
  for (std::size_t i = 1; i < cells.size(); ++i)
    if (cells[i].key == cells[kept].key)
      join(cells[kept], cells[i]);
    else
      cells[++kept] = cells[i];
  if (!cells.empty()) cells.resize(kept + 1);
  Behind result;
  for (const Cell& cell : cells) {
    result.key.push_back(cell.key);
    result.depth.insert(result.depth.end(), cell.depth, cell.depth + Dim);
  }
  return result;
}

}  // namespace tilth::boundary
