// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/elements.hpp"
#include "../components.hpp"
#include "arrays.hpp"

namespace tilth::bind {

namespace {

/// Reads tilth.mpm.pattern.Elements.
struct ElementsView : kernel::Elements {
  ConstShorts shorts[2];
  ConstIntegers integers[5];

  explicit ElementsView(nb::handle of) : kernel::Elements{} {
    shorts[0] = nb::cast<ConstShorts>(of.attr("node"));
    shorts[1] = nb::cast<ConstShorts>(of.attr("block_position"));
    const char* names[5] = {"colour_start", "slab_start", "order", "block_start", "node_start"};
    for (int i = 0; i < 5; ++i) integers[i] = nb::cast<ConstIntegers>(of.attr(names[i]));
    elements = static_cast<std::int64_t>(integers[4].size()) - 1;
    node_start = integers[4].data();
    for (std::int64_t e = 0; e < elements; ++e)
      if (nodes_of(e) > kernel::maximum_element_nodes)
        throw std::invalid_argument("an element has too many nodes");
    require_size(shorts[0], node_start[elements], "node");
    require_size(integers[2], elements, "order");
    require_size(integers[3], elements, "block_start");
    node = shorts[0].data();
    colours = static_cast<std::int64_t>(integers[0].size()) - 1;
    colour_start = integers[0].data();
    slab_start = integers[1].data();
    order = integers[2].data();
  }

  kernel::BlockPositions blocks() const { return {integers[3].data(), shorts[1].data()}; }

  std::int64_t entries() const { return node_start[elements]; }

  /// The number of nodes of every element; refuses elements that differ in it.
  int same_nodes() const {
    const int nodes = elements > 0 ? nodes_of(0) : 0;
    for (std::int64_t e = 0; e < elements; ++e)
      if (nodes_of(e) != nodes) throw std::invalid_argument("elements differ in their nodes");
    if (nodes > kernel::maximum_nodes) throw std::invalid_argument("an element has too many nodes");
    return nodes;
  }
};

void add_element_forces(nb::handle of, ConstDoubles force, Doubles nodal) {
  const ElementsView elements(of);
  const int components = static_cast<int>(nodal.shape(1));
  require_size(force, elements.entries() * components, "force");
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    kernel::add_element_forces<count()>(elements, force.data(), nodal.data());
  });
}

template <class Matrices, int Dim>
void add_products(const ElementsView& elements, const Matrices& matrices, const double* vector,
                  bool magnitude, double* product) {
  const auto add = magnitude ? &kernel::add_element_products<true, Dim, Matrices>
                             : &kernel::add_element_products<false, Dim, Matrices>;
  add(elements, matrices, vector, product);
}

void require_dense(const ElementsView& elements, const ConstDoubles& matrix, int components) {
  const std::int64_t unknowns = std::int64_t{elements.same_nodes()} * components;
  require_size(matrix, elements.elements * unknowns * unknowns, "matrix");
}

void require_scaled(const ElementsView& elements, const ConstDoubles& weight,
                    const ConstDoubles& unit, const ConstFlags& free, int components) {
  require_size(weight, elements.elements, "weight");
  const std::int64_t nodes = elements.same_nodes();
  require_size(unit, nodes * nodes, "unit");
  require_size(free, elements.elements * nodes * components, "free");
}

void add_dense_products(nb::handle of, ConstDoubles matrix, ConstDoubles vector, bool magnitude,
                        Doubles product) {
  const ElementsView elements(of);
  const int components = static_cast<int>(vector.shape(1));
  require_dense(elements, matrix, components);
  require_size(product, static_cast<std::int64_t>(vector.size()), "product");
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    using Matrices = kernel::DenseMatrices<count()>;
    add_products<Matrices, count()>(elements, Matrices{matrix.data()}, vector.data(), magnitude,
                                    product.data());
  });
}

