// SPDX-License-Identifier: BSD-3-Clause
// The coarse matrix P^T A P. A coarse row first gathers the rows of its children in a box of fine
// points around it, which interpolation then contracts to coarse points, one direction at a time.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "../caught.hpp"
#include "level.hpp"

namespace tilth::multigrid {

/// The box around a coarse node of a lattice of dimension `Dim`: `fine` points to either side,
/// `coarse` points after contraction.
template <int Dim>
struct Box {
  template <int Components>
  explicit Box(const Level<Components>& level) {
    std::int32_t extent = 1;
#pragma omp parallel for schedule(static) reduction(max : extent) if (level.threaded())
    for (std::int32_t v = 0; v < level.nodes(); ++v)
      for (std::int64_t e = level.row_start[v]; e < level.row_start[v + 1]; ++e)
        for (int k = 0; k < Dim; ++k)
          extent =
              std::max(extent, std::abs(level.lattice[level.column[e]][k] - level.lattice[v][k]));
    fine = extent + 1;
    coarse = (fine + 1) / 2;
  }

  std::int64_t side() const { return 2 * fine + 1; }
  std::int64_t coarse_side() const { return 2 * coarse + 1; }
  std::int64_t points() const { return side() * side() * (Dim == 3 ? side() : 1); }
  std::int64_t coarse_points() const {
    return coarse_side() * coarse_side() * (Dim == 3 ? coarse_side() : 1);
  }
  std::int64_t code(const LatticeIndex& p) const { return p[0] + side() * (p[1] + side() * p[2]); }
  std::int64_t centre() const { return fine * (1 + side() * (1 + (Dim == 3 ? side() : 0))); }

  /// Contracts `width` numbers per point along one direction after the other, the slowest first.
  template <class T>
  const T* contract(T* box, T* scratch, std::int64_t width) const {
    for (int k = Dim - 1; k >= 0; --k) {
      // layout (outer coarse directions..., direction k, inner fine directions..., width)
      std::int64_t inner = width;
      for (int i = 0; i < k; ++i) inner *= side();
      std::int64_t outer = 1;
      for (int i = k + 1; i < Dim; ++i) outer *= coarse_side();
      for (std::int64_t o = 0; o < outer; ++o)
        for (std::int64_t c = -coarse; c <= coarse; ++c) {
          T* out = scratch + (o * coarse_side() + c + coarse) * inner;
          std::fill(out, out + inner, T(0));
          for (std::int64_t f = 2 * c - 1; f <= 2 * c + 1; ++f) {
            if (f < -fine || f > fine) continue;
            const T weight = f == 2 * c ? T(1) : T(0.5);
            const T* in = box + (o * side() + f + fine) * inner;
#pragma omp simd
            for (std::int64_t i = 0; i < inner; ++i) out[i] += weight * in[i];
          }
        }
      std::swap(box, scratch);
    }
    return box;
  }

