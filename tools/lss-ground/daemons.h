#pragma once

// The daemons that publish under one vehicle_id: one, or several by mistake or on purpose. A
// restarted daemon is not a second one, because the old one is silent. Pure functions of the given
// time.

#include <cstddef>
#include <vector>

#include "lss.h"
#include "tools/lss-ground/outbox.h"

namespace lss::ground {

class Daemons {
 public:
  static constexpr Clock::duration kGone = std::chrono::seconds(10);  // time of the last message
  static constexpr std::size_t kMost = 8;

  void heard(const lss_Instance& instance, Clock::time_point now);
  // The daemons that publish at the same time; empty: there is one, or none.
  std::vector<lss_Instance> rivals(Clock::time_point now) const;

 private:
  struct Daemon {
    lss_Instance instance{};
    Clock::time_point since{}, heard{};
  };
  std::vector<Daemon> daemons_;
};

}  // namespace lss::ground
