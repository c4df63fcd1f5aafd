// SPDX-License-Identifier: BSD-3-Clause
// Mohr-Coulomb plasticity, non-associated, with a tension cut-off and linear softening; return
// mapping to planes, edges and vertices in principal axes (Clausen, Damkilde & Andersen 2006;
// de Souza Neto et al. 2008, ch. 8; docs/materials/mohr_coulomb.md). With tau_1 >= tau_2 >= tau_3:
//   f_13 = (1 + sin phi) tau_1 - (1 - sin phi) tau_3 - 2 c cos phi <= 0,  f_12, f_23 alike,
//   t_i = tau_i - T <= 0.
// On the planes of an active set, rows A of gradients and B of flow directions (A with psi):
//   H = A D B^T,  dg = H^-1 (A tau_trial - k),  tau = tau_trial - D B^T dg.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "law.hpp"

namespace tilth::material {

/// Tension cut-off of a law without one [stress].
inline constexpr double no_tension_cut_off = std::numeric_limits<double>::max();

inline constexpr double degree = 3.14159265358979323846 / 180.0;

/// Strength at a plastic strain, and its derivatives by this strain.
struct Strength {
  double cohesion, cohesion_slope;   // [stress]
  double sine, cosine, angle_slope;  // of the friction angle; slope in radians
  double tension, tension_slope;     // tension cut-off [stress]
};

/// Return of a sorted trial stress to planes of constant strength.
class MohrCoulombReturn {
 public:
  TILTH_FUNCTION MohrCoulombReturn(const HenckyElasticity& elasticity, const double sorted[3],
                                   double dilation_sine, const Strength& strength)
      : elasticity_(elasticity),
        trial_(sorted),
        strength_(strength),
        dilation_sine_(dilation_sine) {
    double largest = 0.0;
    for (int a = 0; a < 3; ++a) largest = std::max(largest, std::fabs(sorted[a]));
    size_ = std::max(largest, strength.cohesion);
  }

  double tau[3];   // stress after the return, sorted
  int planes = 0;  // in the active set
  int set = -1;    // number of the active set

  TILTH_FUNCTION bool elastic() const { return violation(trial_) <= round_off * size_; }

  /// Finds the active set and the stress; `first` is the set to try first. False if none fits.
  TILTH_FUNCTION bool solve(int first) {
    if (first >= 0 && try_set(first)) return true;
    for (int s = 0; s < set_count; ++s)
      if (s != first && try_set(s)) return true;
    // all that is left flows to the apex, the end of the cut-off's axis
    return strength_.tension < no_tension_cut_off && try_set(all_tension, false);
  }

  /// d tau / d trial at constant strength, sorted axes: D - D B^T H^-1 A D.
  TILTH_FUNCTION void tangent(double result[3][3]) const {
    const double lambda = elasticity_.bulk - 2.0 / 3.0 * elasticity_.shear;
    const double twice = 2.0 * elasticity_.shear;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        result[a][b] = planes == 3 ? 0.0 : lambda + (a == b ? twice : 0.0);
    if (planes == 3) return;
    for (int i = 0; i < planes; ++i)
      for (int j = 0; j < planes; ++j)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b)
            result[a][b] -= stiff_flow_[i][a] * inverse_[i][j] * stiff_gradient_[j][b];
  }

  /// d tau / d plastic strain at constant trial stress: -D B^T H^-1 (dA tau - dk).
  TILTH_FUNCTION void softening(double result[3]) const {
    for (int a = 0; a < 3; ++a) result[a] = 0.0;
    for (int j = 0; j < planes; ++j) {
      const double change = change_of_yield(sets()[set][j]);
      for (int i = 0; i < planes; ++i)
        for (int a = 0; a < 3; ++a) result[a] -= stiff_flow_[i][a] * inverse_[i][j] * change;
    }
  }

 private:
  static constexpr double round_off = 1e-13;
  // planes: 0 f_13, 1 f_12, 2 f_23, 3 t_1, 4 t_2, 5 t_3
  static constexpr int set_count = 10, all_tension = 5;
  using Sets = int[set_count][3];
  TILTH_FUNCTION static constexpr const Sets& sets() { return sets_; }
  static constexpr Sets sets_ = {{0, -1, -1}, {0, 1, -1}, {0, 2, -1}, {3, -1, -1}, {3, 4, -1},
                                 {3, 4, 5},   {0, 3, -1}, {0, 1, 3},  {0, 3, 4},   {0, 2, 3}};

