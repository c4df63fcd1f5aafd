// SPDX-License-Identifier: BSD-3-Clause
// The constitutive law of the points of one body, behind one virtual call for a batch of points:
// the kernels are compiled once, whatever the number of laws.
#pragma once

#include <concepts>
#include <cstdint>

#include "../lanes.hpp"
#include "hencky_elasticity.hpp"
#include "law.hpp"

namespace tilth::material {

/// The time that a step takes [time]. Laws of the list do not depend on it.
struct Interval {
  double in_stage = 0.0;  // at its start, since the stage began
  double total = 0.0;     // at its start, since the analysis began
  double size = 0.0;      // 0 where nothing takes time, as in strength reduction
};

/// State of the points of one body; rows of `width` columns.
struct StateArrays {
  const double* plastic_before;  // (n, 2) equivalent plastic strain, dissipation density
  const double* before;          // (n, width)
  double* after;                 // (n, width)
  std::int64_t width;
  Interval interval = {};
};

/// Trial strains of up to `lane_count` points and the results, in principal axes.
struct LawBatch {
  int size = 0;                     // lanes in use
  unsigned wanted = 0;              // lanes to evaluate, by bits
  std::int64_t point[lane_count];   // index of the point in its body
  double trial[3][lane_count];      // elastic logarithmic strain [-]
  double kirchhoff[3][lane_count];  // [stress]
  double elastic[3][lane_count];    // elastic logarithmic strain after the return [-]
  double tangent[9][lane_count];    // d kirchhoff[a] / d trial[b] at 3 a + b [stress]
  double dissipated[lane_count];    // energy dissipated by plastic strain per initial volume
  unsigned failed = 0;              // lanes without a solution, by bits
};

class PointLaw {
 public:
  virtual ~PointLaw() = default;

  /// Evaluates the wanted lanes of a batch.
  virtual void update(LawBatch& batch, const StateArrays& state) const = 0;

  /// As in `Law`, of point p.
  virtual bool initial_state(std::int64_t p, const double* tau, double* state) const = 0;
  virtual bool elastic_strain(std::int64_t p, const double* tau, const double* state,
                              double* strain) const = 0;
  virtual double energy(std::int64_t p, const double* strain, const double* state) const = 0;
  virtual ElasticModuli moduli(std::int64_t p, const double* strain, const double* state) const = 0;

  /// Whether the moduli depend on neither strain nor state.
  virtual bool constant_moduli() const { return false; }
};

/// A law of the list with the same parameters for all points (`stride` 0) or a row for each.
template <Law M>
class LawOf final : public PointLaw {
 public:
  LawOf(const double* parameters, std::int64_t stride) : parameters_(parameters), stride_(stride) {}

  M at(std::int64_t p) const { return M::from(parameters_ + stride_ * p); }

  void update(LawBatch& batch, const StateArrays& state) const override {
    if (stride_ > 0) {
      update_with(batch, state, [this](std::int64_t p) { return at(p); });
    } else {
      const M law = at(0);
      update_with(batch, state, [&law](std::int64_t) -> const M& { return law; });
    }
  }

  bool initial_state(std::int64_t p, const double* tau, double* state) const override {
    return at(p).initial_state(tau, state);
  }
  bool elastic_strain(std::int64_t p, const double* tau, const double* state,
                      double* strain) const override {
    return at(p).elastic_strain(tau, state, strain);
  }
  double energy(std::int64_t p, const double* strain, const double* state) const override {
    return at(p).energy(strain, state);
  }
  ElasticModuli moduli(std::int64_t p, const double* strain, const double* state) const override {
    return at(p).moduli(strain, state);
  }
  bool constant_moduli() const override { return std::derived_from<M, HenckyElasticity>; }

 private:
  const double* parameters_;
  std::int64_t stride_;

  template <class At>
  void update_with(LawBatch& batch, const StateArrays& state, At&& law_at) const {
    for (int lane = 0; lane < batch.size; ++lane) {
      if (!(batch.wanted >> lane & 1u)) continue;
      const std::int64_t p = batch.point[lane];
      const double trial[3] = {batch.trial[0][lane], batch.trial[1][lane], batch.trial[2][lane]};
      double tau[3], elastic[3], tangent[3][3];
      const M& law = law_at(p);
      if (!law.update(trial, state.plastic_before[2 * p], state.before + state.width * p,
                      state.after + state.width * p, tau, elastic, tangent)) {
        batch.failed |= 1u << lane;
        continue;
      }
      double pore_pressure = 0.0;  // works on every strain, so it dissipates nothing
      if constexpr (requires { law.pore_pressure(tau); })
        pore_pressure = law.pore_pressure(state.after + state.width * p);
      double opened = 0.0;  // closes without stress, so it dissipates nothing
      if constexpr (requires { law.opened(tau); })
        opened = law.opened(state.before + state.width * p) / 3.0;
      batch.dissipated[lane] = 0.0;
      for (int a = 0; a < 3; ++a) {
        batch.dissipated[lane] += (tau[a] + pore_pressure) * (trial[a] + opened - elastic[a]);
        batch.kirchhoff[a][lane] = tau[a];
        batch.elastic[a][lane] = elastic[a];
        for (int b = 0; b < 3; ++b) batch.tangent[3 * a + b][lane] = tangent[a][b];
      }
    }
  }
};

}  // namespace tilth::material
