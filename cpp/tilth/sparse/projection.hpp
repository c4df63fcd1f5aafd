// SPDX-License-Identifier: BSD-3-Clause
// Conjugate gradients for a symmetric matrix of numbers and several right sides at once: the
// projection of the points' motion to the nodes. Results are identical for any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../lanes.hpp"
#include "../parallel.hpp"

namespace tilth::sparse {

/// A matrix in compressed rows with sorted columns and a complete diagonal.
struct SymmetricMatrix {
  std::int64_t rows;
  const std::int64_t* row_start;
  const std::int32_t* column;
  const double* value;
};

/// Solves with symmetric Gauss-Seidel as preconditioner, in the form of Eisenstat (1981), in which
/// it costs nothing. With the unit diagonal split off, the scaled matrix is I + L + U + E, where L
/// and U couple rows of one block of rows, and E rows of different blocks. The unknowns are
/// (I + U) x, so that the product of the preconditioned matrix with p is
///
///     t + (I + L)^-1 (p - t + E t),   t = (I + U)^-1 p.
///
/// Width: number of vectors of four right sides.
template <int Width>
class Projection {
 public:
  static constexpr int columns = 4 * Width;
  using Row = std::array<HalfLanes, Width>;

  /// known: unknowns that stay zero, as of rows without mass, (rows, columns).
  /// shift: added to the diagonal, relative to it.
  Projection(const SymmetricMatrix& matrix, double shift, const bool* known)
      : matrix_(matrix),
        blocks_((matrix.rows + rows_of_block - 1) / rows_of_block),
        root_(matrix.rows),
        place_(matrix.rows),
        scaled_(matrix.row_start[matrix.rows]),
        free_(matrix.rows) {
    for_blocks([&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const std::int32_t* first = matrix.column + matrix.row_start[i];
        const std::int32_t* last = matrix.column + matrix.row_start[i + 1];
        auto at = [&](std::int64_t c) {
          return matrix.row_start[i] + (std::lower_bound(first, last, c) - first);
        };
        place_[i] = {at(begin), at(i), at(end)};
        const double diagonal = (1.0 + shift) * matrix.value[place_[i][1]];
        root_[i] = diagonal > 0.0 ? 1.0 / std::sqrt(diagonal) : 0.0;
        for (int k = 0; k < columns; ++k)
          free_[i][k / 4][k % 4] = known[i * columns + k] || diagonal <= 0.0 ? 0.0 : 1.0;
      }
    });
    for_blocks([&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i)
        for (std::int64_t e = matrix.row_start[i]; e < matrix.row_start[i + 1]; ++e)
          scaled_[e] = root_[i] * matrix.value[e] * root_[matrix.column[e]];
    });
  }

  /// Replaces right sides (rows, columns) by the solutions. Returns whether all residuals became
  /// smaller than `tolerance` times the vectors `scale` (rows, columns), in the preconditioner's
  /// norm, in `limit` iterations.
  bool solve(double tolerance, int limit, const double* scale, double* right) {
    const std::int64_t n = matrix_.rows;
    std::vector<Row> r(n), p(n, Row{}), t(n), q(n), x(n, Row{});
    const auto precondition = [&](const double* from) {
      return sum_over_blocks([&](std::int64_t begin, std::int64_t end) {
        Row sum{};
        for (std::int64_t i = begin; i < end; ++i) {
          r[i] = forward(i, r, load(from + i * columns, root_[i]));
          add_square(r[i], sum);
        }
        return sum;
      });
    };
    Row target = precondition(scale), r_r = precondition(right), ratio{};
    for (int w = 0; w < Width; ++w) target[w] *= tolerance * tolerance;
    bool done = all_below(r_r, target);
    for (int iteration = 0; !done && iteration < limit; ++iteration) {
      for_blocks([&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = end - 1; i >= begin; --i) {
          for (int w = 0; w < Width; ++w) p[i][w] = r[i][w] + ratio[w] * p[i][w];
          t[i] = backward(i, t, p[i]);
        }
      });
      const Row p_q = sum_over_blocks([&](std::int64_t begin, std::int64_t end) {
        Row sum{};
        for (std::int64_t i = begin; i < end; ++i) {
          Row rest;
          for (int w = 0; w < Width; ++w) rest[w] = p[i][w] - t[i][w];
          q[i] = forward(i, q, beyond_block(i, t, rest));
          // The sweep of later rows needs (I + L)^-1 alone: t is added when q is used.
          for (int w = 0; w < Width; ++w) sum[w] += p[i][w] * (q[i][w] + t[i][w]);
        }
        return sum;
      });
      Row length;
      for (int w = 0; w < Width; ++w)
        for (int k = 0; k < 4; ++k)
          length[w][k] = r_r[w][k] > target[w][k] && p_q[w][k] > 0.0 ? r_r[w][k] / p_q[w][k] : 0.0;
      const Row before = r_r;
      r_r = sum_over_blocks([&](std::int64_t begin, std::int64_t end) {
        Row sum{};
        for (std::int64_t i = begin; i < end; ++i) {
          for (int w = 0; w < Width; ++w) {
            x[i][w] += length[w] * t[i][w];
            r[i][w] -= length[w] * (q[i][w] + t[i][w]);
          }
          add_square(r[i], sum);
        }
        return sum;
      });
      for (int w = 0; w < Width; ++w)
        for (int k = 0; k < 4; ++k)
          ratio[w][k] = before[w][k] > 0.0 ? r_r[w][k] / before[w][k] : 0.0;
      done = all_below(r_r, target);
    }
    for_blocks([&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i)
        for (int k = 0; k < columns; ++k) right[i * columns + k] = root_[i] * x[i][k / 4][k % 4];
    });
    return done;
  }

 private:
  static constexpr std::int64_t rows_of_block = 4096;

  static Row load(const double* from, double factor) {
    Row row;
    for (int w = 0; w < Width; ++w)
      for (int k = 0; k < 4; ++k) row[w][k] = factor * from[4 * w + k];
    return row;
  }

  static void add_square(const Row& row, Row& sum) {
    for (int w = 0; w < Width; ++w) sum[w] += row[w] * row[w];
  }

  static bool all_below(const Row& row, const Row& limit) {
    for (int w = 0; w < Width; ++w)
      for (int k = 0; k < 4; ++k)
        if (!(row[w][k] <= limit[w][k])) return false;
    return true;
  }

  Row less(std::int64_t first, std::int64_t last, const std::vector<Row>& x, Row row) const {
    for (std::int64_t e = first; e < last; ++e) {
      const Row& other = x[matrix_.column[e]];
      for (int w = 0; w < Width; ++w) row[w] -= scaled_[e] * other[w];
    }
    return row;
  }

  Row free_of(std::int64_t i, Row row) const {
    for (int w = 0; w < Width; ++w) row[w] *= free_[i][w];
    return row;
  }

  Row forward(std::int64_t i, const std::vector<Row>& x, const Row& right) const {
    return free_of(i, less(place_[i][0], place_[i][1], x, right));
  }

  Row backward(std::int64_t i, const std::vector<Row>& x, const Row& right) const {
    return free_of(i, less(place_[i][1] + 1, place_[i][2], x, right));
  }

  /// Adds E x to a row; the signs of `less` are turned twice.
  Row beyond_block(std::int64_t i, const std::vector<Row>& x, Row row) const {
    for (int w = 0; w < Width; ++w) row[w] = -row[w];
    row = less(matrix_.row_start[i], place_[i][0], x, row);
    row = less(place_[i][2], matrix_.row_start[i + 1], x, row);
    for (int w = 0; w < Width; ++w) row[w] = -row[w];
    return row;
  }

  template <class Action>
  void for_blocks(Action action) const {
    const std::int64_t n = matrix_.rows;
#pragma omp parallel for schedule(static) if (matrix_.row_start[n] >= 8 * parallel_from)
    for (std::int64_t b = 0; b < blocks_; ++b)
      action(b * rows_of_block, std::min(n, (b + 1) * rows_of_block));
  }

  /// Adds the blocks' sums in order.
  template <class Sum>
  Row sum_over_blocks(Sum sum) const {
    std::vector<Row> sums(blocks_);
    for_blocks([&](std::int64_t begin, std::int64_t end) {
      sums[begin / rows_of_block] = sum(begin, end);
    });
    Row total{};
    for (const Row& own : sums)
      for (int w = 0; w < Width; ++w) total[w] += own[w];
    return total;
  }

  SymmetricMatrix matrix_;
  std::int64_t blocks_;
  std::vector<double> root_;  // of the inverse diagonal
  std::vector<std::array<std::int64_t, 3>>
      place_;  // begin of the block, diagonal, end of the block
  std::vector<double> scaled_;
  std::vector<Row> free_;
};

/// product <- A x for each of some columns, x (rows, Columns).
template <int Columns>
void symmetric_product(const SymmetricMatrix& matrix, const double* x, double* product) {
#pragma omp parallel for schedule(static) if (matrix.row_start[matrix.rows] >= 8 * parallel_from)
  for (std::int64_t i = 0; i < matrix.rows; ++i) {
    double sum[Columns] = {};
    for (std::int64_t e = matrix.row_start[i]; e < matrix.row_start[i + 1]; ++e)
      for (int k = 0; k < Columns; ++k)
        sum[k] += matrix.value[e] * x[std::int64_t{matrix.column[e]} * Columns + k];
    for (int k = 0; k < Columns; ++k) product[i * Columns + k] = sum[k];
  }
}

}  // namespace tilth::sparse
