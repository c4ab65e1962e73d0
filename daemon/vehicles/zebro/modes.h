#pragma once

// Lunar Zebro's part of the locomotion controller: its modes (idl/zebro/commands.h), goals, flags,
// events, guards and rows. Pure data and pure functions.

#include "daemon/cycle/controller.h"
#include "daemon/cycle/supervisor.h"
#include "idl/zebro/commands.h"

namespace lss::zebro {

// Target of a chain of modes.
enum class Goal : std::uint8_t {
  none,  // stay in the mode that was commanded
  stand,
  walk,
  lie,
  stow,
  idle,      // motors off when the running motion has ended
  lie_idle,  // lie down, then motors off
  leg,       // a leg moves by direct command
};

enum Flag : std::uint8_t {
  kPanelOut = 1u << 0,  // deployed, or not known to be retracted
  kPanelMoving = 1u << 1,
  kMotorsConfirmed = 1u << 2,  // all legs report motion control on
  kFreeing = 1u << 3,          // error solving moves one leg
};

namespace event {
using lc::vehicle_event;
// commanded
inline constexpr lc::Event start = vehicle_event(0), start_stand = vehicle_event(1),
                           start_walk = vehicle_event(2), stop = vehicle_event(3),
                           stop_lay_down = vehicle_event(4), stand = vehicle_event(5),
                           lay_down = vehicle_event(6), stow = vehicle_event(7),
                           walk = vehicle_event(8), walk_zero = vehicle_event(9),
                           leg = vehicle_event(10), panel_deploy = vehicle_event(11),
                           panel_retract = vehicle_event(12);
// reports
inline constexpr lc::Event motors_confirmed = vehicle_event(13), motion_done = vehicle_event(14),
                           panel_arrived_in = vehicle_event(15),
                           panel_arrived_out = vehicle_event(16),
                           panel_seen_out = vehicle_event(17);
// of error solving
inline constexpr lc::Event free_leg = vehicle_event(18), leg_freed = vehicle_event(19),
                           isolate = vehicle_event(20);
// commanded, in Idle and FatalError
inline constexpr lc::Event isolate_leg = vehicle_event(21), restore_leg = vehicle_event(22),
                           panel_is_in = vehicle_event(23);
}  // namespace event

enum Action : lc::ActionSet {
  kMotorsOn = lc::ActionSet{1} << lc::kVehicleActions,
  kConfirm = kMotorsOn << 1,
  kStandUp = kMotorsOn << 2,
  kWalk = kMotorsOn << 3,
  kFinishStep = kMotorsOn << 4,
  kLayDown = kMotorsOn << 5,
  kStow = kMotorsOn << 6,
  kMoveLeg = kMotorsOn << 7,
  kPanelDeploy = kMotorsOn << 8,
  kPanelRetract = kMotorsOn << 9,
  kPanelIsIn = kMotorsOn << 10,
  kPanelIsOut = kMotorsOn << 11,
  kFreeLeg = kMotorsOn << 12,
  kPanelForgone = kMotorsOn << 13,  // its module is out of service
  kPanelStop = kMotorsOn << 14,     // where it is; without an effect when it rests
};

extern const lc::Table kTable;

// Whether the others can stand and walk without these modules (bit i: module i+1), with the default
// gaits.
bool enough_legs_without(unsigned isolated) noexcept;

// The event of a command of the DDS face; Event::none when it is not one of ours.
lc::Event event_of(const Request& request) noexcept;

// Layout of SupervisorState::sense, for guards on measured values: [0..6] position_rad of the
// modules, NaN when unknown; [7] the fastest a leg may turn, rad/s; [8] legs with motion control
// on; [9] the first module that stopped by itself and was not reset since, 0: none; [10] the
// largest number of error-solving rounds of a present fault, [11] its module, [12] the limit; [13]
// the longest lease, ms, after which a safe stop ends before a silent OBC is an emergency; [14] a
// leg out of service without which the others cannot walk, 0: none.
inline constexpr std::size_t kSenseTurnLimit = kModules, kSenseMotorsOn = kModules + 1,
                             kSenseTripped = kModules + 2, kSenseSolveRounds = kModules + 3,
                             kSenseSolveModule = kModules + 4, kSenseSolveLimit = kModules + 5,
                             kSenseLongestLease = kModules + 6, kSenseUnstable = kModules + 7;

// The command that takes a module out of service, as after a restart of the daemon.
Request isolation_of(unsigned module) noexcept;

// For the supervisor.
const Logic& logic() noexcept;

}  // namespace lss::zebro
