// SPDX-License-Identifier: BSD-3-Clause
// Points whose domains have corners (basis/corners.hpp): their supports, basis values and motion. A
// point's nodes are those of the cells that contain a corner; the cells need not be adjacent.
// Points that share these cells form a group, which stores them in a list
// (docs/decisions/0014-corner-domains.md). Corners are relative to the point, shape (n, 2^Dim,
// Dim).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../basis/corners.hpp"
#include "../basis/gimp.hpp"
#include "../grid.hpp"
#include "../grid_lines.hpp"
#include "../parallel.hpp"
#include "simplex.hpp"
#include "view.hpp"

namespace tilth::kernel {

using basis::corners_of;

/// A cell of a support is identified by its index in the bounding box: bits per direction.
template <int Dim>
inline constexpr int index_bits = Dim == 2 ? 8 : 5;

/// Largest number of cells of this box in each direction.
template <int Dim>
inline constexpr int widest_support = 1 << index_bits<Dim>;

/// Number of 64-bit codes that identify the cells of a support, four cells in each.
template <int Dim>
inline constexpr int codes_of = corners_of<Dim> / 4;

/// The cell along one axis that contains a coordinate, in cells; for coordinates that keys cannot
/// represent, and those that are not numbers, the first cell that is out of range.
inline std::int64_t clamped_cell(double coordinate) {
  constexpr double limit = key_bias;
  return static_cast<std::int64_t>(std::floor(std::max(-limit, std::min(limit, coordinate))));
}

/// Coordinates of a corner, in cells, and the cell that contains it. A corner on a grid line
/// belongs to the cell on the domain's side of it: overlaps below `relative_overlap` are no support
/// (gimp.hpp).
template <int Dim>
Lattice locate_corner(const double* position, const double* corner, const GridLines& grid,
                      double local[Dim]) {
  Lattice cell{0, 0, 0};
  for (int k = 0; k < Dim; ++k) {
    const Axis& axis = grid[k];
    const double reach = 1.0 - basis::Gimp::relative_overlap;
    if (axis.graded()) {
      cell[k] = clamped_cell(axis.in_cells(position[k] + corner[k] * reach));
      local[k] = axis.in_cells_like(cell[k], position[k] + corner[k]);
      continue;
    }
    const double centre = axis.in_cells(position[k]), offset = corner[k] / axis.size;
    local[k] = centre + offset;
    cell[k] = clamped_cell(centre + offset * reach);
  }
  return cell;
}

enum SupportFailure : std::int64_t { out_of_range = -1, too_wide = -2 };

/// Key of the lowest corner of the box of cells around each point's support, or a SupportFailure,
/// and the indices of the cells in that box, (n, codes): ascending, the last one repeated. Returns
/// the number of failures.
template <int Dim>
std::int64_t corner_supports(std::int64_t points, const double* position, const double* corner,
                             const GridLines& grid, std::int64_t* keys, std::int64_t* codes) {
  constexpr int corners = corners_of<Dim>;
  std::int64_t failures = 0;
#pragma omp parallel for schedule(static) reduction(+ : failures) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    Lattice cell[corners], low{0, 0, 0}, high{0, 0, 0};
    for (int c = 0; c < corners; ++c) {
      double local[Dim];
      cell[c] =
          locate_corner<Dim>(position + Dim * p, corner + Dim * (corners * p + c), grid, local);
      for (int k = 0; k < Dim; ++k) {
        low[k] = c == 0 ? cell[c][k] : std::min(low[k], cell[c][k]);
        high[k] = c == 0 ? cell[c][k] : std::max(high[k], cell[c][k]);
      }
    }
    bool inside = true, narrow = true;
    for (int k = 0; k < Dim; ++k) {
      inside = inside && low[k] > -largest_index && high[k] < largest_index;
      narrow = narrow && high[k] - low[k] < widest_support<Dim>;
    }
    keys[p] = !inside ? out_of_range : (!narrow ? too_wide : pack(low));
    failures += keys[p] < 0;
    std::uint64_t index[corners] = {};
    if (keys[p] >= 0)
      for (int c = 0; c < corners; ++c)
        for (int k = Dim - 1; k >= 0; --k)
          index[c] =
              (index[c] << index_bits<Dim>) | static_cast<std::uint64_t>(cell[c][k] - low[k]);
    std::sort(index, index + corners);
    const auto* last = std::unique(index, index + corners);
    for (int w = 0; w < codes_of<Dim>; ++w) {
      std::uint64_t code = 0;
      for (int c = 4 * w; c < 4 * w + 4; ++c)
        code = (code << 16) | (index + c < last ? index[c] : *(last - 1));
      codes[codes_of<Dim> * p + w] = static_cast<std::int64_t>(code);
    }
  }
  return failures;
}

