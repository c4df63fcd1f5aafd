// SPDX-License-Identifier: BSD-3-Clause
// The part of a coarse matrix P^T A P that comes from some rows of A, as those that one of several
// processes owns; the whole is the sum of these parts.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "galerkin.hpp"
#include "galerkin_by_rows.hpp"
#include "hierarchy.hpp"
#include "transfer.hpp"

namespace tilth::multigrid {

/// Interface for the bindings, for any dimension and number of components.
class CoarsePart {
 public:
  virtual ~CoarsePart() = default;

  /// Lattice, rows and columns of the coarse level.
  virtual const Lattice& lattice() const = 0;
  virtual const std::vector<std::int64_t>& row_start() const = 0;
  virtual const std::vector<std::int32_t>& column() const = 0;

  /// Fills the coarse blocks (coarse entries, components, components) from those of A.
  virtual void blocks(const double* fine, double* coarse) = 0;

  /// coarse <- P^T fine, of the chosen rows.
  virtual void restricted(const double* fine, double* coarse) const = 0;

  /// fine <- P coarse, zero for constrained unknowns.
  virtual void interpolated(const double* coarse, double* fine) const = 0;

  /// Numbers in the blocks of the finer level, components, and unknowns of both levels.
  virtual std::int64_t numbers() const = 0;
  virtual std::int64_t components() const = 0;
  virtual std::int64_t unknowns() const = 0;
  virtual std::int64_t coarse_unknowns() const = 0;
};

/// Part of a coarse matrix on a lattice of dimension `Dim` with `Components` unknowns per node.
template <int Dim, int Components>
class CoarsePartOf final : public CoarsePart {
 public:
  /// `lattice` sorted along z, y, x; `constrained` (nodes * components) marks prescribed unknowns;
  /// `chosen` (nodes) marks the rows.
  CoarsePartOf(std::vector<LatticeIndex> lattice, std::vector<std::int64_t> row_start,
               std::vector<std::int32_t> column, const bool* constrained, const bool* chosen)
      : fine_(Lattice(std::move(lattice))), coarse_(fine_.lattice.coarser()) {
    fine_.row_start = std::move(row_start), fine_.column = std::move(column);
    std::vector<char> held(fine_.nodes(), 0);
    for (std::int64_t i = 0; i < fine_.unknowns(); ++i)
      if (constrained[i]) {
        fine_.mask[i % Components][i / Components] = 0.0f;
        held[i / Components] = 1;
      }
    fine_.source.masked = held;
    for (std::int32_t v = 0; v < fine_.nodes(); ++v)
      for (std::int64_t e = fine_.row_start[v]; e < fine_.row_start[v + 1]; ++e)
        fine_.source.masked[v] |= held[fine_.column[e]];
    link(fine_, coarse_.lattice);
    keep_children(chosen);
    fine_.by_rows = Box<Dim>(fine_).fine > widest_box;
    if (fine_.by_rows)
      set_coarse_pattern_by_rows(fine_, coarse_);
    else
      set_coarse_pattern<Dim>(fine_, coarse_);
  }

  const Lattice& lattice() const override { return coarse_.lattice; }
  const std::vector<std::int64_t>& row_start() const override { return coarse_.row_start; }
  const std::vector<std::int32_t>& column() const override { return coarse_.column; }

  void blocks(const double* fine, double* coarse) override {
    double greatest = 0.0;
    for (std::int64_t i = 0; i < numbers(); ++i) greatest = std::max(greatest, std::abs(fine[i]));
    fine_.source.blocks = fine;
    fine_.source.scale = greatest > 0.0 ? 1.0 / greatest : 1.0;
    if (fine_.by_rows)
      fill_coarse_matrix_by_rows(fine_, coarse_);
    else
      fill_coarse_matrix<Dim>(fine_, coarse_);
    fine_.source.blocks = nullptr;
    for (std::size_t i = 0; i < coarse_.value.size(); ++i)
      coarse[i] = coarse_.value[i] / fine_.source.scale;
  }

  void restricted(const double* fine, double* coarse) const override {
    for (std::int32_t c = 0; c < coarse_.nodes(); ++c)
      for (int i = 0; i < Components; ++i) {
        double sum = 0.0;
        for (std::int64_t e = fine_.child_start[c]; e < fine_.child_start[c + 1]; ++e) {
          const std::int64_t v = fine_.child[e];
          sum += fine_.child_weight[e] * fine_.mask[i][v] * fine[v * Components + i];
        }
        coarse[std::int64_t{c} * Components + i] = sum;
      }
  }

  void interpolated(const double* coarse, double* fine) const override {
    for (std::int32_t v = 0; v < fine_.nodes(); ++v)
      for (int i = 0; i < Components; ++i) {
        double sum = 0.0;
        for (std::int64_t e = fine_.parent_start[v]; e < fine_.parent_start[v + 1]; ++e)
          sum += fine_.parent_weight[e] * coarse[std::int64_t{fine_.parent[e]} * Components + i];
        fine[std::int64_t{v} * Components + i] = fine_.mask[i][v] * sum;
      }
  }

  std::int64_t numbers() const override { return fine_.row_start.back() * Components * Components; }
  std::int64_t components() const override { return Components; }
  std::int64_t unknowns() const override { return fine_.unknowns(); }
  std::int64_t coarse_unknowns() const override { return coarse_.unknowns(); }

 private:
  /// Leaves each coarse node those of its children that are chosen.
  void keep_children(const bool* chosen) {
    std::int64_t kept = 0, e = 0;
    for (std::int32_t c = 0; c < coarse_.nodes(); ++c) {
      for (; e < fine_.child_start[c + 1]; ++e)
        if (chosen[fine_.child[e]]) {
          fine_.child[kept] = fine_.child[e];
          fine_.child_weight[kept++] = fine_.child_weight[e];
        }
      fine_.child_start[c + 1] = kept;
    }
    fine_.child.resize(kept);
    fine_.child_weight.resize(kept);
  }

  Level<Components> fine_, coarse_;
};

}  // namespace tilth::multigrid
