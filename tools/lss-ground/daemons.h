#pragma once

// Which daemons speak under one vehicle_id: one, or several by mistake or on purpose. A daemon that
// was started again is no second one: the one before it says nothing any more. Pure functions of
// the time that they are given.

#include <cstddef>
#include <vector>

#include "lss.h"
#include "tools/lss-ground/outbox.h"

namespace lss::ground {

class Daemons {
 public:
  static constexpr Clock::duration kGone = std::chrono::seconds(10);  // it was heard last then
  static constexpr std::size_t kMost = 8;

  void heard(const lss_Instance& instance, Clock::time_point now);
  // Those that speak in turns; empty: there is one, or none.
  std::vector<lss_Instance> rivals(Clock::time_point now) const;

 private:
  struct Daemon {
    lss_Instance instance{};
    Clock::time_point since{}, heard{};
  };
  std::vector<Daemon> daemons_;
};

}  // namespace lss::ground
