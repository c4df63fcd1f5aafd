// SPDX-License-Identifier: BSD-3-Clause
// The coarsest level is solved by a dense factorisation.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "level.hpp"

namespace tilth::multigrid {

/// LU factors with row interchanges.
class DenseFactors {
 public:
  template <int Dim>
  void factorise(const Level<Dim>& level) {
    n_ = level.unknowns();
    factor_.assign(n_ * n_, 0.0);
    pivot_.resize(n_);
    free_.resize(n_);
    for (std::int64_t row = 0; row < n_; ++row)
      free_[row] = level.mask[row % Dim][row / Dim] != 0.0f;
    for (std::int32_t v = 0; v < level.nodes(); ++v)
      for (std::int64_t e = 0; e < level.entries(v); ++e)
        for (int i = 0; i < Dim; ++i)
          for (int j = 0; j < Dim; ++j) {
            const std::int64_t row = std::int64_t{v} * Dim + i;
            const std::int64_t column =
                std::int64_t{level.column[level.row_start[v] + e]} * Dim + j;
            factor_[row * n_ + column] =
                free_[row] && free_[column] ? level.at(v, e, i, j) : row == column;
          }
    for (std::int64_t k = 0; k < n_; ++k) {
      std::int64_t pivot = k;
      for (std::int64_t i = k + 1; i < n_; ++i)
        if (std::abs(factor_[i * n_ + k]) > std::abs(factor_[pivot * n_ + k])) pivot = i;
      pivot_[k] = pivot;
      if (pivot != k)
        for (std::int64_t j = 0; j < n_; ++j)
          std::swap(factor_[k * n_ + j], factor_[pivot * n_ + j]);
      const double by = factor_[k * n_ + k];
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

  template <int Dim>
  void solve(const Field<Dim>& right, Field<Dim>& solution) const {
    std::vector<double> x(n_);
    for (std::int64_t k = 0; k < n_; ++k) x[k] = right[k % Dim][k / Dim];
    for (std::int64_t k = 0; k < n_; ++k) {
      std::swap(x[k], x[pivot_[k]]);
    }
    for (std::int64_t k = 0; k < n_; ++k)
      for (std::int64_t j = 0; j < k; ++j) x[k] -= factor_[k * n_ + j] * x[j];
    for (std::int64_t k = n_; k-- > 0;) {
      for (std::int64_t j = k + 1; j < n_; ++j) x[k] -= factor_[k * n_ + j] * x[j];
      const double by = factor_[k * n_ + k];
      x[k] = by != 0.0 ? x[k] / by : 0.0;
      solution[k % Dim][k / Dim] = static_cast<float>(x[k]);
    }
  }

 private:
  std::int64_t n_ = 0;
  std::vector<char> free_;
  std::vector<double> factor_;
  std::vector<std::int64_t> pivot_;
};

}  // namespace tilth::multigrid
