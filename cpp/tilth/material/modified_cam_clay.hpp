// SPDX-License-Identifier: BSD-3-Clause
// Modified Cam Clay with hyperelasticity that depends on the pressure (Borja & Tamagnini 1998;
// Roscoe & Burland 1968; docs/materials/modified_cam_clay.md). Compression positive, P and Q are
// the mean and the deviatoric Kirchhoff stress, ev and es the elastic strains that belong to them:
//   energy = P0 kappa exp(w) + 3/2 mu es^2,  w = ev / kappa,  mu = mu0 + alpha P0 exp(w)
//   f = Q^2 / M^2 + P (P - Pc) <= 0,  Pc = Pc_n exp((ev_trial - ev) / (lambda - kappa))
// lambda and kappa are slopes in ln(volume) - ln(P).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "law.hpp"

namespace tilth::material {

struct ModifiedCamClay {
  static constexpr const char* name = "modified_cam_clay";
  static constexpr std::array parameter_names{
      "compression_slope",   "swelling_slope",          "critical_state_slope", "shear_modulus",
      "shear_modulus_ratio", "overconsolidation_ratio", "reference_pressure"};
  static constexpr std::array state_variables{StateVariable{"preconsolidation_pressure", "stress"}};
  static constexpr bool symmetric_tangent = false;  // of finite steps

  double lambda, kappa;  // slopes for Kirchhoff stress
  double slope;          // M
  double shear_modulus;  // mu0 [stress]
  double shear_ratio;    // alpha: shear modulus over P0 exp(w)
  double ratio;          // overconsolidation ratio if positive, else minus Pc_0
  double reference;      // P0 [stress]

  TILTH_FUNCTION static ModifiedCamClay from(const double* parameter) {
    return {parameter[0], parameter[1], parameter[2], parameter[3],
            parameter[4], parameter[5], parameter[6]};
  }

  TILTH_FUNCTION bool valid() const {
    return kappa > 0.0 && lambda > kappa && slope > 0.0 && reference > 0.0 &&
           shear_modulus >= 0.0 && shear_ratio >= 0.0 && shear_modulus + shear_ratio > 0.0 &&
           ratio != 0.0;
  }

  /// Invariants of a principal strain, compression positive; returns |deviator|.
  TILTH_FUNCTION static double invariants(const double strain[3], double& volumetric,
                                          double& deviatoric, double direction[3]) {
    volumetric = -(strain[0] + strain[1] + strain[2]);
    double squared = 0.0;
    for (int a = 0; a < 3; ++a) {
      direction[a] = strain[a] + volumetric / 3.0;
      squared += direction[a] * direction[a];
    }
    const double norm = std::sqrt(squared);
    deviatoric = std::sqrt(2.0 / 3.0) * norm;
    for (int a = 0; a < 3; ++a) direction[a] = norm > 0.0 ? direction[a] / norm : 0.0;
    return norm;
  }

  /// Stress invariants of elastic strains, and what their derivatives need.
  struct Elastic {
    double pressure, deviator;  // P, Q
    double bulk, shear, cross;  // dP/dev, mu, dP/des = dQ/dev
  };

  TILTH_FUNCTION Elastic elastic(double ev, double es) const {
    const double isotropic = reference * std::exp(ev / kappa);
    const double mu = shear_modulus + shear_ratio * isotropic;
    const double pressure = isotropic * (1.0 + 1.5 * shear_ratio * es * es / kappa);
    return {pressure, 3.0 * mu * es, pressure / kappa, mu,
            3.0 * shear_ratio * isotropic * es / kappa};
  }

  /// Whether the stored energy is convex there: with a shear modulus that follows the pressure it
  /// is not at large ratios Q / P.
  TILTH_FUNCTION static bool is_stable(const Elastic& e) {
    return 3.0 * e.shear * e.bulk > e.cross * e.cross;
  }

