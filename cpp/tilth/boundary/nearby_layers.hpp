// SPDX-License-Identifier: BSD-3-Clause
// Which layers of cells have the material points that may touch a position: a search that looks
// there alone stays short where large points far away lie in a grid with small cells.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../grid_lines.hpp"

namespace tilth::boundary {

/// Along each axis: which layers of cells have material points that reach a layer. On a uniform
/// grid all those at most `around` layers away; with cells of different sizes as listed, from the
/// layer `first` on.
struct NearbyLayers {
  struct Range {
    std::int64_t low, high;
  };
  std::array<std::int64_t, 3> around{}, first{};
  std::array<std::vector<Range>, 3> listed;
  std::array<double, 3> farthest{};  // distance of the points from a position in the layer [length]

  Range of(int axis, std::int64_t layer) const {
    const auto& ranges = listed[axis];
    if (ranges.empty()) return {layer - around[axis], layer + around[axis]};
    const std::int64_t at = layer - first[axis];
    return at < 0 || at >= std::ssize(ranges) ? Range{layer, layer - 1} : ranges[at];
  }
};

/// Returns the layers at most `around` (Dim) cells away.
template <int Dim>
NearbyLayers layers_around(const std::int64_t* around, const GridLines& grid) {
  NearbyLayers layers;
  for (int k = 0; k < Dim; ++k) {
    layers.around[k] = around[k];
    layers.farthest[k] = static_cast<double>(around[k] + 1) * grid[k].largest_width();
  }
  return layers;
}

/// Returns the layers whose points, at `centre` (points, Dim), are at most `reach` (points, Dim)
/// away from some position in the layer or in the ones next to it.
template <int Dim>
NearbyLayers layers_within(std::int64_t points, const double* centre, const double* reach,
                           const GridLines& grid) {
  NearbyLayers layers;
  std::vector<std::int64_t> own(points), low(points), high(points);
  for (int k = 0; k < Dim; ++k) {
    double longest = 0.0;
    std::int64_t lowest = 0, highest = -1;
    for (std::int64_t p = 0; p < points; ++p) {
      const double x = centre[Dim * p + k], length = reach[Dim * p + k] * (1.0 + 1e-6);
      const auto ends = grid[k].around(x, length);
      own[p] = static_cast<std::int64_t>(std::floor(grid[k].in_cells(x)));
      low[p] = static_cast<std::int64_t>(std::floor(ends.low)) - 1;
      high[p] = static_cast<std::int64_t>(std::floor(ends.high)) + 1;
      longest = std::max(longest, length);
      lowest = p == 0 ? low[p] : std::min(lowest, low[p]);
      highest = p == 0 ? high[p] : std::max(highest, high[p]);
    }
    layers.first[k] = lowest, layers.farthest[k] = longest + 2.0 * grid[k].largest_width();
    auto& ranges = layers.listed[k];
    ranges.resize(highest - lowest + 1, {highest, lowest - 1});
    for (std::int64_t p = 0; p < points; ++p)
      for (std::int64_t layer = low[p]; layer <= high[p]; ++layer) {
        auto& range = ranges[layer - lowest];
        range.low = std::min(range.low, own[p]), range.high = std::max(range.high, own[p]);
      }
  }
  return layers;
}

}  // namespace tilth::boundary
