// SPDX-License-Identifier: BSD-3-Clause
// Reads tilth.mpm.f_bar.Centres and the boxes of tilth.mpm.stencil.Stencil.
#pragma once

#include "../kernel/cell_shares.hpp"
#include "../kernel/cluster.hpp"
#include "../kernel/f_bar.hpp"
#include "stencil_view.hpp"

namespace tilth::bind {

/// Reads tilth.mpm.f_bar.Centres; None for no F-bar.
struct CentresView : kernel::Centres {
  ConstIntegers arrays64[2];
  ConstShorts arrays32[3];
  ConstDoubles read[8];
  Doubles written[2];
  bool given;

  explicit CentresView(nb::handle centres)
      : kernel::Centres{}, given(!centres.is_none()), object_(centres) {
    if (!given) return;
    arrays32[0] = attribute<ConstShorts>(centres, "count");
    arrays32[1] = attribute<ConstShorts>(centres, "cell");
    arrays32[2] = attribute<ConstShorts>(centres, "corner_node");
    arrays64[0] = attribute<ConstIntegers>(centres, "cell_start");
    arrays64[1] = attribute<ConstIntegers>(centres, "share_start");
    for (int i = 0; i < 8; ++i) read[i] = attribute<ConstDoubles>(centres, numbers[i]);
    written[0] = attribute<Doubles>(centres, "jacobian_ratio");
    written[1] = attribute<Doubles>(centres, "jacobian");
    count = arrays32[0].data();
    cell = arrays32[1].data();
    corner_node = arrays32[2].size() > 0 ? arrays32[2].data() : nullptr;
    cell_start = arrays64[0].data();
    share_start = arrays64[1].data();
    share = read[0].data();
    volume_change = read[1].data();
    trace = read[2].data();
    jacobian_ratio_before = read[3].data();
    pressure = read[4].data();
    hoop_share = read[5].data();
    hoop_gradient = read[6].data();
    hoop_change = read[7].data();
    jacobian_ratio = written[0].data();
    jacobian = written[1].data();
  }

  const kernel::Centres* get() const { return given ? this : nullptr; }

  /// Number of the cells.
  std::int64_t cells() const { return size_of(read[1]); }

  /// Refuses cells and shares that are not those of groups with the first points `group_start`.
  void require_cells(std::int64_t groups, const std::int64_t* group_start) const {
    require_size(arrays64[0], groups + 1, "cell_start");
    require_starts(arrays64[0], size_of(arrays32[1]), "cell_start");
    require_indices(arrays32[1], cells(), "cell");
    require_size(arrays64[1], groups + 1, "share_start");
    require_starts(arrays64[1], size_of(read[0]), "share_start");
    require(group_start[groups] <= size_of(read[0]), "share", "lacks points");
    bool other = false;
    for (std::int64_t g = 0; g < groups; ++g)
      other |= share_start[g + 1] - share_start[g] !=
               (cell_start[g + 1] - cell_start[g]) * (group_start[g + 1] - group_start[g]);
    require(!other, "share_start", "does not fit to the points and cells of a group");
  }

  /// Refuses centres that are not those of the points of a stencil.
  void require_fits(const StencilView& stencil, nb::handle stencil_handle,
                    const std::string& kind_name) const {
    if (!given) return;
    const bool hoop = kind_name == "axisymmetric";  // not one of what was checked before
    require_size(read[5], hoop ? size_of(read[0]) : 0, "hoop_share");
    require_size(read[6], hoop ? cells() << stencil.dim : 0, "hoop_gradient");
    require_size(read[7], hoop ? cells() : 0, "hoop_change");
    auto others = parts_of(object_, numbers);
    for (const auto& part : parts_of(object_, {"jacobian_ratio", "jacobian"}))
      others.push_back(part);
    others.push_back(nb::borrow(stencil_handle));
    check_once(object_,
               parts_of(object_, {"count", "cell_start", "cell", "corner_node", "share_start"}),
               others, [&] {
                 require_valid(stencil);
                 return std::int64_t{0};
               });
  }

 private:
  static constexpr const char* numbers[8] = {
      "share",    "volume_change", "trace",         "jacobian_ratio_before",
      "pressure", "hoop_share",    "hoop_gradient", "hoop_change"};

  nb::handle object_;

