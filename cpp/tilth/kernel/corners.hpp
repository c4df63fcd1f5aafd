// SPDX-License-Identifier: BSD-3-Clause
// Points whose domains have corners (basis/corners.hpp): their supports, basis values and motion. A
// point's nodes are those of the cells that hold a corner; the cells need not be neighbours. Points
// that share these cells make a group, which keeps them in a list
// (docs/decisions/0014-corner-domains.md). Corners are given from the point, shape (n, 2^Dim, Dim).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../basis/corners.hpp"
#include "../basis/gimp.hpp"
#include "../grid.hpp"
#include "../parallel.hpp"
#include "view.hpp"

namespace tilth::kernel {

using basis::corners_of;

/// A cell of a support is told by its place in the box around it, so many bits a direction.
template <int Dim>
inline constexpr int place_bits = Dim == 2 ? 8 : 5;

/// Most cells of this box in each direction.
template <int Dim>
inline constexpr int widest_support = 1 << place_bits<Dim>;

/// Numbers of 64 bits that tell the cells of a support, four in each.
template <int Dim>
inline constexpr int words_of = corners_of<Dim> / 4;

/// A regular grid: position of a node and size of a cell, (Dim).
struct Cells {
  const double* origin;
  const double* size;
};

/// A corner's place in cells and the cell that it lies in. A corner on a grid line belongs to the
/// cell on the domain's side of it: overlaps below `relative_overlap` are no support (gimp.hpp).
template <int Dim>
Lattice corner_place(const double* position, const double* corner, const Cells& cells,
                     double place[Dim]) {
  Lattice cell{0, 0, 0};
  for (int k = 0; k < Dim; ++k) {
    const double centre = (position[k] - cells.origin[k]) / cells.size[k];
    const double reach = corner[k] / cells.size[k];
    place[k] = centre + reach;
    const double inside = centre + reach * (1.0 - basis::Gimp::relative_overlap);
    // beyond the reach of a key any number will do that is beyond it too
    cell[k] =
        static_cast<std::int64_t>(std::floor(std::clamp(inside, -1.0 * key_bias, 1.0 * key_bias)));
  }
  return cell;
}

enum SupportFailure : std::int64_t { beyond_reach = -1, too_wide = -2 };

/// Key of the lowest corner of the box of cells around each point's support, or a SupportFailure,
/// and the places of the cells in that box, (n, words): ascending, the last one repeated. Returns
/// the number of failures.
template <int Dim>
std::int64_t corner_supports(std::int64_t points, const double* position, const double* corner,
                             const Cells& cells, std::int64_t* keys, std::int64_t* words) {
  constexpr int corners = corners_of<Dim>;
  std::int64_t failures = 0;
#pragma omp parallel for schedule(static) reduction(+ : failures) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    Lattice cell[corners], low{0, 0, 0}, high{0, 0, 0};
    for (int c = 0; c < corners; ++c) {
      double place[Dim];
      cell[c] =
          corner_place<Dim>(position + Dim * p, corner + Dim * (corners * p + c), cells, place);
      for (int k = 0; k < Dim; ++k) {
        low[k] = c == 0 ? cell[c][k] : std::min(low[k], cell[c][k]);
        high[k] = c == 0 ? cell[c][k] : std::max(high[k], cell[c][k]);
      }
    }
    bool inside = true, narrow = true;
    for (int k = 0; k < Dim; ++k) {
      inside = inside && low[k] > -key_reach && high[k] < key_reach;
      narrow = narrow && high[k] - low[k] < widest_support<Dim>;
    }
    keys[p] = !inside ? beyond_reach : (!narrow ? too_wide : pack(low));
    failures += keys[p] < 0;
    std::uint64_t place[corners] = {};
    if (keys[p] >= 0)
      for (int c = 0; c < corners; ++c)
        for (int k = Dim - 1; k >= 0; --k)
          place[c] =
              (place[c] << place_bits<Dim>) | static_cast<std::uint64_t>(cell[c][k] - low[k]);
    std::sort(place, place + corners);
    const auto* last = std::unique(place, place + corners);
    for (int w = 0; w < words_of<Dim>; ++w) {
      std::uint64_t word = 0;
      for (int c = 4 * w; c < 4 * w + 4; ++c)
        word = (word << 16) | (place + c < last ? place[c] : *(last - 1));
      words[words_of<Dim> * p + w] = static_cast<std::int64_t>(word);
    }
  }
  return failures;
}

