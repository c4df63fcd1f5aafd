// SPDX-License-Identifier: BSD-3-Clause
// Laws that the user brings as compiled code (docs/howto/write_your_own_material.md). Their elastic
// part is Hencky's; a row of parameters begins with Young's modulus and Poisson's ratio.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "../user_code.hpp"
#include "point_law.hpp"

namespace tilth::material {

/// What the user's compiled laws have in common: elasticity, initial state, checks of results.
class UserLaw : public PointLaw {
 public:
  /// `initial`: state variables at the start. `label`: the law in messages.
  UserLaw(const double* parameters, std::int64_t stride, std::vector<double> initial,
          std::string label)
      : parameters_(parameters),
        stride_(stride),
        initial_(std::move(initial)),
        label_(std::move(label)) {}

  void update(LawBatch& batch, const StateArrays& state) const override {
    constexpr double unset = std::numeric_limits<double>::quiet_NaN();
    for (int lane = 0; lane < batch.size; ++lane) {
      if (!(batch.wanted >> lane & 1u)) continue;
      const std::int64_t p = batch.point[lane];
      const double trial[3] = {batch.trial[0][lane], batch.trial[1][lane], batch.trial[2][lane]};
      double tau[3] = {unset, unset, unset}, elastic[3] = {unset, unset, unset}, tangent[3][3];
      for (auto& row : tangent) std::fill(row, row + 3, unset);
      const double* before = state.before + state.width * p;
      double* after = state.after + state.width * p;
      std::copy(before, before + state_count(), after);
      if (!evaluate(p, trial, state, before, after, tau, elastic, tangent) || !all_finite(tau, 3) ||
          !all_finite(elastic, 3) || !all_finite(tangent[0], 9) ||
          !all_finite(after, state_count())) {
        batch.failed |= 1u << lane;
        continue;
      }
      batch.dissipated[lane] = 0.0;
      for (int a = 0; a < 3; ++a) {
        batch.dissipated[lane] += tau[a] * (trial[a] - elastic[a]);
        batch.kirchhoff[a][lane] = tau[a];
        batch.elastic[a][lane] = elastic[a];
        for (int b = 0; b < 3; ++b) batch.tangent[3 * a + b][lane] = tangent[a][b];
      }
    }
  }

  bool initial_state(std::int64_t /*p*/, const double* /*tau*/, double* state) const override {
    std::copy(initial_.begin(), initial_.end(), state);
    return true;
  }
  bool elastic_strain(std::int64_t p, const double* tau, const double* state,
                      double* strain) const override {
    return elasticity(p).elastic_strain(tau, state, strain);
  }
  double energy(std::int64_t p, const double* strain, const double* state) const override {
    return elasticity(p).energy(strain, state);
  }
  ElasticModuli moduli(std::int64_t p, const double* strain, const double* state) const override {
    return elasticity(p).moduli(strain, state);
  }

 protected:
  /// As `update` of a `Law`, of point p; `state` holds `state_before` at first.
  virtual bool evaluate(std::int64_t p, const double trial[3], const StateArrays& arrays,
                        const double* state_before, double* state, double tau[3], double elastic[3],
                        double tangent[3][3]) const = 0;

  virtual std::int64_t state_count() const { return static_cast<std::int64_t>(initial_.size()); }

  const double* parameters(std::int64_t p) const { return parameters_ + stride_ * p; }

  HenckyElasticity elasticity(std::int64_t p) const {
    return HenckyElasticity::from(parameters(p)[0], parameters(p)[1]);
  }

  const std::vector<double>& initial() const { return initial_; }

  const char* label() const { return label_.c_str(); }

 private:
  const double* parameters_;
  std::int64_t stride_;
  std::vector<double> initial_;
  std::string label_;

  static bool all_finite(const double* numbers, std::int64_t count) {
    return std::all_of(numbers, numbers + count, [](double x) { return std::isfinite(x); });
  }
};

/// The user's function; returns 0, or another number where it finds no solution. `tangent` holds
/// d kirchhoff[a] / d trial[b] at 3 a + b.
using UserFunction = int (*)(const double* parameters, const double* trial, double plastic_strain,
                             const double* state_before, double* state, double* kirchhoff,
                             double* elastic, double* tangent);

class CompiledLaw final : public UserLaw {
 public:
  CompiledLaw(UserFunction function, const double* parameters, std::int64_t stride,
              std::vector<double> initial, std::string label)
      : UserLaw(parameters, stride, std::move(initial), std::move(label)), function_(function) {}

 protected:
  bool evaluate(std::int64_t p, const double trial[3], const StateArrays& arrays,
                const double* state_before, double* state, double tau[3], double elastic[3],
                double tangent[3][3]) const override {
    return user_code::call(label(), [&] {
             return function_(parameters(p), trial, arrays.plastic_before[2 * p], state_before,
                              state, tau, elastic, tangent[0]);
           }) == 0;
  }

 private:
  UserFunction function_;
};

}  // namespace tilth::material