  HenckyElasticity elasticity_;
  const double* trial_;
  Strength strength_;
  double dilation_sine_, size_;
  double stiff_flow_[3][3], stiff_gradient_[3][3], inverse_[3][3];

  /// Gradient of a plane's yield function, or its flow direction with the dilation angle's sine.
  TILTH_FUNCTION static void gradient(int plane, double sine, double result[3]) {
    for (int a = 0; a < 3; ++a) result[a] = 0.0;
    if (plane >= 3) {
      result[plane - 3] = 1.0;
      return;
    }
    result[plane == 2 ? 1 : 0] = 1.0 + sine;
    result[plane == 1 ? 1 : 2] = -(1.0 - sine);
  }

  TILTH_FUNCTION double yield(int plane, const double stress[3]) const {
    if (plane >= 3) return stress[plane - 3] - strength_.tension;
    const double major = stress[plane == 2 ? 1 : 0], minor = stress[plane == 1 ? 1 : 2];
    return (major - minor) + strength_.sine * (major + minor) -
           2.0 * strength_.cohesion * strength_.cosine;
  }

  /// d yield / d plastic strain at constant stress.
  TILTH_FUNCTION double change_of_yield(int plane) const {
    if (plane >= 3) return -strength_.tension_slope;
    const double major = tau[plane == 2 ? 1 : 0], minor = tau[plane == 1 ? 1 : 2];
    return strength_.angle_slope *
               (strength_.cosine * (major + minor) + 2.0 * strength_.cohesion * strength_.sine) -
           2.0 * strength_.cohesion_slope * strength_.cosine;
  }

  TILTH_FUNCTION double violation(const double stress[3]) const {
    const double shear = yield(0, stress);
    return strength_.tension < no_tension_cut_off ? std::max(shear, yield(3, stress)) : shear;
  }

  TILTH_FUNCTION void stiffen(const double x[3], double result[3]) const {
    const double lambda = elasticity_.bulk - 2.0 / 3.0 * elasticity_.shear;
    const double trace = lambda * (x[0] + x[1] + x[2]);
    for (int a = 0; a < 3; ++a) result[a] = trace + 2.0 * elasticity_.shear * x[a];
  }

  /// Inverse of the first n rows and columns; n is `planes`.
  TILTH_FUNCTION bool invert(const double h[3][3]) {
    if (planes == 1) {
      inverse_[0][0] = 1.0 / h[0][0];
      return h[0][0] > 0.0;
    }
    if (planes == 2) {
      const double det = h[0][0] * h[1][1] - h[0][1] * h[1][0];
      inverse_[0][0] = h[1][1] / det;
      inverse_[0][1] = -h[0][1] / det;
      inverse_[1][0] = -h[1][0] / det;
      inverse_[1][1] = h[0][0] / det;
      return det > 0.0;
    }
    double det = 0.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
        inverse_[i][j] = h[a][c] * h[b][d] - h[a][d] * h[b][c];
        if (i == 0) det += h[j][0] * inverse_[i][j];
      }
    for (auto& row : inverse_)
      for (double& entry : row) entry /= det;
    return det != 0.0 && std::isfinite(det);
  }

  /// Returns to the planes of a set; whether all multipliers are positive (unless not `checked`)
  /// and no plane is violated.
  TILTH_FUNCTION bool try_set(int s, bool checked = true) {
    double flow[3][3], slope[3][3], h[3][3], excess[3];
    planes = 0;
    for (int plane : sets()[s]) {
      if (plane < 0) break;
      if (plane >= 3 && !(strength_.tension < no_tension_cut_off)) return false;
      gradient(plane, strength_.sine, slope[planes]);
      gradient(plane, dilation_sine_, flow[planes]);
      stiffen(slope[planes], stiff_gradient_[planes]);
      stiffen(flow[planes], stiff_flow_[planes]);
      excess[planes] = yield(plane, trial_);
      ++planes;
    }
    for (int i = 0; i < planes; ++i)
      for (int j = 0; j < planes; ++j) {
        h[i][j] = 0.0;
        for (int a = 0; a < 3; ++a) h[i][j] += slope[i][a] * stiff_flow_[j][a];
      }
    if (!invert(h)) return false;
    double multiplier[3];
    for (int a = 0; a < 3; ++a) tau[a] = trial_[a];
    for (int i = 0; i < planes; ++i) {
      multiplier[i] = 0.0;
      for (int j = 0; j < planes; ++j) multiplier[i] += inverse_[i][j] * excess[j];
      for (int a = 0; a < 3; ++a) tau[a] -= stiff_flow_[i][a] * multiplier[i];
    }
    polish(s);
    set = s;
    if (!checked) return true;
    for (int i = 0; i < planes; ++i)
      if (multiplier[i] * elasticity_.shear < -round_off * size_) return false;
    const double allowed = 100.0 * round_off * size_;
    return tau[0] - tau[1] >= -allowed && tau[1] - tau[2] >= -allowed && violation(tau) <= allowed;
  }

  /// Sets what the set's planes fix without the cancellation of large trial stresses.
  TILTH_FUNCTION void polish(int s) {
    for (int plane : sets()[s])
      if (plane >= 3) tau[plane - 3] = strength_.tension;
    if (s == 1 || s == 7) tau[2] = tau[1] = 0.5 * (tau[1] + tau[2]);
    if (s == 2) tau[0] = tau[1] = 0.5 * (tau[0] + tau[1]);
    if (s == 9) tau[1] = strength_.tension;
  }
};