void add_dense_blocks(nb::handle of, ConstDoubles matrix, Doubles blocks) {
  const ElementsView elements(of);
  const int components = static_cast<int>(blocks.shape(1));
  require_dense(elements, matrix, components);
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    using Matrices = kernel::DenseMatrices<count()>;
    kernel::add_element_blocks<count()>(elements, elements.blocks(), Matrices{matrix.data()},
                                        blocks.data());
  });
}

void add_scaled_products(nb::handle of, ConstDoubles weight, ConstDoubles unit, ConstFlags free,
                         ConstDoubles vector, bool magnitude, Doubles product) {
  const ElementsView elements(of);
  const int components = static_cast<int>(vector.shape(1));
  require_scaled(elements, weight, unit, free, components);
  require_size(product, static_cast<std::int64_t>(vector.size()), "product");
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    using Matrices = kernel::ScaledMatrix<count()>;
    add_products<Matrices, count()>(elements, Matrices{weight.data(), unit.data(), free.data()},
                                    vector.data(), magnitude, product.data());
  });
}

void add_scaled_blocks(nb::handle of, ConstDoubles weight, ConstDoubles unit, ConstFlags free,
                       Doubles blocks) {
  const ElementsView elements(of);
  const int components = static_cast<int>(blocks.shape(1));
  require_scaled(elements, weight, unit, free, components);
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    using Matrices = kernel::ScaledMatrix<count()>;
    kernel::add_element_blocks<count()>(elements, elements.blocks(),
                                        Matrices{weight.data(), unit.data(), free.data()},
                                        blocks.data());
  });
}

void add_row_products(nb::handle of, ConstDoubles row, ConstDoubles vector, bool magnitude,
                      Doubles product) {
  const ElementsView elements(of);
  const int components = static_cast<int>(vector.shape(1));
  require_size(row, elements.entries() * components, "row");
  require_size(product, static_cast<std::int64_t>(vector.size()), "product");
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    using Matrices = kernel::RowProducts<count()>;
    add_products<Matrices, count()>(elements, Matrices{elements.node_start, row.data()},
                                    vector.data(), magnitude, product.data());
  });
}

void add_row_blocks(nb::handle of, ConstDoubles row, Doubles blocks) {
  const ElementsView elements(of);
  const int components = static_cast<int>(blocks.shape(1));
  require_size(row, elements.entries() * components, "row");
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    using Matrices = kernel::RowProducts<count()>;
    kernel::add_element_blocks<count()>(elements, elements.blocks(),
                                        Matrices{elements.node_start, row.data()}, blocks.data());
  });
}

}  // namespace

void bind_elements(nb::module_& module) {
  using namespace nb::literals;
  module.def("add_element_forces", &add_element_forces, "elements"_a, "force"_a, "nodal"_a,
             "Adds the elements' forces (entries, components) to nodal (nodes, components).");
  module.def(
      "add_dense_products", &add_dense_products, "elements"_a, "matrix"_a, "vector"_a,
      "magnitude"_a, "product"_a,
      "Adds the elements' matrices (e, n, n, components, components), or those of their entries' "
      "magnitudes, times vector to product.");
  module.def(
      "add_dense_blocks", &add_dense_blocks, "elements"_a, "matrix"_a, "blocks"_a,
      "Adds the elements' matrices (e, n, n, components, components) to the node-block matrix.");
  module.def("add_scaled_products", &add_scaled_products, "elements"_a, "weight"_a, "unit"_a,
             "free"_a, "vector"_a, "magnitude"_a, "product"_a,
             "As add_dense_products for matrices weight_e unit_ab of each free component.");
  module.def("add_scaled_blocks", &add_scaled_blocks, "elements"_a, "weight"_a, "unit"_a, "free"_a,
             "blocks"_a,
             "As add_dense_blocks for matrices weight_e unit_ab of each free component.");
  module.def("add_row_products", &add_row_products, "elements"_a, "row"_a, "vector"_a,
             "magnitude"_a, "product"_a,
             "As add_dense_products for matrices that are a row's product with itself.");
  module.def("add_row_blocks", &add_row_blocks, "elements"_a, "row"_a, "blocks"_a,
             "As add_dense_blocks for matrices that are a row's product with itself.");
}

}  // namespace tilth::bind
