// SPDX-License-Identifier: BSD-3-Clause
// Exceptions of parallel loops.
#pragma once

#include <atomic>
#include <exception>

namespace tilth {

/// Keeps the first exception of a parallel region: one that leaves the region would end the
/// program. Every piece of a region that allocates memory is run by `run`; after the region
/// `rethrow` is called.
class Caught {
 public:
  /// Calls `body()`, unless an exception has been caught before.
  template <class Body>
  void run(Body&& body) noexcept {
    if (any_.load(std::memory_order_relaxed)) return;
    try {
      body();
    } catch (...) {
      if (!any_.exchange(true)) first_ = std::current_exception();
    }
  }

  /// Throws the exception that was caught, if there was one.
  void rethrow() const {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::atomic<bool> any_{false};
  std::exception_ptr first_;
};

}  // namespace tilth
