// SPDX-License-Identifier: BSD-3-Clause
// Reads tilth.mpm.grid.Stencil into the struct of pointers that the kernels take.
#pragma once

#include "../kernel/view.hpp"
#include "arrays.hpp"

namespace tilth::bind {

/// Keeps the arrays of a Python `Stencil` alive while a kernel runs.
struct StencilView : kernel::Stencil {
  ConstIntegers arrays64[6];
  ConstShorts nodes, counts;
  ConstDoubles values, hat_slopes;
  int dim;

  explicit StencilView(nb::handle stencil) : kernel::Stencil{} {
    const char* names[6] = {"start",        "node_start", "value_start",
                            "colour_start", "slab_start", "order"};
    for (int i = 0; i < 6; ++i) arrays64[i] = nb::cast<ConstIntegers>(stencil.attr(names[i]));
    nodes = nb::cast<ConstShorts>(stencil.attr("node"));
    counts = nb::cast<ConstShorts>(stencil.attr("count"));
    values = nb::cast<ConstDoubles>(stencil.attr("value"));
    hat_slopes = nb::cast<ConstDoubles>(stencil.attr("hat_slope"));
    dim = nb::cast<int>(stencil.attr("dim"));
    groups = static_cast<std::int64_t>(arrays64[0].size()) - 1;
    start = arrays64[0].data();
    node_start = arrays64[1].data();
    value_start = arrays64[2].data();
    colour_start = arrays64[3].data();
    colours = static_cast<std::int64_t>(arrays64[3].size()) - 1;
    slab_start = arrays64[4].data();
    order = arrays64[5].data();
    node = nodes.data();
    count = nb::cast<bool>(stencil.attr("boxed")) ? counts.data() : nullptr;
    value = values.data();
    hat_slope = hat_slopes.size() > 0 ? hat_slopes.data() : nullptr;
  }

  std::int64_t points() const { return start[groups]; }
};

}  // namespace tilth::bind
