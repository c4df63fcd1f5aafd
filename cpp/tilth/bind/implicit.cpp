// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/cut_at_grid.hpp"
#include "../boundary/penalty.hpp"
#include "../boundary/soil_contact.hpp"
#include "../kind.hpp"
#include "grid_view.hpp"

namespace tilth::bind {

namespace {

/// Refuses segments or triangles that are cut into more pieces than memory has room for.
void require_few_pieces(const ConstDoubles& corner, const GridLines& grid, int dim) {
  constexpr double most_pieces = 1 << 24, farthest = in_integers;
  double pieces = 0.0;
  bool far = false;
  for (std::size_t f = 0; f < corner.shape(0); ++f) {
    double span[3] = {1.0, 1.0, 1.0};
    for (int k = 0; k < dim; ++k) {
      double least = farthest, greatest = -farthest;
      for (int c = 0; c < dim; ++c) {
        const double x = grid[k].in_cells(corner.data()[(f * dim + c) * dim + k]);
        far |= !(std::fabs(x) <= farthest);
        least = std::min(least, x), greatest = std::max(greatest, x);
      }
      span[k] += greatest - least;
    }
    pieces +=
        dim == 2 ? span[0] + span[1] : span[0] * span[1] + span[1] * span[2] + span[2] * span[0];
  }
  require(!far, "corner", "has entries that are not numbers or too far from the grid's origin");
  require(pieces <= most_pieces, "corner", "spans too many cells");
}

auto cut_simplices(ConstDoubles corner, nb::handle grid_handle) {
  rows_of(corner, 3, "corner");
  const std::size_t dim = corner.shape(2);
  require(dim == 2 || dim == 3, "corner", "has not two or three components per corner");
  require(corner.shape(1) == dim, "corner", "has not as many corners as a simplex");
  const GridView grid(grid_handle, static_cast<int>(dim));
  require_few_pieces(corner, grid, static_cast<int>(dim));
  boundary::Pieces pieces;
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    pieces = boundary::cut_simplices<decltype(kind)::dim>(
        static_cast<std::int64_t>(corner.shape(0)), corner.data(), grid);
  });
  const std::size_t count = pieces.facet.size();
  return std::make_tuple(give(std::move(pieces.corner), {count, dim, dim}),
                         give(std::move(pieces.facet)));
}

/// Cells around a position in which material points are sought are less than this.
constexpr std::int64_t farthest_around = 1 << 12;

/// Refuses points that reach more cells than memory has room for.
void require_few_layers(const ConstDoubles& reach, const ConstDoubles& centre,
                        const GridLines& grid, int dim) {
  for (std::size_t i = 0; i < reach.size(); ++i) {
    const auto ends = grid[static_cast<int>(i) % dim].around(centre.data()[i], reach.data()[i]);
    require(ends.high - ends.low < farthest_around, "reach", "spans too many cells");
  }
}

auto find_contact(ConstIntegers start, ConstDoubles position, ConstDoubles normal,
                  ConstDoubles part, ConstDoubles centre, ConstDoubles half_length,
                  ConstDoubles edge, ConstDoubles inverse, ConstIntegers around, ConstDoubles reach,
                  nb::handle grid_handle) {
  const std::int64_t points = rows_of(centre, 2, "centre");
  const int dim = dimension_of(centre, "centre");
  const std::int64_t boundaries = require_starts(start, rows_of(position, 2, "position"), "start");
  const bool boxes = edge.size() == 0;
  const GridView grid(grid_handle, dim);
  require_table(position, rows_of(position, 2, "position"), dim, "position");
  grid.require_in_grid(position, "position", in_integers);
  grid.require_in_grid(centre, "centre");
  require_size(half_length, points * dim, "half_length");
  require_size(edge, boxes ? 0 : points * dim * dim, "edge");
  require_size(inverse, static_cast<std::int64_t>(edge.size()), "inverse");
  grid.require_in_cells(half_length, "half_length");
  grid.require_in_cells(edge, "edge");
  require_size(around, dim, "around");
  require_indices(around, farthest_around, "around");
  require_size(reach, reach.size() == 0 ? 0 : points * dim, "reach");
  require_few_layers(reach, centre, grid, dim);
  require_size(normal, size_of(position), "normal");
  require_size(part, size_of(position) * dim, "part");
  grid.require_in_cells(part, "part");
  std::vector<std::int64_t> nearest(position.shape(0));
  std::vector<double> fraction(position.shape(0));
  with_dimension(dim, [&](auto kind) {
    constexpr int d = decltype(kind)::dim;
    const auto sorted = boundary::sort_by_cell<d>(points, centre.data(), grid);
    const auto nearby = reach.size() == 0
                            ? boundary::layers_around<d>(around.data(), grid)
                            : boundary::layers_within<d>(points, centre.data(), reach.data(), grid);
    const auto find = [&](const auto& extent) {
      boundary::find_contact<d>(boundaries, start.data(), position.data(), normal.data(), sorted,
                                centre.data(), extent, nearby, grid, nearest.data());
      boundary::contact_fractions<d>(boundaries, start.data(), position.data(), normal.data(),
                                     part.data(), sorted, centre.data(), extent, nearby, grid,
                                     nearest.data(), fraction.data());
    };
    if (boxes)
      find(boundary::Boxes<d>{half_length.data()});
    else
      find(boundary::Parallelepipeds<d>{edge.data(), inverse.data()});
  });
  return std::make_tuple(give(std::move(nearest)), give(std::move(fraction)));
}

auto boundary_penalty(ConstDoubles normal, ConstDoubles projector, ConstDoubles moduli,
                      ConstDoubles square) {
  const auto n = static_cast<std::size_t>(rows_of(normal, 2, "normal"));
  const auto dim = static_cast<std::size_t>(dimension_of(normal, "normal"));
  require_size(projector, static_cast<std::int64_t>(n * dim * dim), "projector");
  require_size(moduli, static_cast<std::int64_t>(2 * n), "moduli");
  require_size(square, static_cast<std::int64_t>(n), "square");
  std::vector<double> penalty(n * dim * dim);
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    boundary::boundary_penalty<decltype(kind)::dim>(static_cast<std::int64_t>(n), normal.data(),
                                                    projector.data(), moduli.data(), square.data(),
                                                    penalty.data());
  });
  return give(std::move(penalty), {n, dim, dim});
}

}  // namespace

void bind_implicit(nb::module_& module) {
  using namespace nb::literals;
  module.def("cut_simplices", &cut_simplices, "corner"_a, "grid"_a,
             "Segments or triangles (n,dim,dim) cut at the grid: pieces, and the facet of each.");
  module.def(
      "find_contact", &find_contact, "start"_a, "position"_a, "normal"_a, "part"_a, "centre"_a,
      "half_length"_a, "edge"_a, "inverse"_a, "around"_a, "reach"_a, "grid"_a,
      "Number of the nearest material point in contact with each quadrature point, -1 without "
      "contact, and the fraction of its tributary area in contact.");
  module.def("boundary_penalty", &boundary_penalty, "normal"_a, "projector"_a, "moduli"_a,
             "square"_a, "Stress per slip (n,dim,dim) of a boundary's quadrature points.");
}

}  // namespace tilth::bind