  TILTH_FUNCTION bool elastic_strain(const double tau[3], const double* /*state*/,
                                     double strain[3]) const {
    double pressure, deviator, direction[3];
    const double norm = invariants(tau, pressure, deviator, direction);
    pressure /= 3.0;
    if (!(pressure > 0.0)) return false;
    const double q = std::sqrt(1.5) * norm;
    // P = x (1 + 1.5 alpha es^2 / kappa) with es = q / (3 (mu0 + alpha x)): Newton's method for x
    double x = pressure, es = 0.0;
    for (int iteration = 0;; ++iteration) {
      es = q / (3.0 * (shear_modulus + shear_ratio * x));
      const double factor = 1.5 * shear_ratio * es * es / kappa;
      const double residual = x * (1.0 + factor) - pressure;
      if (std::fabs(residual) <= 1e-15 * pressure) break;
      const double change = -2.0 * factor * shear_ratio / (shear_modulus + shear_ratio * x);
      const double derivative = 1.0 + factor + x * change;
      if (iteration == 60 || !(derivative > 0.0)) return false;
      x = std::max(x - residual / derivative, 0.1 * x);
      if (std::fabs(residual) <= 4e-15 * pressure) break;
    }
    es = q / (3.0 * (shear_modulus + shear_ratio * x));
    const double ev = kappa * std::log(x / reference);
    if (!is_stable(elastic(ev, es))) return false;
    for (int a = 0; a < 3; ++a) strain[a] = -ev / 3.0 + std::sqrt(1.5) * es * direction[a];
    return true;
  }

  TILTH_FUNCTION bool initial_state(const double* tau, double* state) const {
    double pressure, deviator, direction[3];
    const double q = std::sqrt(1.5) * invariants(tau, pressure, deviator, direction);
    pressure /= 3.0;
    if (!(pressure > 0.0)) return false;
    state[0] = ratio > 0.0 ? ratio * (pressure + q * q / (slope * slope * pressure)) : -ratio;
    return true;
  }

  TILTH_FUNCTION double energy(const double strain[3], const double* /*state*/) const {
    double ev, es, direction[3];
    invariants(strain, ev, es, direction);
    const double isotropic = reference * std::exp(ev / kappa);
    return isotropic * kappa + 1.5 * (shear_modulus + shear_ratio * isotropic) * es * es;
  }

  TILTH_FUNCTION ElasticModuli moduli(const double* strain, const double* /*state*/) const {
    double ev, es, direction[3];
    invariants(strain, ev, es, direction);
    const Elastic e = elastic(ev, es);
    return {e.bulk, e.shear};
  }

  TILTH_FUNCTION bool update(const double trial[3], double /*plastic_strain*/,
                             const double* state_before, double* state, double tau[3],
                             double elastic_after[3], double tangent[3][3]) const {
    double ev_trial, es_trial, direction[3];
    const double norm = invariants(trial, ev_trial, es_trial, direction);
    double ev = ev_trial, es = es_trial, consolidation = state_before[0];
    Elastic e = elastic(ev, es);
    // d(ev, es) / d(ev_trial, es_trial)
    double part[2][2] = {{1.0, 0.0}, {0.0, 1.0}};
    const double size = e.pressure * e.pressure + e.deviator * e.deviator / (slope * slope);
    if (!std::isfinite(size)) return false;
    double shear_part = 1.0;  // es / es_trial
    if (size - e.pressure * consolidation > 1e-13 * size) {
      if (!return_to_surface(ev_trial, es_trial, ev, es, consolidation)) return false;
      e = elastic(ev, es);
      if (!differentiate(ev_trial, es_trial, ev, es, consolidation, e, part)) return false;
      shear_part = es_trial > 0.0 ? es / es_trial : part[1][1];
    }
    if (!is_stable(e)) return false;
    state[0] = consolidation;
    const double root = std::sqrt(2.0 / 3.0);
    for (int a = 0; a < 3; ++a) {
      tau[a] = -e.pressure + root * e.deviator * direction[a];
      elastic_after[a] = ev == ev_trial && es == es_trial
                             ? trial[a]
                             : -ev / 3.0 + shear_part * norm * direction[a];
    }
    // stress invariants by trial strain invariants
    const double pv = e.bulk * part[0][0] + e.cross * part[1][0];
    const double ps = e.bulk * part[0][1] + e.cross * part[1][1];
    const double qv = e.cross * part[0][0] + 3.0 * e.shear * part[1][0];
    const double qs = e.cross * part[0][1] + 3.0 * e.shear * part[1][1];
    const double across = 2.0 * e.shear * shear_part;  // perpendicular to the deviator
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const double deviator = (a == b ? 1.0 : 0.0) - 1.0 / 3.0;
        tangent[a][b] = pv - root * ps * direction[b] - root * qv * direction[a] +
                        (2.0 / 3.0 * qs - across) * direction[a] * direction[b] + across * deviator;
      }
    return true;
  }

