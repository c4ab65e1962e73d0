#pragma once

// The scout's part of the locomotion controller (daemon/cycle/controller.h). Pure data and
// functions.

#include "commands.h"
#include "daemon/cycle/supervisor.h"

namespace lss::scout {

enum class Goal : std::uint8_t { none, off };  // of Stopping: motors off

namespace event {
inline constexpr lc::Event of_scout(unsigned n) {
  return static_cast<lc::Event>(lc::kVehicleEvents + n);
}
inline constexpr lc::Event start = of_scout(0), stop = of_scout(1), drive = of_scout(2),
                           motors_confirmed = of_scout(3), stands = of_scout(4);
}  // namespace event

enum Action : lc::ActionSet {
  kMotorsOn = lc::ActionSet{1} << lc::kVehicleActions,
  kDrive = kMotorsOn << 1,
  kHalt = kMotorsOn << 2,
};

extern const lc::Table kTable;
const Logic& logic() noexcept;

}  // namespace lss::scout
