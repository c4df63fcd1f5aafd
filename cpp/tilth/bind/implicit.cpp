// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/cut.hpp"
#include "../boundary/surface.hpp"
#include "../boundary/touch.hpp"
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

auto touching_points(ConstIntegers start, ConstDoubles place, ConstDoubles normal,
                     ConstDoubles position, ConstDoubles half_edge, ConstDoubles origin,
                     ConstDoubles cell_size) {
  const auto points = static_cast<std::int64_t>(position.shape(0));
  const int dim = static_cast<int>(position.shape(1));
  require_size(half_edge, points * dim * dim, "half_edge");
  require_size(normal, static_cast<std::int64_t>(place.size()), "normal");
  std::vector<std::int64_t> nearest(place.shape(0));
  with_dimension(dim, [&](auto kind) {
    boundary::touching_points<decltype(kind)::dim>(
        static_cast<std::int64_t>(start.size()) - 1, start.data(), place.data(), normal.data(),
        points, position.data(), half_edge.data(), origin.data(), cell_size.data(), nearest.data());
  });
  return give(std::move(nearest));
}

auto surface_elements(ConstIntegers start, ConstDoubles shape, ConstDoubles penalty,
                      ConstDoubles constant) {
  const auto elements = static_cast<std::int64_t>(start.size()) - 1;
  const std::size_t n = shape.shape(1), dim = constant.shape(1);
  require_size(penalty, static_cast<std::int64_t>(shape.shape(0) * dim * dim), "penalty");
  std::vector<double> matrix(elements * n * n * dim * dim), force(elements * n * dim);
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    boundary::surface_elements<decltype(kind)::dim>(elements, start.data(), static_cast<int>(n),
                                                    shape.data(), penalty.data(), constant.data(),
                                                    matrix.data(), force.data());
  });
  const auto e = static_cast<std::size_t>(elements);
  return std::make_tuple(give(std::move(matrix), {e, n, n, dim, dim}),
                         give(std::move(force), {e, n, dim}));
}

}  // namespace

void bind_implicit(nb::module_& module) {
  using namespace nb::literals;
  module.def("cut_simplices", &cut_simplices, "corner"_a, "origin"_a, "cell_size"_a,
             "Segments or triangles (n,dim,dim) cut at the grid: pieces, and the facet of each.");
  module.def("touching_points", &touching_points, "start"_a, "place"_a, "normal"_a, "position"_a,
             "half_edge"_a, "origin"_a, "cell_size"_a,
             "Number of the nearest material point that each place touches, -1 if none.");
  module.def("surface_elements", &surface_elements, "start"_a, "shape"_a, "penalty"_a, "constant"_a,
             "Matrix (e,n,n,dim,dim) and force (e,n,dim) of a boundary's elements.");
}

}  // namespace tilth::bind
