// SPDX-License-Identifier: BSD-3-Clause
// Dense factorisation of the coarsest level.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "level.hpp"

namespace tilth::multigrid {

/// LU factors with row interchanges. Entries have single precision: where a pivot is smaller than
/// their round-off, the unknown is set to zero. This occurs for coarse nodes from which the same
/// free unknowns are interpolated.
class DenseFactors {
 public:
  template <int Components>
  void factorise(const Level<Components>& level) {
    n_ = level.unknowns();
    factor_.assign(n_ * n_, 0.0);
    pivot_.resize(n_);
    free_.resize(n_);
    for (std::int64_t row = 0; row < n_; ++row)
      free_[row] = level.mask[row % Components][row / Components] != 0.0f;
    for (std::int32_t v = 0; v < level.nodes(); ++v)
      for (std::int64_t e = 0; e < level.entries(v); ++e)
        for (int i = 0; i < Components; ++i)
          for (int j = 0; j < Components; ++j) {
            const std::int64_t row = std::int64_t{v} * Components + i;
            const std::int64_t column =
                std::int64_t{level.column[level.row_start[v] + e]} * Components + j;
            factor_[row * n_ + column] =
                free_[row] && free_[column] ? level.at(v, e, i, j) : row == column;
          }
    std::vector<double> largest(n_, 0.0);  // of each column
    for (std::int64_t row = 0; row < n_; ++row)
      for (std::int64_t k = 0; k < n_; ++k)
        largest[k] = std::max(largest[k], std::abs(factor_[row * n_ + k]));
    for (std::int64_t k = 0; k < n_; ++k) {
      std::int64_t pivot = k;
      for (std::int64_t i = k + 1; i < n_; ++i)
        if (std::abs(factor_[i * n_ + k]) > std::abs(factor_[pivot * n_ + k])) pivot = i;
      const bool regular = std::abs(factor_[pivot * n_ + k]) > round_off * largest[k];
      if (!regular) pivot = k;  // the row of the same unknown, which is then singular too
      pivot_[k] = pivot;
      if (pivot != k)
        for (std::int64_t j = 0; j < n_; ++j)
          std::swap(factor_[k * n_ + j], factor_[pivot * n_ + j]);
      double& by = factor_[k * n_ + k];
      if (!regular) by = 0.0;
      for (std::int64_t i = k + 1; i < n_; ++i) {
        const double times = by != 0.0 ? factor_[i * n_ + k] / by : 0.0;
        factor_[i * n_ + k] = times;
        if (times == 0.0) continue;
#pragma omp simd
        for (std::int64_t j = k + 1; j < n_; ++j)
          factor_[i * n_ + j] -= times * factor_[k * n_ + j];
      }
    }
  }

  template <int Components>
  void solve(const Field<Components>& right, Field<Components>& solution) const {
    std::vector<double> x(n_);
    for (std::int64_t k = 0; k < n_; ++k) x[k] = right[k % Components][k / Components];
    for (std::int64_t k = 0; k < n_; ++k) {
      std::swap(x[k], x[pivot_[k]]);
    }
    for (std::int64_t k = 0; k < n_; ++k)
      for (std::int64_t j = 0; j < k; ++j) x[k] -= factor_[k * n_ + j] * x[j];
    for (std::int64_t k = n_; k-- > 0;) {
      for (std::int64_t j = k + 1; j < n_; ++j) x[k] -= factor_[k * n_ + j] * x[j];
      const double by = factor_[k * n_ + k];
      x[k] = by != 0.0 ? x[k] / by : 0.0;
      solution[k % Components][k / Components] = static_cast<float>(x[k]);
    }
  }

 private:
  static constexpr double round_off = 0x1p-21;  // four units in the last place of an entry

  std::int64_t n_ = 0;
  std::vector<char> free_;
  std::vector<double> factor_;
  std::vector<std::int64_t> pivot_;
};

}  // namespace tilth::multigrid
