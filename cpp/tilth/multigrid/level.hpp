// SPDX-License-Identifier: BSD-3-Clause
// One level of the hierarchy: its matrix and vectors in single precision.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "lattice.hpp"
#include "strips.hpp"

namespace tilth::multigrid {

/// The matrix of the finest level: node blocks (entries, Components, Components), with their scale
/// and mask. Rows are converted to single precision on demand: a copy would take half as much
/// memory as the matrix.
struct Source {
  const double* blocks = nullptr;  // null except during `fill`, and on coarser levels
  double scale = 1.0;
  std::vector<char> masked;  // rows with a constrained unknown, their own or a neighbour's
};

/// Rows of node blocks, (entries, Components, Components), from which coarse matrices and diagonal
/// blocks are made, and the same coefficients in strips, for products.
template <int Components>
struct Level {
  explicit Level(Lattice of)
      : lattice(std::move(of)),
        inverse(nodes()),
        mask(nodes(), 1.0f),
        right(nodes()),
        solution(nodes()),
        correction(nodes()),
        residual(nodes()),
        other(nodes()),
        eigenvector(nodes()) {}

  /// Sets the pattern, which must contain the diagonal blocks. The finest level has no `value`.
  void set_pattern(std::vector<std::int64_t> starts, std::vector<std::int32_t> columns) {
    row_start = std::move(starts), column = std::move(columns);
    diagonal.resize(nodes());
    for (std::int32_t v = 0; v < nodes(); ++v)
      for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e)
        if (column[e] == v) diagonal[v] = static_cast<std::int32_t>(e - row_start[v]);
    strips.set_pattern(row_start, column);
  }

  std::int32_t nodes() const { return lattice.nodes(); }
  std::int64_t unknowns() const { return std::int64_t{nodes()} * Components; }
  std::int64_t entries(std::int32_t v) const { return row_start[v + 1] - row_start[v]; }
  bool threaded() const { return row_start.back() >= 8 * parallel_from; }

  float at(std::int32_t v, std::int64_t entry, int i, int j) const {
    const std::int64_t index = ((row_start[v] + entry) * Components + i) * Components + j;
    if (source.blocks == nullptr) return value[index];
    const float number = static_cast<float>(source.scale * source.blocks[index]);
    return number * mask[i][v] * mask[j][column[row_start[v] + entry]];
  }

  /// The blocks of a row; they are in `buffer` if the level does not store them.
  const float* row(std::int32_t v, Floats& buffer) const {
    constexpr int size = Components * Components;
    if (source.blocks == nullptr) return value.data() + row_start[v] * size;
    const double* in = source.blocks + row_start[v] * size;
    const std::int64_t count = entries(v);
    if (static_cast<std::int64_t>(buffer.size()) < count * size) buffer.resize(count * size);
    float* out = buffer.data();
    for (std::int64_t k = 0; k < count * size; ++k)
      out[k] = static_cast<float>(source.scale * in[k]);
    for (std::int64_t e = 0; source.masked[v] && e < count; ++e) {
      const std::int32_t other = column[row_start[v] + e];
      for (int i = 0; i < Components; ++i)
        for (int j = 0; j < Components; ++j)
          out[e * size + i * Components + j] *= mask[i][v] * mask[j][other];
    }
    return out;
  }

  std::int64_t bytes() const {
    return lattice.bytes() + strips.bytes() + inverse.bytes() + mask.bytes() + right.bytes() +
           solution.bytes() + correction.bytes() + residual.bytes() + other.bytes() +
           eigenvector.bytes() +
           bytes_of(row_start, column, diagonal, value, has_own_block, shared_start, shared_node,
                    shared_inverse, parent_start, child_start, parent, child, parent_weight,
                    child_weight);
  }

  Lattice lattice;
  std::vector<std::int64_t> row_start;
  std::vector<std::int32_t> column, diagonal;  // diagonal: which entry of the row it is
  Floats value;
  Source source;
  Strips<Components> strips;
  Field<Components * Components> inverse;  // of the diagonal blocks, zero for constrained unknowns
  std::vector<char> has_own_block;         // whether a node shares no block
  std::vector<std::int64_t> shared_start;  // the other blocks: their nodes, and inverses
  std::vector<std::int32_t> shared_node;
  Floats shared_inverse;
  Field<Components> mask;  // 1 free, 0 constrained
  Field<Components> right, solution, correction, residual, other, eigenvector;
  bool by_rows = false;  // how the next coarser matrix is made
  float largest = 1.0f;  // bound of the eigenvalues of inverse * matrix

  // to the next coarser level: a node's parents, and a parent's nodes, with their weights
  std::vector<std::int64_t> parent_start, child_start;
  std::vector<std::int32_t> parent, child;
  std::vector<float> parent_weight, child_weight;
};

}  // namespace tilth::multigrid
