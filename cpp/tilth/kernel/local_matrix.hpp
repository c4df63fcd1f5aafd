// SPDX-License-Identifier: BSD-3-Clause
// Local matrix of a cluster of groups: it takes sums of outer products of the groups' points and is
// added to the node-block matrix once. Its entries have the matrix's order, block[a][b][i][k], so
// that the blocks of consecutive nodes are added as one row of numbers.
#pragma once

#include <algorithm>
#include <cstdint>

#include "cluster.hpp"
#include "dense_product.hpp"

namespace tilth::kernel {

/// Positions of the blocks of a group in the matrix: for each row node and each run of consecutive
/// column nodes, the position of the run's first block.
struct BlockPositions {
  const std::int64_t* start;     // (groups) offset into `position`
  const std::int32_t* position;  // (row nodes x runs) per group
  std::int64_t entries;          // of `position`
  std::int64_t blocks;           // of the matrix
};

/// Runs of consecutive nodes of a group.
struct NodeRuns {
  int count = 0;
  int end[maximum_element_nodes];

  NodeRuns(int n, const std::int32_t* node) {
    for (int b = 1; b <= n; ++b)
      if (b == n || node[b] != node[b - 1] + 1) end[count++] = b;
  }
};

/// Prefetches the blocks of a group, of so many numbers each, which are scattered over the matrix.
/// Returns whether all are inside of it.
template <int Entries>
bool prefetch_blocks(std::int64_t group, int n, const NodeRuns& runs, const BlockPositions& blocks,
                     const double* matrix) {
  constexpr int line = 8;  // numbers of a cache line
  const std::int64_t first = blocks.start[group];
  if (first < 0 || first > blocks.entries - std::int64_t{n} * runs.count) return false;
  const std::int32_t* position = blocks.position + first;
  bool inside = true;
  for (int a = 0; a < n; ++a)
    for (int run = 0, b = 0; run < runs.count; b = runs.end[run++], ++position) {
      const int numbers = (runs.end[run] - b) * Entries;
      inside = inside && *position >= 0 && *position <= blocks.blocks - (runs.end[run] - b);
      const double* entry = matrix + std::int64_t{*position} * Entries;
      for (int e = 0; e < numbers; e += line) __builtin_prefetch(entry + e, 1);
      __builtin_prefetch(entry + numbers - 1, 1);
    }
  return inside;
}

/// Adds the numbers of a register.
template <class Register>
void add_registers(const Register& part, double* to) {
  *reinterpret_cast<Register*>(to) += part;
}

/// Adds `count` numbers.
inline void add_numbers(const double* from, int count, double* to) {
  int e = 0;
  for (; e + 8 <= count; e += 8)
    add_registers(*reinterpret_cast<const UnalignedWide*>(from + e), to + e);
  for (; e < count; ++e) to[e] += from[e];
}

/// Adds a group's dense matrix block[a][b] of so many numbers each to the rows of its nodes.
template <int Entries>
void scatter_blocks(int n, const NodeRuns& runs, const std::int32_t* position, const double* block,
                    double* matrix) {
  for (int a = 0; a < n; ++a)
    for (int run = 0, b = 0; run < runs.count; b = runs.end[run++], ++position) {
      const int count = (runs.end[run] - b) * Entries;
      add_numbers(block, count, matrix + std::int64_t{*position} * Entries);
      block += count;
    }
}

/// Adds the transpose of a square block.
template <int Entries>
void add_transposed(const double* from, double* to) {
  static_assert(Entries == 1 || Entries == 4 || Entries == 9);
  if constexpr (Entries == 1) {
    *to += *from;
    return;
  }
  const auto& low = *reinterpret_cast<const UnalignedHalf*>(from);
  if constexpr (Entries == 4) {
    add_registers(UnalignedHalf{low[0], low[2], low[1], low[3]}, to);
  } else if constexpr (wide_registers) {
    const UnalignedWide eight = *reinterpret_cast<const UnalignedWide*>(from);
    add_registers(UnalignedWide{eight[0], eight[3], eight[6], eight[1], eight[4], eight[7],
                                eight[2], eight[5]},
                  to);
    to[8] += from[8];
  } else {
    const auto& high = *reinterpret_cast<const UnalignedHalf*>(from + 4);
    add_registers(UnalignedHalf{low[0], low[3], high[2], low[1]}, to);
    add_registers(UnalignedHalf{high[0], high[3], low[2], high[1]}, to + 4);
    to[8] += from[8];
  }
}

/// Local matrix between the nodes of a cluster, in blocks of so many numbers. Of a symmetric one,
/// whose blocks are square, only those b >= a are used, `a` and `b` places of nodes in the cluster.
template <int Entries>
class LocalMatrix {
 public:
  static constexpr int entries = Entries;
  static constexpr bool square = entries == 1 || entries == 4 || entries == 9;

  LocalMatrix(int nodes, bool symmetric)
      : symmetric(symmetric), stride_(padded_columns(nodes * entries)), size_(nodes * stride_) {
    std::fill_n(spare_row(), stride_ + 4, 0.0);
  }

  LocalMatrix(const LocalMatrix&) = delete;
  LocalMatrix& operator=(const LocalMatrix&) = delete;

  const bool symmetric;

  double* row(int a) { return entry_ + a * stride_; }
  double* spare_row() { return entry_ + size_; }
  double* block(int a, int b) { return row(a) + b * entries; }

