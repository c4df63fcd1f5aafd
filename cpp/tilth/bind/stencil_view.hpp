// SPDX-License-Identifier: BSD-3-Clause
// Reads tilth.mpm.stencil.Stencil into the struct of pointers that the kernels take.
#pragma once

#include "../kernel/view.hpp"
#include "checked.hpp"
#include "checks.hpp"

namespace tilth::bind {

/// Refuses an order of parallel assembly that is not one of `items` groups or elements.
inline void require_colouring(const ConstIntegers& colour_start, const ConstIntegers& slab_start,
                              const ConstIntegers& order, std::int64_t items) {
  require_starts(slab_start, size_of(order), "slab_start");
  require_starts(colour_start, size_of(slab_start) - 1, "colour_start");
  require_size(order, items, "order");
  require_indices(order, items, "order");
}

/// Returns one more than the greatest node number, 0 without nodes; refuses negative ones.
inline std::int64_t end_of(const ConstShorts& node) {
  require_indices(node, std::int64_t{1} << 31, "node");
  const std::int32_t* end = node.data() + node.size();
  return node.size() == 0 ? 0 : std::int64_t{*std::max_element(node.data(), end)} + 1;
}

/// Keeps the arrays of a Python `Stencil` alive while a kernel runs.
struct StencilView : kernel::Stencil {
  ConstIntegers arrays64[6];
  ConstShorts nodes, counts;
  ConstDoubles values, own_slopes;
  int dim;

  explicit StencilView(nb::handle stencil) : kernel::Stencil{} {
    const char* names[6] = {"start",        "node_start", "value_start",
                            "colour_start", "slab_start", "order"};
    for (int i = 0; i < 6; ++i) arrays64[i] = attribute<ConstIntegers>(stencil, names[i]);
    nodes = attribute<ConstShorts>(stencil, "node");
    counts = attribute<ConstShorts>(stencil, "count");
    values = attribute<ConstDoubles>(stencil, "value");
    own_slopes = attribute<ConstDoubles>(stencil, "hat_slope");
    dim = number_attribute<int>(stencil, "dim");
    groups = size_of(arrays64[0]) - 1;
    start = arrays64[0].data();
    node_start = arrays64[1].data();
    value_start = arrays64[2].data();
    colour_start = arrays64[3].data();
    colours = size_of(arrays64[3]) - 1;
    slab_start = arrays64[4].data();
    order = arrays64[5].data();
    node = nodes.data();
    count = number_attribute<bool>(stencil, "boxed") ? counts.data() : nullptr;
    value = values.data();
    hat_slope = own_slopes.size() > 0 ? own_slopes.data() : nullptr;
    hat_slopes = size_of(own_slopes) > dim ? dim : 0;  // the same for all groups
    nodes_ = check_once(stencil,
                        parts_of(stencil, {"start", "node_start", "value_start", "colour_start",
                                           "slab_start", "order", "node", "count"}),
                        parts_of(stencil, {"value", "hat_slope", "dim", "boxed"}), [&] {
                          require_valid();
                          return end_of(nodes);
                        });
  }

  std::int64_t points() const { return start[groups]; }

  /// Refuses an array of `rows` nodes that has not all nodes of the stencil.
  void require_nodes(std::int64_t rows, const char* name) const {
    if (nodes_ > rows) refuse(name, "has less rows than the stencil has nodes");
  }

  /// Refuses a kind of analysis of another dimension.
  void require_kind(const std::string& kind_name) const {
    if (dimension_of_kind(kind_name) != dim) refuse("kind", "has another dimension than stencil");
  }

  /// Refuses vectors (n, dim) or (n, columns) that are not one per point.
  void require_points(const ConstDoubles& array, std::int64_t columns, const char* name) const {
    require_size(array, points() * columns, name);
  }

 private:
  std::int64_t nodes_;  // one more than the greatest node number

  void require_valid() const {
    require(dim == 2 || dim == 3, "dim", "is not 2 or 3");
    require(groups >= 0, "start", "is empty, expected one entry more than groups");
    require_starts(arrays64[0], start[groups], "start");
    require_size(arrays64[1], groups + 1, "node_start");
    require_starts(arrays64[1], size_of(nodes), "node_start");
    require_size(arrays64[2], groups + 1, "value_start");
    require_starts(arrays64[2], size_of(values), "value_start");
    require(points() <= size_of(values), "start", "has more points than value has entries");
    require_colouring(arrays64[3], arrays64[4], arrays64[5], groups);
    if (hat_slope != nullptr)
      require_size(own_slopes, hat_slopes > 0 ? groups * dim : dim, "hat_slope");
    require_size(counts, 3 * groups, "count");
    bool many = false, other = false, little = false;
    for (std::int64_t g = 0; g < groups; ++g) {
      const std::int64_t own = node_start[g + 1] - node_start[g];
      std::int64_t numbers = (1 + dim) * own;
      if (count != nullptr) {
        const std::int64_t x = count[3 * g], y = count[3 * g + 1], z = count[3 * g + 2];
        many |= x < 1 || y < 1 || z < 1 || x > kernel::maximum_nodes || y > kernel::maximum_nodes ||
                z > kernel::maximum_nodes;
        other |= own != x * y * (dim == 3 ? z : 1);
        if (hat_slope != nullptr) other |= own != 1 << dim;
        numbers = hat_slope != nullptr ? dim : 2 * (x + y + (dim == 3 ? z : 0));
      }
      many |= own > kernel::maximum_nodes;
      little |= value_start[g + 1] - value_start[g] != numbers * (start[g + 1] - start[g]);
    }
    require(!many, "count", "or node_start has a group with too many nodes");
    require(!other, "count", "and node_start differ in the nodes of a group");
    require(!little, "value_start", "does not fit to the points and nodes of a group");
  }
};

}  // namespace tilth::bind
