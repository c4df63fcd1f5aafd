// SPDX-License-Identifier: BSD-3-Clause
// The coarse matrix P^T A P. A coarse row first gathers the rows of its children in a box of fine
// places around it, which interpolation then contracts to coarse places, one direction at a time.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "level.hpp"

namespace tilth::multigrid {

/// The box around a coarse node of a lattice of dimension `Dim`: `fine` places to either side,
/// `coarse` places after contraction.
template <int Dim>
struct Box {
  template <int Components>
  explicit Box(const Level<Components>& level) {
    std::int32_t reach = 1;
#pragma omp parallel for schedule(static) reduction(max : reach) if (level.threaded())
    for (std::int32_t v = 0; v < level.nodes(); ++v)
      for (std::int64_t e = level.row_start[v]; e < level.row_start[v + 1]; ++e)
        for (int k = 0; k < Dim; ++k)
          reach =
              std::max(reach, std::abs(level.lattice[level.column[e]][k] - level.lattice[v][k]));
    fine = reach + 1;
    coarse = (fine + 1) / 2;
  }

  std::int64_t side() const { return 2 * fine + 1; }
  std::int64_t coarse_side() const { return 2 * coarse + 1; }
  std::int64_t places() const { return side() * side() * (Dim == 3 ? side() : 1); }
  std::int64_t coarse_places() const {
    return coarse_side() * coarse_side() * (Dim == 3 ? coarse_side() : 1);
  }
  std::int64_t code(const Place& p) const { return p[0] + side() * (p[1] + side() * p[2]); }
  std::int64_t centre() const { return fine * (1 + side() * (1 + (Dim == 3 ? side() : 0))); }

  /// Contracts `width` numbers per place along one direction after the other, the slowest first.
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
void couple(const Level<Components>& fine, Level<Components>& coarse) {
  const Box<Dim> box(fine);
  const std::int64_t n = coarse.nodes(), reach = box.coarse;
  std::vector<std::int64_t> code(fine.nodes()), start(n + 1, 0);
  for (std::int32_t v = 0; v < fine.nodes(); ++v) code[v] = box.code(fine.lattice[v]);
  const std::int64_t places = box.coarse_places();
  std::vector<char> coupled(n * places);
#pragma omp parallel if (fine.threaded())
  {
    std::vector<float> touched(box.places()), scratch(box.places());
#pragma omp for schedule(static)
    for (std::int64_t c = 0; c < n; ++c) {
      std::fill(touched.begin(), touched.end(), 0.0f);
      const Place& p = coarse.lattice[c];
      const std::int64_t origin = box.code({2 * p[0], 2 * p[1], 2 * p[2]}) - box.centre();
      for (std::int64_t k = fine.child_start[c]; k < fine.child_start[c + 1]; ++k)
        for (std::int64_t e = fine.row_start[fine.child[k]]; e < fine.row_start[fine.child[k] + 1];
             ++e)
          touched[code[fine.column[e]] - origin] = 1.0f;
      const float* found = box.contract(touched.data(), scratch.data(), 1);
      for (std::int64_t k = 0; k < places; ++k) {
        coupled[c * places + k] = found[k] != 0.0f;
        start[c + 1] += found[k] != 0.0f;
      }
    }
  }
  for (std::int64_t c = 0; c < n; ++c) start[c + 1] += start[c];
  std::vector<std::int32_t> column(start[n]);
#pragma omp parallel for schedule(static) if (fine.threaded())
  for (std::int64_t c = 0; c < n; ++c) {
    const Place& p = coarse.lattice[c];
    const char* found = coupled.data() + c * places;
    std::int64_t at = start[c];
    for (std::int64_t z = Dim == 3 ? -reach : 0; z <= (Dim == 3 ? reach : 0); ++z)
      for (std::int64_t y = -reach; y <= reach; ++y)
        for (std::int64_t x = -reach; x <= reach; ++x)
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
void multiply_out(const Level<Components>& fine, Level<Components>& coarse) {
  const Box<Dim> box(fine);
  constexpr std::int64_t width = Components * Components;
  const std::int64_t row_size = box.places() * width, reach = box.coarse;
  std::vector<std::int64_t> code(fine.nodes());
  for (std::int32_t v = 0; v < fine.nodes(); ++v) code[v] = box.code(fine.lattice[v]);
#pragma omp parallel if (fine.threaded())
  {
    Floats rows(row_size), scratch(row_size), buffer;
#pragma omp for schedule(static)
    for (std::int32_t c = 0; c < coarse.nodes(); ++c) {
      std::fill(rows.begin(), rows.end(), 0.0f);
      const Place& p = coarse.lattice[c];
      const std::int64_t origin = box.code({2 * p[0], 2 * p[1], 2 * p[2]}) - box.centre();
      for (std::int64_t k = fine.child_start[c]; k < fine.child_start[c + 1]; ++k) {
        const std::int32_t v = fine.child[k];
        const float weight = fine.child_weight[k];
        const std::int64_t count = fine.entries(v);
        const std::int32_t* column = fine.column.data() + fine.row_start[v];
        const auto add = [&](const auto* value, auto factor) {
          for (std::int64_t first = 0; first < count;) {
            const std::int64_t place = code[column[first]];
            std::int64_t last = first + 1;  // consecutive places along x are one piece
            while (last < count && code[column[last]] - place == last - first) ++last;
            float* out = rows.data() + (place - origin) * width;
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
        const Place& q = coarse.lattice[column[e]];
        std::int64_t place = q[0] - p[0] + reach + box.coarse_side() * (q[1] - p[1] + reach);
        if (Dim == 3) place += box.coarse_side() * box.coarse_side() * (q[2] - p[2] + reach);
        for (int j = 0; j < width; ++j) out[e * width + j] = sums[place * width + j];
      }
    }
  }
}

}  // namespace tilth::multigrid
