// SPDX-License-Identifier: BSD-3-Clause
// When a loop is worth more than one thread.
#pragma once

#include <cstdint>

namespace tilth {

/// Fewer points (or groups of points) than this are worked on by one thread: waking the others
/// takes longer.
inline constexpr std::int64_t parallel_from = 2000;

}  // namespace tilth
