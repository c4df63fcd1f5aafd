// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/multipliers.hpp"

#include "../boundary/exterior_nodes.hpp"
#include "../kind.hpp"
#include "grid_view.hpp"

namespace tilth::bind {

namespace {

/// Returns the dimension; refuses arrays that are not those of CellsInContact.
int require_cells(const ConstIntegers& start, const ConstShorts& node, const ConstDoubles& local,
                  const ConstDoubles& normal, const ConstIntegers& lattice) {
  constexpr double unit_tolerance = 1e-3, farthest = 1 << key_bits;
  const std::int64_t cells = rows_of(node, 2, "node"), points = rows_of(local, 2, "local");
  const int dim = dimension_of(local, "local");
  require_table(node, cells, 1 << dim, "node");
  require_indices(node, require_lattice(lattice, "lattice"), "node");
  require_size(start, cells + 1, "start");
  require_starts(start, points, "start");
  bool empty = false, other = false;
  for (std::int64_t c = 0; c < cells; ++c) empty |= start.data()[c] == start.data()[c + 1];
  require(!empty, "start", "has a cell without points");
  require_magnitude(local, farthest, "local");
  require_table(normal, points, dim, "normal");
  for (std::int64_t q = 0; q < points; ++q) {
    double square = 0.0;
    for (int k = 0; k < dim; ++k) square += normal.data()[q * dim + k] * normal.data()[q * dim + k];
    other |= !(std::fabs(square - 1.0) <= unit_tolerance);
  }
  require(!other, "normal", "has vectors that are not unit vectors");
  return dim;
}

/// Refuses families that do not follow one another, as Families and MultiplierSpace require.
void require_families(const ConstIntegers& start, const ConstIntegers& first_cell,
                      const ConstIntegers& end_cell, const ConstIntegers& first_direction,
                      const ConstDoubles& direction, int dim) {
  const std::int64_t families = size_of(first_cell), cells = size_of(start) - 1;
  require_size(end_cell, families, "end_cell");
  require_size(first_direction, families, "first_direction");
  require_indices(first_cell, cells + 1, "first_cell");
  require_indices(end_cell, cells + 1, "end_cell");
  std::int64_t directions = 0;
  for (std::int64_t f = 0; f < families; ++f) {
    const std::int64_t first = first_cell.data()[f], end = end_cell.data()[f];
    require(first <= end, "end_cell", "is less than first_cell");
    require(f == 0 || first != first_cell.data()[f - 1] || end >= end_cell.data()[f - 1],
            "end_cell", "differs between families of the same cells");
    require(first_direction.data()[f] == directions, "first_direction",
            "does not follow the points of the families");
    directions += start.data()[end] - start.data()[first];
  }
  require_table(direction, directions, dim, "direction");
  require_finite(direction, "direction");
}

auto multiplier_space(ConstIntegers start, ConstShorts node, ConstDoubles local,
                      ConstDoubles normal, ConstIntegers lattice, nb::handle grid_handle,
                      ConstIntegers first_cell, ConstIntegers end_cell,
                      ConstIntegers first_direction, ConstDoubles direction,
                      ConstFlags constrained) {
  const int dim = require_cells(start, node, local, normal, lattice);
  const GridView grid(grid_handle, dim);
  const std::int64_t cells = rows_of(node, 2, "node");
  require_families(start, first_cell, end_cell, first_direction, direction, dim);
  require_size(constrained, rows_of(lattice, 2, "lattice") * dim, "constrained");
  const boundary::Families families{static_cast<std::int64_t>(first_cell.size()), first_cell.data(),
                                    end_cell.data(), first_direction.data(), direction.data()};
  std::vector<std::int64_t> owner, family, point;
  std::vector<double> position;
  with_dimension(dim, [&](auto kind) {
    constexpr int d = decltype(kind)::dim;
    const boundary::CellsInContact<d> at{cells,         start.data(),   node.data(), local.data(),
                                         normal.data(), lattice.data(), grid};
    auto found = boundary::MultiplierSpace<d>(at, families, constrained.data()).vertices();
    owner = std::move(found.owner), family = std::move(found.family);
    point = std::move(found.point), position = std::move(found.position);
  });
  const std::size_t count = family.size();
  return std::make_tuple(give(std::move(owner)), give(std::move(family)), give(std::move(point)),
                         give(std::move(position), {count, static_cast<std::size_t>(dim)}));
}

auto exterior_nodes(ConstIntegers start, ConstShorts node, ConstDoubles local, ConstDoubles normal,
                    ConstIntegers lattice, nb::handle grid_handle) {
  const auto dim = static_cast<std::size_t>(require_cells(start, node, local, normal, lattice));
  const GridView grid(grid_handle, static_cast<int>(dim));
  const std::int64_t cells = rows_of(node, 2, "node");
  boundary::ExteriorNodes found;
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    found = boundary::exterior_nodes<decltype(kind)::dim>(
        {cells, start.data(), node.data(), local.data(), normal.data(), lattice.data(), grid});
  });
  const std::size_t nodes = found.key.size();
  return std::make_tuple(give(std::move(found.key)), give(std::move(found.depth), {nodes, dim, 2}));
}

