// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/stencil.hpp"

#include "../basis/list.hpp"
#include "../kernel/basis_values.hpp"
#include "../kind.hpp"
#include "grid_view.hpp"
#include "stencil_view.hpp"

namespace tilth::bind {

namespace {

std::int64_t support_keys(const std::string& basis_name, ConstDoubles position,
                          ConstDoubles half_length, nb::handle grid_handle, Integers keys) {
  const std::int64_t points = rows_of(position, 2, "position");
  const int dim = dimension_of(position, "position");
  const GridView grid(grid_handle, dim);
  require_size(half_length, points * dim, "half_length");
  require_size(keys, points, "keys");
  std::int64_t outside = 0;
  nb::gil_scoped_release release;
  with_dimension(dim, [&](auto kind) {
    basis::with_basis(basis_name, [&](auto basis) {
      outside = kernel::support_keys<decltype(basis), decltype(kind)::dim>(
          points, position.data(), half_length.data(), grid, keys.data());
    });
  });
  return outside;
}

auto group_points(int dim, ConstIntegers keys) {
  require_indices(keys, std::numeric_limits<std::int64_t>::max(), "keys");
  kernel::Groups groups;
  with_dimension(dim, [&](auto kind) {
    groups = kernel::group_points<decltype(kind)::dim>(static_cast<std::int64_t>(keys.size()),
                                                       keys.data());
  });
  const std::size_t n = groups.start.size() - 1;
  return std::make_tuple(give(std::move(groups.start)), give(std::move(groups.first), {n, 3}),
                         give(std::move(groups.count), {n, 3}));
}

/// Returns the number of boxes of nodes; refuses empty ones and those beyond the range of keys.
std::int64_t require_boxes(const ConstIntegers& first, const ConstShorts& count) {
  const std::int64_t boxes = require_lattice(first, "first");
  require_table(count, boxes, 3, "count");
  bool wrong = false, outside = false;
  for (std::int64_t i = 0; i < 3 * boxes; ++i) {
    wrong |= count.data()[i] < 1;
    outside |= first.data()[i] + count.data()[i] > key_bias;
  }
  require(!wrong, "count", "is less than one");
  require(!outside, "count", "extends beyond the largest lattice index");
  return boxes;
}

/// Refuses boxes with more nodes than can support a point.
void require_supports(const ConstShorts& count) {
  bool many = false;
  for (std::int64_t i = 0; i < size_of(count); i += 3) {
    const std::int32_t* box = count.data() + i;
    many |= box[0] > kernel::maximum_nodes || box[1] > kernel::maximum_nodes ||
            box[2] > kernel::maximum_nodes ||
            std::int64_t{box[0]} * box[1] * box[2] > kernel::maximum_nodes;
  }
  require(!many, "count", "has a group with too many nodes");
}

auto active_nodes(ConstIntegers first, ConstShorts count) {
  const std::int64_t groups = require_boxes(first, count);
  require_supports(count);
  return give(kernel::active_nodes(groups, first.data(), count.data()));
}

auto lattice(ConstIntegers keys) {
  require_keys(keys, "keys");
  std::vector<std::int64_t> indices;
  indices.reserve(3 * keys.size());
  for (std::size_t v = 0; v < keys.size(); ++v) {
    const Lattice index = unpack(keys.data()[v]);
    indices.insert(indices.end(), index.begin(), index.end());
  }
  return give(std::move(indices), {keys.size(), 3});
}

auto node_keys(ConstIntegers indices) {
  std::vector<std::int64_t> keys(rows_of(indices, 2, "indices"));
  require_table(indices, static_cast<std::int64_t>(keys.size()), 3, "indices");
  for (std::size_t v = 0; v < keys.size(); ++v) {
    const std::int64_t* index = indices.data() + 3 * v;
    bool inside = true;
    for (int k = 0; k < 3; ++k) inside = inside && index[k] >= -key_bias && index[k] < key_bias;
    keys[v] = inside ? pack({index[0], index[1], index[2]}) : -1;
  }
  return give(std::move(keys));
}

auto group_nodes(ConstIntegers first, ConstShorts count, ConstIntegers keys,
                 ConstIntegers node_start) {
  const std::int64_t groups = require_boxes(first, count);
  require_supports(count);
  require_size(node_start, groups + 1, "node_start");
  bool other = node_start.data()[0] != 0;
  for (std::int64_t g = 0; g < groups; ++g) {
    const std::int32_t* box = count.data() + 3 * g;
    other |= node_start.data()[g + 1] !=
             static_cast<std::int64_t>(static_cast<std::uint64_t>(node_start.data()[g]) +
                                       static_cast<std::uint64_t>(box[0] * box[1] * box[2]));
  }
  require(!other, "node_start", "does not fit to count");
  std::vector<std::int32_t> nodes(node_start.data()[groups]);
  require(kernel::group_nodes(groups, first.data(), count.data(), size_of(keys), keys.data(),
                              node_start.data(), nodes.data()),
          "keys", "lacks a node of a group, or is not ascending");
  return give(std::move(nodes));
}

void basis_factors(const std::string& basis_name, ConstIntegers start, ConstIntegers first,
                   ConstShorts count, ConstIntegers value_start, ConstDoubles position,
                   ConstDoubles half_length, nb::handle grid_handle, Doubles factors) {
  const std::int64_t groups = require_boxes(first, count);
  require_supports(count);
  const int dim = dimension_of(position, "position");
  const std::int64_t points = rows_of(position, 2, "position");
  const GridView grid(grid_handle, dim);
  require_size(half_length, points * dim, "half_length");
  require_size(start, groups + 1, "start");
  require_starts(start, points, "start");
  require_size(value_start, groups + 1, "value_start");
  require_starts(value_start, size_of(factors), "value_start");
  const bool local = basis_name == basis::Linear::name;
  bool other = false;
  for (std::int64_t g = 0; g < groups; ++g) {
    std::int64_t numbers = 0;
    for (int k = 0; k < dim; ++k) numbers += local ? 1 : 2 * count.data()[3 * g + k];
    other |= value_start.data()[g + 1] - value_start.data()[g] !=
             numbers * (start.data()[g + 1] - start.data()[g]);
  }
  require(!other, "value_start", "does not fit to the points and nodes of a group");
  nb::gil_scoped_release release;
  with_dimension(dim, [&](auto kind) {
    basis::with_basis(basis_name, [&](auto basis) {
      kernel::basis_factors<decltype(basis), decltype(kind)::dim>(
          groups, start.data(), first.data(), count.data(), value_start.data(), position.data(),
          half_length.data(), grid, factors.data());
    });
  });
}

/// Values and gradients of all points, as the kernels have them.
void basis_values(nb::handle stencil_handle, Doubles value, Doubles gradient) {
  const StencilView stencil(stencil_handle);
  std::int64_t numbers = 0;
  for (std::int64_t g = 0; g < stencil.groups; ++g)
    numbers += (stencil.start[g + 1] - stencil.start[g]) * stencil.nodes_of(g);
  require_size(value, numbers, "value");
  require_size(gradient, numbers * stencil.dim, "gradient");
  with_dimension(stencil.dim, [&](auto kind) {
    constexpr int dim = decltype(kind)::dim;
    double* to_value = value.data();
    double* to_gradient = gradient.data();
    for (std::int64_t g = 0; g < stencil.groups; ++g) {
      const int n = stencil.nodes_of(g);
      kernel::GroupBasis<dim, 0, true, true> basis(stencil, g);
      for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
        basis.advance();
        to_value = std::copy_n(basis.value, n, to_value);
        to_gradient = std::copy_n(basis.gradient, dim * n, to_gradient);
      }
    }
  });
}

auto colour_groups(ConstIntegers first, ConstShorts count) {
  auto colouring = kernel::colour_groups(require_boxes(first, count), first.data(), count.data());
  return std::make_tuple(give(std::move(colouring.colour_start)),
                         give(std::move(colouring.slab_start)), give(std::move(colouring.order)));
}

auto basis_names() {
  nb::list names;
  const auto append = [&](auto... each) { (names.append(decltype(each)::name), ...); };
  std::apply(append, basis::List{});
  std::apply(append, basis::CornerList{});
  return names;
}

}  // namespace

