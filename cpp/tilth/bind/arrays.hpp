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

template <class T>
using Array = nb::ndarray<T, nb::c_contig, nb::device::cpu>;

/// An array that is taken as it is. Others, of another type or layout, raise TypeError.
template <class T>
struct ExactArray : Array<T> {
  using Array<T>::Array;
  ExactArray(Array<T> array) : Array<T>(std::move(array)) {}
};

// The rule for arguments and attributes. Arrays that a function writes are exact: a kernel must not
// write into a converted copy. Indices and flags that it reads are exact too, as a conversion may
// change them. Only numbers that it reads are converted: to double precision, in C order.
using Doubles = ExactArray<double>;
using ConstDoubles = Array<const double>;
using Integers = ExactArray<std::int64_t>;
using ConstIntegers = ExactArray<const std::int64_t>;
using Flags = ExactArray<bool>;
using ConstFlags = ExactArray<const bool>;
using ConstShorts = ExactArray<const std::int32_t>;

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
void bind_point_forces(nb::module_& module);
void bind_point_integrals(nb::module_& module);
void bind_materials(nb::module_& module);
void bind_sparse(nb::module_& module);
void bind_elements(nb::module_& module);
void bind_implicit(nb::module_& module);
void bind_gap(nb::module_& module);
void bind_multipliers(nb::module_& module);
void bind_points_in_cells(nb::module_& module);
void bind_multigrid(nb::module_& module);
void bind_user_code(nb::module_& module);

}  // namespace tilth::bind

namespace nanobind::detail {

template <class T>
struct type_caster<tilth::bind::ExactArray<T>> {
  using Array = tilth::bind::Array<T>;
  NB_TYPE_CASTER(tilth::bind::ExactArray<T>, make_caster<Array>::Name)

  bool from_python(handle source, std::uint32_t flags, cleanup_list* cleanup) noexcept {
    make_caster<Array> caster;
    const auto exact = flags & ~static_cast<std::uint32_t>(cast_flags::convert);
    if (!caster.from_python(source, exact, cleanup)) return false;
    value = std::move(caster.value);
    return true;
  }
};

}  // namespace nanobind::detail
