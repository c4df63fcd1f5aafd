// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/advance.hpp"
#include "../kernel/cell_shares.hpp"
#include "../kernel/cell_volumes.hpp"
#include "../kernel/internal_force.hpp"
#include "../kernel/mass.hpp"
#include "../kernel/predictor.hpp"
#include "../kernel/stiffness.hpp"
#include "../kernel/strain_smoothing.hpp"
#include "../kernel/stress.hpp"
#include "centres_view.hpp"
#include "grid_view.hpp"
#include "law.hpp"

namespace tilth::bind {

namespace {

int response_size(const std::string& kind_name) {
  int size = 0;
  with_kind(kind_name, [&](auto kind) { size = kernel::response_size<decltype(kind)>; });
  return size;
}

template <class Function>
void map_principal_values(const std::string& kind_name, const ConstDoubles& tensor,
                          const Doubles& result, const char* name, Function function) {
  const std::int64_t points = rows_of(tensor, 2, "tensor");
  require_table(tensor, points, 6, "tensor");
  require_size(result, 6 * points, name);
  nb::gil_scoped_release release;
  with_kind(kind_name, [&](auto kind) {
    kernel::map_principal_values<decltype(kind)>(points, tensor.data(), result.data(), function);
  });
}

void elastic_deformation(const std::string& kind_name, ConstDoubles strain, Doubles deformation) {
  map_principal_values(kind_name, strain, deformation, "deformation",
                       [](double value) { return std::expm1(2.0 * value); });
}

void elastic_strain(const std::string& kind_name, ConstDoubles deformation, Doubles strain) {
  map_principal_values(kind_name, deformation, strain, "strain",
                       [](double value) { return 0.5 * std::log1p(value); });
}

auto volumetric_strains(ConstDoubles deformation) {
  std::vector<double> strain(rows_of(deformation, 2, "deformation"));
  require_table(deformation, static_cast<std::int64_t>(strain.size()), 6, "deformation");
  kernel::volumetric_strains(static_cast<std::int64_t>(strain.size()), deformation.data(),
                             strain.data());
  return give(std::move(strain));
}

std::tuple<std::int64_t, std::int64_t> stress_update(
    const std::string& kind_name, nb::handle material, ConstDoubles parameters,
    nb::handle stencil_handle, ConstDoubles displacement, ConstDoubles position,
    ConstDoubles elastic_before, ConstDoubles plastic_before, ConstDoubles state_before,
    Doubles elastic, Doubles plastic, Doubles state, Doubles response, nb::handle centres_handle,
    ConstFlags torn_off, Flags kept, ConstDoubles interval) {
  const StencilView stencil(stencil_handle);
  const CentresView centres(centres_handle);
  const std::int64_t n = stencil.points(), width = columns_of(state, "state");
  stencil.require_kind(kind_name);
  require_table(displacement, rows_of(displacement, 2, "displacement"), stencil.dim,
                "displacement");
  stencil.require_nodes(rows_of(displacement, 2, "displacement"), "displacement");
  stencil.require_points(position, stencil.dim, "position");
  require_size(elastic_before, 6 * n, "elastic_before");
  require_size(plastic_before, 2 * n, "plastic_before");
  require_table(state_before, n, width, "state_before");
  require_size(state, n * width, "state");
  centres.require_fits(stencil, stencil_handle, kind_name);
  require_size(elastic, 6 * n, "elastic");
  require_size(plastic, 2 * n, "plastic");
  require_size(response, response_size(kind_name) * n, "response");
  const bool tears = size_of(torn_off) > 0;
  if (tears) {
    require_size(torn_off, n, "torn_off");
    require_size(kept, n, "kept");
  }
  const kernel::StressArrays arrays{position.data(),
                                    elastic_before.data(),
                                    plastic_before.data(),
                                    state_before.data(),
                                    elastic.data(),
                                    plastic.data(),
                                    state.data(),
                                    response.data(),
                                    width,
                                    tears ? torn_off.data() : nullptr,
                                    tears ? kept.data() : nullptr,
                                    interval_of(interval)};
  const CheckedLaw checked = checked_law(material, parameters, n, width);
  kernel::Failure failure;
  nb::gil_scoped_release release;
  checked.evaluate([&](const material::PointLaw& law) {
    with_kind(kind_name, [&](auto kind) {
      failure = kernel::stress_update<decltype(kind)>(stencil, law, displacement.data(), arrays,
                                                      centres.get());
    });
  });
  return {failure.point, static_cast<std::int64_t>(failure.status)};
}

void internal_force(const std::string& kind_name, nb::handle stencil_handle, ConstDoubles volume,
                    ConstDoubles position, ConstDoubles response, Doubles force,
                    nb::handle centres_handle) {
  const StencilView stencil(stencil_handle);
  const CentresView centres(centres_handle);
  stencil.require_kind(kind_name);
  require_size(volume, stencil.points(), "volume");
  stencil.require_points(position, stencil.dim, "position");
  stencil.require_points(response, response_size(kind_name), "response");
  require_table(force, rows_of(force, 2, "force"), stencil.dim, "force");
  stencil.require_nodes(rows_of(force, 2, "force"), "force");
  centres.require_fits(stencil, stencil_handle, kind_name);
  nb::gil_scoped_release release;
  with_kind(kind_name, [&](auto kind) {
    kernel::internal_force<decltype(kind)>(stencil, volume.data(), position.data(), response.data(),
                                           centres.get(), force.data());
  });
}

void stiffness(const std::string& kind_name, nb::handle stencil_handle, ConstIntegers block_start,
               ConstShorts block_position, ConstDoubles volume, ConstDoubles position,
               ConstDoubles response, Doubles matrix, nb::handle centres_handle) {
  const StencilView stencil(stencil_handle);
  const CentresView centres(centres_handle);
  stencil.require_kind(kind_name);
  require_size(volume, stencil.points(), "volume");
  stencil.require_points(position, stencil.dim, "position");
  stencil.require_points(response, response_size(kind_name), "response");
  require_size(block_start, stencil.groups, "block_start");
  const std::int64_t blocks_of_matrix = rows_of(matrix, 3, "matrix");
  require_size(matrix, blocks_of_matrix * stencil.dim * stencil.dim, "matrix");
  centres.require_fits(stencil, stencil_handle, kind_name);
  const kernel::BlockPositions blocks{block_start.data(), block_position.data(),
                                      size_of(block_position), blocks_of_matrix};
  const SupportsView supports(stencil_handle, stencil);
  nb::gil_scoped_release release;
  bool fits = true;
  with_kind(kind_name, [&](auto kind) {
    using K = decltype(kind);
    const auto* of_points = reinterpret_cast<const kernel::Response<K>*>(response.data());
    fits = kernel::stiffness<K>(stencil, supports.boxes, blocks,
                                {volume.data(), position.data(), of_points, centres.get()},
                                matrix.data());
  });
  require(fits, "block_position", "does not fit to block_start, stencil and matrix");
}

void add_mass(nb::handle stencil_handle, ConstIntegers block_start, ConstShorts block_position,
              ConstDoubles mass, Doubles matrix) {
  const StencilView stencil(stencil_handle);
  require_size(mass, stencil.points(), "mass");
  require_size(block_start, stencil.groups, "block_start");
  const kernel::BlockPositions blocks{block_start.data(), block_position.data(),
                                      size_of(block_position), size_of(matrix)};
  nb::gil_scoped_release release;
  const auto add = stencil.dim == 2 ? &kernel::add_mass<2> : &kernel::add_mass<3>;
  require(add(stencil, blocks, mass.data(), matrix.data()), "block_position",
          "does not fit to block_start, stencil and matrix");
}

/// Adds each point's volume and its volume times `weight` to the cells that its domain intersects.
void fill_cells(nb::handle stencil_handle, ConstDoubles position, ConstDoubles half_length,
                ConstDoubles volume, ConstDoubles weight, nb::handle grid_handle,
                ConstIntegers cell_keys, Doubles filled) {
  const StencilView stencil(stencil_handle);
  const BoxesView boxes(stencil_handle, stencil);
  const GridView grid(grid_handle, stencil.dim);
  boxes.require_domains(position, half_length);
  require_size(volume, stencil.points(), "volume");
  require_size(weight, stencil.points(), "weight");
  require_size(filled, 2 * size_of(cell_keys), "filled");
  const int dim = stencil.dim;
  const auto fill = dim == 2 ? &kernel::fill_cells<2> : &kernel::fill_cells<3>;
  require(
      fill(stencil, boxes.first.data(), boxes.count.data(), position.data(), half_length.data(),
           volume.data(), weight.data(), grid, size_of(cell_keys), cell_keys.data(), filled.data()),
      "cell_keys", "lacks a cell of the stencil");
}

/// Cells and shares of F-bar (tilth.mpm.f_bar.Centres), and the moments of the material in the
/// cells.
auto share_among_cells(nb::handle stencil_handle, ConstDoubles position, ConstDoubles half_length,
                       ConstDoubles weight, nb::handle grid_handle, ConstIntegers cell_keys,
                       bool axisymmetric) {
  const StencilView stencil(stencil_handle);
  const BoxesView boxes(stencil_handle, stencil);
  const GridView grid(grid_handle, stencil.dim);
  boxes.require_domains(position, half_length);
  require_size(weight, stencil.points(), "weight");
  const int dim = stencil.dim;
  require(!axisymmetric || dim == 2, "axisymmetric", "is true in 3D");
  std::vector<std::int64_t> cell_start(stencil.groups + 1, 0), share_start(stencil.groups + 1, 0);
  for (std::int64_t g = 0; g < stencil.groups; ++g) {
    const std::int32_t* nodes = boxes.count.data() + 3 * g;
    const std::int64_t of_group =
        std::int64_t{nodes[0] - 1} * (nodes[1] - 1) * (dim == 3 ? nodes[2] - 1 : 1);
    cell_start[g + 1] = cell_start[g] + of_group;
    share_start[g + 1] = share_start[g] + of_group * (stencil.start[g + 1] - stencil.start[g]);
  }
  const std::int64_t cells = size_of(cell_keys);
  std::vector<std::int32_t> cell(cell_start.back());
  SharesOwner shares(dim, axisymmetric, cells, share_start);
  const auto fill = dim == 2 ? &kernel::share_among_cells<2> : &kernel::share_among_cells<3>;
  require(fill(stencil, boxes.first.data(), boxes.count.data(), position.data(), half_length.data(),
               weight.data(), grid, cells, cell_keys.data(), cell_start.data(), cell.data(),
               shares.get()),
          "cell_keys", "lacks a cell of the stencil");
  return std::make_tuple(give(std::move(cell_start)), give(std::move(cell)),
                         give(std::move(share_start)), shares.give_shares(), shares.give_moment(),
                         shares.give_hoop_shares(), shares.give_hoop_moment());
}

void update_centres(const std::string& kind_name, ConstShorts node, ConstDoubles gradient,
                    ConstDoubles hoop_gradient, ConstDoubles displacement, Doubles volume_change,
                    Doubles trace, Doubles hoop_change) {
  const int dim = dimension_of_kind(kind_name);
  const bool hoop = kind_name == "axisymmetric";
  const std::int64_t cells = rows_of(node, 2, "node"),
                     nodes = rows_of(displacement, 2, "displacement");
  require_table(node, cells, 1 << dim, "node");
  require_table(displacement, nodes, dim, "displacement");
  require_indices(node, nodes, "node");
  require_size(gradient, size_of(node) * dim, "gradient");
  require_size(hoop_gradient, hoop ? size_of(node) : 0, "hoop_gradient");
  require_size(volume_change, cells, "volume_change");
  require_size(trace, size_of(gradient), "trace");
  require_size(hoop_change, hoop ? cells : 0, "hoop_change");
  const kernel::CentreArrays arrays{node.data(),          gradient.data(), hoop_gradient.data(),
                                    volume_change.data(), trace.data(),    hoop_change.data()};
  nb::gil_scoped_release release;
  with_kind(kind_name, [&](auto kind) {
    kernel::update_centres<decltype(kind)>(cells, arrays, displacement.data());
  });
}

auto smooth_strains(ConstIntegers group_start, nb::handle centres_handle, std::int64_t cells,
                    ConstDoubles strain, ConstDoubles volume, ConstDoubles fraction) {
  const CentresView centres(centres_handle);
  require(centres.given, "centres", "is None");
  const std::int64_t groups = size_of(group_start) - 1;
  require(groups >= 0, "group_start", "is empty, expected one entry more than groups");
  const std::int64_t points = group_start.data()[groups];
  require_starts(group_start, points, "group_start");
  centres.require_cells(groups, group_start.data());
  require(cells == centres.cells(), "cells", "is not the number of cells of centres");
  require_size(strain, points, "strain");
  require_size(volume, points, "volume");
  require_size(fraction, points, "fraction");
  std::vector<double> increment(points);
  kernel::smooth_strains(groups, group_start.data(), centres, cells, strain.data(), volume.data(),
                         fraction.data(), increment.data());
  return give(std::move(increment));
}

void add_predictions(nb::handle stencil_handle, ConstDoubles node_position, ConstDoubles position,
                     ConstDoubles displacement, ConstDoubles gradient, ConstDoubles volume,
                     Doubles sum) {
  const StencilView stencil(stencil_handle);
  const std::int64_t dim = stencil.dim;
  require_table(node_position, rows_of(node_position, 2, "node_position"), dim, "node_position");
  stencil.require_nodes(rows_of(node_position, 2, "node_position"), "node_position");
  require_size(position, stencil.points() * dim, "position");
  require_size(displacement, stencil.points() * dim, "displacement");
  require_size(gradient, stencil.points() * dim * dim, "gradient");
  require_size(volume, stencil.points(), "volume");
  require_size(sum, static_cast<std::int64_t>(node_position.shape(0)) * (1 + dim), "sum");
  nb::gil_scoped_release release;
  const auto add = dim == 2 ? &kernel::add_predictions<2> : &kernel::add_predictions<3>;
  add(stencil, node_position.data(), position.data(), displacement.data(), gradient.data(),
      volume.data(), sum.data());
}

auto current_volumes(ConstDoubles deformation_gradient, ConstDoubles initial_volume) {
  std::vector<double> volume(initial_volume.size());
  const auto points = static_cast<std::int64_t>(volume.size());
  require_size(deformation_gradient, 9 * points, "deformation_gradient");
  kernel::current_volumes(points, deformation_gradient.data(), initial_volume.data(),
                          volume.data());
  return give(std::move(volume));
}

void advance(const std::string& kind_name, nb::handle stencil_handle, ConstDoubles displacement,
             ConstDoubles position, ConstDoubles response, ConstDoubles plastic_before,
             ConstDoubles plastic_after, Doubles last_gradient, Doubles deformation_gradient,
             Doubles cauchy, Doubles elastic_share, double forgotten_strain, ConstFlags kept) {
  const StencilView stencil(stencil_handle);
  const std::int64_t n = stencil.points();
  stencil.require_kind(kind_name);
  require_table(displacement, rows_of(displacement, 2, "displacement"), stencil.dim,
                "displacement");
  stencil.require_nodes(rows_of(displacement, 2, "displacement"), "displacement");
  stencil.require_points(position, stencil.dim, "position");
  require_size(response, response_size(kind_name) * n, "response");
  require_size(plastic_before, 2 * n, "plastic_before");
  require_size(plastic_after, 2 * n, "plastic_after");
  require_size(last_gradient, stencil.dim * stencil.dim * n, "last_gradient");
  require_size(deformation_gradient, 9 * n, "deformation_gradient");
  require_size(cauchy, 6 * n, "cauchy");
  require_size(elastic_share, n, "elastic_share");
  const bool tears = size_of(kept) > 0;
  if (tears) require_size(kept, n, "kept");
  const kernel::ConvergedArrays arrays{position.data(),       response.data(),
                                       plastic_before.data(), plastic_after.data(),
                                       last_gradient.data(),  deformation_gradient.data(),
                                       cauchy.data(),         elastic_share.data(),
                                       forgotten_strain,      tears ? kept.data() : nullptr};
  nb::gil_scoped_release release;
  with_kind(kind_name, [&](auto kind) {
    kernel::advance<decltype(kind)>(stencil, displacement.data(), arrays);
  });
}

void stretch_domains(const std::string& kind_name, const std::string& rule,
                     ConstDoubles deformation_gradient, ConstDoubles initial_half_length,
                     Doubles half_length) {
  const std::int64_t points = rows_of(half_length, 2, "half_length");
  require_table(half_length, points, dimension_of_kind(kind_name), "half_length");
  require_size(initial_half_length, size_of(half_length), "initial_half_length");
  require_size(deformation_gradient, 9 * points, "deformation_gradient");
  with_kind(kind_name, [&](auto kind) {
    kernel::stretch_domains<decltype(kind)>(points, kernel::domain_rule(rule),
                                            deformation_gradient.data(), initial_half_length.data(),
                                            half_length.data());
  });
}

void move_domain_faces(ConstDoubles position, ConstIntegers node_keys, ConstDoubles displacement,
                       nb::handle grid_handle, Doubles half_length) {
  const std::int64_t points = rows_of(position, 2, "position"), nodes = size_of(node_keys);
  const int dim = dimension_of(position, "position");
  const GridView grid(grid_handle, dim);
  grid.require_in_grid(position, "position");
  require_table(half_length, points, dim, "half_length");
  grid.require_in_cells(half_length, "half_length");
  require_table(displacement, nodes, dim, "displacement");
  const auto move = dim == 2 ? &kernel::move_domain_faces<2> : &kernel::move_domain_faces<3>;
  move(points, position.data(), nodes, node_keys.data(), displacement.data(), grid,
       half_length.data());
}

}  // namespace

void bind_points(nb::module_& module) {
  using namespace nb::literals;
  module.def("response_size", &response_size, "kind"_a,
             "Number of doubles per point in the response of stress_update.");
  module.def("elastic_deformation", &elastic_deformation, "kind"_a, "strain"_a, "deformation"_a,
             "Fills exp(2 strain) - 1, six components per point.");
  module.def("elastic_strain", &elastic_strain, "kind"_a, "deformation"_a, "strain"_a,
             "Fills log(1 + deformation) / 2, six components per point.");
  module.def("volumetric_strains", &volumetric_strains, "deformation"_a,
             "Traces of log(1 + deformation) / 2, one per point.");
  module.def("stress_update", &stress_update, "kind"_a, "material"_a, "parameters"_a, "stencil"_a,
             "displacement"_a, "position"_a, "elastic_before"_a, "plastic_before"_a,
             "state_before"_a, "elastic"_a, "plastic"_a, "state"_a, "response"_a,
             nb::arg("centres").none(), "torn_off"_a, "kept"_a, "interval"_a,
             "Stress update of all points; returns (point, status): (-1, 0) or the first failure "
             "(status 1: inverted, 2: return mapping). Points that are torn_off may keep their "
             "shape; it fills kept. Both are empty if none is. interval (3,): the time at the "
             "start of the step in the stage and in total, and its size.");
  module.def("internal_force", &internal_force, "kind"_a, "stencil"_a, "volume"_a, "position"_a,
             "response"_a, "force"_a, nb::arg("centres").none(),
             "Adds the internal force to force (nodes, dim).");
  module.def("stiffness", &stiffness, "kind"_a, "stencil"_a, "block_start"_a, "block_position"_a,
             "volume"_a, "position"_a, "response"_a, "matrix"_a, nb::arg("centres").none(),
             "Adds the consistent stiffness to the blocks (entries, dim, dim).");
  module.def("add_mass", &add_mass, "stencil"_a, "block_start"_a, "block_position"_a, "mass"_a,
             "matrix"_a, "Adds the points' consistent mass to the blocks (entries).");
  module.def("fill_cells", &fill_cells, "stencil"_a, "position"_a, "half_length"_a, "volume"_a,
             "weight"_a, "grid"_a, "cell_keys"_a, "filled"_a,
             "Adds volume and volume times weight of the points to filled (cells, 2).");
  module.def("share_among_cells", &share_among_cells, "stencil"_a, "position"_a, "half_length"_a,
             "weight"_a, "grid"_a, "cell_keys"_a, "axisymmetric"_a,
             "Cells of each group, shares of each point, moments of the cells, and those of the "
             "hoop (see f_bar.py).");
  module.def(
      "update_centres", &update_centres, "kind"_a, "node"_a, "gradient"_a, "hoop_gradient"_a,
      "displacement"_a, "volume_change"_a, "trace"_a, "hoop_change"_a,
      "Fills volume_change, trace and hoop_change of F-bar's cells for a nodal displacement (see "
      "f_bar.py).");
  module.def(
      "smooth_strains", &smooth_strains, "group_start"_a, "centres"_a, "cells"_a, "strain"_a,
      "volume"_a, "fraction"_a,
      "Increments of the points' volumetric strains towards their cells' mean (see f_bar.py).");
  module.def(
      "add_predictions", &add_predictions, "stencil"_a, "node_position"_a, "position"_a,
      "displacement"_a, "gradient"_a, "volume"_a, "sum"_a,
      "Adds weights and weighted displacements of the points' fields to sum (nodes, 1+dim).");
  module.def("current_volumes", &current_volumes, "deformation_gradient"_a, "initial_volume"_a,
             "det F times the initial volume of each point.");
  module.def("advance", &advance, "kind"_a, "stencil"_a, "displacement"_a, "position"_a,
             "response"_a, "plastic_before"_a, "plastic_after"_a, "last_gradient"_a,
             "deformation_gradient"_a, "cauchy"_a, "elastic_share"_a, "forgotten_strain"_a,
             "kept"_a, "Updates the points' arrays after a converged step with this displacement.");
  module.def("stretch_domains", &stretch_domains, "kind"_a, "rule"_a, "deformation_gradient"_a,
             "initial_half_length"_a, "half_length"_a,
             "Half lengths of domains from the deformation gradient.");
  module.def("move_domain_faces", &move_domain_faces, "position"_a, "node_keys"_a, "displacement"_a,
             "grid"_a, "half_length"_a, "Half lengths of domains from their moved faces.");
}

}  // namespace tilth::bind