void bind_stencil(nb::module_& module) {
  using namespace nb::literals;
  module.def("basis_names", &basis_names, nb::sig("def basis_names() -> list[str]"),
             "Names of the bases, in the order of basis/list.hpp.");
  module.def("support_keys", &support_keys, "basis"_a, "position"_a, "half_length"_a, "grid"_a,
             "keys"_a,
             "Fills the support key of each point; returns how many are out of range (key -1).");
  module.def("group_points", &group_points, "dim"_a, "keys"_a,
             "Groups of sorted keys: start (g+1), first node (g,3), nodes per direction (g,3).");
  module.def("active_nodes", &active_nodes, "first"_a, "count"_a,
             "Sorted keys of all nodes of the groups.");
  module.def("lattice", &lattice, "keys"_a, "Lattice indices (n,3) of node keys.");
  module.def("node_keys", &node_keys, "indices"_a,
             "Keys of lattice indices (n,3); -1 for an index out of range.");
  module.def("group_nodes", &group_nodes, "first"_a, "count"_a, "keys"_a, "node_start"_a,
             "Node numbers of each group, x fastest.");
  module.def("basis_factors", &basis_factors, "basis"_a, "start"_a, "first"_a, "count"_a,
             "value_start"_a, "position"_a, "half_length"_a, "grid"_a, "factors"_a,
             "Fills the factors of all points' basis, direction by direction.");
  module.def("basis_values", &basis_values, "stencil"_a, "value"_a, "gradient"_a,
             "Fills basis values, then gradients (dim, nodes), point after point.");
  module.def("colour_groups", &colour_groups, "first"_a, "count"_a,
             "Order of parallel assembly: colour_start, slab_start, order.");
}

}  // namespace tilth::bind
