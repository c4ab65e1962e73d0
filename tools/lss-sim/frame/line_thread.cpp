#include "tools/lss-sim/frame/line_thread.h"

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

namespace lss::sim {
namespace {

constexpr int kPriority = 60;
constexpr TimeNs kRetryNs = 100 * kMillisecond;  // when the port cannot be created again
constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();

timespec to_timespec(TimeNs time_ns) {
  return {.tv_sec = time_ns / kSecond, .tv_nsec = time_ns % kSecond};
}

}  // namespace

TimeNs monotonic_now() {
  if (lockstep::on()) return lockstep::now();
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecond + now.tv_nsec;
}

void keep_time(int fifo_priority) {
  ::prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);  // the default adds 50 us to every wait
  const sched_param wanted{.sched_priority = fifo_priority};
  ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted);
}

LineThread::LineThread(std::filesystem::path link, const Uart::Parameters& parameters,
                       LineDevice& device)
    : port_(std::move(link)),
      uart_(parameters, device),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

LineThread::~LineThread() {
  stop_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

tl::expected<void, std::string> LineThread::open() {
  if (auto opened = port_.open(); !opened) return opened;
  wire_.open(port_.link().filename().string());
  return {};
}

tl::expected<void, std::string> LineThread::start() {
  if (auto opened = open(); !opened) return opened;
  thread_ = std::thread([this] { loop(); });
  return {};
}

void LineThread::wake() { [[maybe_unused]] const int result = ::eventfd_write(wake_.get(), 1); }

void LineThread::set_fault(const Fault& fault, bool attach) {
  const std::lock_guard lock(mutex_);
  uart_.faults.set(fault, attach);
}

void LineThread::unplug(TimeNs duration_ns) {
  plug_at_ns_ = duration_ns > 0 ? monotonic_now() + duration_ns : 0;
  wake();
}

void LineThread::loop() {
  keep_time(kPriority);
  while (!stop_) {
    const TimeNs wake_ns = serve(monotonic_now());
    pollfd files[] = {{wake_.get(), POLLIN, 0}, {port_.fd(), POLLIN, 0}};
    const nfds_t count = port_.is_open() ? 2 : 1;
    const timespec wait = to_timespec(std::max<TimeNs>(0, wake_ns - monotonic_now()));
    ::ppoll(files, count, wake_ns == kNever ? nullptr : &wait, nullptr);
    eventfd_t ignored = 0;
    if ((files[0].revents & POLLIN) != 0) ::eventfd_read(wake_.get(), &ignored);
  }
}

TimeNs LineThread::serve(TimeNs now) {
  const std::lock_guard lock(mutex_);
  const TimeNs plug_at_ns = plug_at_ns_;
  if (now < plug_at_ns) {
    port_.close();
    wire_.close();
    uart_.forget();
    return plug_at_ns;
  }
  if (!port_.is_open()) {
    if (const auto opened = open(); !opened) {
      fmt::print(stderr, "lss-sim: {}; trying again\n", opened.error());
      return now + kRetryNs;
    }
  }
  read(now);
  uart_.advance(now);
  if (const auto bytes = uart_.take(now); !bytes.empty()) {
    if (!lockstep::on()) {
      port_.write(bytes);
    } else if (wire_.is_heard()) {
      wire_.sent(port_.write(bytes));
    }
  }
  return uart_.next_wake();
}

void LineThread::read(TimeNs now) {
  bool more = !lockstep::on() || wire_.coming();
  while (more) {
    const auto bytes = port_.read();
    if (!bytes.empty()) uart_.from_master(bytes, now);
    wire_.took(bytes.size());
    more = wire_.awaits(port_.fd());
  }
}

}  // namespace lss::sim
