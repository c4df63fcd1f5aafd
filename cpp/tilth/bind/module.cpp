// SPDX-License-Identifier: BSD-3-Clause
#include <omp.h>

#include "../parallel.hpp"
#include "checked.hpp"
#include "checks.hpp"

namespace {

constexpr int most_threads = 1024;
constexpr std::int64_t most_points = std::int64_t{1} << 48;  // multiples of it do not overflow

}  // namespace

NB_MODULE(_core, module) {
  module.doc() = "Kernels of tilth: flat arrays in, flat arrays out, no hidden state.";
  module.def(
      "set_threads",
      [](int threads) {
        tilth::bind::require(threads >= 1, "threads", "is less than one");
        tilth::bind::require(threads <= most_threads, "threads", "is more than 1024");
        omp_set_num_threads(threads);
      },
      nanobind::arg("threads"), "Number of threads of all following kernels, 1 to 1024.");
  module.def("threads", [] { return omp_get_max_threads(); }, "Number of threads in use.");
  module.def(
      "set_parallel_from",
      [](std::int64_t points) {
        tilth::bind::require(points >= 0, "points", "is negative");
        tilth::bind::require(points <= most_points, "points", "is more than 2^48");
        tilth::parallel_from = points;
      },
      nanobind::arg("points"), "Number of points from which loops use more than one thread.");
  module.def(
      "parallel_from", [] { return tilth::parallel_from; },
      "Number of points from which loops use more than one thread.");
  using tilth::bind::Checked;
  nanobind::class_<Checked>(module, "Checked", "What the core has checked of an object.")
      .def(nanobind::init<>())
      .def(
          "__reduce__",
          [](nanobind::handle self) {
            return nanobind::make_tuple(self.type(), nanobind::make_tuple());
          },
          nanobind::sig("def __reduce__(self) -> tuple[type[Checked], tuple[()]]"));
  tilth::bind::bind_stencil(module);
  tilth::bind::bind_corners(module);
  tilth::bind::bind_points(module);
  tilth::bind::bind_point_forces(module);
  tilth::bind::bind_point_integrals(module);
  tilth::bind::bind_materials(module);
  tilth::bind::bind_sparse(module);
  tilth::bind::bind_elements(module);
  tilth::bind::bind_implicit(module);
  tilth::bind::bind_gap(module);
  tilth::bind::bind_multipliers(module);
  tilth::bind::bind_points_in_cells(module);
  tilth::bind::bind_multigrid(module);
  tilth::bind::bind_user_code(module);
}
