#pragma once

// How long a client waits for what a daemon sends. Pure functions.

#include <chrono>
#include <cstdint>

#include "lss.h"

namespace lss::cli {

// The daemon sends a heartbeat each second, and its status soon after each change and answer.
inline constexpr std::chrono::nanoseconds kDaemonLost = std::chrono::seconds(3);
inline constexpr std::chrono::nanoseconds kStatusFollows = std::chrono::milliseconds(1500);
// Twice the validity of a command.
inline constexpr std::chrono::nanoseconds kAnswer = std::chrono::seconds(2);

// Whether a daemon had the time to acknowledge a command that was sent `since` ago, when its status
// last showed sent_ns. Simulated time may pass slowly: there the daemon has kAnswer of that, or 20
// s.
inline bool could_answer(std::chrono::nanoseconds since, std::int64_t sent_ns,
                         const lss_Status& status) {
  constexpr std::chrono::nanoseconds kSlowly = std::chrono::seconds(20);
  if (since < kAnswer) return false;
  const std::chrono::nanoseconds passed(status.time_ns - sent_ns);
  return !status.simulated_time || passed >= kAnswer || since >= kSlowly;
}

}  // namespace lss::cli
