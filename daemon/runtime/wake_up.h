#pragma once

// Wakes the thread that waits for it, in real and in simulated time. One thread waits; any thread
// wakes it, without waiting itself.

#include <poll.h>
#include <sys/eventfd.h>

#include <array>

#include "daemon/runtime/clock.h"
#include "drivers/file.h"
#include "drivers/lockstep/lockstep.h"

namespace lss {

class WakeUp {
 public:
  void wake() noexcept {
    if (lockstep::on()) return waiter_.wake();
    [[maybe_unused]] const int failed = ::eventfd_write(file_.get(), 1);
  }

  // Until it is woken, that time, or an event of the other file; the events.
  short wait(TimeNs until, int other = -1, short events = 0) noexcept {
    if (lockstep::on()) {
      waiter_.wait(until);
      return 0;
    }
    std::array<pollfd, 2> files{{{file_.get(), POLLIN, 0}, {other, events, 0}}};
    const timespec left = to_timespec(left_until(until));
    ::ppoll(files.data(), files.size(), &left, nullptr);
    if (eventfd_t count = 0; files[0].revents != 0) ::eventfd_read(file_.get(), &count);
    return files[1].revents;
  }

 private:
  File file_{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
  lockstep::Waiter waiter_;  // in simulated time
};

}  // namespace lss
