#pragma once

// The running daemon of one vehicle: its threads and what goes between them (docs/architecture.md
// has the picture). bus/NAME move bytes, frame runs the cycle at every boundary, actuate releases
// the command of the frame at the offset, the DDS listener puts requests down, publish carries away
// what the frame has to say. frame, actuate and bus are real-time: they never allocate, lock, log
// or call DDS.
//
// Vehicle: what daemon/core/cycle.h asks for. Buses: the vehicle's wiring,
//   Buses(config, parameters), probe() -> expected, bodies() -> {name, function}, stop(),
//   collect(Inputs&) (frame thread), release(const Command&) (actuate thread), dropped().

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/core/app.h"
#include "daemon/core/clock.h"
#include "daemon/core/command_port.h"
#include "daemon/core/cycle.h"
#include "daemon/core/frame_clock.h"
#include "daemon/core/publisher.h"
#include "daemon/rt/thread.h"

namespace lss {

template <class Vehicle, class Buses>
class Runtime final : public App {
 public:
  using Parameters = typename Buses::Parameters;

  Runtime(const config::Config& config, const Parameters& parameters, const Logic& logic,
          const Vocabulary& vocabulary)
      : config_(config),
        buses_(config_, parameters),
        vehicle_(parameters),
        supervisor_(logic, {.obc_timeout_ns = config.obc_timeout_ns}),
        port_(logic, static_cast<std::uint32_t>(config.lease_min_ms),
              static_cast<std::uint32_t>(config.lease_max_ms)),
        publisher_(config_, vocabulary) {
    port_.show(supervisor_.state());
  }
  ~Runtime() override { stop(); }

  tl::expected<void, std::string> start() override {
    if (auto ok = buses_.probe(); !ok) return ok;
    // DDS first: its threads inherit the ordinary scheduling of this one.
    if (auto ok = publisher_.open([this](const Request& r) {
          port_.receive(r, [this](const Ack& ack) { publisher_.answer(ack); });
        });
        !ok) {
      return ok;
    }
    const auto locked = rt::lock_memory();
    if (!locked && config_.realtime_enforce) return locked;
    if (!locked) publisher_.complain(locked.error());
    publisher_.memory_locked(locked.has_value());
    rt::populate_memory();

    // The grid begins a little ahead, on a whole period of the monotonic clock.
    const TimeNs epoch = (now_ns() / config_.period_ns + 2) * config_.period_ns;
    clock_ = std::make_unique<FrameClock>(epoch, config_.period_ns, config_.offset_ns);
    for (auto& [name, body] : buses_.bodies()) {
      if (auto ok = launch(name, std::move(body)); !ok) return ok;
    }
    if (auto ok = launch("actuate", [this] { actuate(); }); !ok) return ok;
    if (auto ok = launch("frame", [this] { frame(); }); !ok) return ok;
    // READY is when frames run and every thread has touched what it will touch.
    const TimeNs until = now_ns() + 5 * kSecond;
    while (frames() < kWarmUpFrames) {
      if (now_ns() > until)
        return tl::unexpected(std::string(
            "the frame thread does not run: check the CPU numbers and priorities in [realtime]"));
      sleep_until(now_ns() + config_.period_ns);
    }
    for (const auto& thread : threads_) thread->mark_ready();
    publisher_.start(
        threads_, [this] { return newest_telemetry(); }, [this] { return port_.refused(); });
    return {};
  }

  void stop() override {
    if (threads_.empty()) return;
    shut_down_ = true;
    const std::uint64_t last = frames() + kShutDownFrames;
    const TimeNs until = now_ns() + kSecond;
    while (frames() < last && now_ns() < until) sleep_until(now_ns() + config_.period_ns);
    stop_ = true;
    buses_.stop();
    for (const auto& thread : threads_) thread->join();
    publisher_.stop();
    threads_.clear();
  }

  std::uint64_t frames() const override { return frames_.load(std::memory_order_relaxed); }
  std::string summary() const override { return publisher_.summary(); }
  bool wants_restart() const override { return publisher_.wants_restart(); }

 private:
  static constexpr std::uint64_t kWarmUpFrames = 5;
  static constexpr std::uint64_t kShutDownFrames =
      10;  // for the safe command to reach every module

  // What the frame thread hands to the actuate thread, and what that one reports back.
  struct Due {
    std::uint64_t frame = 0;  // 0: none yet
    typename Vehicle::Command command{};
  };
  struct Released {
    TimeNs released_ns = 0;
    std::uint64_t overruns = 0, repeated = 0;
    bool limit = false;
  };

