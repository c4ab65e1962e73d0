#include "tools/lss-sim/frame/can_thread.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>

#include "tools/lss-sim/frame/line_thread.h"

namespace lss::sim {
namespace {

constexpr int kPriority = 60;
constexpr TimeNs kRetryNs = 100 * kMillisecond;  // when the end cannot be opened again
constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();

}  // namespace

CanThread::CanThread(std::string address, const CanBus::Parameters& parameters, CanDevice& device)
    : end_(std::move(address)),
      bus_(parameters, device),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

CanThread::~CanThread() {
  stop_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

tl::expected<void, std::string> CanThread::start() {
  if (auto opened = end_.open(); !opened) return opened;
  thread_ = std::thread([this] { loop(); });
  return {};
}

void CanThread::wake() { [[maybe_unused]] const int result = ::eventfd_write(wake_.get(), 1); }

void CanThread::set_fault(const Fault& fault, bool attach) {
  {
    const std::lock_guard lock(mutex_);
    if (!bus_.faults.set(fault, attach)) {
      const double seconds = attach ? fault.values.front() : 0;
      bus_.bus_off(monotonic_now(), static_cast<TimeNs>(seconds * kSecond));
    }
  }
  wake();
}

bool CanThread::is_off() {
  const std::lock_guard lock(mutex_);
  return bus_.is_off();
}

bool CanThread::unplugged() const { return monotonic_now() < plug_at_ns_; }

void CanThread::unplug(TimeNs duration_ns) {
  plug_at_ns_ = duration_ns > 0 ? monotonic_now() + duration_ns : 0;
  wake();
}

void CanThread::loop() {
  keep_time(kPriority);
  while (!stop_) {
    const TimeNs wake_ns = serve(monotonic_now());
    pollfd files[] = {{wake_.get(), POLLIN, 0}, {end_.fd(), POLLIN, 0}};
    const nfds_t count = end_.is_open() ? 2 : 1;
    const TimeNs left_ns = std::max<TimeNs>(0, wake_ns - monotonic_now());
    const timespec wait{.tv_sec = left_ns / kSecond, .tv_nsec = left_ns % kSecond};
    ::ppoll(files, count, wake_ns == kNever ? nullptr : &wait, nullptr);
    eventfd_t ignored = 0;
    if ((files[0].revents & POLLIN) != 0) ::eventfd_read(wake_.get(), &ignored);
  }
}

TimeNs CanThread::serve(TimeNs now) {
  const std::lock_guard lock(mutex_);
  const TimeNs plug_at_ns = plug_at_ns_;
  if (now < plug_at_ns) {
    end_.close();
    bus_.advance(now);  // nodes continue and receive nothing
    bus_.forget();
    return plug_at_ns;
  }
  if (!end_.is_open()) {
    if (const auto opened = end_.open(); !opened) {
      fmt::print(stderr, "lss-sim: {}; trying again\n", opened.error());
      return now + kRetryNs;
    }
  }
  for (const CanFrame& frame : end_.read()) bus_.from_master(frame, now);
  bus_.advance(now);
  if (const auto frames = bus_.take(now); !frames.empty()) end_.write(frames);
  return bus_.next_wake();
}

}  // namespace lss::sim
