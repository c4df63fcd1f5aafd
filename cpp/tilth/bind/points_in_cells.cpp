// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/points_in_cells.hpp"

#include "../kind.hpp"
#include "grid_view.hpp"

namespace tilth::bind {

namespace {

auto locate_in_cells(ConstDoubles position, nb::handle grid_handle, ConstIntegers cell_keys) {
  const auto n = static_cast<std::size_t>(rows_of(position, 2, "position"));
  const auto dim = static_cast<std::size_t>(dimension_of(position, "position"));
  const GridView grid(grid_handle, static_cast<int>(dim));
  grid.require_in_grid(position, "position");
  std::vector<std::int64_t> key(n);
  std::vector<double> local(n * dim);
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    boundary::locate_in_cells<decltype(kind)::dim>(
        static_cast<std::int64_t>(n), position.data(), grid,
        static_cast<std::int64_t>(cell_keys.size()), cell_keys.data(), key.data(), local.data());
  });
  return std::make_tuple(give(std::move(key)), give(std::move(local), {n, dim}));
}

auto shape_values(ConstDoubles local) {
  const auto n = static_cast<std::size_t>(rows_of(local, 2, "local"));
  const auto dim = static_cast<std::size_t>(dimension_of(local, "local"));
  const std::size_t corners = std::size_t{1} << dim;
  std::vector<double> value(n * corners);
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    boundary::shape_functions<decltype(kind)::dim>(static_cast<std::int64_t>(n), local.data(),
                                                   nullptr, value.data(), nullptr);
  });
  return give(std::move(value), {n, corners});
}

auto shape_functions(ConstDoubles local, ConstDoubles size) {
  const auto n = static_cast<std::size_t>(rows_of(local, 2, "local"));
  const auto dim = static_cast<std::size_t>(dimension_of(local, "local"));
  const std::size_t corners = std::size_t{1} << dim;
  require_table(size, static_cast<std::int64_t>(n), static_cast<std::int64_t>(dim), "size");
  std::vector<double> value(n * corners), gradient(n * corners * dim);
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    boundary::shape_functions<decltype(kind)::dim>(static_cast<std::int64_t>(n), local.data(),
                                                   size.data(), value.data(), gradient.data());
  });
  return std::make_tuple(give(std::move(value), {n, corners}),
                         give(std::move(gradient), {n, corners, dim}));
}

boundary::PointsInCells view(const ConstIntegers& start, const ConstShorts& node,
                             const ConstDoubles& value, std::int64_t nodes_of_grid) {
  const std::int64_t cells = rows_of(node, 2, "node"), nodes = columns_of(node, "node");
  require(nodes == 4 || nodes == 8, "node", "has not 4 or 8 columns");
  require_indices(node, nodes_of_grid, "node");
  const std::int64_t points = rows_of(value, 2, "value");
  require_table(value, points, nodes, "value");
  require_size(start, cells + 1, "start");
  require_starts(start, points, "start");
  return {cells, static_cast<int>(nodes), start.data(), node.data(), value.data()};
}

auto interpolate_in_cells(ConstIntegers start, ConstShorts node, ConstDoubles value,
                          ConstDoubles nodal) {
  const auto components = static_cast<std::size_t>(columns_of(nodal, "nodal"));
  const auto at = view(start, node, value, rows_of(nodal, 2, "nodal"));
  const auto n = static_cast<std::size_t>(at.start[at.cells]);
  std::vector<double> vector(n * components);
  boundary::interpolate(at, static_cast<int>(components), nodal.data(), vector.data());
  return give(std::move(vector), {n, components});
}

void scatter_in_cells(ConstIntegers start, ConstShorts node, ConstDoubles value,
                      ConstDoubles vector, Doubles nodal) {
  const auto at = view(start, node, value, rows_of(nodal, 2, "nodal"));
  const int components = static_cast<int>(columns_of(nodal, "nodal"));
  require_table(vector, at.start[at.cells], components, "vector");
  boundary::scatter(at, components, vector.data(), nodal.data());
}

}  // namespace

void bind_points_in_cells(nb::module_& module) {
  using namespace nb::literals;
  module.def("locate_in_cells", &locate_in_cells, "position"_a, "grid"_a, "cell_keys"_a,
             "Keys of the cells with soil in or nearest to which points (n,dim) lie, and the "
             "points' local coordinates (n,dim), in cells.");
  module.def("shape_values", &shape_values, "local"_a,
             "Shape functions (n,2^dim) at local coordinates (n,dim) in a cell, x fastest.");
  module.def(
      "shape_functions", &shape_functions, "local"_a, "size"_a,
      "Shape functions (n,2^dim) and their gradients (n,2^dim,dim) at local coordinates in cells "
      "of the sizes (n,dim).");
  module.def("interpolate_in_cells", &interpolate_in_cells, "start"_a, "node"_a, "value"_a,
             "nodal"_a, "sum_a N_a nodal_a at the points of each cell.");
  module.def("scatter_in_cells", &scatter_in_cells, "start"_a, "node"_a, "value"_a, "vector"_a,
             "nodal"_a, "Adds sum_q N_qa vector_q to nodal.");
}

}  // namespace tilth::bind
