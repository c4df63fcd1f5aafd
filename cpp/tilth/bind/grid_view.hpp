// SPDX-License-Identifier: BSD-3-Clause
// Reads tilth.grid.background.Grid into the lines that the kernels take.
#pragma once

#include "../grid_lines.hpp"
#include "checks.hpp"

namespace tilth::bind {

/// Keeps the arrays of a Python `Grid` alive while a kernel runs.
class GridView : public GridLines {
 public:
  /// Refuses a grid of another number of directions, or one whose lines define no cells.
  GridView(nb::handle grid, int dim) : GridLines{} {
    origin_ = attribute<ConstDoubles>(grid, "origin");
    size_ = attribute<ConstDoubles>(grid, "cell_size");
    const auto lines = number_attribute<nb::tuple>(grid, "lines");
    require_size(origin_, dim, "origin");
    require_finite(origin_, "origin");
    require_size(size_, dim, "cell_size");
    constexpr double least = 1e-100, greatest = 1e100;  // their squares are numbers
    for (int k = 0; k < dim; ++k)
      require(size_.data()[k] >= least && size_.data()[k] <= greatest, "cell_size",
              "is not positive, or too small or too large for a number");
    require(lines.size() == 0 || static_cast<int>(lines.size()) == dim, "lines",
            "are not those of each direction");
    line_.resize(lines.size());
    for (int k = 0; k < dim; ++k) axis[k] = {origin_.data()[k], size_.data()[k]};
    for (std::size_t k = 0; k < lines.size(); ++k) read(lines[k], k);
  }

  /// Refuses vectors (n, dim) of which a component is not a number or not less than `limit` of the
  /// smallest cells; with `from_origin` positions.
  template <class Array>
  void require_in_cells(const Array& vector, const std::string& name, double limit = in_lattice,
                        bool from_origin = false) const {
    const std::int64_t dim = size_of(size_);
    const double* x = vector.data();
    bool outside = false;
    for (std::int64_t k = 0; k < dim; ++k) {
      const double from = from_origin ? axis[k].origin : 0.0, size = axis[k].size;
      for (std::int64_t i = k; i < size_of(vector); i += dim)
        outside |= !(std::fabs((x[i] - from) / size) < limit);
    }
    if (outside)
      refuse(name, "has entries that are not numbers or too many cells from the grid's origin");
  }

  void require_in_grid(const ConstDoubles& position, const std::string& name,
                       double limit = in_lattice) const {
    require_in_cells(position, name, limit, true);
  }

 private:
  ConstDoubles origin_, size_;
  std::vector<ConstDoubles> line_;

  void read(nb::handle lines, std::size_t k) {
    require(nb::try_cast<ConstDoubles>(lines, line_[k], false), "lines",
            "are not arrays of numbers");
    const std::int64_t count = size_of(line_[k]);
    const double* line = line_[k].data();
    if (count == 0) return;
    bool wrong = count < 2 || line[0] != 0.0;
    for (std::int64_t i = 1; i < count; ++i)
      wrong |= !(line[i] - line[i - 1] >= 0.999 * axis[k].size) || !std::isfinite(line[i]);
    require(!wrong, "lines", "do not ascend from 0 by at least the size of the smallest cell");
    axis[k].line = line, axis[k].lines = count;
  }
};

}  // namespace tilth::bind
