#pragma once

// Modules being reset by a `reset` command: silent until they answer again or their time is over. A
// vehicle ignores these when it judges silence. Frame thread; time is data; no allocation.

#include <array>
#include <cstdint>

#include "daemon/cycle/supervisor.h"

namespace lss {

class Resets {
 public:
  // `restarts`: how often the module has restarted so far.
  void begin(std::size_t module, TimeNs now, std::uint64_t restarts) noexcept {
    modules_ = static_cast<std::uint16_t>(modules_ | 1u << module);
    begun_ns_[module] = now;
    restarts_[module] = restarts;
  }
  bool away(std::size_t module) const noexcept { return (modules_ >> module & 1u) != 0; }

  // Once per frame, before silence is judged: which are back, and which were silent for longer than
  // `limit`. restarts(module) as in begin(), answers(module): in this frame.
  template <class Restarts, class Answers>
  void watch(TimeNs now, TimeNs limit, bool port_open, Restarts&& restarts, Answers&& answers,
             Supervisor& s) noexcept {
    for (std::size_t i = 0; modules_ >> i != 0; ++i) {
      if (!away(i)) continue;
      const auto number = static_cast<std::uint16_t>(i + 1);
      const TimeNs since_ns = now - begun_ns_[i];
      const bool there = answers(i);
      if (since_ns == 0) s.note(EventId::reset_begun, number, seconds(limit));
      if (there && restarts(i) != restarts_[i]) {
        end(i);
        s.note(EventId::reset_ended, number, seconds(since_ns));
      } else if (since_ns > limit) {
        end(i);
        const Reason absent = port_open ? Reason::module_silent : Reason::port_closed;
        s.reset_failed(there ? Reason::not_reset : absent, number);
      }
    }
    s.set_resetting(modules_);
  }

 private:
  static double seconds(TimeNs time) noexcept { return static_cast<double>(time) * 1e-9; }
  void end(std::size_t module) noexcept {
    modules_ = static_cast<std::uint16_t>(modules_ & ~(1u << module));
  }

  std::uint16_t modules_ = 0;  // bit i: module i+1
  std::array<TimeNs, kMaxModules> begun_ns_{};
  std::array<std::uint64_t, kMaxModules> restarts_{};
};

}  // namespace lss
