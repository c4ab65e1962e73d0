#pragma once

// Time in all drivers and threads.

#include <cstdint>

namespace lss {

// CLOCK_MONOTONIC in nanoseconds. Wall-clock time exists only in logs and in DDS fields named
// `utc`.
using TimeNs = std::int64_t;

inline constexpr TimeNs kMicrosecond = 1'000;
inline constexpr TimeNs kMillisecond = 1'000'000;
inline constexpr TimeNs kSecond = 1'000'000'000;

}  // namespace lss
