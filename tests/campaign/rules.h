#pragma once

// Requirements on every frame of a vehicle's run, with any faults: orders are numbers in their
// ranges; outside Operational none moves the vehicle; it is at standstill soon after it left
// Operational, and stays so. World: play.h.

#include <fmt/format.h>

#include <algorithm>

#include "daemon/cycle/messages.h"

namespace lss::campaign {

template <class World>
class Rules {
 public:
  unsigned stops = 0;             // into FatalError
  double slowest_rest_s = 0;      // from leaving Operational
  double slowest_cut_rest_s = 0;  // the same with the bus cut

  // After every frame. broke(text): what does not hold.
  template <class Broke>
  void look(World& world, Broke&& broke) {
    const double now_s = world.chain.seconds();
    if (!world.sound()) broke("an order is no number, or out of its range");
    if (world.chain.state() == State::operational) {
      was_operational_ = true;
      rested_ = was_cut_ = false;
      return;
    }
    was_cut_ = was_cut_ || world.cut();
    if (was_operational_) {
      was_operational_ = false;
      left_s_ = now_s;
      if (world.chain.state() == State::fatal_error) ++stops;
    }
    if (world.may_move()) {
      left_s_ = now_s;
      rested_ = false;
      return;
    }
    if (world.moves()) broke("an order moves it outside Operational");
    if (world.rests()) {
      double& slowest_s = was_cut_ ? slowest_cut_rest_s : slowest_rest_s;
      if (!rested_) slowest_s = std::max(slowest_s, now_s - left_s_);
      rested_ = true;
    } else if (now_s - left_s_ > (was_cut_ ? World::kCutRest_s : World::kRest_s)) {
      if (!complained_)
        broke(fmt::format("moves {:.1f} s after Operational: {}", now_s - left_s_, world.motion()));
      complained_ = true;
    }
  }

 private:
  double left_s_ = 0;  // when it left Operational
  bool was_operational_ = false, was_cut_ = false, rested_ = true, complained_ = false;
};

}  // namespace lss::campaign
