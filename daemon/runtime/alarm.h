#pragma once

// One thread waits until a time; any other may ring before. POSIX semaphore: nothing allocates, and
// ring() never waits.

#include <semaphore.h>

#include <algorithm>
#include <cerrno>

#include "daemon/runtime/clock.h"

namespace lss {

class Alarm {
 public:
  Alarm() noexcept { ::sem_init(&rung_, 0, 0); }
  ~Alarm() { ::sem_destroy(&rung_); }
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  // Any thread. Not lost when no thread waits yet: the next wait returns at once.
  void ring() noexcept {
    ::sem_post(&rung_);
    if (lockstep::on()) waiter_.wake();
  }

  // Waits until then, the last `spin_ns` awake (wait_until in clock.h). True: it was rung before.
  bool wait(TimeNs time_ns, TimeNs spin_ns) noexcept {
    if (lockstep::on()) {
      while (::sem_trywait(&rung_) != 0) {
        if (now_ns() >= time_ns) return false;
        waiter_.wait(time_ns);
      }
      return true;
    }
    const timespec asleep = to_timespec(std::max(time_ns, spin_ns) - spin_ns);
    do {
      if (::sem_clockwait(&rung_, CLOCK_MONOTONIC, &asleep) == 0) return true;
    } while (errno == EINTR);
    wait_until(time_ns, spin_ns);
    return false;
  }

 private:
  ::sem_t rung_;
  lockstep::Waiter waiter_;
};

}  // namespace lss
