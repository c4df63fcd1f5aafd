// SPDX-License-Identifier: BSD-3-Clause
// Inverses of the diagonal blocks that scale the smoother's operator. Nodes whose coupling is about
// as strong as their own stiffness share a block, such as nodes on both sides of an implicit
// boundary: a penalty constrains only their common motion, and the stiffness of their relative
// motion is not visible in the blocks of single nodes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "../caught.hpp"
#include "level.hpp"

namespace tilth::multigrid {

inline constexpr float strong = 0.25f;      // coupling over the geometric mean of own stiffnesses
inline constexpr float very_strong = 0.6f;  // couplings that mark where blocks are shared
inline constexpr int maximum_block_nodes = 8;  // nodes: the corners of a cell
inline constexpr int bins = 32;                // of coupling strengths, to order them

/// Replaces a dense matrix (n, n) by its inverse in place, by Gauss and Jordan with row
/// interchanges. Entries have single precision: where a pivot is smaller than their round-off, its
/// row is set to zero. This occurs for coarse nodes that have the same children only.
inline void invert(int n, double* matrix) {
  constexpr int maximum_size = 3 * maximum_block_nodes;
  constexpr double round_off = 0x1p-23;
  int pivot[maximum_size];
  double largest[maximum_size] = {};
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) largest[k] = std::max(largest[k], std::abs(matrix[i * n + k]));
  for (int k = 0; k < n; ++k) {
    pivot[k] = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(matrix[i * n + k]) > std::abs(matrix[pivot[k] * n + k])) pivot[k] = i;
    double* own = matrix + k * n;
    if (pivot[k] != k) std::swap_ranges(own, own + n, matrix + pivot[k] * n);
    const double by = std::abs(own[k]) > round_off * largest[k] ? 1.0 / own[k] : 0.0;
    own[k] = by != 0.0 ? 1.0 : 0.0;
    for (int j = 0; j < n; ++j) own[j] *= by;
    for (int i = 0; i < n; ++i) {
      double* row = matrix + i * n;
      const double times = row[k];
      if (i == k || times == 0.0) continue;
      row[k] = 0.0;
#pragma omp simd
      for (int j = 0; j < n; ++j) row[j] -= times * own[j];
    }
  }
  for (int k = n; k-- > 0;)
    if (pivot[k] != k)
      for (int i = 0; i < n; ++i) std::swap(matrix[i * n + k], matrix[i * n + pivot[k]]);
}

/// Groups nodes by their strong couplings, the strongest first, and only near very strong ones:
/// elsewhere blocks of one node are cheaper and suffice for the smoother.
template <int Components>
void group_coupled_nodes(Level<Components>& level) {
  std::vector<float> own(level.nodes());
#pragma omp parallel for schedule(static) if (level.threaded())
  for (std::int32_t v = 0; v < level.nodes(); ++v) {
    float sum = 0.0f;
    for (int i = 0; i < Components; ++i)
      for (int j = 0; j < Components; ++j) {
        const float number = level.at(v, level.diagonal[v], i, j);
        sum += number * number;
      }
    own[v] = std::sqrt(sum);
  }
  std::vector<signed char> bin(level.column.size(), -1);
  Caught caught;
#pragma omp parallel if (level.threaded())
  {
    Floats buffer;
#pragma omp for schedule(static)
    for (std::int32_t v = 0; v < level.nodes(); ++v)
      caught.run([&] {
        const float* row = level.row(v, buffer);
        for (std::int64_t e = level.diagonal[v] + 1; e < level.entries(v); ++e) {
          const float* block = row + e * Components * Components;
          float coupling = 0.0f;
#pragma omp simd reduction(+ : coupling)
          for (int k = 0; k < Components * Components; ++k) coupling += block[k] * block[k];
          const std::int64_t at = level.row_start[v] + e;
          const float both = own[v] * own[level.column[at]];
          if (coupling > strong * strong * both)
            bin[at] = static_cast<signed char>(std::min(std::sqrt(coupling / both), 0.99f) * bins);
        }
      });
  }
  caught.rethrow();
  std::vector<char> near(level.nodes(), 0);
  for (std::int32_t v = 0; v < level.nodes(); ++v)
    for (std::int64_t at = level.row_start[v]; at < level.row_start[v + 1]; ++at)
      if (bin[at] >= static_cast<int>(very_strong * bins)) near[v] = near[level.column[at]] = 1;
  const std::vector<char> centre = near;
  for (std::int32_t v = 0; v < level.nodes(); ++v)
    for (std::int64_t at = level.row_start[v]; centre[v] && at < level.row_start[v + 1]; ++at)
      near[level.column[at]] = 1;
  std::array<std::vector<std::pair<std::int32_t, std::int32_t>>, bins> pairs;
  for (std::int32_t v = 0; v < level.nodes(); ++v)
    for (std::int64_t at = level.row_start[v]; near[v] && at < level.row_start[v + 1]; ++at)
      if (bin[at] >= 0 && near[level.column[at]]) pairs[bin[at]].push_back({v, level.column[at]});

  std::vector<std::int32_t> group(level.nodes(), -1);
  std::vector<std::vector<std::int32_t>> members;
  for (int strength = bins; strength-- > 0;)
    for (const auto& [v, w] : pairs[strength]) {
      for (const std::int32_t u : {v, w})
        if (group[u] < 0)
          group[u] = static_cast<std::int32_t>(members.size()), members.push_back({u});
      auto &mine = members[group[v]], &other = members[group[w]];
      if (group[v] == group[w] || mine.size() + other.size() > maximum_block_nodes) continue;
      const std::int32_t into = group[v];
      for (const std::int32_t u : other) group[u] = into, mine.push_back(u);
      other.clear();
    }
  level.has_own_block.assign(level.nodes(), 1);
  level.shared_start.assign(1, 0);
  level.shared_node.clear();
  for (auto& nodes : members) {
    if (nodes.size() < 2) continue;
    std::sort(nodes.begin(), nodes.end());
    for (const std::int32_t v : nodes) level.has_own_block[v] = 0;
    level.shared_node.insert(level.shared_node.end(), nodes.begin(), nodes.end());
    level.shared_start.push_back(static_cast<std::int64_t>(level.shared_node.size()));
  }
}

