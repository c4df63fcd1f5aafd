// SPDX-License-Identifier: BSD-3-Clause
// Constitutive laws with checked parameters and state variables.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "../material/list.hpp"
#include "../material/umat.hpp"
#include "../user_code.hpp"
#include "checks.hpp"
#include "python_law.hpp"

namespace tilth::bind {

/// A law with its parameters.
class CheckedLaw {
 public:
  explicit CheckedLaw(std::unique_ptr<material::PointLaw> law) : law_(std::move(law)) {}
  explicit CheckedLaw(std::unique_ptr<material::UserLaw> law)
      : is_compiled_(true), law_(std::move(law)) {}
  explicit CheckedLaw(std::unique_ptr<PythonLaw> law) : python_(law.get()), law_(std::move(law)) {}

  /// Calls `kernel(law)`; twice if the law is written in Python, so the kernel must be repeatable.
  template <class Kernel>
  void evaluate(Kernel&& kernel) const {
    std::optional<user_code::Around> around;
    if (is_compiled_) around.emplace();
    kernel(std::as_const(*law_));
    if (python_ == nullptr) return;
    python_->answer();
    kernel(std::as_const(*law_));
  }

 private:
  PythonLaw* python_ = nullptr;
  bool is_compiled_ = false;
  std::unique_ptr<material::PointLaw> law_;
};

/// Parameters of `points` points: one row for all, or a row for each.
struct ParameterRows {
  const double* data;
  std::int64_t count, stride, rows;

  /// Refuses other than `least` parameters, or at least as many if `open`.
  ParameterRows(const ConstDoubles& parameters, std::int64_t points, std::int64_t least, bool open)
      : data(parameters.data()) {
    const bool each = parameters.ndim() == 2;
    count = each ? columns_of(parameters, "parameters") : size_of(parameters);
    require(count == least || (open && count > least), "parameters", "has another number of them");
    if (each)
      require_table(parameters, points, count, "parameters");
    else
      require_size(parameters, count, "parameters");
    require_finite(parameters, "parameters");
    stride = each ? count : 0;
    rows = each ? points : 1;
  }

  /// Refuses parameters of which `valid(row)` is not true.
  template <class Valid>
  void require_valid(Valid&& valid) const {
    bool all = true;
    for (std::int64_t i = 0; i < rows; ++i) all = all && valid(data + count * i);
    require(all, "parameters", "give a bulk or shear modulus that is not positive");
  }
};

inline void require_width(std::int64_t width, std::int64_t count) {
  require(width >= count, "state", "has less columns than the law has state variables");
}

/// Returns the time that a step takes, (3,): at its start in the stage and in total, and its size.
inline material::Interval interval_of(const ConstDoubles& interval) {
  require_size(interval, 3, "interval");
  require_finite(interval, "interval");
  const double* time = interval.data();
  require(time[2] >= 0.0, "interval", "has a negative size");
  return {time[0], time[1], time[2]};
}

/// Returns a law of the user; `user` has the attributes of the classes in
/// src/tilth/model/user_laws.py.
inline CheckedLaw checked_user_law(nb::handle user, const ConstDoubles& parameters,
                                   std::int64_t points, std::int64_t width) {
  const nb::object kind = nb::getattr(user, "kind", nb::none());
  if (kind.equal(nb::str("python"))) {
    const auto count = number_attribute<std::int64_t>(user, "state_count");
    require(count >= 0, "state_count", "is negative");
    require_width(width, count);
    return CheckedLaw(std::make_unique<PythonLaw>(nb::borrow(user), points, count));
  }
  const bool umat = kind.equal(nb::str("umat"));
  if (!umat && !kind.equal(nb::str("compiled")))
    throw nb::type_error("material is neither the name of a law nor a law of the user");
  const auto address = number_attribute<std::uintptr_t>(user, "address");
  require(address != 0, "address", "is null");
  const auto initial = attribute<ConstDoubles>(user, "initial");
  require_finite(initial, "initial");
  std::vector<double> first(initial.data(), initial.data() + initial.size());
  const std::int64_t leading = umat ? material::UmatLaw::leading_parameters : 2;
  const ParameterRows rows(parameters, points, leading, true);
  rows.require_valid(
      [](const double* row) { return material::HenckyElasticity::from(row[0], row[1]).valid(); });
  require_width(width, size_of(initial) + (umat ? material::UmatLaw::further_state : 0));
  auto label = nb::cast<std::string>(nb::getattr(user, "label", nb::str("a law of the user")));
  if (umat) {
    const auto name = nb::cast<std::string>(nb::getattr(user, "name", nb::str("")));
    return CheckedLaw(std::unique_ptr<material::UserLaw>(std::make_unique<material::UmatLaw>(
        reinterpret_cast<material::UmatRoutine>(address),
        std::vector<char>(name.begin(), name.end()), rows.data, rows.stride, rows.count - leading,
        std::move(first), std::move(label))));
  }
  return CheckedLaw(std::unique_ptr<material::UserLaw>(std::make_unique<material::CompiledLaw>(
      reinterpret_cast<material::UserFunction>(address), rows.data, rows.stride, std::move(first),
      std::move(label))));
}

/// Returns a law for `points` points whose state arrays have `width` columns. `law` is the
/// name of a law of the list, or an object for a law of the user. `parameters` are (m,) for all
/// points or (points, m). Refuses parameters of another shape, that are not finite or give moduli
/// that are not positive, and less columns than state variables.
inline CheckedLaw checked_law(nb::handle law, const ConstDoubles& parameters, std::int64_t points,
                              std::int64_t width) {
  if (!nb::isinstance<nb::str>(law)) return checked_user_law(law, parameters, points, width);
  std::unique_ptr<material::PointLaw> result;
  material::with_law(nb::cast<std::string>(law), [&]<material::Law M>() {
    require_width(width, static_cast<std::int64_t>(M::state_variables.size()));
    const ParameterRows rows(parameters, points,
                             static_cast<std::int64_t>(M::parameter_names.size()), false);
    rows.require_valid([](const double* row) { return M::from(row).valid(); });
    result = std::make_unique<material::LawOf<M>>(rows.data, rows.stride);
  });
  return CheckedLaw(std::move(result));
}

}  // namespace tilth::bind