/// Principal axes in the order of decreasing trial stress.
struct SortedAxes {
  int axis[3] = {0, 1, 2};

  TILTH_FUNCTION explicit SortedAxes(const double tau[3]) {
    const auto sort = [&](int a, int b) {
      if (tau[axis[a]] < tau[axis[b]]) std::swap(axis[a], axis[b]);
    };
    sort(0, 1);
    sort(1, 2);
    sort(0, 1);
  }

  TILTH_FUNCTION void sort(const double x[3], double sorted[3]) const {
    for (int a = 0; a < 3; ++a) sorted[a] = x[axis[a]];
  }
  TILTH_FUNCTION void restore(const double sorted[3], double x[3]) const {
    for (int a = 0; a < 3; ++a) x[axis[a]] = sorted[a];
  }
  TILTH_FUNCTION void restore(const double sorted[3][3], double x[3][3]) const {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) x[axis[a]][axis[b]] = sorted[a][b];
  }
};

struct MohrCoulomb : HenckyElasticity {
  static constexpr const char* name = "mohr_coulomb";
  static constexpr std::array parameter_names{
      "young_modulus",     "poisson_ratio",           "cohesion",
      "friction_angle",    "dilation_angle",          "tension_cut_off",
      "residual_cohesion", "residual_friction_angle", "softening_strain"};
  static constexpr auto state_variables = no_state;
  static constexpr bool symmetric_tangent = false;

  double cohesion;                              // [stress]
  double friction;                              // friction angle [rad]
  double dilation_sine;                         // sine of the dilation angle
  double tension_cut_off;                       // greatest principal stress [stress]
  double residual_cohesion, residual_friction;  // from `softening_strain` on
  double softening_strain;                      // equivalent plastic strain
  double sine, cosine;                          // of `friction`

  TILTH_FUNCTION static MohrCoulomb from(const double* parameter) {
    return {HenckyElasticity::from(parameter[0], parameter[1]),
            parameter[2],
            degree * parameter[3],
            std::sin(degree * parameter[4]),
            parameter[5],
            parameter[6],
            degree * parameter[7],
            parameter[8],
            std::sin(degree * parameter[3]),
            std::cos(degree * parameter[3])};
  }

  TILTH_FUNCTION bool softens() const {
    return residual_cohesion != cohesion || residual_friction != friction;
  }

  TILTH_FUNCTION Strength strength(double plastic_strain) const {
    Strength s{cohesion, 0.0, sine, cosine, 0.0, tension_cut_off, 0.0};
    if (softens() && plastic_strain > 0.0) {
      const double part = std::min(plastic_strain / softening_strain, 1.0);
      s.cohesion =
          part < 1.0 ? cohesion + part * (residual_cohesion - cohesion) : residual_cohesion;
      const double angle =
          part < 1.0 ? friction + part * (residual_friction - friction) : residual_friction;
      s.sine = std::sin(angle);
      s.cosine = std::cos(angle);
    }
    if (softens() && plastic_strain < softening_strain) {
      s.cohesion_slope = (residual_cohesion - cohesion) / softening_strain;
      s.angle_slope = (residual_friction - friction) / softening_strain;
    }
    if (s.sine > 0.0 && s.cohesion * s.cosine < s.tension * s.sine) {  // the apex
      s.tension = s.cohesion * s.cosine / s.sine;
      s.tension_slope =
          s.cohesion_slope * s.cosine / s.sine - s.angle_slope * s.cohesion / (s.sine * s.sine);
    }
    return s;
  }