/// Inverts the block of one node by its cofactors; zero where the node shares a block.
template <int Components>
void invert_own(Level<Components>& level, std::int32_t v) {
  double a[Components][Components], cofactor[Components][Components];
  bool free[Components];
  for (int i = 0; i < Components; ++i) free[i] = level.has_own_block[v] && level.mask[i][v] != 0.0f;
  for (int i = 0; i < Components; ++i)
    for (int j = 0; j < Components; ++j)
      a[i][j] = free[i] && free[j] ? level.at(v, level.diagonal[v], i, j) : double(i == j);
  for (int i = 0; i < Components; ++i)
    for (int j = 0; j < Components; ++j) {
      if constexpr (Components == 3) {
        const int k = (i + 1) % 3, l = (i + 2) % 3, m = (j + 1) % 3, n = (j + 2) % 3;
        cofactor[i][j] = a[k][m] * a[l][n] - a[k][n] * a[l][m];
      } else if constexpr (Components == 1) {
        cofactor[i][j] = 1.0;
      } else {
        cofactor[i][j] = i == j ? a[1 - i][1 - j] : -a[1 - i][1 - j];
      }
    }
  double determinant = 0.0;
  for (int j = 0; j < Components; ++j) determinant += a[0][j] * cofactor[0][j];
  for (int i = 0; i < Components; ++i)
    for (int j = 0; j < Components; ++j)
      level.inverse[i * Components + j][v] = free[i] && free[j] && determinant != 0.0
                                                 ? static_cast<float>(cofactor[j][i] / determinant)
                                                 : 0.0f;
}

/// Marks unknowns without stiffness as constrained.
template <int Components>
void constrain_unsupported(Level<Components>& level) {
  for (std::int32_t v = 0; v < level.nodes(); ++v)
    for (int i = 0; i < Components; ++i)
      if (!(level.at(v, level.diagonal[v], i, i) > 0.0f)) level.mask[i][v] = 0.0f;
}

/// Inverts the blocks on the free unknowns; an unknown without stiffness becomes constrained.
template <int Components>
void invert_diagonal(Level<Components>& level) {
  constrain_unsupported(level);
  group_coupled_nodes(level);
  const auto inverse_of = [&](const std::int32_t* node, int nodes, auto inverse) {
    const int n = nodes * Components;
    std::vector<double> matrix(std::size_t(n) * n, 0.0);
    const auto free = [&](int i) {
      return level.mask[i % Components][node[i / Components]] != 0.0f;
    };
    for (int a = 0; a < nodes; ++a)
      for (std::int64_t e = 0; e < level.entries(node[a]); ++e)
        for (int b = 0; b < nodes; ++b)
          if (level.column[level.row_start[node[a]] + e] == node[b])
            for (int i = 0; i < Components; ++i)
              for (int j = 0; j < Components; ++j)
                if (free(a * Components + i) && free(b * Components + j))
                  matrix[(a * Components + i) * n + b * Components + j] =
                      level.at(node[a], e, i, j);
    for (int i = 0; i < n; ++i)
      if (!free(i)) matrix[i * n + i] = 1.0;
    invert(n, matrix.data());
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        inverse[i * n + j] = free(i) && free(j) ? static_cast<float>(matrix[i * n + j]) : 0.0f;
  };
#pragma omp parallel for schedule(static) if (level.threaded())
  for (std::int32_t v = 0; v < level.nodes(); ++v) invert_own(level, v);
  constexpr int column = maximum_block_nodes * Components;  // padded: one length for all loops
  const auto groups = static_cast<std::int64_t>(level.shared_start.size()) - 1;
  Caught caught;
  level.shared_inverse.assign(level.shared_node.size() * Components * column, 0.0f);
#pragma omp parallel for schedule(static) if (level.threaded())
  for (std::int64_t g = 0; g < groups; ++g)
    caught.run([&] {
      const std::int64_t first = level.shared_start[g];
      const int nodes = static_cast<int>(level.shared_start[g + 1] - first), n = nodes * Components;
      std::vector<float> rows(std::size_t(n) * n);
      inverse_of(level.shared_node.data() + first, nodes, rows.data());
      float* inverse = level.shared_inverse.data() + first * Components * column;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) inverse[j * column + i] = rows[i * n + j];
    });
  caught.rethrow();
}

}  // namespace tilth::multigrid
