// SPDX-License-Identifier: BSD-3-Clause
// The matrix of the free unknowns in compressed columns, in a given order of the nodes: its
// structure, and for each entry the index of its value in the node-block matrix. Found once a
// step; every Newton iteration only gathers values.
#pragma once

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "../caught.hpp"
#include "../indices.hpp"
#include "../parallel.hpp"

namespace tilth::sparse {

struct Restriction {
  std::vector<std::int64_t> unknown;  // (free) node * components + component of each column
  std::vector<std::int32_t> start;    // (free + 1)
  std::vector<std::int32_t> row;      // sorted within a column
  std::vector<std::int64_t> source;   // of each entry, in the array of blocks
};

/// `order` lists all nodes; `constrained` (nodes * components) marks what is prescribed. The
/// pattern must be symmetric with sorted rows, as that of block_pattern is.
///
/// Throws std::invalid_argument if it is not, or if `order` lists a node twice.
inline Restriction restrict_to_free(std::int64_t nodes, int components,
                                    const std::int64_t* row_start, const std::int32_t* column,
                                    const std::int64_t* order, const bool* constrained) {
  // the block (w, v) of each block (v, w): rows are visited in order, columns are sorted
  std::vector<std::int64_t> transposed(row_start[nodes]), next(row_start, row_start + nodes);
  for (std::int64_t v = 0; v < nodes; ++v)
    for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e) {
      const std::int32_t w = column[e];
      if (next[w] == row_start[w + 1] || column[next[w]] != v)
        throw std::invalid_argument("column is not symmetric, or not sorted within a row");
      transposed[next[w]++] = e;
    }

  Restriction result;
  std::vector<std::int32_t> first(nodes), free(nodes), rank(nodes, -1);
  for (std::int64_t k = 0; k < nodes; ++k) {
    const std::int64_t v = order[k];
    if (rank[v] >= 0) throw std::invalid_argument("order lists a node twice");
    rank[v] = static_cast<std::int32_t>(k);
    first[v] = static_cast<std::int32_t>(result.unknown.size());
    for (int i = 0; i < components; ++i)
      if (!constrained[v * components + i]) result.unknown.push_back(v * components + i);
    free[v] = static_cast<std::int32_t>(result.unknown.size()) - first[v];
  }
  result.start.assign(result.unknown.size() + 1, 0);
  for (std::int64_t v = 0; v < nodes; ++v) {
    std::int32_t rows = 0;
    for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e) rows += free[column[e]];
    for (std::int32_t k = 0; k < free[v]; ++k) result.start[first[v] + k + 1] = rows;
  }
  for (std::size_t c = 0; c < result.unknown.size(); ++c) result.start[c + 1] += result.start[c];
  result.row.resize(result.start.back());
  result.source.resize(result.start.back());

  Caught caught;
#pragma omp parallel if (8 * nodes >= parallel_from)
  {
    std::vector<std::int64_t> block;
#pragma omp for schedule(static)
    for (std::int64_t v = 0; v < nodes; ++v)
      caught.run([&] {
        block.resize(row_start[v + 1] - row_start[v]);
        for (std::size_t i = 0; i < block.size(); ++i)
          block[i] = row_start[v] + static_cast<std::int64_t>(i);
        std::sort(block.begin(), block.end(), [&](std::int64_t a, std::int64_t b) {
          return rank[column[a]] < rank[column[b]];
        });
        for (std::int32_t k = 0; k < free[v]; ++k) {
          const std::int64_t component = result.unknown[first[v] + k] - v * components;
          std::int32_t at = result.start[first[v] + k];
          for (const std::int64_t e : block) {
            const std::int32_t w = column[e];
            for (std::int32_t i = 0; i < free[w]; ++i, ++at) {
              const std::int64_t row_component =
                  result.unknown[first[w] + i] - std::int64_t{w} * components;
              result.row[at] = first[w] + i;
              result.source[at] =
                  (transposed[e] * components + row_component) * components + component;
            }
          }
        }
      });
  }
  caught.rethrow();
  return result;
}

/// value[i] = block[source[i]]; returns whether all indices are below `blocks`, the size of
/// `block`.
inline bool gather(std::int64_t entries, const std::int64_t* source, std::int64_t blocks,
                   const double* block, double* value) {
  constexpr std::int64_t piece = 512;  // its indices are in the cache when they are used
  bool outside = false;
#pragma omp parallel for schedule(static) reduction(|| : outside) if (entries >= 8 * parallel_from)
  for (std::int64_t begin = 0; begin < entries; begin += piece) {
    const std::int64_t end = std::min(begin + piece, entries);
    if (!all_below(source + begin, end - begin, blocks)) {
      outside = true;
      continue;
    }
    for (std::int64_t i = begin; i < end; ++i) value[i] = block[source[i]];
  }
  return !outside;
}

}  // namespace tilth::sparse
