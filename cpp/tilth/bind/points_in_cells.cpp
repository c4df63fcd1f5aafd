// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/points_in_cells.hpp"

#include "../boundary/domain_trace.hpp"
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
    boundary::locate_in_cells<decltype(kind)::dim>(static_cast<std::int64_t>(n), position.data(),
                                                   {grid, size_of(cell_keys), cell_keys.data()},
                                                   key.data(), local.data());
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

auto trace_of_domains(ConstIntegers start, ConstDoubles position, ConstIntegers owner,
                      ConstIntegers shift, ConstDoubles centre, ConstDoubles corner,
                      nb::handle grid_handle, ConstIntegers cell_keys, ConstIntegers keys,
                      ConstIntegers cell_start, ConstShorts node, ConstDoubles value) {
  const std::int64_t samples = rows_of(position, 2, "position");
  const std::int64_t points = rows_of(centre, 2, "centre");
  const int dim = dimension_of(centre, "centre");
  const std::int64_t corners = std::int64_t{1} << dim;
  const GridView grid(grid_handle, dim);
  const auto at = view(cell_start, node, value, size_of(keys));
  require(at.nodes == corners, "node", "has not as many columns as a cell has corners");
  require_size(start, at.start[at.cells] + 1, "start");
  require_starts(start, samples, "start");
  require_table(position, samples, dim, "position");
  grid.require_in_grid(position, "position");
  require_size(owner, samples, "owner");
  require_indices(owner, points, "owner");
  require_size(shift, samples, "shift");
  grid.require_in_grid(centre, "centre");
  require_size(corner, points * corners * dim, "corner");
  grid.require_in_cells(corner, "corner");
  Found missing;
  boundary::TraceTerms terms;
  with_dimension(dim, [&](auto kind) {
    terms = boundary::trace_of_domains<decltype(kind)::dim>(
        at, {start.data(), position.data(), owner.data(), shift.data()},
        {centre.data(), corner.data()}, {grid, size_of(cell_keys), cell_keys.data()},
        {size_of(keys), keys.data()}, missing);
  });
  require(!missing, "keys", "lack nodes of cells that a domain reaches");
  return std::make_tuple(give(std::move(terms.count)), give(std::move(terms.node)),
                         give(std::move(terms.value)));
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
  module.def(
      "trace_of_domains", &trace_of_domains, "start"_a, "position"_a, "owner"_a, "shift"_a,
      "centre"_a, "corner"_a, "grid"_a, "cell_keys"_a, "keys"_a, "cell_start"_a, "node"_a,
      "value"_a,
      "Displacements at places by those of nodes, the mean over each place's samples on domains "
      "with corners: number of nodes of each place, nodes and shares.");
}

}  // namespace tilth::bind