  /// Stress on all axes at the end of the pyramid.
  TILTH_FUNCTION double apex(double plastic_strain) const {
    return strength(plastic_strain).tension;
  }

  TILTH_FUNCTION bool update(const double trial[3], double plastic_strain,
                             const double* /*state_before*/, double* /*state*/, double tau[3],
                             double elastic[3], double tangent[3][3]) const {
    respond(trial, tau, elastic, tangent);
    const SortedAxes axes(tau);
    double sorted[3];
    axes.sort(tau, sorted);
    MohrCoulombReturn returned(*this, sorted, dilation_sine, strength(plastic_strain));
    if (returned.elastic()) return true;
    double slope[3][3];
    if (softens() && plastic_strain < softening_strain) {
      if (!return_with_softening(sorted, plastic_strain, returned, slope)) return false;
    } else {
      if (!returned.solve(-1)) return false;
      returned.tangent(slope);
    }
    axes.restore(returned.tau, tau);
    axes.restore(slope, tangent);
    return elastic_strain(tau, nullptr, elastic);
  }

 private:
  /// Equivalent plastic strain of the step, of stresses returned from `sorted`, and its gradient by
  /// the stress, reversed.
  TILTH_FUNCTION double plastic_increment(const double sorted[3], const double tau[3],
                                          double gradient[3]) const {
    double mean = 0.0, squared = 0.0;
    for (int a = 0; a < 3; ++a) mean += (sorted[a] - tau[a]) / 3.0;
    for (int a = 0; a < 3; ++a) {
      gradient[a] = sorted[a] - tau[a] - mean;
      squared += gradient[a] * gradient[a];
    }
    const double norm = std::sqrt(squared), factor = std::sqrt(2.0 / 3.0) / (2.0 * shear);
    for (int a = 0; a < 3; ++a) gradient[a] *= norm > 0.0 ? factor / norm : 0.0;
    return factor * norm;
  }

  /// Finds the plastic strain at the end of the step by Newton's method in a bracket, and the
  /// tangent with the loss of strength.
  TILTH_FUNCTION bool return_with_softening(const double sorted[3], double before,
                                            MohrCoulombReturn& returned, double slope[3][3]) const {
    double gradient[3], low = before, high = softening_strain, strain = before;
    double change[3], feedback = 0.0;
    bool at_high = false;  // whether the end of softening was tried
    for (int iteration = 0;; ++iteration) {
      const int last = returned.set;
      returned = {*this, sorted, dilation_sine, strength(strain)};
      if (!returned.solve(last)) return false;
      const double residual = before + plastic_increment(sorted, returned.tau, gradient) - strain;
      if (strain >= softening_strain && residual >= 0.0) {  // the residual strength
        returned.tangent(slope);
        return true;
      }
      returned.softening(change);
      feedback = 0.0;
      for (int a = 0; a < 3; ++a) feedback -= gradient[a] * change[a];
      (residual > 0.0 ? low : high) = strain;
      if (std::fabs(residual) <= 1e-14 * (softening_strain + strain)) break;
      if (iteration == 100) return false;
      const double newton = strain + residual / (1.0 - feedback);
      double next = newton > low && newton < high ? newton : 0.5 * (low + high);
      if (!(newton < high) && !at_high) next = high;
      at_high = at_high || next == softening_strain;
      if (next == strain) break;
      strain = next;
    }
    if (!(feedback < 1.0)) return false;  // the strength falls faster than the stress can
    returned.tangent(slope);
    double along[3];  // d(plastic strain) / d(trial strain)
    for (int b = 0; b < 3; ++b) {
      along[b] = 2.0 * shear * gradient[b];
      for (int a = 0; a < 3; ++a) along[b] -= gradient[a] * slope[a][b];
    }
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) slope[a][b] += change[a] * along[b] / (1.0 - feedback);
    return true;
  }
};

}  // namespace tilth::material
