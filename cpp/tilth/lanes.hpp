// SPDX-License-Identifier: BSD-3-Clause
// SIMD type of eight numbers, one for each of eight points. Templates over a number type T
// (tensor.hpp, kernel/point_stress.hpp) run with `double` and with `Lanes`. The result of a lane
// does not depend on the other lanes, so results do not depend on how points form batches.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "annotation.hpp"

namespace tilth {

inline constexpr int lane_count = 8;

/// Halves of four lanes: two independent operations at a time hide the latency of one.
using HalfLanes = double __attribute__((vector_size(32)));
using HalfBits = std::uint64_t __attribute__((vector_size(32)));
using HalfMask = std::int64_t __attribute__((vector_size(32)));

struct Mask {
  HalfMask low, high;

  bool operator[](int lane) const { return lane < 4 ? low[lane] != 0 : high[lane - 4] != 0; }
};

struct Lanes {
  HalfLanes low, high;

  Lanes() = default;
  Lanes(HalfLanes first, HalfLanes second) : low(first), high(second) {}
  Lanes(double value) : low(value - HalfLanes{}), high(low) {}  // the same in all lanes

  static Lanes load(const double* from) {
    Lanes x;
    std::memcpy(&x, from, sizeof x);
    return x;
  }
  void store(double* to) const { std::memcpy(to, this, sizeof *this); }
};

inline Lanes operator+(const Lanes& a, const Lanes& b) { return {a.low + b.low, a.high + b.high}; }
inline Lanes operator-(const Lanes& a, const Lanes& b) { return {a.low - b.low, a.high - b.high}; }
inline Lanes operator*(const Lanes& a, const Lanes& b) { return {a.low * b.low, a.high * b.high}; }
inline Lanes operator/(const Lanes& a, const Lanes& b) { return {a.low / b.low, a.high / b.high}; }
inline Lanes operator-(const Lanes& a) { return {-a.low, -a.high}; }
inline Lanes& operator+=(Lanes& a, const Lanes& b) { return a = a + b; }
inline Lanes& operator-=(Lanes& a, const Lanes& b) { return a = a - b; }
inline Mask operator>(const Lanes& a, const Lanes& b) { return {a.low > b.low, a.high > b.high}; }
inline Mask operator>=(const Lanes& a, const Lanes& b) {
  return {a.low >= b.low, a.high >= b.high};
}
inline Mask operator&(const Mask& a, const Mask& b) { return {a.low & b.low, a.high & b.high}; }

/// `yes` where the condition holds, else `no`.
TILTH_FUNCTION double select(bool condition, double yes, double no) { return condition ? yes : no; }
inline Lanes select(const Mask& condition, const Lanes& yes, const Lanes& no) {
  return {condition.low ? yes.low : no.low, condition.high ? yes.high : no.high};
}

TILTH_FUNCTION bool any(bool condition) { return condition; }
inline bool any(const Mask& condition) {
  const HalfMask either = condition.low | condition.high;
  return (either[0] | either[1] | either[2] | either[3]) != 0;
}

TILTH_FUNCTION double square_root(double x) { return std::sqrt(x); }
inline HalfLanes square_root(const HalfLanes& x) {
  return HalfLanes{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
}
inline Lanes square_root(const Lanes& x) { return {square_root(x.low), square_root(x.high)}; }

TILTH_FUNCTION double magnitude(double x) { return std::fabs(x); }
inline Lanes magnitude(const Lanes& x) {
  return {x.low < 0.0 ? -x.low : x.low, x.high < 0.0 ? -x.high : x.high};
}

/// log(1 + x) for x > -1, accurate to about one unit in the last place. 1 + x = 2^k (1 + f), where
/// 1 + f is between sqrt(1/2) and sqrt(2), and log(1 + f) = 2 artanh(s) with s = f / (2 + f). The
/// form 2 s = f - s f preserves the digits of f.
inline HalfLanes log_one_plus(const HalfLanes& x) {
  constexpr std::uint64_t root_half = 0x3fe6a09e00000000, fraction = 0x000fffffffffffff;
  constexpr std::uint64_t one = 0x3ff0000000000000, two_to_52 = 0x4330000000000000;
  constexpr double log_2 = 0x1.62e42feep-1, log_2_rest = 1.90821492927058770002e-10;
  const HalfLanes sum = 1.0 + x;
  HalfBits bits;
  std::memcpy(&bits, &sum, sizeof bits);
  bits += one - root_half;
  const HalfBits exponent = (bits >> 52) | two_to_52, reduced = (bits & fraction) + root_half;
  HalfLanes k, f;
  std::memcpy(&k, &exponent, sizeof k);
  k -= 0x1p52 + 1023.0;
  std::memcpy(&f, &reduced, sizeof f);
  const HalfMask near_zero = k == 0.0;
  const HalfLanes lost = (k > 1.0 ? 1.0 - (sum - x) : x - (sum - 1.0)) / sum;  // by rounding 1 + x
  f = near_zero ? x : f - 1.0;
  const HalfLanes rounding = near_zero ? HalfLanes{} : lost;
  const HalfLanes s = f / (2.0 + f), z = s * s;
  HalfLanes series = z * (2.0 / 21.0);
  for (int n = 19; n >= 3; n -= 2) series = z * (2.0 / n + series);
  return (k * log_2_rest + rounding) - s * (f - series) + f + k * log_2;
}
TILTH_FUNCTION double log_one_plus(double x) { return std::log1p(x); }
inline Lanes log_one_plus(const Lanes& x) { return {log_one_plus(x.low), log_one_plus(x.high)}; }

}  // namespace tilth
