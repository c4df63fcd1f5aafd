// SPDX-License-Identifier: BSD-3-Clause
// Keys of the unbounded regular grid: a lattice index per direction packed into one integer whose
// order is x fastest, so that sorted nodes along x are consecutive numbers.
#pragma once

#include <array>
#include <cstdint>

namespace tilth {

inline constexpr int key_bits = 20;  // per direction
inline constexpr std::int64_t key_bias = std::int64_t{1} << (key_bits - 1);
inline constexpr std::int64_t key_mask = (std::int64_t{1} << key_bits) - 1;
inline constexpr std::int64_t largest_index = key_bias - 8;  // in magnitude, that a key represents

using Lattice = std::array<std::int64_t, 3>;

/// Key of a lattice index; unused directions are zero.
inline std::int64_t pack(const Lattice& index) {
  return ((index[2] + key_bias) << (2 * key_bits)) | ((index[1] + key_bias) << key_bits) |
         (index[0] + key_bias);
}

inline Lattice unpack(std::int64_t key) {
  return {(key & key_mask) - key_bias, ((key >> key_bits) & key_mask) - key_bias,
          ((key >> (2 * key_bits)) & key_mask) - key_bias};
}

/// A point's support in one key: the first node's lattice index, then one bit per direction: 0
/// for two nodes, 1 for three. Points with equal keys share all their nodes.
inline std::int64_t pack_support(const Lattice& first, const std::array<int, 3>& count) {
  const std::int64_t code = (count[0] - 2) | ((count[1] - 2) << 1) | ((count[2] - 2) << 2);
  return (pack(first) << 3) | code;
}

inline void unpack_support(std::int64_t key, Lattice& first, std::array<int, 3>& count) {
  first = unpack(key >> 3);
  for (int k = 0; k < 3; ++k) count[k] = 2 + static_cast<int>((key >> k) & 1);
}

}  // namespace tilth
