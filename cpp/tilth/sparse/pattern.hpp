// SPDX-License-Identifier: BSD-3-Clause
// Pattern of the node-block matrix: every pair of nodes that share a group, and the positions of
// each group's blocks in it, for any number of neighbours.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "../caught.hpp"
#include "../parallel.hpp"

namespace tilth::sparse {

/// Groups of nodes: `node_start` (groups + 1), `node` their node numbers.
struct NodeGroups {
  std::int64_t groups;
  const std::int64_t* node_start;
  const std::int32_t* node;
};

struct Pattern {
  std::vector<std::int64_t> row_start;  // (nodes + 1)
  std::vector<std::int32_t> column;     // sorted within a row
};

inline Pattern block_pattern(std::int64_t nodes, const NodeGroups& groups) {
  std::vector<std::int64_t> first(nodes + 1, 0);  // groups of each node, by counting sort
  const std::int64_t entries = groups.node_start[groups.groups];
  for (std::int64_t e = 0; e < entries; ++e) ++first[groups.node[e] + 1];
  for (std::int64_t v = 0; v < nodes; ++v) first[v + 1] += first[v];
  std::vector<std::int64_t> group_of(entries), fill(first.begin(), first.end() - 1);
  for (std::int64_t g = 0; g < groups.groups; ++g)
    for (std::int64_t e = groups.node_start[g]; e < groups.node_start[g + 1]; ++e)
      group_of[fill[groups.node[e]]++] = g;

  Pattern pattern;
  pattern.row_start.resize(nodes + 1, 0);
  std::vector<std::vector<std::int32_t>> columns_of(omp_get_max_threads());
  Caught caught;
#pragma omp parallel if (8 * nodes >= parallel_from)
  {
    auto& columns = columns_of[omp_get_thread_num()];  // of a contiguous range of rows
    std::vector<std::int64_t> seen;
    caught.run([&] { seen.assign(nodes, -1); });
    std::int64_t first_row = nodes;
#pragma omp for schedule(static)
    for (std::int64_t v = 0; v < nodes; ++v)
      caught.run([&] {
        first_row = std::min(first_row, v);
        const auto row = static_cast<std::ptrdiff_t>(columns.size());
        for (std::int64_t e = first[v]; e < first[v + 1]; ++e) {
          const std::int64_t g = group_of[e];
          for (std::int64_t k = groups.node_start[g]; k < groups.node_start[g + 1]; ++k) {
            const std::int32_t w = groups.node[k];
            if (seen[w] == v) continue;
            seen[w] = v;
            columns.push_back(w);
          }
        }
        std::sort(columns.begin() + row, columns.end());
        pattern.row_start[v + 1] = static_cast<std::int64_t>(columns.size()) - row;
      });
#pragma omp single
    caught.run([&] {
      for (std::int64_t v = 0; v < nodes; ++v) pattern.row_start[v + 1] += pattern.row_start[v];
      pattern.column.resize(pattern.row_start[nodes]);
    });
    caught.run([&] {
      if (first_row < nodes)
        std::copy(columns.begin(), columns.end(),
                  pattern.column.begin() + pattern.row_start[first_row]);
    });
  }
  caught.rethrow();
  return pattern;
}

/// Positions of a group's blocks: per row node one entry for each run of consecutive columns.
struct Positions {
  std::vector<std::int64_t> start;  // (groups)
  std::vector<std::int32_t> position;
};

/// Throws std::invalid_argument if two nodes of a group have no block.
inline Positions block_positions(const NodeGroups& groups, const std::int64_t* row_start,
                                 const std::int32_t* column) {
  Positions result;
  result.start.resize(groups.groups);
  std::int64_t total = 0;
  for (std::int64_t g = 0; g < groups.groups; ++g) {
    const std::int64_t begin = groups.node_start[g], end = groups.node_start[g + 1];
    std::int64_t runs = 1;
    for (std::int64_t e = begin + 1; e < end; ++e) runs += groups.node[e] != groups.node[e - 1] + 1;
    result.start[g] = total;
    total += runs * (end - begin);
  }
  result.position.resize(total);
  bool missing = false;
#pragma omp parallel for schedule(static) \
    reduction(|| : missing) if (8 * groups.groups >= parallel_from)
  for (std::int64_t g = 0; g < groups.groups; ++g) {
    std::int32_t* out = result.position.data() + result.start[g];
    const std::int64_t begin = groups.node_start[g], end = groups.node_start[g + 1];
    for (std::int64_t a = begin; a < end; ++a) {
      const std::int32_t* row = column + row_start[groups.node[a]];
      const std::int32_t* row_end = column + row_start[groups.node[a] + 1];
      const std::int32_t* found = nullptr;
      for (std::int64_t b = begin; b < end; ++b) {
        if (b > begin && groups.node[b] == groups.node[b - 1] + 1) {
          found += found != row_end;
        } else {
          found = std::lower_bound(row, row_end, groups.node[b]);
          *out++ = static_cast<std::int32_t>(found - column);
        }
        missing = missing || found == row_end || *found != groups.node[b];
      }
    }
  }
  if (missing) throw std::invalid_argument("column lacks a pair of nodes of a group");
  return result;
}

}  // namespace tilth::sparse
