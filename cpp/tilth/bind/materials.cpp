// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/given_gradients.hpp"
#include "../kernel/material_points.hpp"
#include "law.hpp"

namespace tilth::bind {

namespace {

auto materials() {
  nb::dict result;
  material::for_each_law([&]<material::Law M>() {
    nb::list parameters, variables;
    for (const char* name : M::parameter_names) parameters.append(name);
    for (const auto& v : M::state_variables) variables.append(nb::make_tuple(v.name, v.unit));
    result[M::name] = nb::make_tuple(parameters, variables, M::symmetric_tangent);
  });
  return result;
}

/// Calls `function(kind, law)` with the lock of the interpreter released.
template <class Function>
void with_kind_and_law(const std::string& kind_name, nb::handle material,
                       const ConstDoubles& parameters, std::int64_t points, std::int64_t width,
                       Function&& function) {
  const CheckedLaw checked = checked_law(material, parameters, points, width);
  nb::gil_scoped_release release;
  checked.evaluate(
      [&](const auto& law) { with_kind(kind_name, [&](auto kind) { function(kind, law); }); });
}

/// Returns the number of points of tensors (n, 6); refuses other arrays.
std::int64_t points_of(const ConstDoubles& tensor, const char* name) {
  const std::int64_t points = rows_of(tensor, 2, name);
  require_table(tensor, points, 6, name);
  return points;
}

/// Returns the number of columns of `state`; refuses other than one row per point.
template <class Array>
std::int64_t width_of(const Array& state, std::int64_t points, const char* name) {
  const std::int64_t width = columns_of(state, name);
  require_table(state, points, width, name);
  return width;
}

std::int64_t initial_state(const std::string& kind_name, nb::handle material,
                           ConstDoubles parameters, ConstDoubles kirchhoff, Doubles state) {
  const std::int64_t points = points_of(kirchhoff, "kirchhoff");
  const std::int64_t width = width_of(state, points, "state");
  std::int64_t failed = -1;
  with_kind_and_law(kind_name, material, parameters, points, width,
                    [&](auto kind, const auto& law) {
                      failed = kernel::initial_state<decltype(kind)>(points, law, kirchhoff.data(),
                                                                     state.data(), width);
                    });
  return failed;
}

void elastic_moduli(const std::string& kind_name, nb::handle material, ConstDoubles parameters,
                    ConstDoubles deformation, ConstDoubles state, Doubles bulk, Doubles shear,
                    Doubles young) {
  const std::int64_t points = points_of(deformation, "deformation");
  const std::int64_t width = width_of(state, points, "state");
  require_size(bulk, points, "bulk");
  require_size(shear, points, "shear");
  require_size(young, points, "young");
  with_kind_and_law(
      kind_name, material, parameters, points, width, [&](auto kind, const auto& law) {
        kernel::elastic_moduli<decltype(kind)>(points, law, deformation.data(), state.data(), width,
                                               bulk.data(), shear.data(), young.data());
      });
}

void stored_energy(const std::string& kind_name, nb::handle material, ConstDoubles parameters,
                   ConstDoubles deformation, ConstDoubles state, Doubles energy) {
  const std::int64_t points = points_of(deformation, "deformation");
  const std::int64_t width = width_of(state, points, "state");
  require_size(energy, points, "energy");
  with_kind_and_law(kind_name, material, parameters, points, width,
                    [&](auto kind, const auto& law) {
                      kernel::stored_energy<decltype(kind)>(points, law, deformation.data(),
                                                            state.data(), width, energy.data());
                    });
}

std::int64_t elastic_deformation_of(const std::string& kind_name, nb::handle material,
                                    ConstDoubles parameters, ConstDoubles kirchhoff,
                                    ConstDoubles state, Doubles deformation) {
  const std::int64_t points = points_of(kirchhoff, "kirchhoff");
  const std::int64_t width = width_of(state, points, "state");
  require_size(deformation, 6 * points, "deformation");
  std::int64_t failed = -1;
  with_kind_and_law(kind_name, material, parameters, points, width,
                    [&](auto kind, const auto& law) {
                      failed = kernel::elastic_deformation_of<decltype(kind)>(
                          points, law, kirchhoff.data(), state.data(), width, deformation.data());
                    });
  return failed;
}

void return_to_law(const std::string& kind_name, nb::handle material, ConstDoubles parameters,
                   ConstDoubles trial, ConstDoubles plastic_before, ConstDoubles state_before,
                   Doubles elastic, Doubles plastic, Doubles state, Doubles kirchhoff,
                   Flags admissible) {
  const std::int64_t points = points_of(trial, "trial");
  const std::int64_t width = width_of(state_before, points, "state_before");
  require_size(state, points * width, "state");
  require_size(plastic_before, 2 * points, "plastic_before");
  require_size(elastic, 6 * points, "elastic");
  require_size(plastic, 2 * points, "plastic");
  require_size(kirchhoff, 6 * points, "kirchhoff");
  require_size(admissible, points, "admissible");
  const kernel::StressArrays arrays{
      nullptr,        trial.data(),   plastic_before.data(), state_before.data(),
      elastic.data(), plastic.data(), state.data(),          nullptr,
      width};
  with_kind_and_law(kind_name, material, parameters, points, width,
                    [&](auto kind, const auto& law) {
                      kernel::return_to_law<decltype(kind)>(points, law, arrays, kirchhoff.data(),
                                                            admissible.data());
                    });
}

std::tuple<std::int64_t, std::int64_t> update_of_gradients(
    const std::string& kind_name, nb::handle material, ConstDoubles parameters,
    ConstDoubles gradient, ConstDoubles elastic_before, ConstDoubles plastic_before,
    ConstDoubles state_before, Doubles elastic, Doubles plastic, Doubles state, Doubles kirchhoff,
    Doubles tangent, ConstDoubles interval) {
  const std::int64_t points = points_of(elastic_before, "elastic_before");
  const std::int64_t width = width_of(state_before, points, "state_before");
  require_size(gradient, 9 * points, "gradient");
  require_size(plastic_before, 2 * points, "plastic_before");
  require_size(elastic, 6 * points, "elastic");
  require_size(plastic, 2 * points, "plastic");
  require_size(state, points * width, "state");
  require_size(kirchhoff, 6 * points, "kirchhoff");
  require_size(tangent, 54 * points, "tangent");
  kernel::Failure failure;
  const material::Interval of_step = interval_of(interval);
  with_kind_and_law(
      kind_name, material, parameters, points, width, [&](auto kind, const auto& law) {
        using K = decltype(kind);
        std::vector<double> response(points * kernel::response_size<K>);
        kernel::StressArrays arrays{
            nullptr,        elastic_before.data(), plastic_before.data(), state_before.data(),
            elastic.data(), plastic.data(),        state.data(),          response.data(),
            width};
        arrays.interval = of_step;
        failure = kernel::update_of_gradients<K>(points, law, gradient.data(), arrays,
                                                 kirchhoff.data(), tangent.data());
      });
  return {failure.point, static_cast<std::int64_t>(failure.status)};
}

/// Points in principal axes, for the contract tests and for material-point studies.
void principal_update(nb::handle law_or_name, ConstDoubles parameters, ConstDoubles trial,
                      ConstDoubles plastic_before, ConstDoubles state_before, Doubles state,
                      Doubles kirchhoff, Doubles elastic, Doubles tangent, Flags admissible) {
  const std::int64_t points = rows_of(trial, 2, "trial");
  const std::int64_t width = width_of(state_before, points, "state_before");
  require_table(trial, points, 3, "trial");
  require_size(plastic_before, 2 * points, "plastic_before");
  require_size(state, points * width, "state");
  require_size(kirchhoff, 3 * points, "kirchhoff");
  require_size(elastic, 3 * points, "elastic");
  require_size(tangent, 9 * points, "tangent");
  require_size(admissible, points, "admissible");
  const CheckedLaw checked = checked_law(law_or_name, parameters, points, width);
  checked.evaluate([&](const material::PointLaw& law) {
    for (std::int64_t first = 0; first < points; first += lane_count) {
      material::LawBatch batch{};
      for (std::int64_t p = first; p < points && p < first + lane_count; ++p) {
        for (int a = 0; a < 3; ++a) batch.trial[a][batch.size] = trial.data()[3 * p + a];
        batch.point[batch.size++] = p;
      }
      batch.wanted = (1u << batch.size) - 1;
      law.update(batch, {plastic_before.data(), state_before.data(), state.data(), width});
      for (int lane = 0; lane < batch.size; ++lane) {
        const std::int64_t p = first + lane;
        admissible.data()[p] = !(batch.failed >> lane & 1u);
        for (int a = 0; a < 3; ++a) {
          kirchhoff.data()[3 * p + a] = batch.kirchhoff[a][lane];
          elastic.data()[3 * p + a] = batch.elastic[a][lane];
        }
        for (int k = 0; k < 9; ++k) tangent.data()[9 * p + k] = batch.tangent[k][lane];
      }
    }
  });
}

}  // namespace

void bind_materials(nb::module_& module) {
  using namespace nb::literals;
  module.def("materials", &materials,
             nb::sig("def materials() -> dict[str, tuple[list[str], list[tuple[str, str]], bool]]"),
             "Name -> (parameter names, names and units of state variables, symmetric tangent).");
  module.def("initial_state", &initial_state, "kind"_a, "material"_a, "parameters"_a, "kirchhoff"_a,
             "state"_a,
             "Fills the state variables of points with Kirchhoff stresses (n, 6) at the start; "
             "returns the first point whose law cannot have its stress, else -1.");
  module.def("elastic_moduli", &elastic_moduli, "kind"_a, "material"_a, "parameters"_a,
             "deformation"_a, "state"_a, "bulk"_a, "shear"_a, "young"_a,
             "Fills the bulk, shear and Young's modulus of each point.");
  module.def("stored_energy", &stored_energy, "kind"_a, "material"_a, "parameters"_a,
             "deformation"_a, "state"_a, "energy"_a,
             "Fills the stored energy per unit initial volume of each point.");
  module.def("elastic_deformation_of", &elastic_deformation_of, "kind"_a, "material"_a,
             "parameters"_a, "kirchhoff"_a, "state"_a, "deformation"_a,
             "Elastic deformation of Kirchhoff stresses (n, 6); returns the first point whose law "
             "has none, else -1.");
  module.def("return_to_law", &return_to_law, "kind"_a, "material"_a, "parameters"_a, "trial"_a,
             "plastic_before"_a, "state_before"_a, "elastic"_a, "plastic"_a, "state"_a,
             "kirchhoff"_a, "admissible"_a,
             "Return mapping of elastic deformations (n, 6) taken as trial states.");
  module.def("update_of_gradients", &update_of_gradients, "kind"_a, "material"_a, "parameters"_a,
             "gradient"_a, "elastic_before"_a, "plastic_before"_a, "state_before"_a, "elastic"_a,
             "plastic"_a, "state"_a, "kirchhoff"_a, "tangent"_a, "interval"_a,
             "Stress update for the step's displacement gradients (n, 3, 3); fills also the "
             "Kirchhoff stress (n, 6) and its derivative (n, 6, 9). Returns as stress_update.");
  module.def("principal_update", &principal_update, "material"_a, "parameters"_a, "trial"_a,
             "plastic_before"_a, "state_before"_a, "state"_a, "kirchhoff"_a, "elastic"_a,
             "tangent"_a, "admissible"_a, "Return mapping of points (n, 3) in principal axes.");
}

}  // namespace tilth::bind
