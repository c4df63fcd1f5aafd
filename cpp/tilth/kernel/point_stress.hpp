// SPDX-License-Identifier: BSD-3-Clause
// Stress update of single points: displacement gradient -> trial elastic strain -> return mapping
// in principal logarithmic strains. The tensors of `lane_count` points are computed at a time; the
// constitutive law is evaluated point by point.
// (Simo 1992; Charlton, Coombs & Augarde 2017; docs/theory/mechanics.md)
#pragma once

#include <cmath>
#include <cstdint>

#include "../material/point_law.hpp"
#include "../tensor.hpp"
#include "f_bar.hpp"
#include "response.hpp"

namespace tilth::kernel {

/// State of the points at the start of the step and for the trial displacement.
struct StressArrays {
  const double* position;          // (n, dim), for the radius
  const double* elastic_before;    // (n, 6) elastic left Cauchy-Green tensor less the identity
  const double* plastic_before;    // (n, 2) equivalent plastic strain, dissipation density
  const double* state_before;      // (n, state_width) internal variables of the material
  double* elastic;                 // (n, 6)
  double* plastic;                 // (n, 2)
  double* state;                   // (n, state_width)
  double* response;                // (n, response_size)
  std::int64_t state_width;        // columns of the state arrays, at least state_count
  const bool* torn_off = nullptr;  // (n) torn off at an edge of the soil; null if none is
  bool* kept = nullptr;            // (n) which of them keep their shape; null with torn_off
  material::Interval interval = {};
};

/// Whether a point that is torn off keeps its shape in the step: it bears nothing, and would be
/// pressed to less than half its volume, or turned inside out. Also where F-bar has no volume.
inline bool keeps_shape(const double h[3][3]) { return !(jacobian_minus_one(h) > -0.5); }

enum class PointStatus : std::int64_t { good = 0, inverted = 1, return_mapping = 2 };

/// Trial left Cauchy-Green tensor less the identity: c + X + X^T + X H^T with X = H (1 + c), where
/// c = b - 1 at the start of the step and H the displacement gradient; exact for small strains.
template <class T>
TILTH_FUNCTION void trial_deformation(const T h[3][3], const T before[6], T after[6]) {
  const T b[3][3] = {{1.0 + before[0], before[3], before[5]},
                     {before[3], 1.0 + before[1], before[4]},
                     {before[5], before[4], 1.0 + before[2]}};
  T x[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) x[i][j] = h[i][0] * b[0][j] + h[i][1] * b[1][j] + h[i][2] * b[2][j];
  for (int k = 0; k < 6; ++k) {
    const int i = row_of_component[k];
    const int j = column_of_component[k];
    after[k] =
        before[k] + x[i][j] + x[j][i] + x[i][0] * h[j][0] + x[i][1] * h[j][1] + x[i][2] * h[j][2];
  }
}

/// Inverse of F = 1 + H; returns det F.
template <class T>
TILTH_FUNCTION T invert(const T f[3][3], T inverse[3][3]) {
  T cofactor[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      cofactor[i][j] = f[i1][j1] * f[i2][j2] - f[i1][j2] * f[i2][j1];
    }
  const T determinant =
      f[0][0] * cofactor[0][0] + f[0][1] * cofactor[0][1] + f[0][2] * cofactor[0][2];
  const T one_over = 1.0 / determinant;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) inverse[i][j] = cofactor[j][i] * one_over;
  return determinant;
}

/// (tau_a - tau_b) / (beta_a - beta_b); near equal principal strains the limit
/// (d tau_a/d eps_a - d tau_a/d eps_b) / (2 beta), whose error is quadratic in the gap.
template <class T>
TILTH_FUNCTION T shear_stiffness(const T tau[3], const T tangent[3][3], const T strain[3],
                                 const T beta_minus_one[3], int a, int b) {
  const T gap = strain[a] - strain[b];
  const T scale = magnitude(strain[0]) + magnitude(strain[1]) + magnitude(strain[2]);
  const T limit = 0.5 * (tangent[a][a] - tangent[a][b] + tangent[b][b] - tangent[b][a]);
  const T slope = select(magnitude(gap) > 1e-5 * scale, (tau[a] - tau[b]) / gap, limit);
  return slope *
         logarithm_divided_difference(strain[a], strain[b], beta_minus_one[a], beta_minus_one[b]);
}