  void require_valid(const StencilView& stencil) const {
    const std::int64_t corners = 1 << stencil.dim;
    require_cells(stencil.groups, stencil.start);
    require_size(read[2], cells() * corners * stencil.dim, "trace");
    require_size(read[3], stencil.points(), "jacobian_ratio_before");
    require_size(read[4], stencil.points(), "pressure");
    require_size(written[0], stencil.points(), "jacobian_ratio");
    require_size(written[1], stencil.points(), "jacobian");
    bool other = false;
    for (std::int64_t g = 0; g < stencil.groups; ++g) other |= cells_of(g) > kernel::maximum_nodes;
    require(!other, "cell_start", "has a group with too many cells");
    if (corner_node != nullptr) {
      require_size(arrays32[2], size_of(arrays32[1]) * corners, "corner_node");
      for (std::int64_t g = 0; g < stencil.groups; ++g)
        for (std::int64_t i = corners * cell_start[g]; i < corners * cell_start[g + 1]; ++i)
          other |= corner_node[i] < 0 || corner_node[i] >= stencil.nodes_of(g);
      require(!other, "corner_node", "has an index that is not one of the group's nodes");
      return;
    }
    require_size(arrays32[0], 3 * stencil.groups, "count");
    for (std::int64_t g = 0; g < stencil.groups; ++g) {
      const std::int64_t x = count[3 * g], y = count[3 * g + 1];
      const std::int64_t z = stencil.dim == 3 ? count[3 * g + 2] : 2;
      constexpr std::int64_t most = kernel::maximum_nodes;
      other |= x < 2 || y < 2 || z < 2 || x > most || y > most || z > most;
      other |= x * y * (stencil.dim == 3 ? z : 1) != stencil.nodes_of(g);
      other |= (x - 1) * (y - 1) * (z - 1) != cell_start[g + 1] - cell_start[g];
    }
    require(!other, "count", "does not fit to the nodes and cells of a group");
  }
};

/// Arrays of the shares of the domains in the cells, and of the cells' moments.
class SharesOwner {
  static auto table(std::vector<double>&& entries, std::size_t columns) {
    const std::size_t rows = entries.size() / columns;
    return give(std::move(entries), {rows, columns});
  }

 public:
  SharesOwner(int dim, bool axisymmetric, std::int64_t cells,
              const std::vector<std::int64_t>& share_start)
      : columns_(dim == 2 ? kernel::moments_of<2> : kernel::moments_of<3>),
        axisymmetric_(axisymmetric),
        share_(share_start.back()),
        moment_(cells * columns_),
        hoop_share_(axisymmetric ? share_start.back() : 0),
        hoop_moment_(axisymmetric ? cells * kernel::hoop_moments : 0),
        start_(share_start.data()) {}

  kernel::Shares get() {
    return {start_, share_.data(), moment_.data(), axisymmetric_ ? hoop_share_.data() : nullptr,
            hoop_moment_.data()};
  }

  auto give_shares() { return give(std::move(share_)); }
  auto give_moment() { return table(std::move(moment_), columns_); }
  auto give_hoop_shares() { return give(std::move(hoop_share_)); }
  auto give_hoop_moment() { return table(std::move(hoop_moment_), kernel::hoop_moments); }

 private:
  std::size_t columns_;
  bool axisymmetric_;
  std::vector<double> share_, moment_, hoop_share_, hoop_moment_;
  const std::int64_t* start_;
};

/// The boxes of nodes of a Python `Stencil`: each has a cell at least.
struct BoxesView {
  ConstIntegers first;
  ConstShorts count;

  BoxesView(nb::handle handle, const StencilView& stencil)
      : first(attribute<ConstIntegers>(handle, "first")),
        count(attribute<ConstShorts>(handle, "count")),
        stencil_(stencil) {
    require(stencil.count != nullptr, "stencil", "has groups whose nodes do not fill a box");
    require_size(first, 3 * stencil.groups, "first");
    require_lattice(first, "first");
    bool empty = false;
    for (std::int64_t g = 0; g < stencil.groups; ++g)
      for (int k = 0; k < stencil.dim; ++k) empty |= count.data()[3 * g + k] < 2;
    require(!empty, "count", "has a group with less than two nodes in a direction");
  }

  /// Refuses domains that are not those of the points.
  void require_domains(const ConstDoubles& position, const ConstDoubles& half_length) const {
    require_table(position, stencil_.points(), stencil_.dim, "position");
    require_table(half_length, stencil_.points(), stencil_.dim, "half_length");
  }

 private:
  const StencilView& stencil_;
};

/// Reads the boxes around the supports of a Stencil's groups, and their nodes where these do not
/// fill the boxes. The kernel finds nodes that are not inside of their box.
struct SupportsView {
  ConstIntegers first, node_key;
  ConstShorts count;
  kernel::Boxes boxes;

  SupportsView(nb::handle handle, const StencilView& stencil)
      : first(attribute<ConstIntegers>(handle, "first")),
        node_key(attribute<ConstIntegers>(handle, "node_key")),
        count(attribute<ConstShorts>(handle, "count")),
        boxes{first.data(), count.data(), stencil.count == nullptr ? node_key.data() : nullptr} {
    require_size(first, 3 * stencil.groups, "first");
    if (stencil.count == nullptr)
      require_size(node_key, stencil.node_start[stencil.groups], "node_key");
  }
};

}  // namespace tilth::bind
