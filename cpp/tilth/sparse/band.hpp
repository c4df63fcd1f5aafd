// SPDX-License-Identifier: BSD-3-Clause
// LU factors of a sparse matrix, ordered for a narrow band: the work per unknown is proportional to
// the square of the band's width.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "graph.hpp"

namespace tilth::sparse {

/// Factors of a matrix in compressed columns with a fixed pattern. Partial pivoting (Golub and Van
/// Loan, Matrix computations, section 4.3.3), column by column: a column stays in the cache while
/// all columns before it are eliminated from it.
class BandFactors {
 public:
  BandFactors(std::int64_t size, const std::int32_t* start, const std::int32_t* row)
      : size_(size),
        order_(Graph(size, start, row).narrow_order()),
        first_(size),
        end_(size),
        pivot_(size) {
    std::vector<std::int64_t> rank(size);
    for (std::int64_t k = 0; k < size; ++k) {
      rank[order_[k]] = first_[k] = k;
      end_[k] = k + 1;
    }
    for (std::int64_t c = 0; c < size; ++c)
      for (std::int32_t e = start[c]; e < start[c + 1]; ++e) {
        lower_ = std::max(lower_, rank[row[e]] - rank[c]);
        upper_ = std::max(upper_, rank[c] - rank[row[e]]);
        first_[rank[c]] = std::min(first_[rank[c]], rank[row[e]]);
        end_[rank[c]] = std::max(end_[rank[c]], rank[row[e]] + 1);
      }
    std::inclusive_scan(end_.begin(), end_.end(), end_.begin(),
                        [](std::int64_t a, std::int64_t b) { return std::max(a, b); });
    for (std::int64_t& first : first_)  // row interchanges may extend it to here
      first = std::upper_bound(end_.begin(), end_.end(), first) - end_.begin();
    upper_ += lower_;  // for the same reason
    index_.reserve(start[size]);
    for (std::int64_t c = 0; c < size; ++c)
      for (std::int32_t e = start[c]; e < start[c + 1]; ++e)
        index_.push_back(rank[c] * rows() + upper_ + rank[row[e]] - rank[c]);
  }

  std::int64_t size() const { return size_; }
  /// Widths of the factors' band below and above the diagonal.
  std::array<std::int64_t, 2> widths() const { return {lower_, upper_}; }
  std::int64_t entries() const { return static_cast<std::int64_t>(index_.size()); }

  /// Whether the last matrix has factors.
  bool factorised() const { return factorised_; }

  /// Factorises the matrix with these entries; returns whether no pivot is zero.
  bool factorise(const double* value) {
    factorised_ = false;
    factor_.assign(size_ * rows(), 0.0);
    for (std::size_t e = 0; e < index_.size(); ++e) factor_[index_[e]] += value[e];
    for (std::int64_t c = 0; c < size_; ++c) {
      double* column = at_diagonal(c) - c;  // column[i] is entry (i, c)
      for (std::int64_t k = first_[c]; k < c; ++k) {
        std::swap(column[k], column[pivot_[k]]);
        eliminate(k, column);
      }
      const std::int64_t end = end_[c];
      std::int64_t pivot = c;
      for (std::int64_t i = c + 1; i < end; ++i)
        if (std::abs(column[i]) > std::abs(column[pivot])) pivot = i;
      pivot_[c] = pivot;
      std::swap(column[c], column[pivot]);
      if (column[c] == 0.0) return false;
      const double inverse = 1.0 / column[c];
      for (std::int64_t i = c + 1; i < end; ++i) column[i] *= inverse;
    }
    return factorised_ = true;
  }

  /// Solves for one right side; both have one entry per unknown.
  void solve(const double* right, double* solution) const {
    std::vector<double> x(size_);
    for (std::int64_t k = 0; k < size_; ++k) x[k] = right[order_[k]];
    for (std::int64_t k = 0; k < size_; ++k) {
      std::swap(x[k], x[pivot_[k]]);
      eliminate(k, x.data());
    }
    for (std::int64_t c = size_; c-- > 0;) {
      const double* column = at_diagonal(c) - c;
      x[c] /= column[c];
      for (std::int64_t i = first_[c]; i < c; ++i) x[i] -= column[i] * x[c];
    }
    for (std::int64_t k = 0; k < size_; ++k) solution[order_[k]] = x[k];
  }

 private:
  std::int64_t rows() const { return upper_ + 1 + lower_; }
  double* at_diagonal(std::int64_t c) { return factor_.data() + c * rows() + upper_; }
  const double* at_diagonal(std::int64_t c) const { return factor_.data() + c * rows() + upper_; }

  /// Subtracts the factors' column k, below the diagonal, times x[k] from x.
  void eliminate(std::int64_t k, double* x) const {
    const double times = x[k];
    if (times == 0.0) return;
    const double* column = at_diagonal(k) - k;
    const std::int64_t end = end_[k];
#pragma omp simd
    for (std::int64_t i = k + 1; i < end; ++i) x[i] -= column[i] * times;
  }

  std::int64_t size_;
  std::vector<std::int64_t> order_;
  std::int64_t lower_ = 0, upper_ = 0;  // widths of the factors' band
  std::vector<std::int64_t> first_;     // row of each of the factors' columns that may not be 0,
  std::vector<std::int64_t> end_;       // and one past the last such row
  std::vector<std::int64_t> index_;     // of each entry in factor_
  std::vector<double> factor_;          // column by column, rows() each
  bool factorised_ = false;
  std::vector<std::int64_t> pivot_;  // row that was interchanged with each
};

/// product <- A x for a square matrix in compressed columns.
inline void column_product(std::int64_t size, const std::int32_t* start, const std::int32_t* row,
                           const double* value, const double* x, double* product) {
  std::fill(product, product + size, 0.0);
  for (std::int64_t c = 0; c < size; ++c)
    for (std::int32_t e = start[c]; e < start[c + 1]; ++e) product[row[e]] += value[e] * x[c];
}

}  // namespace tilth::sparse
