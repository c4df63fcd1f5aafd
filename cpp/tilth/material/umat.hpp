// SPDX-License-Identifier: BSD-3-Clause
// User materials with the argument list of Abaqus' subroutine UMAT (Abaqus User Subroutines
// Reference Guide, UMAT), for isotropic laws with Hencky elasticity
// (docs/decisions/0023-user-laws.md).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "user_law.hpp"

namespace tilth::material {

using UmatRoutine = void (*)(double* stress, double* statev, double* ddsdde, double* sse,
                             double* spd, double* scd, double* rpl, double* ddsddt, double* drplde,
                             double* drpldt, double* stran, double* dstran, double* time,
                             double* dtime, double* temp, double* dtemp, double* predef,
                             double* dpred, char* cmname, int* ndi, int* nshr, int* ntens,
                             int* nstatv, double* props, int* nprops, double* coords, double* drot,
                             double* pnewdt, double* celent, double* dfgrd0, double* dfgrd1,
                             int* noel, int* npt, int* layer, int* kspt, int* jstep, int* kinc,
                             std::size_t cmname_length);

/// A row of parameters: Young's modulus, Poisson's ratio, CELENT, PROPS. After the routine's own
/// state variables come the principal elastic strains, largest first: the start of the next step.
class UmatLaw final : public UserLaw {
 public:
  static constexpr std::int64_t leading_parameters = 3;
  static constexpr std::int64_t further_state = 3;
  static constexpr int name_length = 80;

  UmatLaw(UmatRoutine routine, std::vector<char> name, const double* parameters,
          std::int64_t stride, std::int64_t properties, std::vector<double> initial,
          std::string label)
      : UserLaw(parameters, stride, std::move(initial), std::move(label)),
        routine_(routine),
        name_(std::move(name)),
        properties_(static_cast<int>(properties)) {
    name_.resize(name_length, ' ');
  }

  bool initial_state(std::int64_t p, const double* tau, double* state) const override {
    UserLaw::initial_state(p, tau, state);
    double* strain = state + initial().size();
    elasticity(p).elastic_strain(tau, state, strain);
    std::sort(strain, strain + 3, std::greater<>());
    return true;
  }

 protected:
  std::int64_t state_count() const override { return UserLaw::state_count() + further_state; }

  bool evaluate(std::int64_t p, const double trial[3], const StateArrays& arrays,
                const double* state_before, double* state, double tau[3], double elastic[3],
                double tangent[3][3]) const override {
    const auto own = static_cast<int>(initial().size());
    const double* start = state_before + own;
    const HenckyElasticity hencky = elasticity(p);
    int order[3] = {0, 1, 2};  // axes of the routine: largest trial strain first
    std::stable_sort(order, order + 3, [&](int a, int b) { return trial[a] > trial[b]; });

    double stress[6] = {}, strain[6] = {}, increment[6] = {}, ddsdde[36] = {};
    hencky.stress(start, stress);
    for (int a = 0; a < 3; ++a) {
      strain[a] = start[a];
      increment[a] = trial[order[a]] - start[a];
    }
    double pnewdt = 1.0;
    call(p, arrays.interval, stress, state, ddsdde, strain, increment, pnewdt);
    if (pnewdt < 1.0) return false;
    const double size =
        std::max({std::fabs(stress[0]), std::fabs(stress[1]), std::fabs(stress[2])});
    for (int k = 3; k < 6; ++k)
      if (!(std::fabs(stress[k]) <= shear_tolerance * size)) return false;  // not isotropic

    double after[3];
    hencky.elastic_strain(stress, state, after);
    double scale = 0.0, flow = 0.0;
    for (int a = 0; a < 3; ++a) {
      scale = std::max({scale, std::fabs(start[a]), std::fabs(trial[a])});
      flow = std::max(flow, std::fabs(after[a] - trial[order[a]]));
    }
    const double round_off =
        64.0 * std::numeric_limits<double>::epsilon() * (1.0 + hencky.bulk / hencky.shear) * scale;
    for (int a = 0; a < 3; ++a) {
      if (flow <= round_off) after[a] = trial[order[a]];
      state[own + a] = after[a];
      elastic[order[a]] = after[a];
      tau[order[a]] = stress[a];
      for (int b = 0; b < 3; ++b) tangent[order[a]][order[b]] = ddsdde[a + 6 * b];
    }
    std::sort(state + own, state + own + 3, std::greater<>());
    return true;
  }

 private:
  static constexpr double shear_tolerance = 1e-10;

  UmatRoutine routine_;
  std::vector<char> name_;
  int properties_;

  /// Calls the routine; it gets copies of what it must not change.
  void call(std::int64_t p, const Interval& interval, double stress[6], double* state,
            double ddsdde[36], double strain[6], double increment[6], double& pnewdt) const {
    double sse = 0.0, spd = 0.0, scd = 0.0, rpl = 0.0, drpldt = 0.0, temperature = 0.0;
    double temperature_change = 0.0, predefined = 0.0, predefined_change = 0.0,
           duration = interval.size;
    double ddsddt[6] = {}, drplde[6] = {}, time[2] = {interval.in_stage, interval.total},
           coords[3] = {};
    double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, gradient_before[9], gradient[9];
    std::copy(rotation, rotation + 9, gradient_before);
    std::copy(rotation, rotation + 9, gradient);
    const double* given = parameters(p);
    double length = given[2], none = 0.0;
    thread_local std::vector<double> props;
    props.assign(given + leading_parameters, given + leading_parameters + properties_);
    char name[name_length];
    std::copy(name_.begin(), name_.end(), name);
    int ndi = 3, nshr = 3, ntens = 6, nstatv = static_cast<int>(initial().size());
    int nprops = properties_, element = 1, point = static_cast<int>(p) + 1, layer = 1, section = 1;
    int step[4] = {1, 1, 0, 0}, kinc = 1;
    double* const own_props = props.data();  // of this thread
    user_code::call(label(), [&] {
      routine_(stress, nstatv > 0 ? state : &none, ddsdde, &sse, &spd, &scd, &rpl, ddsddt, drplde,
               &drpldt, strain, increment, time, &duration, &temperature, &temperature_change,
               &predefined, &predefined_change, name, &ndi, &nshr, &ntens, &nstatv,
               nprops > 0 ? own_props : &none, &nprops, coords, rotation, &pnewdt, &length,
               gradient_before, gradient, &element, &point, &layer, &section, step, &kinc,
               std::size_t{name_length});
    });
  }
};

}  // namespace tilth::material