  /// Sets all blocks that are used to zero.
  void clear() {
    for (int a = 0; a * stride_ < size_; ++a)
      std::fill(symmetric ? block(a, a) : row(a), row(a + 1), 0.0);
  }

  /// Adds the blocks between the nodes of a group at these places to the matrix.
  void scatter(int n, const std::uint8_t* place, const NodeRuns& runs, const std::int32_t* position,
               double* matrix) {
    for (int a = 0; a < n; ++a)
      for (int run = 0, b = 0; run < runs.count; ++run, ++position) {
        const int end = runs.end[run];
        double* to = matrix + std::int64_t{*position} * entries;
        if constexpr (square)
          for (; symmetric && b < std::min(a, end); ++b, to += entries)
            add_transposed<entries>(block(place[b], place[a]), to);
        while (b < end) {
          const int first = b++;
          while (b < end && place[b] == place[b - 1] + 1) ++b;
          add_numbers(block(place[a], place[first]), (b - first) * entries, to);
          to += (b - first) * entries;
        }
      }
  }

  /// Sets the blocks between these places to zero.
  void clear(int n, const std::uint8_t* place) {
    for (int a = 0; a < n; ++a)
      for (int b = symmetric ? a : 0; b < n; ++b)
        std::fill_n(block(place[a], place[b]), entries, 0.0);
  }

 private:
  int stride_, size_;
  alignas(32) double entry_[(maximum_nodes + 1) * padded_columns(maximum_nodes * entries) + 4];
};

/// Sum of outer products of rows over the nodes of a group and rows over its blocks (b, i, k),
/// added to a local matrix when they have become many. N nodes, 0 for a number known at run time.
template <int Entries, int N>
class ProductSum {
 public:
  static constexpr int entries = Entries;
  static constexpr int lanes = padded_columns(entries);  // of a block
  static constexpr int nodes = padded_columns(N > 0 ? N : maximum_nodes + 2);
  static constexpr int columns = (N > 0 ? N : maximum_nodes) * lanes;
  static constexpr int bytes = 24576;  // the rows stay in the first-level cache
  static constexpr int capacity = std::clamp(bytes / (8 * (nodes + columns)), 10, 48);

  /// `overwrite`: the first sum replaces the local matrix, whose nodes are those of the group.
  ProductSum(int n, const std::uint8_t* place, LocalMatrix<entries>& local, bool overwrite)
      : n_(n), place_(place), local_(local), overwrite_(overwrite) {
    int column = 0;
    for (int b = 0; b < n; ++b) {
      if (b == 0 || place[b] != place[b - 1] + 1) {
        column = padded_columns(column);
        if (runs_ > 0) run_end_[runs_ - 1] = column;
        shift_[runs_++] = place[b] * entries - column;
      }
      column_[b] = column;
      column += entries;
    }
    run_end_[runs_ - 1] = padded_columns(column);
  }

  ProductSum(const ProductSum&) = delete;
  ProductSum& operator=(const ProductSum&) = delete;

  /// Makes room for so many products.
  void reserve(int count) {
    if (terms_ + count > capacity) finish();
  }

  /// Appends so many products, for which there is room; returns the number of the first.
  int append(int count) {
    const int first = terms_, n = N > 0 ? N : n_;
    terms_ += count;
    for (int t = first; t < terms_; ++t)
      for (int a = n; a % tile_rows(N) != 0; ++a) left_[t][a] = 0.0;
    if constexpr (entries < 4)  // the last block of a run does not reach to its end
      for (int t = first; t < terms_; ++t)
        for (int run = 0; run < runs_; ++run) std::fill_n(right_[t] + run_end_[run] - 3, 3, 0.0);
    return first;
  }

  double (*left(int t)) [nodes] { return left_ + t; }

  /// Block b of the right row t; room for `lanes` numbers, those after the block are overwritten by
  /// the next one.
  double* right(int t, int b) {
    return right_[t] + column_[b];
  }

  /// Sets the right rows from t on to zero.
  void clear(int t) {
    for (; t < terms_; ++t) std::fill_n(right_[t], run_end_[runs_ - 1], 0.0);
  }

  /// Adds the products to the local matrix.
  void finish() {
    constexpr int rows = tile_rows(N);
    for (int row = 0; row < n_; row += rows) {
      double* begin[rows];
      for (int a = 0; a < rows; ++a)
        begin[a] = row + a < n_ ? local_.row(place_[row + a]) : local_.spare_row();
      int column = local_.symmetric ? column_[row] / 4 * 4 : 0;
      for (int run = 0; run < runs_; ++run) {
        if (run_end_[run] <= column) continue;
        double* to[rows];
        for (int a = 0; a < rows; ++a) to[a] = begin[a] + shift_[run];
        row_product<rows>(terms_, left_, right_, row, column, run_end_[run], to, overwrite_);
        column = run_end_[run];
      }
    }
    overwrite_ = false;
    terms_ = 0;
  }

 private:
  const int n_;
  const std::uint8_t* place_;
  LocalMatrix<entries>& local_;
  bool overwrite_;
  int terms_ = 0, runs_ = 0;
  int column_[N > 0 ? N : maximum_nodes];  // of each block in the right rows
  int run_end_[N > 0 ? N : maximum_nodes], shift_[N > 0 ? N : maximum_nodes];
  alignas(32) double left_[capacity][nodes];
  alignas(32) double right_[capacity][columns];
};

}  // namespace tilth::kernel
