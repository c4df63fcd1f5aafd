// SPDX-License-Identifier: BSD-3-Clause
#include "../sparse/nested_dissection.hpp"
#include "../sparse/pattern.hpp"
#include "arrays.hpp"

namespace tilth::bind {

namespace {

sparse::NodeGroups view(const ConstIntegers& node_start, const ConstShorts& node) {
  return {static_cast<std::int64_t>(node_start.size()) - 1, node_start.data(), node.data()};
}

auto block_pattern(std::int64_t nodes, ConstIntegers node_start, ConstShorts node) {
  auto pattern = sparse::block_pattern(nodes, view(node_start, node));
  return std::make_tuple(give(std::move(pattern.row_start)), give(std::move(pattern.column)));
}

auto block_positions(ConstIntegers node_start, ConstShorts node, ConstIntegers row_start,
                     ConstShorts column) {
  auto positions = sparse::block_positions(view(node_start, node), row_start.data(), column.data());
  return std::make_tuple(give(std::move(positions.start)), give(std::move(positions.position)));
}

auto nested_dissection(ConstIntegers lattice, int reach) {
  const sparse::NestedDissection dissection(static_cast<std::int64_t>(lattice.shape(0)),
                                            lattice.data(), reach);
  return give(std::vector<std::int64_t>(dissection.order()));
}

}  // namespace

void bind_sparse(nb::module_& module) {
  using namespace nb::literals;
  module.def("block_pattern", &block_pattern, "nodes"_a, "node_start"_a, "node"_a,
             "Rows and sorted columns of all pairs of nodes that share a group.");
  module.def("block_positions", &block_positions, "node_start"_a, "node"_a, "row_start"_a,
             "column"_a, "Where each group's blocks stand in the pattern.");
  module.def("nested_dissection", &nested_dissection, "lattice"_a, "reach"_a,
             "Node numbers in a fill-reducing order of elimination.");
}

}  // namespace tilth::bind
