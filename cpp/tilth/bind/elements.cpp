// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/elements.hpp"
#include "../components.hpp"
#include "stencil_view.hpp"

namespace tilth::bind {

namespace {

/// Reads tilth.mpm.pattern.Elements.
struct ElementsView : kernel::Elements {
  ConstShorts shorts[2];
  ConstIntegers integers[5];

  explicit ElementsView(nb::handle of) : kernel::Elements{} {
    shorts[0] = attribute<ConstShorts>(of, "node");
    shorts[1] = attribute<ConstShorts>(of, "block_position");
    const char* names[5] = {"colour_start", "slab_start", "order", "block_start", "node_start"};
    for (int i = 0; i < 5; ++i) integers[i] = attribute<ConstIntegers>(of, names[i]);
    elements = size_of(integers[4]) - 1;
    node_start = integers[4].data();
    nodes_ = check_once(of,
                        parts_of(of, {"node", "block_position", "colour_start", "slab_start",
                                      "order", "block_start", "node_start"}),
                        {}, [&] {
                          require_valid();
                          return end_of(shorts[0]);
                        });
    node = shorts[0].data();
    colours = size_of(integers[0]) - 1;
    colour_start = integers[0].data();
    slab_start = integers[1].data();
    order = integers[2].data();
  }

  kernel::BlockPositions blocks(std::int64_t of_matrix) const {
    return {integers[3].data(), shorts[1].data(), size_of(shorts[1]), of_matrix};
  }

  /// Returns the number of components of nodal vectors (nodes, components) that have all nodes of
  /// the elements.
  template <class Nodal>
  int components_of(const Nodal& nodal, const char* name) const {
    const std::int64_t components = columns_of(nodal, name);
    require(components >= 1 && components <= 3, name, "has not 1, 2 or 3 columns");
    if (nodes_ > rows_of(nodal, 2, name))
      refuse(name, "has less rows than the elements have nodes");
    return static_cast<int>(components);
  }

  std::int64_t entries() const { return node_start[elements]; }

  /// The number of nodes of every element; refuses elements that differ in it.
  int same_nodes() const {
    const int nodes = elements > 0 ? nodes_of(0) : 0;
    for (std::int64_t e = 0; e < elements; ++e)
      if (nodes_of(e) != nodes) throw std::invalid_argument("elements differ in their nodes");
    if (nodes > kernel::maximum_nodes) throw std::invalid_argument("an element has too many nodes");
    return nodes;
  }

 private:
  std::int64_t nodes_;  // one more than the greatest node number

