#pragma once

// The clocks of the machine, or simulated time (drivers/lockstep). Threads read them; the cycle
// never does: it gets time as data.

#include <algorithm>
#include <cerrno>
#include <ctime>

#include "drivers/lockstep/lockstep.h"
#include "drivers/time.h"

namespace lss {

// CLOCK_MONOTONIC, also in simulated time.
inline TimeNs machine_ns() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

inline TimeNs now_ns() noexcept { return lockstep::on() ? lockstep::now() : machine_ns(); }

inline std::int64_t utc_ns() noexcept {
  if (lockstep::on()) return lockstep::utc();
  timespec t{};
  ::clock_gettime(CLOCK_REALTIME, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

inline timespec to_timespec(TimeNs time_ns) noexcept {
  return {static_cast<std::time_t>(time_ns / kSecond), static_cast<long>(time_ns % kSecond)};
}

// Until then; 0 when it has passed. Waiting times may be as far away as TimeNs goes.
inline TimeNs left_until(TimeNs time_ns) noexcept {
  const TimeNs now = now_ns();
  return time_ns > now ? time_ns - now : 0;
}

inline void sleep_until(TimeNs time_ns) noexcept {
  if (lockstep::on()) return lockstep::sleep_until(time_ns);
  const timespec t = to_timespec(time_ns);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

// Sleeps until shortly before and waits the last `spin_ns` awake, which costs CPU time and saves
// the wake-up latency. 0: sleeps only.
inline void wait_until(TimeNs time_ns, TimeNs spin_ns) noexcept {
  if (lockstep::on()) return lockstep::sleep_until(time_ns);
  sleep_until(std::max(time_ns, spin_ns) - spin_ns);
  while (machine_ns() < time_ns) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
  }
}

}  // namespace lss
