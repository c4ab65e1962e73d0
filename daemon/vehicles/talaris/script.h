#pragma once

// Scripts of TALARIS: timed actuations that are sent step by step, checked at reception and as a
// whole, and then run by themselves (TALARIS thesis 4.5.1, A.3.2). Time is counted in frames of 200
// ms from the lead on, so that a step at 0.2 n s is at a release. A valve has one pulse in a frame:
// the next one begins in a later frame than the last one ends in. Frame thread; time is data; no
// allocation.

#include <array>
#include <cstdint>

#include "daemon/cycle/messages.h"
#include "drivers/talaris/orders.h"
#include "idl/talaris/commands.h"

namespace lss::talaris {

inline constexpr TimeNs kFrame = 200 * kMillisecond;

struct ScriptStep {
  std::int32_t at_ms = 0;  // after the lead
  StepKind kind = StepKind::pulse;
  std::uint8_t which = 0;
  std::int32_t on_ms = 0;  // of a pulse
  double value = 0;        // of fans
  std::int32_t end_ms() const noexcept { return at_ms + (kind == StepKind::pulse ? on_ms : 0); }
};

// Orders of a frame's steps to fans: bit i of `fans`; rpm or throttle.
struct FanChange {
  std::uint8_t fans = 0;
  bool rpm = false;
  double value = 0;
};

class Script {
 public:
  // Checks of begin, step and run; a step's number (from 1 on) is the verdict's subject.
  Verdict consider_step(const Request& request) const noexcept;
  Verdict consider_run(std::uint32_t id) const noexcept;
  // The set of valves that it opens, and whether it uses fans.
  std::uint8_t valves() const noexcept { return valves_; }
  bool uses_fans() const noexcept { return fans_; }

  // Only after consider.
  void begin(const Request& request) noexcept;
  void add(const Request& request) noexcept;
  void run() noexcept;
  void end() noexcept { running_ = false; }

  // One frame while it runs: sets its pulses in `orders` (release_ns is set) and calls `change` for
  // each change of fans, in order.
  template <class Change>
  void advance(TalarisOrders& orders, Change change) noexcept {
    const std::int32_t from = now_ms_, until = from + kFrame_ms;
    now_ms_ = until;
    begun_ = done_;
    while (running_ && begun_ < count_ && step_[begun_].at_ms < until) {
      const ScriptStep& step = step_[begun_++];
      if (step.kind == StepKind::pulse) {
        open(step);
      } else {
        change(FanChange{step.which, step.kind == StepKind::rpm, step.value});
      }
    }
    done_ = begun_;
    if (running_) write(orders, from);
  }

  bool running() const noexcept { return running_; }
  // All steps are done and their pulses over.
  bool over() const noexcept { return done_ == count_ && now_ms_ >= end_ms_; }
  std::uint32_t id() const noexcept { return id_; }
  std::uint16_t steps() const noexcept { return announced_; }
  std::uint16_t loaded() const noexcept { return count_; }
  std::uint16_t done() const noexcept { return done_; }
  double elapsed_s() const noexcept {
    return running_ ? static_cast<double>(now_ms_ + kLead_ms) * 1e-3 : 0;
  }

 private:
  static constexpr std::int32_t kFrame_ms = 200;
  static constexpr auto kLead_ms = static_cast<std::int32_t>(kScriptLead_s * 1e3);

  void open(const ScriptStep& step) noexcept;
  void write(TalarisOrders& orders, std::int32_t from_ms) noexcept;

  std::array<ScriptStep, kMaxScriptSteps> step_{};
  std::uint32_t id_ = 0;  // 0: none
  std::uint16_t announced_ = 0, count_ = 0, begun_ = 0, done_ = 0;
  std::array<std::int32_t, kHopperValves> busy_until_ms_{};  // while it is sent: end of the pulses
  std::int32_t end_ms_ = 0;
  std::uint8_t valves_ = 0;
  bool fans_ = false;

  bool running_ = false;
  std::int32_t now_ms_ = 0;  // end of the last frame; negative: of the lead
  struct Window {
    std::int32_t from_ms = 0, to_ms = 0;
  };
  std::array<Window, kHopperValves> window_{};
};

}  // namespace lss::talaris
