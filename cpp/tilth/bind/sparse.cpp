// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/array.h>
#include <nanobind/stl/unique_ptr.h>

#include <memory>

#include "../sparse/band.hpp"
#include "../sparse/graph.hpp"
#include "../sparse/nested_dissection.hpp"
#include "../sparse/pattern.hpp"
#include "../sparse/projection.hpp"
#include "../sparse/restriction.hpp"
#include "checks.hpp"

namespace tilth::bind {

namespace {

sparse::NodeGroups view(const ConstIntegers& node_start, const ConstShorts& node,
                        std::int64_t nodes) {
  const std::int64_t groups = require_starts(node_start, size_of(node), "node_start");
  require_indices(node, nodes, "node");
  return {groups, node_start.data(), node.data()};
}

/// Returns the number of rows of a square pattern.
std::int64_t require_pattern(const ConstIntegers& row_start, const ConstShorts& column) {
  const std::int64_t rows = require_starts(row_start, size_of(column), "row_start");
  require_indices(column, rows, "column");
  return rows;
}

auto block_pattern(std::int64_t nodes, ConstIntegers node_start, ConstShorts node) {
  require(nodes >= 0 && nodes <= size_of(node), "nodes",
          "is negative or more than the entries of node: a node belongs to a group");
  auto pattern = sparse::block_pattern(nodes, view(node_start, node, nodes));
  return std::make_tuple(give(std::move(pattern.row_start)), give(std::move(pattern.column)));
}

auto block_positions(ConstIntegers node_start, ConstShorts node, ConstIntegers row_start,
                     ConstShorts column) {
  const std::int64_t rows = require_pattern(row_start, column);
  auto positions =
      sparse::block_positions(view(node_start, node, rows), row_start.data(), column.data());
  return std::make_tuple(give(std::move(positions.start)), give(std::move(positions.position)));
}

auto nested_dissection(ConstIntegers lattice, int coupling_distance) {
  const std::int64_t nodes = require_lattice(lattice, "lattice");
  require(coupling_distance >= 0, "coupling_distance", "is negative");
  const sparse::NestedDissection dissection(nodes, lattice.data(), coupling_distance);
  return give(std::vector<std::int64_t>(dissection.order()));
}

auto restrict_to_free(int components, ConstIntegers row_start, ConstShorts column,
                      ConstIntegers order, ConstFlags constrained) {
  const std::int64_t nodes = require_pattern(row_start, column);
  require(components >= 1 && components <= 3, "components", "is not 1, 2 or 3");
  require_size(order, nodes, "order");
  require_indices(order, nodes, "order");
  require_size(constrained, nodes * components, "constrained");
  auto result = sparse::restrict_to_free(nodes, components, row_start.data(), column.data(),
                                         order.data(), constrained.data());
  return std::make_tuple(give(std::move(result.unknown)), give(std::move(result.start)),
                         give(std::move(result.row)), give(std::move(result.source)));
}

void gather(ConstIntegers source, ConstDoubles block, Doubles value) {
  require_size(value, size_of(source), "value");
  nb::gil_scoped_release release;
  require(
      sparse::gather(size_of(source), source.data(), size_of(block), block.data(), value.data()),
      "source", "has an index outside of block");
}

auto connected_parts(ConstIntegers row_start, ConstShorts column) {
  const std::int64_t nodes = require_pattern(row_start, column);
  return give(sparse::Graph(nodes, row_start.data(), column.data()).parts());
}

using sparse::BandFactors;

std::unique_ptr<BandFactors> make(ConstShorts start, ConstShorts row) {
  const std::int64_t size = require_starts(start, size_of(row), "start");
  require_indices(row, size, "row");
  return std::make_unique<BandFactors>(size, start.data(), row.data());
}

bool factorise(BandFactors& factors, ConstDoubles value) {
  require_size(value, factors.entries(), "value");
  nb::gil_scoped_release release;
  return factors.factorise(value.data());
}

void solve(const BandFactors& factors, ConstDoubles right, Doubles solution) {
  require(factors.factorised(), "BandFactors", "has no factors: call factorise first");
  require_size(right, factors.size(), "right");
  require_size(solution, factors.size(), "solution");
  nb::gil_scoped_release release;
  factors.solve(right.data(), solution.data());
}

void column_product(ConstShorts start, ConstShorts row, ConstDoubles value, ConstDoubles x,
                    Doubles product) {
  const std::int64_t size = require_starts(start, size_of(row), "start");
  require_indices(row, size, "row");
  require_size(value, size_of(row), "value");
  require_size(x, size, "x");
  require_size(product, size, "product");
  nb::gil_scoped_release release;
  sparse::column_product(size, start.data(), row.data(), value.data(), x.data(), product.data());
}

sparse::SymmetricMatrix symmetric(const ConstIntegers& row_start, const ConstShorts& column,
                                  const ConstDoubles& value) {
  const std::int64_t rows = require_pattern(row_start, column);
  require_size(value, size_of(column), "value");
  return {rows, row_start.data(), column.data(), value.data()};
}

bool project(ConstIntegers row_start, ConstShorts column, ConstDoubles value, double shift,
             ConstFlags known, double tolerance, int limit, ConstDoubles scale, Doubles right) {
  const auto matrix = symmetric(row_start, column, value);
  require(matrix.rows > 0, "row_start", "has no rows");
  const std::int64_t columns = size_of(right) / matrix.rows;
  require(columns == 4 || columns == 8 || columns == 12, "right", "has not 4, 8 or 12 columns");
  require_size(right, matrix.rows * columns, "right");
  require_size(known, matrix.rows * columns, "known");
  require_size(scale, matrix.rows * columns, "scale");
  nb::gil_scoped_release release;
  const auto solve = [&]<int Width>() {
    return sparse::Projection<Width>(matrix, shift, known.data())
        .solve(tolerance, limit, scale.data(), right.data());
  };
  if (columns == 4) return solve.template operator()<1>();
  return columns == 8 ? solve.template operator()<2>() : solve.template operator()<3>();
}

void symmetric_product(ConstIntegers row_start, ConstShorts column, ConstDoubles value,
                       ConstDoubles x, Doubles product) {
  const auto matrix = symmetric(row_start, column, value);
  const int columns = matrix.rows > 0 ? static_cast<int>(size_of(x) / matrix.rows) : 0;
  require(columns == 2 || columns == 3, "x", "has not 2 or 3 columns");
  require_size(x, matrix.rows * columns, "x");
  require_size(product, matrix.rows * columns, "product");
  nb::gil_scoped_release release;
  const auto multiply =
      columns == 2 ? &sparse::symmetric_product<2> : &sparse::symmetric_product<3>;
  multiply(matrix, x.data(), product.data());
}

}  // namespace

void bind_sparse(nb::module_& module) {
  using namespace nb::literals;
  module.def("block_pattern", &block_pattern, "nodes"_a, "node_start"_a, "node"_a,
             "Rows and sorted columns of all pairs of nodes that share a group.");
  module.def("block_positions", &block_positions, "node_start"_a, "node"_a, "row_start"_a,
             "column"_a, "Positions of each group's blocks in the pattern.");
  module.def("restrict_to_free", &restrict_to_free, "components"_a, "row_start"_a, "column"_a,
             "order"_a, "constrained"_a,
             "Matrix of the free unknowns: unknown, column starts, rows, indices in the blocks.");
  module.def("gather", &gather, "source"_a, "block"_a, "value"_a,
             "Fills value[i] = block[source[i]].");
  module.def("nested_dissection", &nested_dissection, "lattice"_a, "coupling_distance"_a,
             "Node numbers in a fill-reducing order of elimination.");
  module.def("connected_parts", &connected_parts, "row_start"_a, "column"_a,
             "Number of the connected component of each row of a symmetric pattern.");
  module.def(
      "project", &project, "row_start"_a, "column"_a, "value"_a, "shift"_a, "known"_a,
      "tolerance"_a, "limit"_a, "scale"_a, "right"_a,
      "Replaces right sides (rows, 4, 8 or 12) by the solutions for a symmetric matrix, zero "
      "where known; returns whether conjugate gradients converged to the tolerance times scale.");
  module.def("symmetric_product", &symmetric_product, "row_start"_a, "column"_a, "value"_a, "x"_a,
             "product"_a, "Fills the product of a matrix with 2 or 3 columns x.");
  module.def("column_product", &column_product, "start"_a, "row"_a, "value"_a, "x"_a, "product"_a,
             "Fills the product A x of a square matrix in compressed columns.");
  nb::class_<BandFactors>(module, "BandFactors",
                          "LU factors of matrices in compressed columns; pattern fixed.")
      .def(nb::new_(&make), "start"_a, "row"_a)
      .def("widths", &BandFactors::widths,
           "Widths of the factors' band below and above the diagonal.")
      .def("factorise", &factorise, "value"_a,
           "Factorises a matrix with these values; returns whether no pivot is zero.")
      .def("solve", &solve, "right"_a, "solution"_a, "Fills the solution for one right side.");
}

}  // namespace tilth::bind
