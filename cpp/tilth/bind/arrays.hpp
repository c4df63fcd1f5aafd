// SPDX-License-Identifier: BSD-3-Clause
// Arrays exchanged with Python: checked views as arguments, owned vectors as results.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tilth::bind {

namespace nb = nanobind;

using Doubles = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using ConstDoubles = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Integers = nb::ndarray<std::int64_t, nb::c_contig, nb::device::cpu>;
using ConstIntegers = nb::ndarray<const std::int64_t, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<bool, nb::c_contig, nb::device::cpu>;
using ConstFlags = nb::ndarray<const bool, nb::c_contig, nb::device::cpu>;
using ConstShorts = nb::ndarray<const std::int32_t, nb::c_contig, nb::device::cpu>;

/// Refuses an array whose number of entries is not the expected one.
template <class Array>
void require_size(const Array& array, std::int64_t size, const char* name) {
  if (static_cast<std::int64_t>(array.size()) != size)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(array.size()) +
                                " entries, expected " + std::to_string(size));
}

/// A NumPy array that takes over a vector's memory without a copy.
template <class T>
nb::ndarray<nb::numpy, T> give(std::vector<T>&& vector, std::vector<std::size_t> shape) {
  auto* owned = new std::vector<T>(std::move(vector));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::ndarray<nb::numpy, T>(owned->data(), shape.size(), shape.data(), owner);
}

template <class T>
nb::ndarray<nb::numpy, T> give(std::vector<T>&& vector) {
  const std::size_t size = vector.size();
  return give(std::move(vector), {size});
}

void bind_stencil(nb::module_& module);
void bind_corners(nb::module_& module);
void bind_points(nb::module_& module);
void bind_materials(nb::module_& module);
void bind_sparse(nb::module_& module);
void bind_elements(nb::module_& module);
void bind_implicit(nb::module_& module);
void bind_multipliers(nb::module_& module);
void bind_points_in_cells(nb::module_& module);
void bind_multigrid(nb::module_& module);

}  // namespace tilth::bind
