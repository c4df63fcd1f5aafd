// SPDX-License-Identifier: BSD-3-Clause
#include "../boundary/multipliers.hpp"

#include "../boundary/exterior_nodes.hpp"
#include "../kind.hpp"
#include "arrays.hpp"

namespace tilth::bind {

namespace {

auto multiplier_space(ConstIntegers start, ConstShorts node, ConstDoubles local,
                      ConstDoubles normal, ConstIntegers lattice, ConstDoubles cell_size,
                      ConstIntegers first_cell, ConstIntegers end_cell,
                      ConstIntegers first_direction, ConstDoubles direction,
                      ConstFlags constrained) {
  const int dim = static_cast<int>(cell_size.size());
  const auto cells = static_cast<std::int64_t>(node.shape(0));
  require_size(start, cells + 1, "start");
  require_size(node, cells << dim, "node");
  require_size(local, start.data()[cells] * dim, "local");
  require_size(normal, start.data()[cells] * dim, "normal");
  require_size(constrained, static_cast<std::int64_t>(lattice.shape(0)) * dim, "constrained");
  const boundary::Families families{static_cast<std::int64_t>(first_cell.size()), first_cell.data(),
                                    end_cell.data(), first_direction.data(), direction.data()};
  std::vector<std::int64_t> owner, family, point;
  std::vector<double> position;
  with_dimension(dim, [&](auto kind) {
    constexpr int d = decltype(kind)::dim;
    const boundary::CellsInContact<d> at{cells,           start.data(),  node.data(),
                                         local.data(),    normal.data(), lattice.data(),
                                         cell_size.data()};
    auto found = boundary::MultiplierSpace<d>(at, families, constrained.data()).vertices();
    owner = std::move(found.owner), family = std::move(found.family);
    point = std::move(found.point), position = std::move(found.position);
  });
  const std::size_t count = family.size();
  return std::make_tuple(give(std::move(owner)), give(std::move(family)), give(std::move(point)),
                         give(std::move(position), {count, static_cast<std::size_t>(dim)}));
}

auto exterior_nodes(ConstIntegers start, ConstShorts node, ConstDoubles local, ConstDoubles normal,
                    ConstIntegers lattice, ConstDoubles cell_size) {
  const std::size_t dim = cell_size.size();
  const auto cells = static_cast<std::int64_t>(node.shape(0));
  require_size(start, cells + 1, "start");
  require_size(local, start.data()[cells] * static_cast<std::int64_t>(dim), "local");
  require_size(normal, static_cast<std::int64_t>(local.size()), "normal");
  boundary::ExteriorNodes found;
  with_dimension(static_cast<int>(dim), [&](auto kind) {
    found = boundary::exterior_nodes<decltype(kind)::dim>({cells, start.data(), node.data(),
                                                           local.data(), normal.data(),
                                                           lattice.data(), cell_size.data()});
  });
  const std::size_t nodes = found.key.size();
  return std::make_tuple(give(std::move(found.key)), give(std::move(found.depth), {nodes, dim}));
}

auto multiplier_means(std::int64_t multipliers, ConstIntegers owner, ConstIntegers point,
                      ConstIntegers cell, ConstShorts node, ConstDoubles weight,
                      ConstDoubles direction, ConstDoubles penalty, ConstDoubles value) {
  const auto slots = static_cast<std::int64_t>(owner.size());
  const std::size_t dim = direction.shape(1);
  require_size(point, slots, "point");
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
             "lattice"_a, "cell_size"_a, "first_cell"_a, "end_cell"_a, "first_direction"_a,
             "direction"_a, "constrained"_a,
             "Vertices of a step's boundaries: the owner of each direction of each point, and of "
             "each vertex the family, the nearest point and the position in cells.");
  module.def("exterior_nodes", &exterior_nodes, "start"_a, "node"_a, "local"_a, "normal"_a,
             "lattice"_a, "cell_size"_a,
             "Sorted keys of exterior nodes and their depth along each axis (nodes,dim).");
  module.def("multiplier_means", &multiplier_means, "multipliers"_a, "owner"_a, "point"_a, "cell"_a,
             "node"_a, "weight"_a, "direction"_a, "penalty"_a, "value"_a,
             "Areas, penalties, and ragged rows (starts, nodes, coefficients) of the multipliers.");
}

}  // namespace tilth::bind
