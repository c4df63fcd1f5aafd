// SPDX-License-Identifier: BSD-3-Clause
// Geometric multigrid on the regular lattice of the background grid: one V-cycle in single
// precision, a preconditioner for Krylov methods in double precision
// (docs/theory/linear_solvers.md).
#pragma once

#include <memory>

#include "chebyshev.hpp"
#include "coarsest.hpp"
#include "galerkin.hpp"
#include "galerkin_by_rows.hpp"
#include "transfer.hpp"

namespace tilth::multigrid {

inline constexpr std::int64_t coarsest_unknowns = 200;
inline constexpr std::int32_t widest_box = 6;  // beyond it coarse matrices are made by rows
inline constexpr int first_power_iterations = 10, later_power_iterations = 4;

/// Interface for the bindings, for any dimension and number of components.
class Hierarchy {
 public:
  virtual ~Hierarchy() = default;

  /// Discards all matrices; later results are identical to those of a new hierarchy.
  virtual void begin() = 0;

  /// Sets the matrix: blocks (entries, components, components).
  virtual void fill(const double* blocks) = 0;

  /// approximate <- one V-cycle for `residual`, zero for constrained unknowns.
  virtual void cycle(const double* residual, double* approximate) = 0;

  /// Whether there is a matrix; without one there are no cycles.
  virtual bool filled() const = 0;

  /// Unknowns of the finest level, and numbers of its blocks.
  virtual std::int64_t unknowns() const = 0;
  virtual std::int64_t numbers() const = 0;

  /// Nodes and blocks of each level, the finest first.
  virtual std::vector<std::int64_t> sizes() const = 0;

  /// Memory of all levels.
  virtual std::int64_t bytes() const = 0;
};

/// Hierarchy on a lattice of dimension `Dim` with `Components` unknowns per node. The dimension
/// only enters the coarse matrices.
template <int Dim, int Components>
class HierarchyOf final : public Hierarchy {
 public:
  /// `lattice` sorted along z, y, x; `constrained` (nodes * components) marks prescribed unknowns.
  HierarchyOf(std::vector<LatticeIndex> lattice, std::vector<std::int64_t> row_start,
              std::vector<std::int32_t> column, const bool* constrained)
      : constrained_(constrained, constrained + lattice.size() * Components) {
    level_.push_back(std::make_unique<Level<Components>>(Lattice(std::move(lattice))));
    level_[0]->set_pattern(std::move(row_start), std::move(column));
    while (level_.back()->unknowns() > coarsest_unknowns) {
      Level<Components>& fine = *level_.back();
      auto coarse = std::make_unique<Level<Components>>(fine.lattice.coarser());
      if (coarse->nodes() >= fine.nodes()) break;
      link(fine, coarse->lattice);
      fine.by_rows = Box<Dim>(fine).fine > widest_box;
      if (fine.by_rows)
        set_coarse_pattern_by_rows(fine, *coarse);
      else
        set_coarse_pattern<Dim>(fine, *coarse);
      level_.push_back(std::move(coarse));
    }
    begin();
  }

  void begin() override {
    filled_ = false;
    for (std::int64_t i = 0; i < level_[0]->unknowns(); ++i)
      level_[0]->mask[i % Components][i / Components] = !constrained_[i];
    find_masked_rows();
    for (auto& level : level_) {
      level->largest = 1.0f;
      std::uint32_t random = 1;
      for (std::int64_t i = 0; i < level->unknowns(); ++i) {
        random = 1664525u * random + 1013904223u;
        level->eigenvector[i % Components][i / Components] =
            static_cast<float>(random >> 8) * 0x1p-23f - 1.0f;
      }
    }
  }