/// Points that wait for their stress update, with their displacement gradients.
struct Batch {
  int size = 0;
  std::int64_t point[lane_count];
  double gradient[3][3][lane_count];  // of the step; hoop part at [2][2]
  double stretch[lane_count];         // F-bar's stretch less 1; 0 without F-bar

  void add(std::int64_t p, const double h[3][3], double stretch_minus_one) {
    point[size] = p;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) gradient[i][j][size] = h[i][j];
    stretch[size] = stretch_minus_one;
    ++size;
  }

  /// Fills unused lanes with the last point.
  void fill() {
    for (int lane = size; lane < lane_count; ++lane) {
      point[lane] = point[size - 1];
      stretch[lane] = stretch[size - 1];
      for (auto& row : gradient)
        for (auto& entry : row) entry[lane] = entry[size - 1];
    }
  }
};

/// Writes `count` numbers of each of the first `size` lanes to array[point][count].
inline void scatter_lanes(const Lanes* from, int count, const Batch& batch, double* array) {
  double of_lanes[64][lane_count];
  for (int e = 0; e < count; ++e) from[e].store(of_lanes[e]);
  for (int lane = 0; lane < batch.size; ++lane) {
    double* to = array + count * batch.point[lane];
    for (int e = 0; e < count; ++e) to[e] = of_lanes[e][lane];
  }
}

inline void gather_lanes(const double* array, int count, const Batch& batch, Lanes* to) {
  double of_lanes[64][lane_count];
  for (int lane = 0; lane < lane_count; ++lane)
    for (int e = 0; e < count; ++e) of_lanes[e][lane] = array[count * batch.point[lane] + e];
  for (int e = 0; e < count; ++e) to[e] = Lanes::load(of_lanes[e]);
}

/// Result of the return mapping for the trial strains of a batch, in principal axes.
struct Returned {
  Lanes elastic[3];             // elastic logarithmic strain
  Lanes deformation[3];         // exp(2 elastic) - 1
  Lanes dissipated;             // energy per initial volume
  Mask yields;                  // whether it differs from the trial strain
  unsigned failed, any_yields;  // by lanes
};

/// Evaluates the law in each lane of `good`: stress, elastic strain and tangent.
inline Returned update_material(const material::PointLaw& law, const Batch& batch, const Mask& good,
                                const Lanes trial[3], const StressArrays& arrays, Lanes tau[3],
                                Lanes tangent[3][3]) {
  material::LawBatch of_law{};
  of_law.size = batch.size;
  for (int a = 0; a < 3; ++a) trial[a].store(of_law.trial[a]);
  for (int lane = 0; lane < batch.size; ++lane) {
    of_law.point[lane] = batch.point[lane];
    if (good[lane]) of_law.wanted |= 1u << lane;
  }
  law.update(of_law, {arrays.plastic_before, arrays.state_before, arrays.state, arrays.state_width,
                      arrays.interval});
  Returned returned;
  returned.failed = of_law.failed;
  returned.any_yields = 0;
  double yields[lane_count] = {}, deformation[3][lane_count] = {};
  for (int lane = 0; lane < batch.size; ++lane) {
    bool other = false;
    for (int a = 0; a < 3; ++a) other = other || of_law.elastic[a][lane] != of_law.trial[a][lane];
    if (!other || !(of_law.wanted >> lane & 1u)) continue;
    returned.any_yields |= 1u << lane;
    yields[lane] = 1.0;
    for (int a = 0; a < 3; ++a) deformation[a][lane] = std::expm1(2.0 * of_law.elastic[a][lane]);
  }
  for (int a = 0; a < 3; ++a) {
    tau[a] = Lanes::load(of_law.kirchhoff[a]);
    returned.elastic[a] = Lanes::load(of_law.elastic[a]);
    returned.deformation[a] = Lanes::load(deformation[a]);
    for (int b = 0; b < 3; ++b) tangent[a][b] = Lanes::load(of_law.tangent[3 * a + b]);
  }
  returned.dissipated = Lanes::load(of_law.dissipated);
  returned.yields = Lanes::load(yields) > 0.0;
  return returned;
}