 private:
  /// The yield surface during a step. Its points are numbered by t >= 0, where t^2 is the decrease
  /// of the elastic volumetric strain from the tip, Q = 0: near the tip es is proportional to t.
  struct Surface {
    const ModifiedCamClay& law;
    double ev_trial, es_trial;
    double tip;                 // elastic volumetric strain there
    double pressure;            // P = Pc there
    double softness, hardness;  // 1 / kappa, 1 / (lambda - kappa)
    double flow;                // 6 / M^2
    double c;                   // P = P0 exp(ev / kappa) (1 + c es^2)

    // of the last point
    double es = 0.0, consolidation = 0.0;
    double wetness = 0.0;  // 2 P - Pc: positive where the soil contracts
    double slope = 0.0;    // d residual / dt

    TILTH_FUNCTION Surface(const ModifiedCamClay& clay, double ev, double es_of_trial,
                           double before)
        : law(clay), ev_trial(ev), es_trial(es_of_trial) {
      softness = 1.0 / clay.kappa;
      hardness = 1.0 / (clay.lambda - clay.kappa);
      flow = 6.0 / (clay.slope * clay.slope);
      c = 1.5 * clay.shear_ratio * softness;
      tip = (std::log(before / clay.reference) + ev * hardness) / (softness + hardness);
      pressure = clay.reference * std::exp(tip * softness);
    }

    /// t where P0 exp(ev / kappa) = Pc / 2: the critical state with a constant shear modulus; else
    /// the critical state is at a larger t.
    TILTH_FUNCTION double critical() const {
      constexpr double log_two = 0.6931471805599453;
      return std::sqrt(log_two / (softness + hardness));
    }

    /// Residual of the flow rule, (es_trial - es) (2 P - Pc) - (ev_trial - ev) 2 Q / M^2: with the
    /// elastic volumetric strain the preconsolidation pressure and by the yield condition es are
    /// known. Its root is the solution.
    TILTH_FUNCTION double residual(double t) {
      const double above = std::expm1(t * t * hardness), below = std::expm1(-t * t * softness);
      const double isotropic = pressure * (1.0 + below);
      consolidation = pressure * (1.0 + above);
      const double by_pressure = law.shear_ratio * isotropic, mu = law.shear_modulus + by_pressure;
      // quadratic equation of es^2: a x^2 + b x = d
      const double a = isotropic * c * isotropic * c;
      const double b = 1.5 * mu * mu * flow + c * isotropic * (2.0 * isotropic - consolidation);
      const double d = isotropic * pressure * (above - below);
      double squared = d / b;
      if (a > 0.0) {
        const double root = std::sqrt(b * b + 4.0 * a * d);
        squared = b >= 0.0 ? 2.0 * d / (b + root) : (root - b) / (2.0 * a);
      }
      es = std::sqrt(squared);
      const double p = isotropic * (1.0 + c * squared), hardening = consolidation * hardness;
      wetness = 2.0 * p - consolidation;
      // by ev: es along the surface, then the flow rule
      const double volume = ev_trial - tip + t * t, left = es_trial - es;
      const double cross = 2.0 * isotropic * c * es, q = 3.0 * mu * es;
      const double fv = q * cross * flow / 3.0 + p * softness * wetness + p * hardening;
      const double fs = q * mu * flow + cross * wetness;
      const double gv = left * (2.0 * p * softness + hardening) + flow * mu * es -
                        volume * by_pressure * softness * flow * es;
      const double gs = -wetness + left * 2.0 * cross - volume * flow * mu;
      slope = -2.0 * t * (gv - gs * fv / fs);
      return left * wetness - volume * flow * mu * es;
    }
  };

  /// Finds a point beyond `wet`, towards the critical state, whose residual is negative.
  TILTH_FUNCTION static bool bracket_dry(Surface& surface, double& wet, double& at_wet, double& dry,
                                         double& at_dry) {
    if (!(dry > wet)) dry = wet + surface.critical();
    double beyond = 0.0;  // past the critical state; 0 if not known
    for (int i = 0; (at_dry = surface.residual(dry)) > 0.0; ++i) {
      if (i == 100) return false;
      if (surface.wetness > 0.0) {
        wet = dry;
        at_wet = at_dry;
        dry = beyond > 0.0 ? 0.5 * (wet + beyond) : 1.5 * dry;
      } else {
        beyond = dry;
        dry = 0.5 * (wet + beyond);
      }
    }
    return true;
  }