  tl::expected<void, std::string> launch(const std::string& name, std::function<void()> body) {
    rt::Wish wish{.name = name};
    for (const config::Thread& t : config_.threads) {
      if (t.name == name) wish = {.name = name, .priority = t.priority, .cpu = t.cpu};
    }
    threads_.push_back(std::make_unique<rt::Thread>());
    auto ok = threads_.back()->start(wish, config_.realtime_enforce, std::move(body));
    if (!ok && !config_.realtime_enforce) {
      publisher_.complain(ok.error());
      return {};
    }
    return ok;
  }

  // Publish thread: nullptr when there is nothing new.
  const void* newest_telemetry() { return telemetry_.update() ? &telemetry_.value() : nullptr; }

  void frame() noexcept;
  void actuate() noexcept;
  void collect(std::uint64_t frame, TimingPoints& timing) noexcept;
  void hand_over(const TimingPoints& timing) noexcept;

  config::Config config_;
  Buses buses_;
  Vehicle vehicle_;
  Supervisor supervisor_;
  CommandPort port_;
  Publisher publisher_;
  std::unique_ptr<FrameClock> clock_;

  Inputs<Vehicle> in_;
  Outputs<Vehicle> out_;
  Latest<typename Vehicle::Telemetry> telemetry_;
  Latest<Due> due_;
  Latest<Released> released_;
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<bool> stop_{false}, shut_down_{false};
  std::vector<std::unique_ptr<rt::Thread>> threads_;
};

// The frame thread.
template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::frame() noexcept {
  std::uint64_t skipped = 0;
  for (std::uint64_t k = 1; !stop_.load(std::memory_order_relaxed);) {
    sleep_until(clock_->boundary(k));
    TimingPoints timing{.frame = k,
                        .boundary_ns = clock_->boundary(k),
                        .woken_ns = now_ns(),
                        .offset_ns = clock_->offset_ns()};
    collect(k, timing);
    cycle(vehicle_, supervisor_, in_, out_, [&](Stage stage) {
      if (stage == Stage::navigated) timing.navigated_ns = now_ns();
    });
    due_.put({.frame = k, .command = out_.command});
    timing.ready_ns = now_ns();
    timing.margin_ns = clock_->release(k) - timing.ready_ns;
    timing.frames_skipped = skipped;
    hand_over(timing);
    frames_.fetch_add(1, std::memory_order_relaxed);
    const std::uint64_t next = clock_->after(k, now_ns());
    skipped += next - k - 1;
    k = next;
  }
}

template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::collect(std::uint64_t frame, TimingPoints& timing) noexcept {
  in_.frame = frame;
  in_.time_ns = timing.boundary_ns;
  buses_.collect(in_);
  in_.request_count = 0;
  while (in_.request_count < kMaxRequests && port_.pop(in_.requests[in_.request_count]))
    ++in_.request_count;
  const Released& released = released_.get();
  in_.late_commands = released.overruns;
  in_.overrun_limit = released.limit || timing.woken_ns - timing.boundary_ns >=
                                            config_.max_consecutive_overruns * clock_->period_ns();
  in_.shut_down = shut_down_.load(std::memory_order_relaxed);
  timing.released_ns = released.released_ns;
  timing.overruns = released.overruns;
  timing.commands_repeated = released.repeated;
  timing.samples = in_.sample_count;
  timing.read_ns = now_ns();
}

template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::hand_over(const TimingPoints& timing) noexcept {
  port_.show(supervisor_.state());
  publisher_.put(supervisor_.outbox());
  publisher_.put(supervisor_.state());
  publisher_.put(timing);
  if (config_.telemetry_periodic || out_.data_requested) telemetry_.put(out_.telemetry);
  publisher_.wake();
}

// The actuate thread: the command of frame k leaves at T_k + offset, never earlier and never "when
// ready".
template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::actuate() noexcept {
  OverrunCounter overruns(config_.max_consecutive_overruns);
  Released report;
  for (std::uint64_t k = 1; !stop_.load(std::memory_order_relaxed);) {
    sleep_until(clock_->release(k));
    const Due& due = due_.get();
    const bool in_time = due.frame == k;
    if (in_time) {
      overruns.in_time();
      report.limit = false;
    } else {
      report.limit = overruns.late();
    }
    // Late once: the previous command again. Late again: nothing, and the bus sees its orders grow
    // stale.
    if (in_time || (due.frame != 0 && overruns.consecutive() == 1)) {
      report.repeated += in_time ? 0 : 1;
      buses_.release(due.command);
    }
    report.released_ns = now_ns();
    // Releases that were slept through are late as well: a standstill of the machine is an overrun.
    const std::uint64_t next = clock_->after(k, report.released_ns - clock_->offset_ns());
    if (next > k + 1) report.limit = overruns.late(next - k - 1);
    report.overruns = overruns.total();
    released_.put(report);
    k = next;
  }
}

}  // namespace lss