/// Groups of points sorted by key and words: see Groups (stencil.hpp), whose box of nodes
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
                                 const std::int64_t* words) {
  constexpr int count_words = words_of<Dim>;
  CornerGroups groups;
  for (std::int64_t p = 0; p < points; ++p) {
    const std::int64_t* own = words + count_words * p;
    if (p > 0 && keys[p] == keys[p - 1] && std::equal(own, own + count_words, own - count_words))
      continue;
    const Lattice first = unpack(keys[p]);
    std::int32_t count[3] = {2, 2, Dim == 3 ? 2 : 1};
    std::int64_t before = -1;
    for (int c = 0; c < corners_of<Dim>; ++c) {
      const auto word = static_cast<std::uint64_t>(own[c / 4]);
      const auto place = static_cast<std::int64_t>((word >> (16 * (3 - c % 4))) & 0xffff);
      if (place == before) break;
      before = place;
      Lattice cell = first;
      for (int k = 0; k < Dim; ++k) {
        const std::int64_t offset = (place >> (k * place_bits<Dim>)) & (widest_support<Dim> - 1);
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

/// Place of a node in a group's ascending list of node keys.
inline int place_in_list(const std::int64_t* list, std::int64_t size, std::int64_t key) {
  return static_cast<int>(std::lower_bound(list, list + size, key) - list);
}

/// Basis values and gradients, laid out as basis_values.hpp has it.
template <int Dim>
void corner_basis_values(std::int64_t groups, const std::int64_t* start,
                         const std::int64_t* node_start, const std::int64_t* node_keys,
                         const std::int64_t* value_start, const double* position,
                         const double* corner, const Cells& cells, double* value) {
#pragma omp parallel for schedule(static) if (start[groups] >= parallel_from)
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
        double place[Dim];
        const Lattice cell = corner_place<Dim>(position + Dim * p, own + Dim * c, cells, place);
        for (int b = 0; b < corners_of<Dim>; ++b) {
          double hat = 1.0;
          for (int k = 0; k < Dim; ++k) {
            const double t = place[k] - static_cast<double>(cell[k]);
            hat *= (b >> k) & 1 ? t : 1.0 - t;
          }
          const int a = place_in_list(list, n, pack(corner_of_cell<Dim>(cell, b)));
          s[a] += weights.value[c] * hat;
          for (int k = 0; k < Dim; ++k) d[k * n + a] += weights.gradient[c][k] * hat;
        }
      }
    }
  }
}

/// Moves corners with the grid's finite-element field: fills `moved` (n, 2^Dim, Dim), from the
/// point's new place, and `shift` (n, Dim), the motion of the point, which is the domain's
/// centroid. In axisymmetry a corner that would cross the axis stays on it. Returns the first point
/// whose domain is folded or inverted then, -1 if none is.
template <int Dim>
std::int64_t move_corners(std::int64_t points, const double* position, const double* corner,
                          std::int64_t nodes, const std::int64_t* node_keys,
                          const double* displacement, const Cells& cells, bool axisymmetric,
                          double* moved, double* shift) {
  std::int64_t folded = points;
#pragma omp parallel for schedule(static) reduction(min : folded) if (points >= parallel_from)
  for (std::int64_t p = 0; p < points; ++p) {
    const double* own = corner + Dim * corners_of<Dim> * p;
    double* after = moved + Dim * corners_of<Dim> * p;
    for (int c = 0; c < corners_of<Dim>; ++c) {
      double place[Dim];
      const Lattice cell = corner_place<Dim>(position + Dim * p, own + Dim * c, cells, place);
      for (int i = 0; i < Dim; ++i) after[Dim * c + i] = own[Dim * c + i];
      for (int b = 0; b < corners_of<Dim>; ++b) {
        double hat = 1.0;
        for (int k = 0; k < Dim; ++k) {
          const double t = place[k] - static_cast<double>(cell[k]);
          hat *= (b >> k) & 1 ? t : 1.0 - t;
        }
        const int a = place_in_list(node_keys, nodes, pack(corner_of_cell<Dim>(cell, b)));
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
  return folded == points ? -1 : folded;
}

/// Cells of the groups, see CentreArrays and Centres (f_bar.hpp).
struct CornerCells {
  const std::int64_t* node_start;  // (groups + 1) in `node`
  const std::int64_t* node;        // keys
  const std::int64_t* cell_start;  // (groups + 1) in `cell`
  const std::int64_t* cell;        // keys
};

/// Places in each direction of a domain that share it among cells: those of the trapezoidal rule,
/// with the corners, so that no cell of the support is left without a share.
inline constexpr int places_per_direction = 5;

/// A place given from the point, in cells, and the lowest and the highest cell that it belongs to:
/// they differ where it lies on a grid line.
template <int Dim>
void place_on_lines(const double* position, const double* from_point, const Cells& cells,
                    double place[Dim], Lattice& low, Lattice& high) {
  low = high = {0, 0, 0};
  for (int k = 0; k < Dim; ++k) {
    place[k] = (position[k] - cells.origin[k]) / cells.size[k] + from_point[k] / cells.size[k];
    const double near = basis::Gimp::relative_overlap;
    low[k] = static_cast<std::int64_t>(std::floor(place[k] - near));
    high[k] = static_cast<std::int64_t>(std::floor(place[k] + near));
  }
}

/// Shares of each point in its group's cells, and moments of the cells (share_among_cells in
/// f_bar.hpp). A domain is represented by 5^Dim places. Each counts for the cell that it lies in,
/// on a grid line for those on both sides, or, where that one is not of the support, for that of
/// the nearest corner. `corner_node` (cells of groups, 2^Dim): where the cells' nodes stand in the
/// group's list.
template <int Dim>
void share_corner_domains(const Stencil& stencil, const CornerCells& supports,
                          const double* position, const double* corner, const double* weight,
                          const Cells& grid, std::int64_t cells, const std::int64_t* cell_keys,
                          std::int32_t* cell, std::int32_t* corner_node,
                          const std::int64_t* share_start, double* share, double* moment) {
  constexpr int corners = corners_of<Dim>;
  constexpr int line = places_per_direction;
  constexpr int parts = Dim == 2 ? line * line : line * line * line;
  for_each_by_colour(stencil, [&](std::int64_t g) {
    const std::int64_t* own_cells = supports.cell + supports.cell_start[g];
    const std::int64_t of_group = supports.cell_start[g + 1] - supports.cell_start[g];
    const std::int64_t* list = supports.node + supports.node_start[g];
    const std::int64_t n = supports.node_start[g + 1] - supports.node_start[g];
    std::int32_t* number = cell + supports.cell_start[g];
    for (std::int64_t e = 0; e < of_group; ++e) {
      number[e] = place_in_list(cell_keys, cells, own_cells[e]);
      for (int b = 0; b < corners; ++b)
        corner_node[corners * (supports.cell_start[g] + e) + b] =
            place_in_list(list, n, pack(corner_of_cell<Dim>(unpack(own_cells[e]), b)));
    }
    for (std::int64_t p = stencil.start[g]; p < stencil.start[g + 1]; ++p) {
      const double* own = corner + Dim * corners * p;
      double* shares = share + share_start[g] + (p - stencil.start[g]) * of_group;
      double part_volume[parts], part_middle[parts][Dim], volume = 0.0;
      for (int part = 0; part < parts; ++part) {
        double xi[Dim], value[corners], slope[corners][Dim], cofactor[Dim][Dim];
        double weight_here = 1.0;
        for (int k = 0, rest = part; k < Dim; ++k, rest /= line) {
          const int along = rest % line;
          xi[k] = 2.0 * along / (line - 1) - 1.0;
          if (along == 0 || along == line - 1) weight_here *= 0.5;
        }
        basis::corner_functions<Dim>(xi, value, slope);
        part_volume[part] = weight_here * basis::cofactors<Dim>(own, slope, cofactor);
        volume += part_volume[part];
        for (int k = 0; k < Dim; ++k) {
          part_middle[part][k] = 0.0;
          for (int c = 0; c < corners; ++c) part_middle[part][k] += value[c] * own[Dim * c + k];
        }
      }
      std::fill(shares, shares + of_group, 0.0);
      for (int part = 0; part < parts; ++part) {
        int nearest = 0;
        for (int k = 0, rest = part; k < Dim; ++k, rest /= line)
          if (2 * (rest % line) > line - 1) nearest |= 1 << k;
        double place[Dim];
        Lattice low, high;  // cells on both sides of a grid line on which the place lies
        place_on_lines<Dim>(position + Dim * p, part_middle[part], grid, place, low, high);
        for (int side = 0; side < corners; ++side) {
          Lattice at = low;
          double its_share = part_volume[part] / volume;
          bool again = false;
          for (int k = 0; k < Dim; ++k) {
            if (low[k] != high[k]) its_share *= 0.5;
            again = again || ((side >> k & 1) && low[k] == high[k]);
            if (side >> k & 1) at[k] = high[k];
          }
          if (again) continue;
          int e = place_in_list(own_cells, of_group, pack(at));
          double centroid[Dim];
          std::copy_n(place, Dim, centroid);
          if (e == of_group || own_cells[e] != pack(at)) {
            double of_corner[Dim];
            const Lattice known =
                corner_place<Dim>(position + Dim * p, own + Dim * nearest, grid, of_corner);
            e = place_in_list(own_cells, of_group, pack(known));
            for (int k = 0; k < Dim; ++k) {
              const auto from = static_cast<double>(known[k]);
              centroid[k] = std::clamp(place[k], from, from + 1.0);
            }
          }
          shares[e] += its_share;
          double* sum = moment + (1 + Dim) * std::int64_t{number[e]};
          sum[0] += weight[p] * its_share;
          for (int k = 0; k < Dim; ++k) sum[1 + k] += weight[p] * its_share * centroid[k];
        }
      }
    }
  });
}

}  // namespace tilth::kernel