  void require_valid() const {
    require_starts(integers[4], size_of(shorts[0]), "node_start");
    bool many = false;
    for (std::int64_t e = 0; e < elements; ++e)
      many |= node_start[e + 1] - node_start[e] > kernel::maximum_element_nodes;
    require(!many, "node_start", "has an element with too many nodes");
    require_size(integers[3], elements, "block_start");
    require_colouring(integers[0], integers[1], integers[2], elements);
  }
};

/// Returns the number of components of node blocks (blocks, components, components).
int components_of_blocks(const Doubles& blocks) {
  const std::int64_t rows = rows_of(blocks, 3, "blocks");
  const auto components = static_cast<std::int64_t>(blocks.shape(1));
  require(components >= 1 && components <= 3, "blocks", "have not 1, 2 or 3 components");
  require_size(blocks, rows * components * components, "blocks");
  return static_cast<int>(components);
}

/// Adds the elements' matrices; `make(count)` returns the matrices for a number of components.
template <class Make>
void add_blocks(const ElementsView& elements, const Doubles& blocks, Make make) {
  const kernel::BlockPositions positions =
      elements.blocks(static_cast<std::int64_t>(blocks.shape(0)));
  nb::gil_scoped_release release;
  const bool fits = with_components(static_cast<int>(blocks.shape(1)), [&](auto count) {
    return kernel::add_element_blocks<count()>(elements, positions, make(count), blocks.data());
  });
  require(fits, "block_position", "does not fit to block_start, elements and blocks");
}

void add_element_forces(nb::handle of, ConstDoubles force, Doubles nodal) {
  const ElementsView elements(of);
  const int components = elements.components_of(nodal, "nodal");
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
                    const ConstDoubles& unit, const ConstShorts& which, const ConstFlags& free,
                    int components) {
  require_size(weight, elements.elements, "weight");
  require_size(which, elements.elements, "which");
  const std::int64_t nodes = elements.same_nodes();
  const std::int64_t units = rows_of(unit, 3, "unit");
  require_size(unit, units * nodes * nodes, "unit");
  bool known = true;
  for (std::int64_t e = 0; e < elements.elements; ++e)
    known &= which.data()[e] >= 0 && which.data()[e] < units;
  require(known, "which", "is not the number of a matrix in unit");
  require_size(free, elements.elements * nodes * components, "free");
}

void add_dense_products(nb::handle of, ConstDoubles matrix, ConstDoubles vector, bool magnitude,
                        Doubles product) {
  const ElementsView elements(of);
  const int components = elements.components_of(vector, "vector");
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
  const int components = components_of_blocks(blocks);
  require_dense(elements, matrix, components);
  add_blocks(elements, blocks,
             [&](auto count) { return kernel::DenseMatrices<count()>{matrix.data()}; });
}

void add_scaled_products(nb::handle of, ConstDoubles weight, ConstDoubles unit, ConstShorts which,
                         ConstFlags free, ConstDoubles vector, bool magnitude, Doubles product) {
  const ElementsView elements(of);
  const int components = elements.components_of(vector, "vector");
  require_scaled(elements, weight, unit, which, free, components);
  require_size(product, static_cast<std::int64_t>(vector.size()), "product");
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    using Matrices = kernel::ScaledMatrix<count()>;
    add_products<Matrices, count()>(elements,
                                    Matrices{weight.data(), unit.data(), which.data(), free.data()},
                                    vector.data(), magnitude, product.data());
  });
}

void add_scaled_blocks(nb::handle of, ConstDoubles weight, ConstDoubles unit, ConstShorts which,
                       ConstFlags free, Doubles blocks) {
  const ElementsView elements(of);
  const int components = components_of_blocks(blocks);
  require_scaled(elements, weight, unit, which, free, components);
  add_blocks(elements, blocks, [&](auto count) {
    return kernel::ScaledMatrix<count()>{weight.data(), unit.data(), which.data(), free.data()};
  });
}

void add_row_products(nb::handle of, ConstDoubles row, ConstDoubles vector, bool magnitude,
                      Doubles product) {
  const ElementsView elements(of);
  const int components = elements.components_of(vector, "vector");
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
  const int components = components_of_blocks(blocks);
  require_size(row, elements.entries() * components, "row");
  add_blocks(elements, blocks, [&](auto count) {
    return kernel::RowProducts<count()>{elements.node_start, row.data()};
  });
}

void add_outer_blocks(nb::handle of, ConstDoubles column, ConstDoubles row, Doubles blocks) {
  const ElementsView elements(of);
  const int components = components_of_blocks(blocks);
  require_size(column, elements.entries() * components, "column");
  require_size(row, elements.entries() * components, "row");
  add_blocks(elements, blocks, [&](auto count) {
    return kernel::OuterProducts<count()>{elements.node_start, column.data(), row.data()};
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
             "which"_a, "free"_a, "vector"_a, "magnitude"_a, "product"_a,
             "As add_dense_products for matrices weight_e unit_ab of each free component; which: "
             "the unit (units, n, n) of each element.");
  module.def("add_scaled_blocks", &add_scaled_blocks, "elements"_a, "weight"_a, "unit"_a, "which"_a,
             "free"_a, "blocks"_a,
             "As add_dense_blocks for matrices weight_e unit_ab of each free component; which: the "
             "unit (units, n, n) of each element.");
  module.def("add_row_products", &add_row_products, "elements"_a, "row"_a, "vector"_a,
             "magnitude"_a, "product"_a,
             "As add_dense_products for matrices that are a row's product with itself.");
  module.def("add_row_blocks", &add_row_blocks, "elements"_a, "row"_a, "blocks"_a,
             "As add_dense_blocks for matrices that are a row's product with itself.");
  module.def("add_outer_blocks", &add_outer_blocks, "elements"_a, "column"_a, "row"_a, "blocks"_a,
             "As add_dense_blocks for matrices that are the product of a column and a row.");
}

}  // namespace tilth::bind