  std::int32_t fine, coarse;
};

/// Finds the pattern of the coarse matrix.
template <int Dim, int Components>
void set_coarse_pattern(const Level<Components>& fine, Level<Components>& coarse) {
  const Box<Dim> box(fine);
  const std::int64_t n = coarse.nodes(), extent = box.coarse;
  std::vector<std::int64_t> code(fine.nodes()), start(n + 1, 0);
  for (std::int32_t v = 0; v < fine.nodes(); ++v) code[v] = box.code(fine.lattice[v]);
  const std::int64_t points = box.coarse_points();
  std::vector<char> coupled(n * points);
  Caught caught;
#pragma omp parallel if (fine.threaded())
  {
    std::vector<float> coupled_fine, scratch;
    caught.run([&] { coupled_fine.resize(box.points()), scratch.resize(box.points()); });
#pragma omp for schedule(static)
    for (std::int64_t c = 0; c < n; ++c)
      caught.run([&] {
        std::fill(coupled_fine.begin(), coupled_fine.end(), 0.0f);
        const LatticeIndex& p = coarse.lattice[c];
        const std::int64_t origin = box.code({2 * p[0], 2 * p[1], 2 * p[2]}) - box.centre();
        for (std::int64_t k = fine.child_start[c]; k < fine.child_start[c + 1]; ++k)
          for (std::int64_t e = fine.row_start[fine.child[k]];
               e < fine.row_start[fine.child[k] + 1]; ++e)
            coupled_fine[code[fine.column[e]] - origin] = 1.0f;
        const float* found = box.contract(coupled_fine.data(), scratch.data(), 1);
        for (std::int64_t k = 0; k < points; ++k) {
          coupled[c * points + k] = found[k] != 0.0f;
          start[c + 1] += found[k] != 0.0f;
        }
      });
  }
  caught.rethrow();
  for (std::int64_t c = 0; c < n; ++c) start[c + 1] += start[c];
  std::vector<std::int32_t> column(start[n]);
#pragma omp parallel for schedule(static) if (fine.threaded())
  for (std::int64_t c = 0; c < n; ++c) {
    const LatticeIndex& p = coarse.lattice[c];
    const char* found = coupled.data() + c * points;
    std::int64_t at = start[c];
    for (std::int64_t z = Dim == 3 ? -extent : 0; z <= (Dim == 3 ? extent : 0); ++z)
      for (std::int64_t y = -extent; y <= extent; ++y)
        for (std::int64_t x = -extent; x <= extent; ++x)
          if (*found++)
            column[at++] = coarse.lattice.find({static_cast<std::int32_t>(p[0] + x),
                                                static_cast<std::int32_t>(p[1] + y),
                                                static_cast<std::int32_t>(p[2] + z)});
  }
  coarse.set_pattern(std::move(start), std::move(column));
  coarse.value.assign(coarse.column.size() * Components * Components, 0.0f);
}

/// Fills the values of the coarse matrix.
template <int Dim, int Components>
void fill_coarse_matrix(const Level<Components>& fine, Level<Components>& coarse) {
  const Box<Dim> box(fine);
  constexpr std::int64_t width = Components * Components;
  const std::int64_t row_size = box.points() * width, extent = box.coarse;
  std::vector<std::int64_t> code(fine.nodes());
  for (std::int32_t v = 0; v < fine.nodes(); ++v) code[v] = box.code(fine.lattice[v]);
  Caught caught;
#pragma omp parallel if (fine.threaded())
  {
    Floats rows, scratch, buffer;
    caught.run([&] { rows.resize(row_size), scratch.resize(row_size); });
#pragma omp for schedule(static)
    for (std::int32_t c = 0; c < coarse.nodes(); ++c)
      caught.run([&] {
        std::fill(rows.begin(), rows.end(), 0.0f);
        const LatticeIndex& p = coarse.lattice[c];
        const std::int64_t origin = box.code({2 * p[0], 2 * p[1], 2 * p[2]}) - box.centre();
        for (std::int64_t k = fine.child_start[c]; k < fine.child_start[c + 1]; ++k) {
          const std::int32_t v = fine.child[k];
          const float weight = fine.child_weight[k];
          const std::int64_t count = fine.entries(v);
          const std::int32_t* column = fine.column.data() + fine.row_start[v];
          const auto add = [&](const auto* value, auto factor) {
            for (std::int64_t first = 0; first < count;) {
              const std::int64_t index = code[column[first]];
              std::int64_t last = first + 1;  // consecutive points along x are added together
              while (last < count && code[column[last]] - index == last - first) ++last;
              float* out = rows.data() + (index - origin) * width;
              const auto* in = value + first * width;
              for (; first + 3 <= last; first += 3, in += 3 * width, out += 3 * width)
#pragma omp simd
                for (std::int64_t j = 0; j < 3 * width; ++j)
                  out[j] += static_cast<float>(factor * in[j]);
              for (std::int64_t j = 0; j < (last - first) * width; ++j)
                out[j] += static_cast<float>(factor * in[j]);
              first = last;
            }
          };
          if (fine.source.blocks != nullptr && !fine.source.masked[v])
            add(fine.source.blocks + fine.row_start[v] * width, fine.source.scale * weight);
          else
            add(fine.row(v, buffer), weight);
        }
        const std::int32_t* column = coarse.column.data() + coarse.row_start[c];
        const float* sums = box.contract(rows.data(), scratch.data(), width);
        float* out = coarse.value.data() + coarse.row_start[c] * width;
        for (std::int64_t e = 0; e < coarse.entries(c); ++e) {
          const LatticeIndex& q = coarse.lattice[column[e]];
          std::int64_t index = q[0] - p[0] + extent + box.coarse_side() * (q[1] - p[1] + extent);
          if (Dim == 3) index += box.coarse_side() * box.coarse_side() * (q[2] - p[2] + extent);
          for (int j = 0; j < width; ++j) out[e * width + j] = sums[index * width + j];
        }
      });
  }
  caught.rethrow();
}

}  // namespace tilth::multigrid
