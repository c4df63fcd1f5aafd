// SPDX-License-Identifier: BSD-3-Clause
#include <omp.h>

#include "arrays.hpp"

NB_MODULE(_core, module) {
  module.doc() = "Kernels of tilth: flat arrays in, flat arrays out, no hidden state.";
  module.def(
      "set_threads", [](int threads) { omp_set_num_threads(threads); }, nanobind::arg("threads"),
      "Number of threads of all following kernels.");
  module.def("threads", [] { return omp_get_max_threads(); }, "Number of threads in use.");
  tilth::bind::bind_stencil(module);
  tilth::bind::bind_points(module);
  tilth::bind::bind_sparse(module);
}
