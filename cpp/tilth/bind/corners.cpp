// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/corners.hpp"

#include "../basis/list.hpp"
#include "../kind.hpp"
#include "centres_view.hpp"
#include "grid_view.hpp"

namespace tilth::bind {

namespace {

/// Calls `function(kind, n)` for the dimension of `position` (n, dim); checks the corners' size.
template <class Function>
void with_corners(const ConstDoubles& position, const ConstDoubles& corner, Function&& function) {
  const std::int64_t points = rows_of(position, 2, "position");
  const int dim = dimension_of(position, "position");
  require_size(corner, points * dim * (1 << dim), "corner");
  with_dimension(dim, [&](auto kind) { function(kind, points); });
}

auto corner_supports(ConstDoubles position, ConstDoubles corner, nb::handle grid_handle) {
  const auto n = static_cast<std::size_t>(rows_of(position, 2, "position"));
  const std::size_t codes_each = dimension_of(position, "position") == 3 ? 2 : 1;
  std::vector<std::int64_t> keys(n), codes(n * codes_each);
  std::int64_t failures = 0;
  const GridView grid(grid_handle, dimension_of(position, "position"));
  with_corners(position, corner, [&](auto kind, std::int64_t points) {
    nb::gil_scoped_release release;
    failures = kernel::corner_supports<decltype(kind)::dim>(points, position.data(), corner.data(),
                                                            grid, keys.data(), codes.data());
  });
  return std::make_tuple(give(std::move(keys)), give(std::move(codes), {n, codes_each}), failures);
}

auto group_corner_points(int dim, ConstIntegers keys, ConstIntegers codes) {
  require_keys(keys, "keys");
  require_size(codes, static_cast<std::int64_t>(keys.size()) * (dim == 3 ? 2 : 1), "codes");
  kernel::CornerGroups groups;
  with_dimension(dim, [&](auto kind) {
    groups = kernel::group_corner_points<decltype(kind)::dim>(
        static_cast<std::int64_t>(keys.size()), keys.data(), codes.data());
  });
  const std::size_t n = groups.start.size() - 1;
  return std::make_tuple(give(std::move(groups.start)), give(std::move(groups.first), {n, 3}),
                         give(std::move(groups.count), {n, 3}), give(std::move(groups.cell_start)),
                         give(std::move(groups.cell)), give(std::move(groups.node_start)),
                         give(std::move(groups.node)));
}

void corner_basis_values(ConstIntegers start, ConstIntegers node_start, ConstIntegers node_keys,
                         ConstIntegers value_start, ConstDoubles position, ConstDoubles corner,
                         nb::handle grid_handle, Doubles value) {
  const std::int64_t groups = require_starts(start, rows_of(position, 2, "position"), "start");
  const int dim = dimension_of(position, "position");
  const GridView grid(grid_handle, dim);
  require_size(node_start, groups + 1, "node_start");
  require_starts(node_start, size_of(node_keys), "node_start");
  require_size(value_start, groups + 1, "value_start");
  require_starts(value_start, size_of(value), "value_start");
  bool other = false, many = false;
  for (std::int64_t g = 0; g < groups; ++g) {
    const std::int64_t nodes = node_start.data()[g + 1] - node_start.data()[g];
    many |= nodes > kernel::maximum_nodes;
    other |= value_start.data()[g + 1] - value_start.data()[g] !=
             (1 + dim) * nodes * (start.data()[g + 1] - start.data()[g]);
  }
  require(!many, "node_start", "has a group with too many nodes");
  require(!other, "value_start", "does not fit to the points and nodes of a group");
  bool complete = true;
  with_corners(position, corner, [&](auto kind, std::int64_t) {
    nb::gil_scoped_release release;
    complete = kernel::corner_basis_values<decltype(kind)::dim>(
        groups, start.data(), node_start.data(), node_keys.data(), value_start.data(),
        position.data(), corner.data(), grid, value.data());
  });
  require(complete, "node_keys", "lack a node of a domain");
}

std::int64_t move_corners(ConstDoubles position, ConstDoubles corner, ConstIntegers node_keys,
                          ConstDoubles displacement, nb::handle grid_handle, bool axisymmetric,
                          Doubles moved, Doubles shift) {
  const std::int64_t nodes = size_of(node_keys);
  const GridView grid(grid_handle, dimension_of(position, "position"));
  require_table(displacement, nodes, dimension_of(position, "position"), "displacement");
  require_size(moved, static_cast<std::int64_t>(corner.size()), "moved");
  require_size(shift, static_cast<std::int64_t>(position.size()), "shift");
  std::int64_t folded = -1;
  with_corners(position, corner, [&](auto kind, std::int64_t points) {
    nb::gil_scoped_release release;
    folded = kernel::move_corners<decltype(kind)::dim>(
        points, position.data(), corner.data(), nodes, node_keys.data(), displacement.data(), grid,
        axisymmetric, moved.data(), shift.data());
  });
  require(folded != kernel::node_missing, "node_keys", "lack a node of a domain");
  return folded;
}

auto share_corner_domains(nb::handle stencil_handle, ConstDoubles position, ConstDoubles corner,
                          ConstDoubles weight, nb::handle grid_handle, ConstIntegers cell_keys,
                          bool axisymmetric) {
  const StencilView stencil(stencil_handle);
  const auto own_start = attribute<ConstIntegers>(stencil_handle, "cell_start");
  const auto own_cell = attribute<ConstIntegers>(stencil_handle, "cell");
  const auto node_key = attribute<ConstIntegers>(stencil_handle, "node_key");
  require_size(own_start, stencil.groups + 1, "cell_start");
  require_starts(own_start, size_of(own_cell), "cell_start");
  require_keys(own_cell, "cell");
  require_size(node_key, size_of(stencil.nodes), "node_key");
  require_table(position, stencil.points(), stencil.dim, "position");
  require_size(weight, stencil.points(), "weight");
  require(!axisymmetric || stencil.dim == 2, "axisymmetric", "is true in 3D");
  const kernel::CornerCells supports{stencil.node_start, node_key.data(), own_start.data(),
                                     own_cell.data()};
  const GridView grid(grid_handle, stencil.dim);
  const std::int64_t cells = size_of(cell_keys);
  std::vector<std::int64_t> share_start(stencil.groups + 1, 0);
  for (std::int64_t g = 0; g < stencil.groups; ++g)
    share_start[g + 1] = share_start[g] + (own_start.data()[g + 1] - own_start.data()[g]) *
                                              (stencil.start[g + 1] - stencil.start[g]);
  std::vector<std::int32_t> cell(own_cell.size());
  std::vector<std::int32_t> corner_node(own_cell.size() << stencil.dim);
  bool complete = true;
  SharesOwner shares(stencil.dim, axisymmetric, cells, share_start);
  with_corners(position, corner, [&](auto kind, std::int64_t) {
    complete = kernel::share_corner_domains<decltype(kind)::dim>(
        stencil, supports, position.data(), corner.data(), weight.data(), grid, cells,
        cell_keys.data(), cell.data(), corner_node.data(), shares.get());
  });
  require(complete, "cell_keys",
          "or the stencil lack a cell or a node of a domain, or a domain has no volume");
  return std::make_tuple(give(std::move(cell)), give(std::move(corner_node)),
                         give(std::move(share_start)), shares.give_shares(), shares.give_moment(),
                         shares.give_hoop_shares(), shares.give_hoop_moment());
}

auto corner_basis_names() {
  nb::list names;
  std::apply([&](auto... each) { (names.append(decltype(each)::name), ...); }, basis::CornerList{});
  return names;
}

}  // namespace

void bind_corners(nb::module_& module) {
  using namespace nb::literals;
  module.def("corner_basis_names", &corner_basis_names,
             nb::sig("def corner_basis_names() -> list[str]"),
             "Names of the bases whose points' domains have corners.");
  module.def("corner_supports", &corner_supports, "position"_a, "corner"_a, "grid"_a,
             "Key (-1: out of range, -2: too wide) and codes of each support; number of failures.");
  module.def("group_corner_points", &group_corner_points, "dim"_a, "keys"_a, "codes"_a,
             "Groups of sorted supports: start, first, count, cell_start, cell keys, node_start, "
             "node keys.");
  module.def("corner_basis_values", &corner_basis_values, "start"_a, "node_start"_a, "node_keys"_a,
             "value_start"_a, "position"_a, "corner"_a, "grid"_a, "value"_a,
             "Fills basis values and gradients of all points.");
  module.def("move_corners", &move_corners, "position"_a, "corner"_a, "node_keys"_a,
             "displacement"_a, "grid"_a, "axisymmetric"_a, "moved"_a, "shift"_a,
             "Fills the moved corners and the points' displacements; first folded domain or -1.");
  module.def("share_corner_domains", &share_corner_domains, "stencil"_a, "position"_a, "corner"_a,
             "weight"_a, "grid"_a, "cell_keys"_a, "axisymmetric"_a,
             "Cells and their nodes' indices in the groups, shares, moments of the cells, and "
             "those of the "
             "hoop (see f_bar.py).");
}

}  // namespace tilth::bind
