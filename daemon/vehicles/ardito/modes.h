#pragma once

// D.I.A.N.A. Ardito's part of the locomotion controller: its modes (idl/ardito/commands.h), goals,
// flags, events, guards and rows. The modes are those of the mobility controller's decision logic
// (Ardito thesis 10), which goes through them by itself towards what was commanded. Pure data and
// pure functions.

#include "daemon/cycle/controller.h"
#include "daemon/cycle/supervisor.h"
#include "idl/ardito/commands.h"

namespace lss::ardito {

// The goal of the mobility controller.
enum class Goal : std::uint8_t {
  none,  // stand still
  drive,
  park,
  idle,  // stand still, then motors off
};

enum Flag : std::uint8_t {
  kMotorsConfirmed = 1u << 0,  // all drives in service report operation enabled
  kAutonomous = 1u << 1,       // the IMU is needed
  kImuLost = 1u << 2,          // silent or implausible
  kButtonIn = 1u << 3,         // the emergency-stop button is pressed
  kPowerBad = 1u << 4,
};

namespace event {
using lc::vehicle_event;
// commanded
inline constexpr lc::Event start = vehicle_event(0), stop = vehicle_event(1),
                           drive = vehicle_event(2), drive_autonomous = vehicle_event(3),
                           park = vehicle_event(4), halt = vehicle_event(5);
// reports
inline constexpr lc::Event warned = vehicle_event(6), motors_confirmed = vehicle_event(7),
                           is_stopped = vehicle_event(8), is_steering = vehicle_event(9),
                           is_running = vehicle_event(10), is_parking = vehicle_event(11),
                           is_decelerating = vehicle_event(12), imu_good = vehicle_event(13),
                           imu_lost = vehicle_event(14), button_out = vehicle_event(15),
                           button_in = vehicle_event(16), power_good = vehicle_event(17),
                           power_bad = vehicle_event(18), autonomy_lost = vehicle_event(20),
                           stuck = vehicle_event(21);
// of error solving
inline constexpr lc::Event isolate = vehicle_event(19);
}  // namespace event

enum Action : lc::ActionSet {
  kBeacon = lc::ActionSet{1} << lc::kVehicleActions,  // on, until motors are off
  kMotorsOn = kBeacon << 1,
  kConfirm = kBeacon << 2,
  kDrive = kBeacon << 3,
  kPark = kBeacon << 4,
  kHalt = kBeacon << 5,
  kByItself = kBeacon << 6,  // the vehicle drives: autonomous
  kByHand = kBeacon << 7,
  kImuIsGood = kBeacon << 8,
  kImuIsLost = kBeacon << 9,
  kButtonIsOut = kBeacon << 10,
  kButtonIsIn = kBeacon << 11,
  kPowerIsGood = kBeacon << 12,
  kPowerIsBad = kBeacon << 13,
};

extern const lc::Table kTable;

inline constexpr unsigned kMostIsolated = 1;  // wheels; the rover goes on with five

// Layout of SupervisorState::sense, for guards on measured values: [0] the speed limit selected at
// start, m/s; [1] how many drives are enabled; [2] the cap of the configuration, m/s; [3] the limit
// of the heading, rad.
inline constexpr std::size_t kSenseLimit = 0, kSenseMotorsOn = 1, kSenseCap = 2, kSenseHeading = 3;

// For the supervisor.
const Logic& logic() noexcept;

}  // namespace lss::ardito
