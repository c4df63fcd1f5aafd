// SPDX-License-Identifier: BSD-3-Clause
// Ranges of indices, found without a branch in the loop, so that it is vectorised.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace tilth {

/// Returns whether all indices are from 0 to `limit` - 1. The sign bit of x is set where x < 0,
/// that of `limit` - 1 - x where x >= `limit`.
template <class T>
bool all_below(const T* index, std::int64_t count, std::int64_t limit) {
  using Unsigned = std::make_unsigned_t<T>;
  if (limit <= 0) return count == 0;
  const auto last =
      static_cast<Unsigned>(std::min<std::int64_t>(limit - 1, std::numeric_limits<T>::max()));
  Unsigned bits = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    const auto x = static_cast<Unsigned>(index[i]);
    bits |= x | (last - x);
  }
  return bits <= static_cast<Unsigned>(std::numeric_limits<T>::max());
}

/// Returns whether `count` + 1 numbers begin with 0 and none is less than the one before.
template <class T>
bool ascends_from_zero(const T* number, std::int64_t count) {
  using Unsigned = std::make_unsigned_t<T>;
  Unsigned bits = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    const auto before = static_cast<Unsigned>(number[i]);
    const auto x = static_cast<Unsigned>(number[i + 1]);
    bits |= x | (x - before);
  }
  return number[0] == 0 && bits <= static_cast<Unsigned>(std::numeric_limits<T>::max());
}

}  // namespace tilth
