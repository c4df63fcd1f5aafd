// SPDX-License-Identifier: BSD-3-Clause
// Transfer between two levels: linear interpolation along each direction of the lattice, and its
// transpose.
#pragma once

#include "level.hpp"

namespace tilth::multigrid {

/// Finds parents and children; `coarse` must be fine.lattice.coarser().
template <int Components>
void link(Level<Components>& fine, const Lattice& coarse) {
  fine.parent_start.assign(fine.nodes() + 1, 0);
  fine.parent.clear(), fine.parent_weight.clear();
  fine.child_start.assign(coarse.nodes() + 1, 0);
  for (std::int32_t v = 0; v < fine.nodes(); ++v) {
    const LatticeIndex& p = fine.lattice[v];
    LatticeIndex step;  // 1 along directions where the node is midway between two coarse ones
    float weight = 1.0f;
    for (int k = 0; k < 3; ++k) {
      step[k] = half_above(p[k]) - half_below(p[k]);
      if (step[k]) weight *= 0.5f;
    }
    for (std::int32_t k = 0; k <= step[2]; ++k)
      for (std::int32_t j = 0; j <= step[1]; ++j)
        for (std::int32_t i = 0; i <= step[0]; ++i) {
          const LatticeIndex at{half_below(p[0]) + i, half_below(p[1]) + j, half_below(p[2]) + k};
          fine.parent.push_back(coarse.find(at));
          fine.parent_weight.push_back(weight);
          ++fine.child_start[fine.parent.back() + 1];
        }
    fine.parent_start[v + 1] = static_cast<std::int64_t>(fine.parent.size());
  }
  for (std::int32_t c = 0; c < coarse.nodes(); ++c) fine.child_start[c + 1] += fine.child_start[c];
  fine.child.resize(fine.parent.size());
  fine.child_weight.resize(fine.parent.size());
  std::vector<std::int64_t> next(fine.child_start.begin(), fine.child_start.end() - 1);
  for (std::int32_t v = 0; v < fine.nodes(); ++v)
    for (std::int64_t e = fine.parent_start[v]; e < fine.parent_start[v + 1]; ++e) {
      const std::int64_t at = next[fine.parent[e]]++;
      fine.child[at] = v, fine.child_weight[at] = fine.parent_weight[e];
    }
}

/// coarse <- P^T residual.
template <int Components>
void restrict_to(const Level<Components>& fine, const Field<Components>& residual,
                 std::int32_t coarse_nodes, Field<Components>& coarse) {
#pragma omp parallel for schedule(static) if (fine.threaded())
  for (std::int32_t c = 0; c < coarse_nodes; ++c) {
    float sum[Components] = {};
    for (std::int64_t e = fine.child_start[c]; e < fine.child_start[c + 1]; ++e)
      for (int i = 0; i < Components; ++i)
        sum[i] += fine.child_weight[e] * residual[i][fine.child[e]];
    for (int i = 0; i < Components; ++i) coarse[i][c] = sum[i];
  }
}

/// solution <- solution + P coarse on the free unknowns.
template <int Components>
void add_interpolated(const Level<Components>& fine, const Field<Components>& coarse,
                      Field<Components>& solution) {
#pragma omp parallel for schedule(static) if (fine.threaded())
  for (std::int32_t v = 0; v < fine.nodes(); ++v)
    for (std::int64_t e = fine.parent_start[v]; e < fine.parent_start[v + 1]; ++e)
      for (int i = 0; i < Components; ++i)
        solution[i][v] += fine.mask[i][v] * fine.parent_weight[e] * coarse[i][fine.parent[e]];
}

}  // namespace tilth::multigrid
