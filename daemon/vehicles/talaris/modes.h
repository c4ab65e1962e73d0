#pragma once

// TALARIS' part of the locomotion controller: its modes (idl/talaris/commands.h), goals, flags,
// events, guards and rows (TALARIS thesis 4.5.1: manual control, duty cycle, scripts, and the three
// steps of the GNC in their order). Pure data and pure functions.

#include "daemon/cycle/controller.h"
#include "daemon/cycle/supervisor.h"
#include "idl/talaris/commands.h"

namespace lss::talaris {

// In Execute: whether it is in the air, and the state after the landing.
enum class Goal : std::uint8_t {
  none,     // on the ground
  flying,   // in the air, as planned
  landing,  // in the air, on its way down: then Standby
  idle,     // in the air, on its way down: then Idle
};

enum Flag : std::uint8_t {
  kCalibrated = 1u << 0,
  kPlanned = 1u << 1,
  kFansArmed = 1u << 2,      // the speed controllers went through their start-up
  kImuLost = 1u << 3,        // silent, or not reliable
  kAltimeterLost = 1u << 4,  // silent, or errors only
};

namespace event {
inline constexpr lc::Event vehicle(unsigned n) {
  return static_cast<lc::Event>(lc::kVehicleEvents + n);
}
// commanded
inline constexpr lc::Event start = vehicle(0), stop = vehicle(1), manual = vehicle(2),
                           duty_cycle = vehicle(3), valve = vehicle(4), pulse = vehicle(5),
                           enable = vehicle(6), arm = vehicle(7), assume_armed = vehicle(8),
                           fan = vehicle(9), standby = vehicle(10), calibrate = vehicle(11),
                           execute = vehicle(12), plan = vehicle(13), gains = vehicle(14),
                           land = vehicle(15), script_upload = vehicle(16),
                           script_run = vehicle(17), script_abort = vehicle(18);
// reports
inline constexpr lc::Event calibrated = vehicle(19), calibration_refused = vehicle(20),
                           lifted_off = vehicle(21), finished = vehicle(22),
                           script_ended = vehicle(23), fans_armed = vehicle(24),
                           fans_unarmed = vehicle(25), imu_good = vehicle(26),
                           imu_lost = vehicle(27), altimeter_good = vehicle(28),
                           altimeter_lost = vehicle(29);
}  // namespace event

enum Action : lc::ActionSet {
  kShut = lc::ActionSet{1} << lc::kVehicleActions,  // valves, fans off: actuation by hand ends
  kValve = kShut << 1,
  kPulse = kShut << 2,
  kEnable = kShut << 3,
  kArm = kShut << 4,
  kIsArmed = kShut << 5,
  kIsUnarmed = kShut << 6,
  kFan = kShut << 7,
  kGncOff = kShut << 8,  // the calibration is cleared
  kCalibrate = kShut << 9,
  kIsCalibrated = kShut << 10,
  kExecute = kShut << 11,
  kPlan = kShut << 12,
  kGains = kShut << 13,
  kLand = kShut << 14,
  kUpload = kShut << 15,
  kRunScript = kShut << 16,
  kEndFlight = kShut << 17,
  kImuIsGood = kShut << 18,
  kImuIsLost = kShut << 19,
  kAltimeterIsGood = kShut << 20,
  kAltimeterIsLost = kShut << 21,
};

extern const lc::Table kTable;

// In Execute and off the ground.
bool airborne(const lc::ControllerState& state) noexcept;

// Commands that only the vehicle can judge: gas and thrust, scripts, valves by hand.
bool considered(std::uint16_t kind) noexcept;

// The event of a command of the DDS face; Event::none when it is not one of ours.
lc::Event event_of(const Request& request) noexcept;

// Whether the command's goal has been reached.
bool reached(std::uint16_t kind, const SupervisorState& state) noexcept;

// The module of a command; 0: none.
unsigned subject_of(const Request& request) noexcept;

// No guards: the vehicle has Actor::consider. Layout of SupervisorState::sense: [0] how many valves
// are open and fans run; [1] whether valves are open by hand or pulses are left.
Verdict sense(const SupervisorState& state, const Request& request) noexcept;
inline constexpr std::size_t kSenseActive = 0, kSensePulsing = 1;

// The command of `kind`, common or talaris' own; nullptr when there is none.
const CommandInfo* command(std::uint16_t kind) noexcept;

// All of the above, for the supervisor.
const Logic& logic() noexcept;

}  // namespace lss::talaris
