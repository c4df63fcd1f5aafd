// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/point_integrals.hpp"

#include "../kernel/point_blocks.hpp"
#include "../kind.hpp"
#include "centres_view.hpp"

namespace tilth::bind {

namespace {

/// Returns the number of components of nodal vectors (nodes, components) or scalars (nodes,).
template <class Nodal, class Vector>
int components_of(const StencilView& stencil, const Nodal& nodal, const Vector& vector) {
  require(nodal.ndim() == 1 || nodal.ndim() == 2, "nodal", "has not one or two axes");
  const auto components = nodal.ndim() == 2 ? static_cast<std::int64_t>(nodal.shape(1)) : 1;
  require(components <= std::numeric_limits<int>::max(), "nodal", "has too many columns");
  stencil.require_nodes(static_cast<std::int64_t>(nodal.shape(0)), "nodal");
  require_size(vector, stencil.points() * components, "vector");
  return static_cast<int>(components);
}

void scatter(nb::handle stencil_handle, ConstDoubles vector, Doubles nodal) {
  const StencilView stencil(stencil_handle);
  const int components = components_of(stencil, nodal, vector);
  nb::gil_scoped_release release;
  const auto scatter = stencil.dim == 2 ? &kernel::scatter<2> : &kernel::scatter<3>;
  scatter(stencil, components, vector.data(), nodal.data());
}

void interpolate(nb::handle stencil_handle, ConstDoubles nodal, Doubles vector) {
  const StencilView stencil(stencil_handle);
  const int components = components_of(stencil, nodal, vector);
  nb::gil_scoped_release release;
  const auto interpolate = stencil.dim == 2 ? &kernel::interpolate<2> : &kernel::interpolate<3>;
  interpolate(stencil, components, nodal.data(), vector.data());
}

/// Refuses an array of another shape.
template <class Array>
void require_shape(const Array& array, const std::vector<std::int64_t>& shape,
                   const std::string& name) {
  rows_of(array, shape.size(), name);
  for (std::size_t axis = 0; axis < shape.size(); ++axis)
    if (static_cast<std::int64_t>(array.shape(axis)) != shape[axis])
      refuse(name, "has " + std::to_string(array.shape(axis)) + " entries along axis " +
                       std::to_string(axis) + ", expected " + std::to_string(shape[axis]));
}

/// Calls `function(one or dim)`, a constant, with the number of components of a field; refuses
/// others.
template <int Dim, class Function>
void with_components(std::size_t components, const std::string& name, Function&& function) {
  if (components == 1) return function(std::integral_constant<int, 1>{});
  if (components == Dim) return function(std::integral_constant<int, Dim>{});
  refuse(name,
         "has " + std::to_string(components) + " components, expected 1 or " + std::to_string(Dim));
}

/// Checks nodal values (nodes, components) and what the points have of them, (n, components, dim).
template <class Nodal, class Gradient>
void require_gradient(const StencilView& stencil, const Nodal& nodal, const Gradient& gradient,
                      const std::string& name) {
  const std::int64_t components = columns_of(nodal, "nodal");
  stencil.require_nodes(rows_of(nodal, 2, "nodal"), "nodal");
  require_shape(gradient, {stencil.points(), components, stencil.dim}, name);
}

void scatter_gradient(nb::handle stencil_handle, ConstDoubles flux, Doubles nodal) {
  const StencilView stencil(stencil_handle);
  require_gradient(stencil, nodal, flux, "flux");
  with_dimension(stencil.dim, [&](auto kind) {
    constexpr int dim = decltype(kind)::dim;
    with_components<dim>(nodal.shape(1), "nodal", [&](auto components) {
      nb::gil_scoped_release release;
      kernel::scatter_gradient<dim, components>(stencil, flux.data(), nodal.data());
    });
  });
}

void interpolate_gradient(nb::handle stencil_handle, ConstDoubles nodal, Doubles gradient) {
  const StencilView stencil(stencil_handle);
  require_gradient(stencil, nodal, gradient, "gradient");
  with_dimension(stencil.dim, [&](auto kind) {
    constexpr int dim = decltype(kind)::dim;
    with_components<dim>(nodal.shape(1), "nodal", [&](auto components) {
      nb::gil_scoped_release release;
      kernel::interpolate_gradient<dim, components>(stencil, nodal.data(), gradient.data());
    });
  });
}

void add_point_blocks(nb::handle stencil_handle, ConstIntegers block_start,
                      ConstShorts block_position, ConstDoubles point_matrix, Doubles matrix) {
  const StencilView stencil(stencil_handle);
  const SupportsView supports(stencil_handle, stencil);
  require_size(block_start, stencil.groups, "block_start");
  const kernel::BlockPositions blocks{block_start.data(), block_position.data(),
                                      size_of(block_position), rows_of(matrix, 3, "matrix")};
  const std::size_t rows = matrix.shape(1), columns = matrix.shape(2);
  require_shape(point_matrix,
                {stencil.points(), static_cast<std::int64_t>(rows), 1 + stencil.dim,
                 static_cast<std::int64_t>(columns), 1 + stencil.dim},
                "point_matrix");
  bool fits = true;
  with_dimension(stencil.dim, [&](auto kind) {
    constexpr int dim = decltype(kind)::dim;
    with_components<dim>(rows, "matrix", [&](auto r) {
      with_components<dim>(columns, "matrix", [&](auto c) {
        nb::gil_scoped_release release;
        fits = kernel::add_point_blocks<dim, r, c>(stencil, supports.boxes, blocks,
                                                   point_matrix.data(), matrix.data());
      });
    });
  });
  require(fits, "block_position", "does not fit to block_start, stencil and matrix");
}

}  // namespace

void bind_point_integrals(nb::module_& module) {
  using namespace nb::literals;
  module.def("scatter", &scatter, "stencil"_a, "vector"_a, "nodal"_a,
             "Adds sum_p S_a vector_p to nodal.");
  module.def("interpolate", &interpolate, "stencil"_a, "nodal"_a, "vector"_a,
             "Fills the points' interpolated vectors.");
  module.def("scatter_gradient", &scatter_gradient, "stencil"_a, "flux"_a, "nodal"_a,
             "Adds sum_p flux_p grad S_a, flux (n, components, dim), to nodal (nodes, components); "
             "1 or dim components.");
  module.def("interpolate_gradient", &interpolate_gradient, "stencil"_a, "nodal"_a, "gradient"_a,
             "Fills the points' gradients (n, components, dim) of nodal (nodes, components); 1 or "
             "dim components.");
  module.def("add_point_blocks", &add_point_blocks, "stencil"_a, "block_start"_a,
             "block_position"_a, "point_matrix"_a, "matrix"_a,
             "Adds sum_p S_a D_p S_b with S = (value, gradient) and the points' matrices D (n, r, "
             "1+dim, c, 1+dim) to the blocks (entries, r, c); r and c are 1 or dim.");
}

}  // namespace tilth::bind
