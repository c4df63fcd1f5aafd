// SPDX-License-Identifier: BSD-3-Clause
// Elements of a few nodes with forces linear in the nodal displacement: products and assembly. An
// element's matrix is dense, one of a few matrices between nodes that elements share, scaled, or
// the product of a row with itself.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#include "../parallel.hpp"
#include "local_matrix.hpp"
#include "view.hpp"

namespace tilth::kernel {

/// Elements, and their order of parallel assembly (colour_groups); the nodes of element e are
/// `node[node_start[e]]` to `node[node_start[e + 1]]`, not included.
struct Elements {
  std::int64_t elements;
  const std::int64_t* node_start;  // (elements + 1)
  const std::int32_t* node;
  std::int64_t colours;
  const std::int64_t* colour_start;
  const std::int64_t* slab_start;
  const std::int64_t* order;

  /// Work in points (Stencil::work): an element counts as eight points.
  std::int64_t work() const { return 8 * elements; }

  int nodes_of(std::int64_t e) const { return static_cast<int>(node_start[e + 1] - node_start[e]); }
};

/// A matrix of its own for each element, shape (elements, n, n, Components, Components).
template <int Components>
struct DenseMatrices {
  const double* matrix;

  struct Element {
    const double* block;
    int n;

    template <bool Magnitude>
    void multiply(const double* in, double* out) const {
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < Components; ++i) {
          double sum = 0.0;
          for (int b = 0; b < n; ++b)
            for (int k = 0; k < Components; ++k) {
              const double entry = block[((a * n + b) * Components + i) * Components + k];
              sum += (Magnitude ? std::fabs(entry) : entry) * in[b * Components + k];
            }
          out[a * Components + i] = sum;
        }
    }

    void add_block(int a, int b, double* into) const {
      const double* own = block + (a * n + b) * Components * Components;
      for (int ik = 0; ik < Components * Components; ++ik) into[ik] += own[ik];
    }
  };

  Element element(std::int64_t e, int n) const {
    return {matrix + e * n * n * Components * Components, n};
  }
};

/// weight_e unit_ab between the components of two nodes in which both are `free`; weights >= 0,
/// `unit` (units, n, n), of which `which` names one for each element, `free` (elements, n,
/// Components).
template <int Components>
struct ScaledMatrix {
  const double* weight;
  const double* unit;
  const std::int32_t* which;
  const bool* free;

  struct Element {
    const double* unit;
    int n;
    double weight;
    double free[maximum_nodes * Components];  // 1 or 0

    template <bool Magnitude>
    void multiply(const double* in, double* out) const {
      for (int a = 0; a < n; ++a) {
        double sum[Components] = {};
        for (int b = 0; b < n; ++b) {
          const double entry = Magnitude ? std::fabs(unit[a * n + b]) : unit[a * n + b];
          for (int i = 0; i < Components; ++i)
            sum[i] += entry * (free[b * Components + i] * in[b * Components + i]);
        }
        for (int i = 0; i < Components; ++i)
          out[a * Components + i] = free[a * Components + i] * weight * sum[i];
      }
    }

    void add_block(int a, int b, double* into) const {
      const double entry = weight * unit[a * n + b];
      for (int i = 0; i < Components; ++i)
        into[i * (Components + 1)] += free[a * Components + i] * free[b * Components + i] * entry;
    }
  };

  Element element(std::int64_t e, int n) const {
    Element result;
    result.unit = unit + std::int64_t{which[e]} * n * n, result.n = n, result.weight = weight[e];
    for (int i = 0; i < n * Components; ++i)
      result.free[i] = free[e * n * Components + i] ? 1.0 : 0.0;
    return result;
  }
};

/// The products of a row (n, Components) for each element with itself; the rows are in one array.
template <int Components>
struct RowProducts {
  const std::int64_t* node_start;
  const double* row;

  struct Element {
    const double* row;
    int n;

    template <bool Magnitude>
    void multiply(const double* in, double* out) const {
      double sum = 0.0;
      for (int i = 0; i < n * Components; ++i)
        sum += (Magnitude ? std::fabs(row[i]) : row[i]) * in[i];
      for (int i = 0; i < n * Components; ++i)
        out[i] = (Magnitude ? std::fabs(row[i]) : row[i]) * sum;
    }

    void add_block(int a, int b, double* into) const {
      for (int i = 0; i < Components; ++i)
        for (int k = 0; k < Components; ++k)
          into[i * Components + k] += row[a * Components + i] * row[b * Components + k];
    }
  };

  Element element(std::int64_t e, int n) const { return {row + node_start[e] * Components, n}; }
};

/// The outer products of a column and a row (n, Components each) for each element; all columns and
/// all rows are in one array each.
template <int Components>
struct OuterProducts {
  const std::int64_t* node_start;
  const double* column;
  const double* row;

  struct Element {
    const double* column;
    const double* row;

    void add_block(int a, int b, double* into) const {
      for (int i = 0; i < Components; ++i)
        for (int k = 0; k < Components; ++k)
          into[i * Components + k] += column[a * Components + i] * row[b * Components + k];
    }
  };

  Element element(std::int64_t e, int) const {
    const std::int64_t first = node_start[e] * Components;
    return {column + first, row + first};
  }
};

/// Adds the forces (entries of `node`, Components) to `nodal` (nodes, Components).
template <int Components>
void add_element_forces(const Elements& elements, const double* force, double* nodal) {
  for_each_by_colour(elements, [&](std::int64_t e) {
    for (std::int64_t a = elements.node_start[e]; a < elements.node_start[e + 1]; ++a)
      for (int i = 0; i < Components; ++i)
        nodal[Components * std::int64_t{elements.node[a]} + i] += force[a * Components + i];
  });
}

/// Adds each element's matrix, or that of its entries' magnitudes, times `vector` (nodes,
/// Components) to `product` (nodes, Components).
template <bool Magnitude, int Components, class Matrices>
void add_element_products(const Elements& elements, const Matrices& matrices, const double* vector,
                          double* product) {
  for_each_by_colour(elements, [&](std::int64_t e) {
    const int n = elements.nodes_of(e);
    const std::int32_t* node = elements.node + elements.node_start[e];
    double in[maximum_element_nodes * Components], out[maximum_element_nodes * Components];
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < Components; ++i)
        in[a * Components + i] = vector[Components * std::int64_t{node[a]} + i];
    matrices.element(e, n).template multiply<Magnitude>(in, out);
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < Components; ++i)
        product[Components * std::int64_t{node[a]} + i] += out[a * Components + i];
  });
}

/// Adds the elements' matrices to the node blocks `matrix`. Returns whether all `blocks` are inside
/// of it; those of other elements are not added.
template <int Components, class Matrices>
bool add_element_blocks(const Elements& elements, const BlockPositions& blocks,
                        const Matrices& matrices, double* matrix) {
  constexpr int entries = Components * Components;
  Found outside;
  for_each_by_colour(elements, [&](std::int64_t e) {
    const int n = elements.nodes_of(e);
    const std::int32_t* node = elements.node + elements.node_start[e];
    if (!prefetch_blocks<entries>(e, n, NodeRuns(n, node), blocks, matrix)) return outside.set();
    const std::int32_t* position = blocks.position + blocks.start[e];
    const auto element = matrices.element(e, n);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++position) {
        double* block = matrix + std::int64_t{*position} * entries;
        do {
          element.add_block(a, b, block);
          block += entries;
          ++b;
        } while (b < n && node[b] == node[b - 1] + 1);
      }
  });
  return !outside;
}

}  // namespace tilth::kernel