/// Adds a step's plastic strain, trial less elastic strain, to the equivalent plastic strain, and
/// its dissipated energy.
inline void add_plastic_strain(const Lanes trial[3], const Returned& returned,
                               Lanes accumulated[2]) {
  Lanes plastic[3];
  for (int a = 0; a < 3; ++a) plastic[a] = trial[a] - returned.elastic[a];
  const Lanes mean = (plastic[0] + plastic[1] + plastic[2]) / 3.0;
  Lanes squared = 0.0;
  for (int a = 0; a < 3; ++a) squared += (plastic[a] - mean) * (plastic[a] - mean);
  accumulated[0] += square_root(2.0 / 3.0 * squared);
  accumulated[1] += returned.dissipated;
}

/// Updates the points of a batch and empties it. Calls `fail(point, status)` for points
/// whose update failed; their results are undefined.
template <class K, class Fail>
void update_batch(const material::PointLaw& law, Batch& batch, const StressArrays& arrays,
                  bool f_bar, Fail&& fail) {
  if (batch.size == 0) return;
  batch.fill();
  Lanes h[3][3], f[3][3], inverse[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      h[i][j] = Lanes::load(batch.gradient[i][j]);
      f[i][j] = i == j ? h[i][j] + 1.0 : h[i][j];
    }
  Mask good = invert(f, inverse) > 0.0;
  if constexpr (K::dim == 2) good = good & (f[2][2] > 0.0);
  if (f_bar) stretch_gradient<K>(Lanes::load(batch.stretch), h);

  Lanes before[6], after[6], trial[3];
  gather_lanes(arrays.elastic_before, 6, batch, before);
  trial_deformation(h, before, after);
  const Spectrum<Lanes> s = spectrum<K::in_plane>(after);
  for (int a = 0; a < 3; ++a) {
    const Mask positive = s.value[a] > -1.0;
    good = good & positive;
    trial[a] = 0.5 * log_one_plus(select(positive, s.value[a], 0.0));
  }

  Response<K, Lanes> response;
  const Returned returned =
      update_material(law, batch, good, trial, arrays, response.kirchhoff, response.tangent);

  Lanes accumulated[2];
  gather_lanes(arrays.plastic_before, 2, batch, accumulated);
  add_plastic_strain(trial, returned, accumulated);
  if (returned.any_yields) {  // elsewhere the trial state is the elastic one
    Lanes elastic[6];
    compose(returned.deformation, s.vector, elastic);
    for (int k = 0; k < 6; ++k) after[k] = select(returned.yields, elastic[k], after[k]);
  }

  for (int a = 0; a < K::dim; ++a) {
    response.beta[a] = 1.0 + s.value[a];
    for (int i = 0; i < K::dim; ++i) response.axis[i][a] = s.vector[i][a];
    for (int j = 0; j < K::dim; ++j) {
      Lanes sum = 0.0;
      for (int i = 0; i < K::dim; ++i) sum += s.vector[i][a] * inverse[j][i];
      response.to_current[a][j] = sum;
    }
  }
  for (int a = 0; a < Response<K>::pairs; ++a) {
    const int b = (a + 1) % 3;
    response.shear[Response<K>::pair(a, b)] =
        shear_stiffness(response.kirchhoff, response.tangent, trial, s.value, a, b);
  }
  if constexpr (K::hoop) response.hoop_inverse = inverse[2][2];

  scatter_lanes(accumulated, 2, batch, arrays.plastic);
  scatter_lanes(after, 6, batch, arrays.elastic);
  scatter_lanes(reinterpret_cast<const Lanes*>(&response), response_size<K>, batch,
                arrays.response);
  for (int lane = 0; lane < batch.size; ++lane) {
    if (!good[lane]) fail(batch.point[lane], PointStatus::inverted);
    if (returned.failed >> lane & 1u) fail(batch.point[lane], PointStatus::return_mapping);
  }
  batch.size = 0;
}

}  // namespace tilth::kernel
