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
using lc::vehicle_event;
// commanded
inline constexpr lc::Event start = vehicle_event(0), stop = vehicle_event(1),
                           manual = vehicle_event(2), duty_cycle = vehicle_event(3),
                           valve = vehicle_event(4), pulse = vehicle_event(5),
                           enable = vehicle_event(6), arm = vehicle_event(7),
                           assume_armed = vehicle_event(8), fan = vehicle_event(9),
                           standby = vehicle_event(10), calibrate = vehicle_event(11),
                           execute = vehicle_event(12), plan = vehicle_event(13),
                           gains = vehicle_event(14), land = vehicle_event(15),
                           script_upload = vehicle_event(16), script_run = vehicle_event(17),
                           script_abort = vehicle_event(18);
// reports
inline constexpr lc::Event calibrated = vehicle_event(19), calibration_refused = vehicle_event(20),
                           lifted_off = vehicle_event(21), finished = vehicle_event(22),
                           script_ended = vehicle_event(23), fans_armed = vehicle_event(24),
                           fans_unarmed = vehicle_event(25), imu_good = vehicle_event(26),
                           imu_lost = vehicle_event(27), altimeter_good = vehicle_event(28),
                           altimeter_lost = vehicle_event(29);
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

// Layout of SupervisorState::sense: [0] how many valves
// are open and fans run; [1] whether valves are open by hand or pulses are left.
inline constexpr std::size_t kSenseActive = 0, kSensePulsing = 1;

// For the supervisor.
const Logic& logic() noexcept;

}  // namespace lss::talaris