  /// Finds a point before `dry`, towards the critical state, whose residual is not negative.
  TILTH_FUNCTION static bool bracket_wet(Surface& surface, double& wet, double& at_wet, double& dry,
                                         double& at_dry) {
    double beyond = -1.0;  // past the critical state, on the wet side; negative if not known
    for (int i = 0; (at_wet = surface.residual(wet)) < 0.0; ++i) {
      if (i == 100) return false;
      if (surface.wetness < 0.0) {
        dry = wet;
        at_dry = at_wet;
        wet = beyond < 0.0 ? 0.5 * wet : 0.5 * (dry + beyond);
      } else {
        beyond = wet;
        wet = 0.5 * (dry + beyond);
      }
    }
    return true;
  }

  /// Finds ev, es and the preconsolidation pressure at the end of the step: Newton's method in a
  /// bracket, which is halved where it leaves it.
  TILTH_FUNCTION bool return_to_surface(double ev_trial, double es_trial, double& ev, double& es,
                                        double& consolidation) const {
    Surface surface(*this, ev_trial, es_trial, consolidation);
    const double start = std::sqrt(std::max(surface.tip - ev_trial, 0.0));
    double wet = start, at_wet = surface.residual(start);  // residual >= 0
    double dry = surface.critical(), at_dry = -1.0;        // residual < 0
    double t = start > 0.0 ? start - at_wet / surface.slope : -1.0;
    const bool contracts = at_wet >= 0.0;
    if (!contracts) {
      std::swap(wet, dry);
      at_dry = at_wet;
    }
    const bool inside = t > std::min(wet, dry) && t < std::max(wet, dry);
    if (shear_ratio > 0.0 || !inside) {
      if (!(contracts ? bracket_dry(surface, wet, at_wet, dry, at_dry)
                      : bracket_wet(surface, wet, at_wet, dry, at_dry)))
        return false;
      t = at_wet == 0.0 ? wet : wet + at_wet * (dry - wet) / (at_wet - at_dry);
    }
    double value = surface.residual(t);
    for (int iteration = 0; value != 0.0; ++iteration) {
      if (iteration == 200) return false;
      (value > 0.0 ? wet : dry) = t;
      const double newton = t - value / surface.slope;
      const bool last = std::fabs(newton - t) <= 1e-8 * t;  // it squares the error
      const bool inside = newton > std::min(wet, dry) && newton < std::max(wet, dry);
      const double next = last || inside ? newton : 0.5 * (wet + dry);
      if (next == t) break;
      t = next;
      value = surface.residual(t);
      if (last) break;
    }
    ev = surface.tip - t * t;
    es = surface.es;
    consolidation = surface.consolidation;
    return true;
  }

  /// Derivative of (ev, es) by the trial invariants from yield condition and flow rule.
  TILTH_FUNCTION bool differentiate(double ev_trial, double es_trial, double ev, double es,
                                    double consolidation, const Elastic& e,
                                    double part[2][2]) const {
    const double m = slope * slope, hardening = consolidation / (lambda - kappa);  // -dPc/dev
    const double wet = 2.0 * e.pressure - consolidation;
    const double shear_slope = (e.shear - shear_modulus) / kappa;  // dmu/dev
    // yield condition
    const double fv = 2.0 * e.deviator * e.cross / m + e.bulk * wet + e.pressure * hardening;
    const double fs = 6.0 * e.deviator * e.shear / m + e.cross * wet;
    const double fv_trial = -e.pressure * hardening;
    // flow rule
    const double gv = (es_trial - es) * (2.0 * e.bulk + hardening) + 2.0 * e.deviator / m -
                      (ev_trial - ev) * 6.0 * shear_slope * es / m;
    const double gs = -wet + (es_trial - es) * 2.0 * e.cross - (ev_trial - ev) * 6.0 * e.shear / m;
    const double gv_trial = -(es_trial - es) * hardening - 2.0 * e.deviator / m;
    const double gs_trial = wet;
    const double determinant = fv * gs - fs * gv;
    if (!(std::fabs(determinant) > 0.0)) return false;
    part[0][0] = (-fv_trial * gs + fs * gv_trial) / determinant;
    part[1][0] = (fv_trial * gv - fv * gv_trial) / determinant;
    part[0][1] = fs * gs_trial / determinant;
    part[1][1] = -fv * gs_trial / determinant;
    return true;
  }
};

}  // namespace tilth::material
