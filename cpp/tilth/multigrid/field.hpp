// SPDX-License-Identifier: BSD-3-Clause
// Vectors of a level in single precision, stored component by component, so that one instruction
// handles several adjacent nodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace tilth::multigrid {

/// Memory that starts on a cache line.
template <class T>
struct Aligned {
  using value_type = T;
  static constexpr std::align_val_t line{64};
  Aligned() = default;
  template <class U>
  Aligned(const Aligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), line)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, line); }
  bool operator==(const Aligned&) const { return true; }
};

using Floats = std::vector<float, Aligned<float>>;

/// Memory of vectors.
template <class... Vectors>
std::int64_t bytes_of(const Vectors&... vectors) {
  return static_cast<std::int64_t>(
      (0 + ... + (vectors.capacity() * sizeof(typename Vectors::value_type))));
}

/// `Components` numbers per node. Up to `margin` entries before the first node and after the last
/// one may be read; they are zero.
template <int Components>
class Field {
 public:
  static constexpr std::int64_t margin = 16;

  explicit Field(std::int64_t nodes = 0, float value = 0.0f)
      : stride_((nodes + 2 * margin - 1) / margin * margin),
        number_(Components * stride_ + margin, 0.0f) {
    for (int i = 0; i < Components; ++i)
      for (std::int64_t v = 0; v < nodes; ++v) (*this)[i][v] = value;
  }

  float* operator[](int i) { return number_.data() + i * stride_ + margin; }
  const float* operator[](int i) const { return number_.data() + i * stride_ + margin; }
  std::int64_t bytes() const { return bytes_of(number_); }

 private:
  std::int64_t stride_;
  Floats number_;
};

}  // namespace tilth::multigrid