/// Groups of points sorted by key and codes: see Groups (stencil.hpp), whose box of nodes
/// first/count encloses the support, and the cells and nodes of each support in ascending order.
struct CornerGroups {
  std::vector<std::int64_t> start;
  std::vector<std::int64_t> first;  // (groups, 3)
  std::vector<std::int32_t> count;  // (groups, 3)
  std::vector<std::int64_t> cell_start{0};
  std::vector<std::int64_t> cell;  // keys of their lowest nodes
  std::vector<std::int64_t> node_start{0};
  std::vector<std::int64_t> node;  // keys
};

template <int Dim>
Lattice corner_of_cell(const Lattice& cell, int c) {
  return {cell[0] + (c & 1), cell[1] + ((c >> 1) & 1), cell[2] + (c >> 2)};
}

template <int Dim>
CornerGroups group_corner_points(std::int64_t points, const std::int64_t* keys,
                                 const std::int64_t* codes) {
  constexpr int codes_each = codes_of<Dim>;
  CornerGroups groups;
  for (std::int64_t p = 0; p < points; ++p) {
    const std::int64_t* own = codes + codes_each * p;
    if (p > 0 && keys[p] == keys[p - 1] && std::equal(own, own + codes_each, own - codes_each))
      continue;
    const Lattice first = unpack(keys[p]);
    std::int32_t count[3] = {2, 2, Dim == 3 ? 2 : 1};
    std::int64_t before = -1;
    for (int c = 0; c < corners_of<Dim>; ++c) {
      const auto code = static_cast<std::uint64_t>(own[c / 4]);
      const auto index = static_cast<std::int64_t>((code >> (16 * (3 - c % 4))) & 0xffff);
      if (index == before) break;
      before = index;
      Lattice cell = first;
      for (int k = 0; k < Dim; ++k) {
        const std::int64_t offset = (index >> (k * index_bits<Dim>)) & (widest_support<Dim> - 1);
        cell[k] += offset;
        count[k] = std::max(count[k], static_cast<std::int32_t>(offset) + 2);
      }
      groups.cell.push_back(pack(cell));
      for (int b = 0; b < corners_of<Dim>; ++b)
        groups.node.push_back(pack(corner_of_cell<Dim>(cell, b)));
    }
    const auto own_nodes = groups.node.begin() + groups.node_start.back();
    std::sort(own_nodes, groups.node.end());
    groups.node.erase(std::unique(own_nodes, groups.node.end()), groups.node.end());
    groups.start.push_back(p);
    groups.first.insert(groups.first.end(), first.begin(), first.end());
    groups.count.insert(groups.count.end(), count, count + 3);
    groups.cell_start.push_back(static_cast<std::int64_t>(groups.cell.size()));
    groups.node_start.push_back(static_cast<std::int64_t>(groups.node.size()));
  }
  groups.start.push_back(points);
  return groups;
}

/// Index of a node in a group's ascending list of node keys.
inline int index_in_list(const std::int64_t* list, std::int64_t size, std::int64_t key) {
  return static_cast<int>(std::lower_bound(list, list + size, key) - list);
}

/// Basis values and gradients, in the layout of basis_values.hpp. Returns whether the groups have
/// all nodes of their points.
template <int Dim>
bool corner_basis_values(std::int64_t groups, const std::int64_t* start,
                         const std::int64_t* node_start, const std::int64_t* node_keys,
                         const std::int64_t* value_start, const double* position,
                         const double* corner, const GridLines& grid, double* value) {
  bool missing = false;
#pragma omp parallel for schedule(static) \
    reduction(|| : missing) if (start[groups] >= parallel_from)
  for (std::int64_t g = 0; g < groups; ++g) {
    const std::int64_t n = node_start[g + 1] - node_start[g];
    const std::int64_t* list = node_keys + node_start[g];
    for (std::int64_t p = start[g]; p < start[g + 1]; ++p) {
      const double* own = corner + Dim * corners_of<Dim> * p;
      const auto weights = basis::corner_weights<Dim>(own);
      double* s = value + value_start[g] + (p - start[g]) * (1 + Dim) * n;
      double* d = s + n;
      std::fill(s, d + Dim * n, 0.0);
      for (int c = 0; c < corners_of<Dim>; ++c) {
        double local[Dim];
        const Lattice cell = locate_corner<Dim>(position + Dim * p, own + Dim * c, grid, local);
        for (int b = 0; b < corners_of<Dim>; ++b) {
          double hat = 1.0;
          for (int k = 0; k < Dim; ++k) {
            const double t = local[k] - static_cast<double>(cell[k]);
            hat *= (b >> k) & 1 ? t : 1.0 - t;
          }
          const std::int64_t key = pack(corner_of_cell<Dim>(cell, b));
          const int a = index_in_list(list, n, key);
          if (a == n || list[a] != key) {
            missing = true;
            continue;
          }
          s[a] += weights.value[c] * hat;
          for (int k = 0; k < Dim; ++k) d[k * n + a] += weights.gradient[c][k] * hat;
        }
      }
    }
  }
  return !missing;
}

