#pragma once

// The scout's part of the locomotion controller (daemon/cycle/controller.h). Pure data and
// functions.

#include "commands.h"
#include "daemon/cycle/supervisor.h"

namespace lss::scout {

enum class Goal : std::uint8_t { none, off };  // of Stopping: motors off

namespace event {
using lc::vehicle_event;
inline constexpr lc::Event start = vehicle_event(0), stop = vehicle_event(1),
                           drive = vehicle_event(2), motors_confirmed = vehicle_event(3),
                           stands = vehicle_event(4);
}  // namespace event

enum Action : lc::ActionSet {
  kMotorsOn = lc::ActionSet{1} << lc::kVehicleActions,
  kDrive = kMotorsOn << 1,
  kHalt = kMotorsOn << 2,
};

extern const lc::Table kTable;
const Logic& logic() noexcept;

}  // namespace lss::scout
