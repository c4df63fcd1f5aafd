// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/array.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "../components.hpp"
#include "../multigrid/hierarchy.hpp"
#include "../multigrid/vector_operations.hpp"
#include "arrays.hpp"

namespace tilth::bind {

namespace {

using multigrid::Hierarchy;

std::unique_ptr<Hierarchy> make(int dim, int components, ConstIntegers lattice,
                                ConstIntegers row_start, ConstShorts column,
                                ConstFlags constrained) {
  const auto nodes = static_cast<std::int64_t>(row_start.size()) - 1;
  require_size(lattice, 3 * nodes, "lattice");
  require_size(constrained, nodes * components, "constrained");
  std::vector<multigrid::LatticeIndex> index(nodes);
  for (std::int64_t v = 0; v < nodes; ++v)
    for (int k = 0; k < 3; ++k) index[v][k] = static_cast<std::int32_t>(lattice.data()[3 * v + k]);
  std::vector<std::int64_t> starts(row_start.data(), row_start.data() + nodes + 1);
  std::vector<std::int32_t> columns(column.data(), column.data() + column.size());
  nb::gil_scoped_release release;
  return with_components(components, [&](auto count) -> std::unique_ptr<Hierarchy> {
    const auto of = [&]<int Dim>() {
      return std::make_unique<multigrid::HierarchyOf<Dim, count()>>(
          std::move(index), std::move(starts), std::move(columns), constrained.data());
    };
    if (dim == 2) return of.template operator()<2>();
    return of.template operator()<3>();
  });
}

void fill(Hierarchy& hierarchy, ConstDoubles blocks) {
  nb::gil_scoped_release release;
  hierarchy.fill(blocks.data());
}

void cycle(Hierarchy& hierarchy, ConstDoubles residual, Doubles approximate) {
  require_size(approximate, static_cast<std::int64_t>(residual.size()), "approximate");
  nb::gil_scoped_release release;
  hierarchy.cycle(residual.data(), approximate.data());
}

void block_product(int components, ConstIntegers row_start, ConstShorts column, ConstDoubles blocks,
                   ConstFlags constrained, ConstDoubles x, Doubles product) {
  const auto nodes = static_cast<std::int64_t>(row_start.size()) - 1;
  require_size(constrained, nodes * components, "constrained");
  require_size(x, nodes * components, "x");
  require_size(product, nodes * components, "product");
  nb::gil_scoped_release release;
  with_components(components, [&](auto count) {
    multigrid::block_product<count(), 1>(nodes, row_start.data(), column.data(), blocks.data(),
                                         constrained.data(), {x.data()}, {product.data()});
  });
}

std::array<double, 3> asymmetry(int components, ConstIntegers row_start, ConstShorts column,
                                ConstDoubles blocks, ConstFlags constrained, ConstDoubles u,
                                ConstDoubles v) {
  const auto nodes = static_cast<std::int64_t>(row_start.size()) - 1;
  require_size(constrained, nodes * components, "constrained");
  require_size(u, nodes * components, "u");
  require_size(v, nodes * components, "v");
  nb::gil_scoped_release release;
  return with_components(components, [&](auto count) {
    return multigrid::asymmetry<count()>(nodes, row_start.data(), column.data(), blocks.data(),
                                         constrained.data(), u.data(), v.data());
  });
}

double inner(ConstDoubles a, ConstDoubles b) {
  require_size(b, static_cast<std::int64_t>(a.size()), "b");
  nb::gil_scoped_release release;
  return multigrid::inner(static_cast<std::int64_t>(a.size()), a.data(), b.data());
}

std::array<double, 2> two_inner(ConstDoubles a, ConstDoubles b, ConstDoubles c) {
  const auto n = static_cast<std::int64_t>(a.size());
  require_size(b, n, "b");
  require_size(c, n, "c");
  nb::gil_scoped_release release;
  return multigrid::two_inner(n, a.data(), b.data(), c.data());
}

void combine(double a, ConstDoubles x, double b, Doubles y) {
  const auto n = static_cast<std::int64_t>(x.size());
  require_size(y, n, "y");
  nb::gil_scoped_release release;
  multigrid::combine(n, a, x.data(), b, y.data());
}

double advance(double length, ConstDoubles p, ConstDoubles q, Doubles x, Doubles r) {
  const auto n = static_cast<std::int64_t>(p.size());
  require_size(q, n, "q");
  require_size(x, n, "x");
  require_size(r, n, "r");
  nb::gil_scoped_release release;
  return multigrid::advance(n, length, p.data(), q.data(), x.data(), r.data());
}

}  // namespace

void bind_multigrid(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<Hierarchy>(module, "Multigrid",
                        "Geometric multigrid over an integer lattice of nodes; pattern fixed.")
      .def(nb::new_(&make), "dim"_a, "components"_a, "lattice"_a, "row_start"_a, "column"_a,
           "constrained"_a)
      .def("begin", &Hierarchy::begin,
           "Discards all matrices; later results are identical to those of a new object.")
      .def("fill", &fill, "blocks"_a, "Sets the values of the matrix.")
      .def("cycle", &cycle, "residual"_a, "approximate"_a,
           "Fills `approximate` with one V-cycle for `residual`.")
      .def("sizes", &Hierarchy::sizes, "Nodes and blocks of each level, the finest first.")
      .def("bytes", &Hierarchy::bytes, "Memory of all levels [byte].");
  module.def("block_product", &block_product, "components"_a, "row_start"_a, "column"_a, "blocks"_a,
             "constrained"_a, "x"_a, "product"_a, "Fills the product A x, zero where constrained.");
  module.def("asymmetry", &asymmetry, "components"_a, "row_start"_a, "column"_a, "blocks"_a,
             "constrained"_a, "u"_a, "v"_a, "Returns A v . A v, u . A v and v . A u.");
  module.def("inner", &inner, "a"_a, "b"_a, "Inner product, identical for any number of threads.");
  module.def("two_inner", &two_inner, "a"_a, "b"_a, "c"_a,
             "Inner products a . b and a . c, as `inner`.");
  module.def("combine", &combine, "a"_a, "x"_a, "b"_a, "y"_a, "Replaces y by a x + b y.");
  module.def("advance", &advance, "length"_a, "p"_a, "q"_a, "x"_a, "r"_a,
             "Adds length p to x, subtracts length q from r; returns r . r, as `inner`.");
}

}  // namespace tilth::bind
