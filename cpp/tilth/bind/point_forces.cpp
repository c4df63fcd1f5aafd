// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/point_forces.hpp"

#include "stencil_view.hpp"

namespace tilth::bind {

namespace {

void step_inverses(const std::string& kind_name, nb::handle stencil_handle,
                   ConstDoubles displacement, ConstDoubles position, Doubles determinant,
                   Doubles inverse) {
  const StencilView stencil(stencil_handle);
  stencil.require_kind(kind_name);
  const std::int64_t nodes = rows_of(displacement, 2, "displacement");
  require_table(displacement, nodes, stencil.dim, "displacement");
  stencil.require_nodes(nodes, "displacement");
  stencil.require_points(position, stencil.dim, "position");
  require_size(determinant, stencil.points(), "determinant");
  require_size(inverse, 9 * stencil.points(), "inverse");
  nb::gil_scoped_release release;
  with_kind(kind_name, [&](auto kind) {
    kernel::step_inverses<decltype(kind)>(stencil, displacement.data(), position.data(),
                                          determinant.data(), inverse.data());
  });
}

void add_force_derivative(nb::handle stencil_handle, ConstIntegers block_start,
                          ConstShorts block_position, ConstDoubles by_displacement,
                          ConstDoubles by_gradient, Doubles matrix) {
  const StencilView stencil(stencil_handle);
  const std::int64_t dim = stencil.dim;
  stencil.require_points(by_displacement, dim * dim, "by_displacement");
  stencil.require_points(by_gradient, dim * dim * dim, "by_gradient");
  require_size(block_start, stencil.groups, "block_start");
  const std::int64_t blocks_of_matrix = rows_of(matrix, 3, "matrix");
  require_size(matrix, blocks_of_matrix * dim * dim, "matrix");
  const kernel::BlockPositions blocks{block_start.data(), block_position.data(),
                                      size_of(block_position), blocks_of_matrix};
  nb::gil_scoped_release release;
  const auto add = dim == 2 ? &kernel::add_force_derivative<2> : &kernel::add_force_derivative<3>;
  require(add(stencil, blocks, by_displacement.data(), by_gradient.data(), matrix.data()),
          "block_position", "does not fit to block_start, stencil and matrix");
}

}  // namespace

void bind_point_forces(nb::module_& module) {
  using namespace nb::literals;
  module.def(
      "step_inverses", &step_inverses, "kind"_a, "stencil"_a, "displacement"_a, "position"_a,
      "determinant"_a, "inverse"_a,
      "Fills determinants (n) and inverses (n, 3, 3) of the points' deformation gradients of "
      "the step.");
  module.def("add_force_derivative", &add_force_derivative, "stencil"_a, "block_start"_a,
             "block_position"_a, "by_displacement"_a, "by_gradient"_a, "matrix"_a,
             "Adds the derivative of forces S_a f of the points by their displacement (n, dim, "
             "dim) and its gradient (n, dim, dim, dim) to the blocks (entries, dim, dim).");
}

}  // namespace tilth::bind
