#pragma once

// Commands, modes and modules of the scout (idl/commands.h). Pure data.

#include "idl/codes.h"
#include "idl/commands.h"

namespace lss::scout {

inline constexpr std::size_t kDrives = 2;
inline constexpr const char* kDriveNames[kDrives] = {"left", "right"};

enum class Mode : std::uint8_t { none, enabling, ready, driving, stopping };
inline constexpr const char* kModeNames[] = {"none", "Enabling", "Ready", "Driving", "Stopping"};

inline constexpr std::uint16_t kStartCommand = 1, kStopCommand = 2, kDriveCommand = 401;
inline constexpr double kMostSpeed_m_s = 0.5, kMostTurn_rad_s = 1.0;

// The parameters of drive, and what the daemon describes them by.
struct Drive {
  double speed_m_s, turn_rad_s;
  static constexpr ParameterInfo kParameters[] = {
      {"speed", "m/s", -kMostSpeed_m_s, kMostSpeed_m_s, kRequired, nullptr, "forward is positive"},
      {"turn", "rad/s", -kMostTurn_rad_s, kMostTurn_rad_s, 0, nullptr, "left is positive"},
  };
};
inline constexpr ParameterInfo kResetParameters[] = {
    {"module", "", -1, kDrives, -1, nullptr, "1 left, 2 right, 0 both, -1 the controller itself",
     true},
};
inline constexpr CommandInfo kCommands[] = {
    {kStartCommand, "start", Access::holder, true, "motors on", {}},
    {kStopCommand, "stop", Access::holder, false, "slow down, then motors off", {}, true},
    {5, "reset", Access::holder, false, "reset a drive, both, or the controller", kResetParameters},
    {kDriveCommand, "drive", Access::holder, true, "drive until another command",
     Drive::kParameters, false, true},
};

inline constexpr FaultId kWheelBlocked{kFirstOwnCode};
inline constexpr CodeInfo kFaults[] = {
    {kFirstOwnCode, "wheel_blocked", 3, "wheel is blocked", "free it, then: lss-cli solve"},
};

}  // namespace lss::scout
