// SPDX-License-Identifier: BSD-3-Clause
#include "../kernel/material_points.hpp"
#include "../material/list.hpp"
#include "arrays.hpp"

namespace tilth::bind {

namespace {

auto materials() {
  nb::dict result;
  std::apply(
      [&](auto... each) {
        (
            [&] {
              using M = decltype(each);
              nb::list parameters, variables;
              for (const char* name : M::parameter_names) parameters.append(name);
              for (const auto& v : M::state_variables)
                variables.append(nb::make_tuple(v.name, v.unit));
              result[M::name] = nb::make_tuple(parameters, variables, M::symmetric_tangent);
            }(),
            ...);
      },
      material::List{});
  return result;
}

std::int64_t width(const ConstDoubles& state) { return static_cast<std::int64_t>(state.shape(1)); }

/// Calls `function(kind, law)` with the lock of the interpreter released.
template <class Function>
void with_law(const std::string& kind_name, const std::string& name, const ConstDoubles& parameters,
              Function&& function) {
  nb::gil_scoped_release release;
  with_kind(kind_name, [&](auto kind) {
    material::with_material(name, parameters.data(), [&](auto law) { function(kind, law); });
  });
}

void initial_state(const std::string& name, ConstDoubles parameters, Doubles state) {
  material::with_material(name, parameters.data(), [&](auto law) {
    require_size(state, static_cast<std::int64_t>(decltype(law)::state_variables.size()), "state");
    law.initial_state(state.data());
  });
}

void elastic_moduli(const std::string& kind_name, const std::string& name, ConstDoubles parameters,
                    ConstDoubles deformation, ConstDoubles state, Doubles bulk, Doubles shear,
                    Doubles young) {
  const auto points = static_cast<std::int64_t>(deformation.shape(0));
  require_size(bulk, points, "bulk");
  require_size(shear, points, "shear");
  require_size(young, points, "young");
  with_law(kind_name, name, parameters, [&](auto kind, auto law) {
    kernel::elastic_moduli<decltype(kind)>(points, law, deformation.data(), state.data(),
                                           width(state), bulk.data(), shear.data(), young.data());
  });
}

void stored_energy(const std::string& kind_name, const std::string& name, ConstDoubles parameters,
                   ConstDoubles deformation, ConstDoubles state, Doubles energy) {
  const auto points = static_cast<std::int64_t>(deformation.shape(0));
  require_size(energy, points, "energy");
  with_law(kind_name, name, parameters, [&](auto kind, auto law) {
    kernel::stored_energy<decltype(kind)>(points, law, deformation.data(), state.data(),
                                          width(state), energy.data());
  });
}

std::int64_t elastic_deformation_of(const std::string& kind_name, const std::string& name,
                                    ConstDoubles parameters, ConstDoubles kirchhoff,
                                    ConstDoubles state, Doubles deformation) {
  const auto points = static_cast<std::int64_t>(kirchhoff.shape(0));
  require_size(deformation, 6 * points, "deformation");
  std::int64_t failed = -1;
  with_law(kind_name, name, parameters, [&](auto kind, auto law) {
    failed = kernel::elastic_deformation_of<decltype(kind)>(
        points, law, kirchhoff.data(), state.data(), width(state), deformation.data());
  });
  return failed;
}

void return_to_law(const std::string& kind_name, const std::string& name, ConstDoubles parameters,
                   ConstDoubles trial, ConstDoubles plastic_before, ConstDoubles state_before,
                   Doubles elastic, Doubles plastic, Doubles state, Doubles kirchhoff,
                   Flags admissible) {
  const auto points = static_cast<std::int64_t>(trial.shape(0));
  require_size(plastic_before, 2 * points, "plastic_before");
  require_size(elastic, 6 * points, "elastic");
  require_size(plastic, 2 * points, "plastic");
  require_size(kirchhoff, 6 * points, "kirchhoff");
  require_size(admissible, points, "admissible");
  const kernel::StressArrays arrays{nullptr,
                                    trial.data(),
                                    plastic_before.data(),
                                    state_before.data(),
                                    elastic.data(),
                                    plastic.data(),
                                    state.data(),
                                    nullptr,
                                    width(state_before)};
  with_law(kind_name, name, parameters, [&](auto kind, auto law) {
    kernel::return_to_law<decltype(kind)>(points, law, arrays, kirchhoff.data(), admissible.data());
  });
}

/// One point in principal axes, for the contract tests and for material-point studies.
bool principal_update(const std::string& name, ConstDoubles parameters, ConstDoubles trial,
                      double plastic_strain, ConstDoubles state_before, Doubles state,
                      Doubles kirchhoff, Doubles elastic, Doubles tangent) {
  require_size(trial, 3, "trial");
  require_size(kirchhoff, 3, "kirchhoff");
  require_size(elastic, 3, "elastic");
  require_size(tangent, 9, "tangent");
  bool admissible = false;
  material::with_material(name, parameters.data(), [&](auto law) {
    admissible = law.update(trial.data(), plastic_strain, state_before.data(), state.data(),
                            kirchhoff.data(), elastic.data(),
                            reinterpret_cast<double (*)[3]>(tangent.data()));
  });
  return admissible;
}

}  // namespace

void bind_materials(nb::module_& module) {
  using namespace nb::literals;
  module.def("materials", &materials,
             nb::sig("def materials() -> dict[str, tuple[list[str], list[tuple[str, str]], bool]]"),
             "Name -> (parameter names, names and units of state variables, symmetric tangent).");
  module.def("initial_state", &initial_state, "material"_a, "parameters"_a, "state"_a,
             "Fills the state variables' values at the start.");
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
  module.def("principal_update", &principal_update, "material"_a, "parameters"_a, "trial"_a,
             "plastic_strain"_a, "state_before"_a, "state"_a, "kirchhoff"_a, "elastic"_a,
             "tangent"_a, "Return mapping of one point in principal axes; true on success.");
}

}  // namespace tilth::bind