  void fill(const double* blocks) override {
    Level<Components>& finest = *level_[0];
    double greatest = 0.0;
    for (std::int32_t v = 0; v < finest.nodes(); ++v)
      for (int i = 0; i < Components; ++i)
        greatest = std::max(
            greatest,
            blocks[((finest.row_start[v] + finest.diagonal[v]) * Components + i) * Components + i]);
    scale_ = greatest > 0.0 ? 1.0 / greatest : 1.0;
    finest.source.blocks = blocks;
    finest.source.scale = scale_;
    for (std::size_t l = 0; l < level_.size(); ++l) {
      if (l > 0) {
        level_[l]->mask = Field<Components>(level_[l]->nodes(), 1.0f);
        if (level_[l - 1]->by_rows)
          fill_coarse_matrix_by_rows(*level_[l - 1], *level_[l]);
        else
          fill_coarse_matrix<Dim>(*level_[l - 1], *level_[l]);
      }
      if (l + 1 == level_.size()) break;
      invert_diagonal(*level_[l]);
      const Level<Components>& level = *level_[l];
      level_[l]->strips.set_values(
          level.row_start, level.has_own_block,
          [&](std::int32_t v, Floats& buffer) { return level.row(v, buffer); });
      bound_eigenvalues(*level_[l], filled_ ? later_power_iterations : first_power_iterations);
    }
    constrain_unsupported(*level_.back());
    coarsest_.factorise(*level_.back());
    finest.source.blocks = nullptr;
    filled_ = true;
  }

  void cycle(const double* residual, double* approximate) override {
    Level<Components>& finest = *level_[0];
    const std::int64_t n = finest.unknowns();
    double greatest = 0.0;
    for (std::int64_t i = 0; i < n; ++i) greatest = std::max(greatest, std::abs(residual[i]));
    const double size = greatest > 0.0 ? greatest : 1.0;
#pragma omp parallel for schedule(static) if (finest.threaded())
    for (std::int32_t v = 0; v < finest.nodes(); ++v)
      for (int i = 0; i < Components; ++i)
        finest.right[i][v] = finest.mask[i][v] *
                             static_cast<float>(residual[std::int64_t{v} * Components + i] / size);
    descend(0);
    const double factor = size * scale_;
#pragma omp parallel for schedule(static) if (finest.threaded())
    for (std::int32_t v = 0; v < finest.nodes(); ++v)
      for (int i = 0; i < Components; ++i)
        approximate[std::int64_t{v} * Components + i] =
            factor * finest.mask[i][v] * finest.solution[i][v];
  }

  bool filled() const override { return filled_; }
  std::int64_t unknowns() const override { return level_[0]->unknowns(); }
  std::int64_t numbers() const override {
    return level_[0]->row_start.back() * Components * Components;
  }

  std::vector<std::int64_t> sizes() const override {
    std::vector<std::int64_t> found;
    for (const auto& level : level_) {
      found.push_back(level->nodes());
      found.push_back(level->row_start.back());
    }
    return found;
  }

  std::int64_t bytes() const override {
    std::int64_t sum = 0;
    for (const auto& level : level_) sum += level->bytes();
    return sum;
  }

 private:
  void find_masked_rows() {
    Level<Components>& finest = *level_[0];
    finest.source.masked.assign(finest.nodes(), 0);
    const auto constrained = [&](std::int32_t v) {
      return std::find(constrained_.begin() + v * Components,
                       constrained_.begin() + (v + 1) * Components,
                       1) != constrained_.begin() + (v + 1) * Components;
    };
    for (std::int32_t v = 0; v < finest.nodes(); ++v)
      if (constrained(v))  // the pattern is symmetric
        for (std::int64_t e = finest.row_start[v]; e < finest.row_start[v + 1]; ++e)
          finest.source.masked[finest.column[e]] = 1;
  }

  void descend(std::size_t l) {
    Level<Components>& level = *level_[l];
    if (l + 1 == level_.size()) {
      coarsest_.solve(level.right, level.solution);
      return;
    }
    Level<Components>& coarse = *level_[l + 1];
    smooth(level, true);
    level.strips.for_product(level.solution,
                             [&](std::int32_t first, std::int32_t count, const auto& product) {
                               for (int i = 0; i < Components; ++i) {
                                 float residual[widest];
                                 for (int k = 0; k < widest; ++k)
                                   residual[k] = level.right[i][first + k] - product[i][k];
                                 store(residual, count, level.residual[i] + first);
                               }
                             });
    restrict_to(level, level.residual, coarse.nodes(), coarse.right);
    descend(l + 1);
    add_interpolated(level, coarse.solution, level.solution);
    smooth(level, false);
  }

  std::vector<char> constrained_;  // (nodes * components): prescribed unknowns
  std::vector<std::unique_ptr<Level<Components>>> level_;
  DenseFactors coarsest_;
  double scale_ = 1.0;
  bool filled_ = false;
};

}  // namespace tilth::multigrid
