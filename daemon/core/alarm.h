#pragma once

// One thread waits for a time; any other may ring before. POSIX semaphore: nothing allocates, and
// whoever rings never waits.

#include <semaphore.h>

#include <cerrno>

#include "daemon/core/clock.h"

namespace lss {

class Alarm {
 public:
  Alarm() noexcept { ::sem_init(&rung_, 0, 0); }
  ~Alarm() { ::sem_destroy(&rung_); }
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  // Any thread. Not lost when nobody waits yet: the next wait returns at once.
  void ring() noexcept { ::sem_post(&rung_); }

  // Until then, the last `spin_ns` of it awake (wait_until in clock.h). True: it was rung before.
  bool wait(TimeNs time_ns, TimeNs spin_ns) noexcept {
    const timespec asleep = to_timespec(time_ns - spin_ns);
    do {
      if (::sem_clockwait(&rung_, CLOCK_MONOTONIC, &asleep) == 0) return true;
    } while (errno == EINTR);
    wait_until(time_ns, spin_ns);
    return false;
  }

 private:
  ::sem_t rung_;
};

}  // namespace lss
