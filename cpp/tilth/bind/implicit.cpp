// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/cut_at_grid.hpp"
#include "../boundary/penalty.hpp"
#include "../boundary/soil_contact.hpp"
#include "../kind.hpp"
#include "arrays.hpp"

namespace tilth::bind {

namespace {

auto cut_simplices(ConstDoubles corner, ConstDoubles origin, ConstDoubles cell_size) {
  const std::size_t dim = corner.shape(2);
  boundary::Pieces pieces;
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    pieces = boundary::cut_simplices<decltype(kind)::dim>(
        static_cast<std::int64_t>(corner.shape(0)), corner.data(), origin.data(), cell_size.data());
  });
  const std::size_t count = pieces.facet.size();
  return std::make_tuple(give(std::move(pieces.corner), {count, dim, dim}),
                         give(std::move(pieces.facet)));
}

auto find_contact(ConstIntegers start, ConstDoubles position, ConstDoubles normal,
                  ConstDoubles part, ConstDoubles centre, ConstDoubles half_length,
                  ConstDoubles edge, ConstDoubles inverse, ConstIntegers around,
                  ConstDoubles origin, ConstDoubles cell_size) {
  const auto points = static_cast<std::int64_t>(centre.shape(0));
  const auto boundaries = static_cast<std::int64_t>(start.size()) - 1;
  const int dim = static_cast<int>(centre.shape(1));
  const bool boxes = edge.size() == 0;
  require_size(half_length, points * dim, "half_length");
  require_size(edge, boxes ? 0 : points * dim * dim, "edge");
  require_size(inverse, static_cast<std::int64_t>(edge.size()), "inverse");
  require_size(around, dim, "around");
  require_size(normal, static_cast<std::int64_t>(position.size()), "normal");
  require_size(part, static_cast<std::int64_t>(position.size()) * dim, "part");
  std::vector<std::int64_t> nearest(position.shape(0));
  std::vector<double> fraction(position.shape(0));
  with_dimension(dim, [&](auto kind) {
    constexpr int d = decltype(kind)::dim;
    const auto sorted =
        boundary::sort_by_cell<d>(points, centre.data(), origin.data(), cell_size.data());
    const auto find = [&](const auto& extent) {
      boundary::find_contact<d>(boundaries, start.data(), position.data(), normal.data(), sorted,
                                centre.data(), extent, around.data(), origin.data(),
                                cell_size.data(), nearest.data());
      boundary::contact_fractions<d>(boundaries, start.data(), position.data(), normal.data(),
                                     part.data(), sorted, centre.data(), extent, around.data(),
                                     origin.data(), cell_size.data(), nearest.data(),
                                     fraction.data());
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
  const std::size_t n = normal.shape(0), dim = normal.shape(1);
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
  module.def("cut_simplices", &cut_simplices, "corner"_a, "origin"_a, "cell_size"_a,
             "Segments or triangles (n,dim,dim) cut at the grid: pieces, and the facet of each.");
  module.def(
      "find_contact", &find_contact, "start"_a, "position"_a, "normal"_a, "part"_a, "centre"_a,
      "half_length"_a, "edge"_a, "inverse"_a, "around"_a, "origin"_a, "cell_size"_a,
      "Number of the nearest material point in contact with each quadrature point, -1 without "
      "contact, and the fraction of its tributary area in contact.");
  module.def("boundary_penalty", &boundary_penalty, "normal"_a, "projector"_a, "moduli"_a,
             "square"_a, "Stress per slip (n,dim,dim) of a boundary's quadrature points.");
}

}  // namespace tilth::bind
