// SPDX-License-Identifier: BSD-3-Clause
// One level of the hierarchy: its matrix and vectors in single precision.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "lattice.hpp"
#include "strips.hpp"

namespace tilth::multigrid {

/// Rows of node blocks, (entries, Dim, Dim), from which coarse matrices and diagonal blocks are
/// made, and the same coefficients in strips, for products.
template <int Dim>
struct Level {
  explicit Level(Lattice of)
      : lattice(std::move(of)),
        inverse(nodes()),
        mask(nodes(), 1.0f),
        right(nodes()),
        solution(nodes()),
        change(nodes()),
        residual(nodes()),
        other(nodes()),
        eigenvector(nodes()) {}

  /// Takes the pattern; diagonal blocks must be in it.
  void set_pattern(std::vector<std::int64_t> starts, std::vector<std::int32_t> columns) {
    row_start = std::move(starts), column = std::move(columns);
    diagonal.resize(nodes());
    for (std::int32_t v = 0; v < nodes(); ++v)
      for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e)
        if (column[e] == v) diagonal[v] = static_cast<std::int32_t>(e - row_start[v]);
    value.assign(column.size() * Dim * Dim, 0.0f);
    strips.set_pattern(row_start, column);
  }

  std::int32_t nodes() const { return lattice.nodes(); }
  std::int64_t unknowns() const { return std::int64_t{nodes()} * Dim; }
  std::int64_t entries(std::int32_t v) const { return row_start[v + 1] - row_start[v]; }
  bool threaded() const { return row_start.back() >= 8 * parallel_from; }

  float at(std::int32_t v, std::int64_t entry, int i, int j) const {
    return value[((row_start[v] + entry) * Dim + i) * Dim + j];
  }

  Lattice lattice;
  std::vector<std::int64_t> row_start;
  std::vector<std::int32_t> column, diagonal;  // diagonal: which entry of the row it is
  Floats value;
  Strips<Dim> strips;
  Field<Dim * Dim> inverse;  // of the diagonal blocks, zero for unknowns that are held
  std::vector<char> alone;   // whether a node has a block of its own
  std::vector<std::int64_t> shared_start;  // the other blocks: their nodes, and inverses
  std::vector<std::int32_t> shared_node;
  Floats shared_inverse;
  Field<Dim> mask;  // 1 free, 0 held
  Field<Dim> right, solution, change, residual, other, eigenvector;
  float largest = 1.0f;  // bound of the eigenvalues of inverse * matrix

  // to the next coarser level: a node's parents, and a parent's nodes, with their weights
  std::vector<std::int64_t> parent_start, child_start;
  std::vector<std::int32_t> parent, child;
  std::vector<float> parent_weight, child_weight;
};

}  // namespace tilth::multigrid
