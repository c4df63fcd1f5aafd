// SPDX-License-Identifier: BSD-3-Clause
// One level of the hierarchy: its matrix in single precision, made for one fast product.
#pragma once

#include <cstdint>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

#include "../parallel.hpp"
#include "lattice.hpp"

namespace tilth::multigrid {

inline constexpr int lanes = 8;  // rows are padded to whole vectors of this many floats

/// Memory that starts on a cache line.
template <class T>
struct Aligned {
  using value_type = T;
  static constexpr std::align_val_t line{64};
  Aligned() = default;
  template <class U>
  Aligned(const Aligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), line)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, line); }
  bool operator==(const Aligned&) const { return true; }
};

using Floats = std::vector<float, Aligned<float>>;

/// Rows of node blocks. A node's row is stored as Dim scalar rows over all its columns' unknowns,
/// each padded with zeros: gathered once, the unknowns serve Dim dot products of whole vectors.
template <int Dim>
struct Level {
  explicit Level(Lattice of) : lattice(std::move(of)) {
    mask.assign(unknowns() + lanes, 1.0f);
    inverse.assign(std::size_t(nodes()) * Dim * Dim, 0.0f);
    for (Floats* vector : {&right, &solution, &other, &change, &residual, &eigenvector})
      vector->assign(unknowns() + lanes, 0.0f);
  }

  /// Takes the pattern; diagonal blocks must be in it.
  void set_pattern(std::vector<std::int64_t> starts, std::vector<std::int32_t> columns) {
    row_start = std::move(starts), column = std::move(columns);
    value_start.resize(nodes() + 1);
    diagonal.resize(nodes());
    std::int64_t at = 0;
    longest = 0;
    for (std::int32_t v = 0; v < nodes(); ++v) {
      value_start[v] = at;
      at += Dim * padded(v);
      longest = std::max(longest, padded(v));
      for (std::int64_t e = row_start[v]; e < row_start[v + 1]; ++e)
        if (column[e] == v) diagonal[v] = static_cast<std::int32_t>(e - row_start[v]);
    }
    value_start[nodes()] = at;
    value.assign(at, 0.0f);
  }

  std::int32_t nodes() const { return lattice.nodes(); }
  std::int64_t unknowns() const { return std::int64_t{nodes()} * Dim; }
  std::int64_t entries(std::int32_t v) const { return row_start[v + 1] - row_start[v]; }
  std::int64_t padded(std::int32_t v) const {
    return (Dim * entries(v) + lanes - 1) / lanes * lanes;
  }
  bool threaded() const { return row_start.back() >= 8 * parallel_from; }

  float& at(std::int32_t v, std::int64_t entry, int i, int j) {
    return value[value_start[v] + i * padded(v) + entry * Dim + j];
  }

  /// Calls `use(v, product)` with (A x)_v for each node; `x` is padded by `lanes` entries.
  template <class Use>
  void for_product(const float* x, Use use) const {
#pragma omp parallel if (threaded())
    {
      // a row's unknowns are gathered while the row before is multiplied: what was just written
      // in pieces cannot be read back in whole vectors without a wait
      Floats gathered(2 * (longest + lanes), 0.0f);
      std::int32_t ready = -1;  // row whose unknowns stand in `local`
      float *local = gathered.data(), *next = local + longest + lanes;
      const auto gather = [&](std::int32_t v, float* to) {
        const std::int32_t* from = column.data() + row_start[v];
        const std::int64_t count = entries(v), length = padded(v);
        // a copy of four floats is one instruction; the next one overwrites what is too much
        for (std::int64_t e = 0; e < count; ++e)
          std::memcpy(to + e * Dim, x + std::int64_t{from[e]} * Dim, (Dim == 2 ? 2 : 4) * 4);
        for (std::int64_t k = count * Dim; k < length; ++k) to[k] = 0.0f;
      };
#pragma omp for schedule(static)
      for (std::int32_t v = 0; v < nodes(); ++v) {
        if (ready != v) gather(v, local);
        if (v + 1 < nodes()) gather(v + 1, next);
        const std::int64_t length = padded(v);
        const float* row = value.data() + value_start[v];
        float product[Dim];
        if constexpr (Dim == 3) {
          const float *second = row + length, *third = second + length;
          float a = 0.0f, b = 0.0f, c = 0.0f;
#pragma omp simd reduction(+ : a, b, c)
          for (std::int64_t k = 0; k < length; ++k) {
            a += row[k] * local[k];
            b += second[k] * local[k];
            c += third[k] * local[k];
          }
          product[0] = a, product[1] = b, product[2] = c;
        } else {
          const float* second = row + length;
          float a = 0.0f, b = 0.0f;
#pragma omp simd reduction(+ : a, b)
          for (std::int64_t k = 0; k < length; ++k) {
            a += row[k] * local[k];
            b += second[k] * local[k];
          }
          product[0] = a, product[1] = b;
        }
        use(v, product);
        std::swap(local, next);
        ready = v + 1;
      }
    }
  }

  Lattice lattice;
  std::vector<std::int64_t> row_start, value_start;
  std::vector<std::int32_t> column, diagonal;  // diagonal: which entry of the row it is
  std::int64_t longest = 0;                    // padded length of the longest row
  Floats value;
  Floats inverse;           // of the diagonal blocks, zero for unknowns that are held
  std::vector<char> alone;  // whether a node has a block of its own
  std::vector<std::int64_t> shared_start;  // the other blocks: their nodes, and inverses
  std::vector<std::int32_t> shared_node;
  Floats shared_inverse;
  Floats mask;  // 1 free, 0 held
  Floats right, solution, other, change, residual, eigenvector;
  float largest = 1.0f;  // bound of the eigenvalues of inverse * matrix

  // to the next coarser level: a node's parents, and a parent's nodes, with their weights
  std::vector<std::int64_t> parent_start, child_start;
  std::vector<std::int32_t> parent, child;
  std::vector<float> parent_weight, child_weight;
};

}  // namespace tilth::multigrid
