// SPDX-License-Identifier: BSD-3-Clause
// Checks of Python objects that hold index arrays, such as Stencil: a pass over these arrays in
// each iteration would take some percent of the time of the kernels. An object whose index arrays
// are read-only is checked at its first use, others at each use.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "arrays.hpp"

namespace tilth::bind {

/// What was checked of an object, whose attribute `_checked` it is: the values of some attributes,
/// and a number that was found. A copy of it is empty.
class Checked {
 public:
  Checked() = default;
  Checked(std::vector<nb::object> parts, std::int64_t found)
      : parts_(std::move(parts)), found_(found) {}

  bool covers(const std::vector<nb::object>& parts) const {
    if (parts_.empty() || parts.size() != parts_.size()) return false;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (!parts[i].is(parts_[i])) return false;
    return true;
  }

  std::int64_t found() const { return found_; }

 private:
  std::vector<nb::object> parts_;
  std::int64_t found_ = 0;
};

/// Returns what `check()` returns, or has returned before for the same parts of the object: its
/// index arrays `indices`, and `others`, of which only the identity matters.
template <class Check>
std::int64_t check_once(nb::handle object, const std::vector<nb::object>& indices,
                        const std::vector<nb::object>& others, Check&& check) {
  for (const nb::object& array : indices)
    if (nb::cast<bool>(array.attr("flags").attr("writeable"))) return check();
  std::vector<nb::object> parts = indices;
  parts.insert(parts.end(), others.begin(), others.end());
  const nb::object before = nb::getattr(object, "_checked", nb::none());
  if (nb::isinstance<Checked>(before)) {
    const auto* checked = nb::cast<const Checked*>(before);
    if (checked->covers(parts)) return checked->found();
  }
  const std::int64_t found = check();
  const nb::object checked = nb::cast(Checked(std::move(parts), found));
  const nb::str name("_checked");
  if (PyObject_GenericSetAttr(object.ptr(), name.ptr(), checked.ptr()) != 0) PyErr_Clear();
  return found;
}

/// Attributes of a Python object.
template <std::size_t Count>
std::vector<nb::object> parts_of(nb::handle object, const char* const (&names)[Count]) {
  std::vector<nb::object> parts;
  for (const char* name : names) parts.push_back(nb::getattr(object, name));
  return parts;
}

}  // namespace tilth::bind
