#include "tools/lss-sim/frame/wire_thread.h"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>

#include "drivers/lockstep/lockstep.h"

namespace lss::sim {
namespace {

constexpr int kPriority = 60;
constexpr TimeNs kRetryNs = 100 * kMillisecond;  // when the end cannot be opened again
constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();

}  // namespace

TimeNs monotonic_now() { return lockstep::on() ? lockstep::now() : lockstep::wall_now(); }

void keep_time(int fifo_priority) {
  ::prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);  // the default adds 50 us to every wait
  const sched_param wanted{.sched_priority = fifo_priority};
  ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted);
}

WireThread::WireThread() : wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

tl::expected<void, std::string> WireThread::start() {
  if (auto opened = open(); !opened) return opened;
  thread_ = std::thread([this] { loop(); });
  return {};
}

void WireThread::stop() {
  stop_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

void WireThread::wake() { [[maybe_unused]] const int result = ::eventfd_write(wake_.get(), 1); }

void WireThread::unplug(TimeNs duration_ns) {
  plug_at_ns_ = duration_ns > 0 ? monotonic_now() + duration_ns : 0;
  wake();
}

void WireThread::loop() {
  keep_time(kPriority);
  while (!stop_) {
    const TimeNs wake_ns = serve(monotonic_now());
    pollfd files[] = {{wake_.get(), POLLIN, 0}, {fd(), POLLIN, 0}};
    const nfds_t count = is_open() ? 2 : 1;
    const TimeNs left_ns = std::max<TimeNs>(0, wake_ns - monotonic_now());
    const timespec wait{.tv_sec = left_ns / kSecond, .tv_nsec = left_ns % kSecond};
    ::ppoll(files, count, wake_ns == kNever ? nullptr : &wait, nullptr);
    eventfd_t ignored = 0;
    if ((files[0].revents & POLLIN) != 0) ::eventfd_read(wake_.get(), &ignored);
  }
}

TimeNs WireThread::serve(TimeNs now) {
  const std::lock_guard lock(mutex_);
  const TimeNs plug_at_ns = plug_at_ns_;
  if (now < plug_at_ns) {
    close(now);
    return plug_at_ns;
  }
  if (!is_open()) {
    if (const auto opened = open(); !opened) {
      fmt::print(stderr, "lss-sim: {}; trying again\n", opened.error());
      return now + kRetryNs;
    }
  }
  return exchange(now);
}

}  // namespace lss::sim
