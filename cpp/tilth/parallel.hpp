// SPDX-License-Identifier: BSD-3-Clause
// Least size of a loop for more than one thread.
#pragma once

#include <atomic>
#include <cstdint>

namespace tilth {

/// Loops over fewer points (or groups, or rows) than this run on one thread: waking the others,
/// which sleep while Python or a linear solver works, takes about as long as the loop.
/// The tests set it to 0.
inline std::int64_t parallel_from = 16000;

/// The stress update does some ten times the work of the other kernels per point.
inline constexpr std::int64_t stress_work = 8;

/// A problem that a parallel loop has found: an exception must not leave such a loop.
class Found {
 public:
  void set() { found_.store(true, std::memory_order_relaxed); }
  explicit operator bool() const { return found_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> found_{false};
};

}  // namespace tilth
