// SPDX-License-Identifier: BSD-3-Clause
// The coarse matrix P^T A P of levels whose nodes are far apart in the lattice, as those of graded
// grids are: row by row, where galerkin.hpp would need large boxes.
#pragma once

#include <algorithm>

#include "../caught.hpp"
#include "level.hpp"

namespace tilth::multigrid {

/// Finds the pattern of the coarse matrix.
template <int Components>
void set_coarse_pattern_by_rows(const Level<Components>& fine, Level<Components>& coarse) {
  const std::int64_t n = coarse.nodes();
  std::vector<std::vector<std::int32_t>> row(n);
  Caught caught;
#pragma omp parallel if (fine.threaded())
  {
    std::vector<std::int32_t> last;  // row in which a coarse node was found last
    caught.run([&] { last.assign(n, -1); });
#pragma omp for schedule(static)
    for (std::int32_t c = 0; c < n; ++c)
      caught.run([&] {
        for (std::int64_t k = fine.child_start[c]; k < fine.child_start[c + 1]; ++k)
          for (std::int64_t e = fine.row_start[fine.child[k]];
               e < fine.row_start[fine.child[k] + 1]; ++e)
            for (std::int64_t p = fine.parent_start[fine.column[e]];
                 p < fine.parent_start[fine.column[e] + 1]; ++p)
              if (last[fine.parent[p]] != c)
                last[fine.parent[p]] = c, row[c].push_back(fine.parent[p]);
        std::sort(row[c].begin(), row[c].end());
      });
  }
  caught.rethrow();
  std::vector<std::int64_t> start(n + 1, 0);
  std::vector<std::int32_t> column;
  for (std::int64_t c = 0; c < n; ++c) {
    column.insert(column.end(), row[c].begin(), row[c].end());
    start[c + 1] = static_cast<std::int64_t>(column.size());
  }
  coarse.set_pattern(std::move(start), std::move(column));
  coarse.value.assign(coarse.column.size() * Components * Components, 0.0f);
}

/// Fills the values of the coarse matrix.
template <int Components>
void fill_coarse_matrix_by_rows(const Level<Components>& fine, Level<Components>& coarse) {
  constexpr int size = Components * Components;
  Caught caught;
#pragma omp parallel if (fine.threaded())
  {
    std::vector<std::int64_t> at;  // entry of each coarse node in the current row
    Floats buffer;
    caught.run([&] { at.resize(coarse.nodes()); });
#pragma omp for schedule(static)
    for (std::int32_t c = 0; c < coarse.nodes(); ++c)
      caught.run([&] {
        float* value = coarse.value.data() + coarse.row_start[c] * size;
        std::fill(value, value + coarse.entries(c) * size, 0.0f);
        for (std::int64_t e = 0; e < coarse.entries(c); ++e)
          at[coarse.column[coarse.row_start[c] + e]] = e;
        for (std::int64_t k = fine.child_start[c]; k < fine.child_start[c + 1]; ++k) {
          const std::int32_t v = fine.child[k];
          const float* in = fine.row(v, buffer);
          for (std::int64_t e = 0; e < fine.entries(v); ++e, in += size) {
            const std::int32_t u = fine.column[fine.row_start[v] + e];
            for (std::int64_t p = fine.parent_start[u]; p < fine.parent_start[u + 1]; ++p) {
              const float weight = fine.child_weight[k] * fine.parent_weight[p];
              float* out = value + at[fine.parent[p]] * size;
              for (int j = 0; j < size; ++j) out[j] += weight * in[j];
            }
          }
        }
      });
  }
  caught.rethrow();
}

}  // namespace tilth::multigrid
