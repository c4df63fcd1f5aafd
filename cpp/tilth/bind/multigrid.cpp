// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/array.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "../components.hpp"
#include "../multigrid/coarse_part.hpp"
#include "../multigrid/hierarchy.hpp"
#include "../multigrid/vector_operations.hpp"
#include "checks.hpp"

namespace tilth::bind {

namespace {

using multigrid::CoarsePart;
using multigrid::Hierarchy;

template <class T>
using Numpy = nb::ndarray<nb::numpy, T>;

constexpr const char* outside_of_matrix = "has an index outside of the matrix";

/// Returns the number of rows of a square pattern. The kernels check its columns, row by row: a
/// pass of its own over them would take a good part of the time of a product.
std::int64_t require_rows(const ConstIntegers& row_start, const ConstShorts& column) {
  return require_starts(row_start, size_of(column), "row_start");
}

void require_blocks(const ConstDoubles& blocks, const ConstShorts& column, int components) {
  require(components >= 1 && components <= 3, "components", "is not 1, 2 or 3");
  require_size(blocks, size_of(column) * components * components, "blocks");
}

/// Refuses lattice indices that are not sorted along z, y, x, in the plane beyond z = 0, or so far
/// apart that the table of their lines has no room.
void require_sorted_lattice(const ConstIntegers& lattice, std::int64_t nodes, int dim) {
  constexpr std::int64_t lines_per_node = 128, least_lines = 1 << 16;
  require_table(lattice, nodes, 3, "lattice");
  require_lattice(lattice, "lattice");
  const std::int64_t* index = lattice.data();
  bool sorted = true, in_plane = true;
  std::int64_t low[3] = {}, high[3] = {};
  for (std::int64_t v = 0; v < nodes; ++v) {
    const std::int64_t* own = index + 3 * v;
    for (int k = 0; k < 3; ++k) {
      low[k] = v == 0 ? own[k] : std::min(low[k], own[k]);
      high[k] = v == 0 ? own[k] : std::max(high[k], own[k]);
    }
    sorted &= v == 0 || pack({own[-3], own[-2], own[-1]}) < pack({own[0], own[1], own[2]});
    in_plane &= own[2] == 0;
  }
  require(sorted, "lattice", "is not sorted along z, y, x, or has a node twice");
  require(dim == 3 || in_plane, "lattice", "has nodes beyond the plane z = 0");
  require((high[1] - low[1] + 1) * (high[2] - low[2] + 1) <=
              std::max(least_lines, lines_per_node * nodes),
          "lattice", "has nodes that are too far apart");
}

/// Refuses a pattern whose rows are not sorted, lack the diagonal block if they need one, or couple
/// distant nodes.
void require_couplings(const ConstIntegers& lattice, const ConstIntegers& row_start,
                       const ConstShorts& column, std::int64_t nodes, bool needs_diagonal) {
  constexpr std::int64_t farthest = 4096;  // in cells; the work grows with its third power
  require_indices(column, nodes, "column");
  bool sorted = true, diagonal = true, near = true;
  for (std::int64_t v = 0; v < nodes; ++v) {
    bool own = false;
    for (std::int64_t e = row_start.data()[v]; e < row_start.data()[v + 1]; ++e) {
      const std::int64_t w = column.data()[e];
      sorted &= e == row_start.data()[v] || column.data()[e - 1] < w;
      own |= w == v;
      for (int k = 0; k < 3; ++k)
        near &= std::abs(lattice.data()[3 * w + k] - lattice.data()[3 * v + k]) <= farthest;
    }
    diagonal &= own || !needs_diagonal;
  }
  require(sorted, "column", "is not sorted within a row");
  require(diagonal, "column", "lacks the diagonal block of a row");
  require(near, "column", "couples nodes that are too far apart");
}

/// Returns a `Kind` of this dimension and number of components on checked lattice and pattern.
template <class Interface, template <int, int> class Kind, class... Flags>
std::unique_ptr<Interface> make(int dim, int components, const ConstIntegers& lattice,
                                const ConstIntegers& row_start, const ConstShorts& column,
                                bool needs_diagonal, const Flags*... flags) {
  const std::int64_t nodes = require_rows(row_start, column);
  require_sorted_lattice(lattice, nodes, dim);
  require_couplings(lattice, row_start, column, nodes, needs_diagonal);
  std::vector<multigrid::LatticeIndex> index(nodes);
  for (std::int64_t v = 0; v < nodes; ++v)
    for (int k = 0; k < 3; ++k) index[v][k] = static_cast<std::int32_t>(lattice.data()[3 * v + k]);
  std::vector<std::int64_t> starts(row_start.data(), row_start.data() + nodes + 1);
  std::vector<std::int32_t> columns(column.data(), column.data() + column.size());
  nb::gil_scoped_release release;
  return with_components(components, [&](auto count) -> std::unique_ptr<Interface> {
    const auto of = [&]<int Dim>() {
      return std::make_unique<Kind<Dim, count()>>(std::move(index), std::move(starts),
                                                  std::move(columns), flags...);
    };
    if (dim == 2) return of.template operator()<2>();
    return of.template operator()<3>();
  });
}

/// Refuses what no grid has; returns the number of nodes.
std::int64_t require_kind(int dim, int components, const ConstIntegers& row_start,
                          const ConstShorts& column, const ConstFlags& constrained) {
  const std::int64_t nodes = require_rows(row_start, column);
  require(dim == 2 || dim == 3, "dim", "is not 2 or 3");
  require(components >= 1 && components <= 3, "components", "is not 1, 2 or 3");
  require_size(constrained, nodes * components, "constrained");
  return nodes;
}

std::unique_ptr<Hierarchy> make_hierarchy(int dim, int components, ConstIntegers lattice,
                                          ConstIntegers row_start, ConstShorts column,
                                          ConstFlags constrained) {
  require_kind(dim, components, row_start, column, constrained);
  return make<Hierarchy, multigrid::HierarchyOf>(dim, components, lattice, row_start, column, true,
                                                 constrained.data());
}

std::unique_ptr<CoarsePart> make_coarse_part(int dim, int components, ConstIntegers lattice,
                                             ConstIntegers row_start, ConstShorts column,
                                             ConstFlags constrained, ConstFlags chosen) {
  const std::int64_t nodes = require_kind(dim, components, row_start, column, constrained);
  require_size(chosen, nodes, "chosen");
  return make<CoarsePart, multigrid::CoarsePartOf>(dim, components, lattice, row_start, column,
                                                   false, constrained.data(), chosen.data());
}

std::tuple<Numpy<std::int64_t>, Numpy<std::int64_t>, Numpy<std::int32_t>> pattern(
    const CoarsePart& part) {
  const std::int64_t nodes = part.lattice().nodes();
  std::vector<std::int64_t> lattice;
  for (std::int64_t v = 0; v < nodes; ++v)
    lattice.insert(lattice.end(), part.lattice()[v].begin(), part.lattice()[v].end());
  std::vector<std::int64_t> row_start = part.row_start();
  std::vector<std::int32_t> column = part.column();
  return {give(std::move(lattice), {static_cast<std::size_t>(nodes), 3}),
          give(std::move(row_start)), give(std::move(column))};
}

Numpy<double> coarse_blocks(CoarsePart& part, ConstDoubles blocks) {
  require_size(blocks, part.numbers(), "blocks");
  const std::size_t entries = part.column().size();
  const auto side = static_cast<std::size_t>(part.components());
  std::vector<double> coarse(entries * side * side);
  {
    nb::gil_scoped_release release;
    part.blocks(blocks.data(), coarse.data());
  }
  return give(std::move(coarse), {entries, side, side});
}

/// Returns nodal values (nodes, components) that `compute` fills.
template <class Compute>
Numpy<double> nodal(std::int64_t unknowns, std::int64_t components, Compute compute) {
  std::vector<double> values(unknowns);
  {
    nb::gil_scoped_release release;
    compute(values.data());
  }
  return give(std::move(values), {static_cast<std::size_t>(unknowns / components),
                                  static_cast<std::size_t>(components)});
}

Numpy<double> restricted(const CoarsePart& part, ConstDoubles fine) {
  require_size(fine, part.unknowns(), "fine");
  return nodal(part.coarse_unknowns(), part.components(),
               [&](double* coarse) { part.restricted(fine.data(), coarse); });
}

Numpy<double> interpolated(const CoarsePart& part, ConstDoubles coarse) {
  require_size(coarse, part.coarse_unknowns(), "coarse");
  return nodal(part.unknowns(), part.components(),
               [&](double* fine) { part.interpolated(coarse.data(), fine); });
}

void fill(Hierarchy& hierarchy, ConstDoubles blocks) {
  require_size(blocks, hierarchy.numbers(), "blocks");
  nb::gil_scoped_release release;
  hierarchy.fill(blocks.data());
}

void cycle(Hierarchy& hierarchy, ConstDoubles residual, Doubles approximate) {
  require(hierarchy.filled(), "Multigrid", "has no matrix: call fill first");
  require_size(residual, hierarchy.unknowns(), "residual");
  require_size(approximate, hierarchy.unknowns(), "approximate");
  nb::gil_scoped_release release;
  hierarchy.cycle(residual.data(), approximate.data());
}

void block_product(int components, ConstIntegers row_start, ConstShorts column, ConstDoubles blocks,
                   ConstFlags constrained, ConstDoubles x, Doubles product) {
  const std::int64_t nodes = require_rows(row_start, column);
  require_blocks(blocks, column, components);
  require_size(constrained, nodes * components, "constrained");
  require_size(x, nodes * components, "x");
  require_size(product, nodes * components, "product");
  nb::gil_scoped_release release;
  const bool inside = with_components(components, [&](auto count) {
    return multigrid::block_product<count(), 1>(nodes, row_start.data(), column.data(),
                                                blocks.data(), constrained.data(), {x.data()},
                                                {product.data()});
  });
  require(inside, "column", outside_of_matrix);
}

std::array<double, 3> asymmetry(int components, ConstIntegers row_start, ConstShorts column,
                                ConstDoubles blocks, ConstFlags constrained, ConstDoubles u,
                                ConstDoubles v) {
  const std::int64_t nodes = require_rows(row_start, column);
  require_blocks(blocks, column, components);
  require_size(constrained, nodes * components, "constrained");
  require_size(u, nodes * components, "u");
  require_size(v, nodes * components, "v");
  nb::gil_scoped_release release;
  const auto sums = with_components(components, [&](auto count) {
    return multigrid::asymmetry<count()>(nodes, row_start.data(), column.data(), blocks.data(),
                                         constrained.data(), u.data(), v.data());
  });
  require(sums.has_value(), "column", outside_of_matrix);
  return *sums;
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
      .def(nb::new_(&make_hierarchy), "dim"_a, "components"_a, "lattice"_a, "row_start"_a,
           "column"_a, "constrained"_a)
      .def("begin", &Hierarchy::begin,
           "Discards all matrices; later results are identical to those of a new object.")
      .def("fill", &fill, "blocks"_a, "Sets the values of the matrix.")
      .def("cycle", &cycle, "residual"_a, "approximate"_a,
           "Fills `approximate` with one V-cycle for `residual`.")
      .def("sizes", &Hierarchy::sizes, "Nodes and blocks of each level, the finest first.")
      .def("bytes", &Hierarchy::bytes, "Memory of all levels [byte].");
  nb::class_<CoarsePart>(module, "CoarsePart",
                         "What chosen rows of a matrix give to that of the next coarser level.")
      .def(nb::new_(&make_coarse_part), "dim"_a, "components"_a, "lattice"_a, "row_start"_a,
           "column"_a, "constrained"_a, "chosen"_a)
      .def("pattern", &pattern, "Lattice indices (n, 3), row starts and columns of that level.")
      .def("blocks", &coarse_blocks, "blocks"_a, "Returns its blocks, from those of the matrix.")
      .def("restricted", &restricted, "fine"_a,
           "Returns what the chosen rows of a residual give, (coarse nodes, components).")
      .def("interpolated", &interpolated, "coarse"_a,
           "Returns interpolated values, zero where constrained, (nodes, components).");
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