inline constexpr std::int64_t node_missing = -2;  // a cell with a corner has not all nodes

/// Moves corners with the grid's finite-element field: fills `moved` (n, 2^Dim, Dim), relative to
/// the point's new position, and `shift` (n, Dim), the displacement of the point, which is the
/// domain's centroid. In axisymmetry a corner that would cross the axis is put on it. Returns the
/// first point whose domain is then folded or inverted, -1 if there is none, or `node_missing`.
template <int Dim>
std::int64_t move_corners(std::int64_t points, const double* position, const double* corner,
                          std::int64_t nodes, const std::int64_t* node_keys,
                          const double* displacement, const GridLines& grid, bool axisymmetric,
                          double* moved, double* shift) {
  std::int64_t folded = points;
  bool missing = false;
#pragma omp parallel for schedule(static) reduction(min : folded) \
    reduction(|| : missing) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    const double* own = corner + Dim * corners_of<Dim> * p;
    double* after = moved + Dim * corners_of<Dim> * p;
    for (int c = 0; c < corners_of<Dim>; ++c) {
      double local[Dim];
      const Lattice cell = locate_corner<Dim>(position + Dim * p, own + Dim * c, grid, local);
      for (int i = 0; i < Dim; ++i) after[Dim * c + i] = own[Dim * c + i];
      for (int b = 0; b < corners_of<Dim>; ++b) {
        double hat = 1.0;
        for (int k = 0; k < Dim; ++k) {
          const double t = local[k] - static_cast<double>(cell[k]);
          hat *= (b >> k) & 1 ? t : 1.0 - t;
        }
        const std::int64_t key = pack(corner_of_cell<Dim>(cell, b));
        const int a = index_in_list(node_keys, nodes, key);
        if (a == nodes || node_keys[a] != key) {
          missing = true;
          continue;
        }
        for (int i = 0; i < Dim; ++i) after[Dim * c + i] += hat * displacement[Dim * a + i];
      }
      if (axisymmetric) after[Dim * c] = std::max(after[Dim * c], -position[Dim * p]);
    }
    if (!(basis::least_stretch<Dim>(after) > 0.0)) {
      folded = std::min(folded, p);
      continue;
    }
    const auto weights = basis::corner_weights<Dim>(after);
    for (int i = 0; i < Dim; ++i) {
      double centroid = 0.0;
      for (int c = 0; c < corners_of<Dim>; ++c) centroid += weights.value[c] * after[Dim * c + i];
      shift[Dim * p + i] = centroid;
      for (int c = 0; c < corners_of<Dim>; ++c) after[Dim * c + i] -= centroid;
    }
  }
  if (missing) return node_missing;
  return folded == points ? -1 : folded;
}

/// Cells of the groups, see CentreArrays and Centres (f_bar.hpp).
struct CornerCells {
  const std::int64_t* node_start;  // (groups + 1) in `node`
  const std::int64_t* node;        // keys
  const std::int64_t* cell_start;  // (groups + 1) in `cell`
  const std::int64_t* cell;        // keys
};

/// Corners of a domain, by `LocalLines` from `low`, not beyond the box of its cells from `low` to
/// `high`.
template <int Dim>
void corners_in_box(const double* position, const double* corner, const LocalLines& lines,
                    const Lattice& low, const Lattice& high,
                    std::array<double, Dim> vertex[corners_of<Dim>]) {
  for (int c = 0; c < corners_of<Dim>; ++c)
    for (int k = 0; k < Dim; ++k) {
      const Axis& axis = lines.grid[k];
      const double local = axis.in_cells_like(low[k], position[k]) - static_cast<double>(low[k]) +
                           corner[Dim * c + k] / axis.width(low[k]);
      const double most = lines.line(k, high[k] - low[k] + 1);
      vertex[c][k] = std::max(0.0, std::min(most, local));
    }
}

/// Radius of corners on the axis [cells], so that the part of a cell with only such corners in the
/// sums of the hoop is a limit, not 0 / 0.
inline constexpr double least_radius = 1e-15;