auto multiplier_means(std::int64_t multipliers, ConstIntegers owner, ConstIntegers point,
                      ConstIntegers cell, ConstShorts node, ConstDoubles weight,
                      ConstDoubles direction, ConstDoubles penalty, ConstDoubles value) {
  const std::int64_t slots = size_of(owner), points = size_of(weight);
  const auto dim = static_cast<std::size_t>(dimension_of(direction, "direction"));
  require(multipliers >= 0 && multipliers <= slots, "multipliers",
          "is negative or more than the entries of owner");
  require_indices(owner, multipliers, "owner");
  require_size(point, slots, "point");
  require_indices(point, points, "point");
  require_indices(cell, rows_of(node, 2, "node"), "cell");
  require_table(node, rows_of(node, 2, "node"), 1 << dim, "node");
  require_size(direction, slots * static_cast<std::int64_t>(dim), "direction");
  require_size(penalty, slots, "penalty");
  require_size(cell, static_cast<std::int64_t>(weight.size()), "cell");
  require_size(value, static_cast<std::int64_t>(weight.size()) << dim, "value");
  boundary::Means means;
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    means = boundary::integrate_means<decltype(kind)::dim>(
        multipliers, slots, owner.data(), point.data(), cell.data(), node.data(), weight.data(),
        direction.data(), penalty.data(), value.data());
  });
  const std::size_t entries = means.node.size();
  return std::make_tuple(give(std::move(means.area)), give(std::move(means.penalty)),
                         give(std::move(means.node_start)), give(std::move(means.node)),
                         give(std::move(means.row), {entries, dim}));
}

}  // namespace

void bind_multipliers(nb::module_& module) {
  using namespace nb::literals;
  module.def("multiplier_space", &multiplier_space, "start"_a, "node"_a, "local"_a, "normal"_a,
             "lattice"_a, "grid"_a, "first_cell"_a, "end_cell"_a, "first_direction"_a,
             "direction"_a, "constrained"_a,
             "Vertices of a step's boundaries: the owner of each direction of each point, and of "
             "each vertex the family, the nearest point and the position in cells.");
  module.def("exterior_nodes", &exterior_nodes, "start"_a, "node"_a, "local"_a, "normal"_a,
             "lattice"_a, "grid"_a,
             "Sorted keys of exterior nodes and their depth along each axis (nodes,dim,2).");
  module.def("multiplier_means", &multiplier_means, "multipliers"_a, "owner"_a, "point"_a, "cell"_a,
             "node"_a, "weight"_a, "direction"_a, "penalty"_a, "value"_a,
             "Areas, penalties, and ragged rows (starts, nodes, coefficients) of the multipliers.");
}

}  // namespace tilth::bind
