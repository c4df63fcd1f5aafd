// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/soil_gap.hpp"
#include "../kind.hpp"
#include "grid_view.hpp"

namespace tilth::bind {

namespace {

auto measure_gap(ConstDoubles position, ConstDoubles normal, ConstDoubles behind, double reach,
                 ConstDoubles centre, ConstDoubles half_length, ConstDoubles corner,
                 nb::handle grid_handle, double widening) {
  const std::int64_t surface_points = rows_of(position, 2, "position");
  const std::int64_t points = rows_of(centre, 2, "centre");
  const int dim = dimension_of(centre, "centre");
  const std::int64_t corners = std::int64_t{1} << dim;
  const GridView grid(grid_handle, dim);
  require_table(position, surface_points, dim, "position");
  grid.require_in_grid(position, "position", in_integers);
  require_table(normal, surface_points, dim, "normal");
  require_magnitude(normal, 1.0 + 1e-6, "normal");
  require_size(behind, surface_points, "behind");
  constexpr double longest = 1e100;
  require_magnitude(behind, longest, "behind");
  for (std::int64_t q = 0; q < surface_points; ++q)
    require(behind.data()[q] >= 0.0, "behind", "has negative entries");
  require(std::fabs(reach) <= longest, "reach", "is not a number or too large");
  require(widening >= 0.0 && widening <= 1.0, "widening", "is not between 0 and 1");
  grid.require_in_grid(centre, "centre");
  require_size(half_length, points * dim, "half_length");
  grid.require_in_cells(half_length, "half_length");
  const bool boxes = corner.size() == 0;
  require_size(corner, boxes ? 0 : points * corners * dim, "corner");
  grid.require_in_cells(corner, "corner");
  std::vector<double> gap(position.shape(0));
  std::vector<std::int64_t> owner(position.shape(0));
  with_dimension(dim, [&](auto kind) {
    constexpr int d = decltype(kind)::dim;
    const boundary::DomainSearch<d> search(points, centre.data(), half_length.data(), grid,
                                           widening);
    const auto measure = [&](const auto& domains) {
      boundary::measure_gap<d>(surface_points, position.data(), normal.data(), behind.data(), reach,
                               search, domains, gap.data(), owner.data());
    };
    if (boxes)
      measure(boundary::Boxes<d>{half_length.data()});
    else
      measure(boundary::CorneredDomains<d>{corner.data()});
  });
  return std::make_tuple(give(std::move(gap)), give(std::move(owner)));
}

}  // namespace

void bind_gap(nb::module_& module) {
  using namespace nb::literals;
  module.def("measure_gap", &measure_gap, "position"_a, "normal"_a, "behind"_a, "reach"_a,
             "centre"_a, "half_length"_a, "corner"_a, "grid"_a, "widening"_a,
             "Distances along normals (n,dim) from surface points to the material points' domains, "
             "and the material point whose domain is entered; -1 and +-inf without an entry.");
}

}  // namespace tilth::bind