/// Shares of each point in its group's cells, and moments of the cells (see Shares in
/// cell_shares.hpp), from the exact division of its domain along the grid's lines. Parts in cells
/// without a corner of the domain, whose nodes are not its own, count for none; the shares of the
/// others are then larger. `corner_node` (cells of groups, 2^Dim): indices of the cells' nodes in
/// the group's list. The hoop's shares and moments are those of the basis: sums over the corners
/// with their weights. Returns whether all cells of the domains and their nodes were found, and
/// every domain has a volume.
template <int Dim>
bool share_corner_domains(const Stencil& stencil, const CornerCells& supports,
                          const double* position, const double* corner, const double* weight,
                          const GridLines& grid, std::int64_t cells, const std::int64_t* cell_keys,
                          std::int32_t* cell, std::int32_t* corner_node, const Shares& result) {
  constexpr int corners = corners_of<Dim>, moments = moments_of<Dim>;
  Found missing;
  for_each_by_colour(stencil, [&](std::int64_t g) {
    const std::int64_t* own_cells = supports.cell + supports.cell_start[g];
    const std::int64_t of_group = supports.cell_start[g + 1] - supports.cell_start[g];
    const std::int64_t* list = supports.node + supports.node_start[g];
    const std::int64_t n = supports.node_start[g + 1] - supports.node_start[g];
    std::int32_t* number = cell + supports.cell_start[g];
    if (of_group < 1 || of_group > corners) return missing.set();
    Lattice low = unpack(own_cells[0]), high = low;
    for (std::int64_t e = 0; e < of_group; ++e) {
      const Lattice place = unpack(own_cells[e]);
      number[e] = index_in_list(cell_keys, cells, own_cells[e]);
      bool found = number[e] < cells && cell_keys[number[e]] == own_cells[e];
      for (int b = 0; b < corners; ++b) {
        const std::int64_t key = pack(corner_of_cell<Dim>(place, b));
        const int a = index_in_list(list, n, key);
        found = found && a < n && list[a] == key;
        corner_node[corners * (supports.cell_start[g] + e) + b] = a;
      }
      for (int k = 0; k < Dim; ++k) {
        low[k] = std::min(low[k], place[k]);
        high[k] = std::max(high[k], place[k]);
        found = found && high[k] - low[k] < widest_support<Dim>;
      }
      if (!found) return missing.set();
    }
    const auto find = [&](const Lattice& place) {
      const int e = index_in_list(own_cells, of_group, pack(place));
      return e < of_group && own_cells[e] == pack(place) ? e : -1;
    };
    for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
      const double* own = corner + Dim * corners * p;
      const std::int64_t entry = result.share_start[g] + (p - stencil.start[g]) * of_group;
      std::array<double, Dim> vertex[corners];
      const LocalLines lines{grid, low};
      corners_in_box<Dim>(position + Dim * p, own, lines, low, high, vertex);
      double part[corners][moments] = {}, total = 0.0;
      for_simplices<Dim>(vertex, [&](const Simplex<Dim>& simplex) {
        std::array<std::int64_t, Dim> at;
        divide_among_cells<Dim>(simplex, lines, at,
                                [&](const Simplex<Dim>& piece, const auto& place) {
                                  Lattice of_piece = low;
                                  for (int k = 0; k < Dim; ++k)
                                    of_piece[k] += std::min(place[k], high[k] - low[k]);
                                  const int e = find(of_piece);
                                  if (e >= 0) add_moments<Dim>(piece, lines, place, part[e]);
                                });
      });
      for (std::int64_t e = 0; e < of_group; ++e) total += part[e][0];
      if (!(total > 0.0)) return missing.set();
      for (std::int64_t e = 0; e < of_group; ++e) {
        result.share[entry + e] = part[e][0] / total;
        double* sum = result.moment + moments * std::int64_t{number[e]};
        for (int m = 0; m < moments; ++m) sum[m] += weight[p] * part[e][m] / total;
      }
      if constexpr (Dim == 2) {
        if (result.hoop_share == nullptr) continue;
        const auto weights = basis::corner_weights<Dim>(own);
        const double radius = position[Dim * p];
        std::fill_n(result.hoop_share + entry, of_group, 0.0);
        for (int c = 0; c < corners; ++c) {
          double local[Dim];
          const Lattice place = locate_corner<Dim>(position + Dim * p, own + Dim * c, grid, local);
          const int e = find(place);
          if (e < 0) return missing.set();
          for (int k = 0; k < Dim; ++k) local[k] -= static_cast<double>(place[k]);
          double of_corner = radius + own[Dim * c];
          if (std::fabs(of_corner) < least_radius * grid[0].size)
            of_corner = least_radius * grid[0].size;
          result.hoop_share[entry + e] += weights.value[c] * of_corner / radius;
          add_hoop_moments(local, of_corner, weight[p] * weights.value[c] / radius,
                           result.hoop_moment + hoop_moments * std::int64_t{number[e]});
        }
      }
    }
  });
  return !missing;
}

}  // namespace tilth::kernel
