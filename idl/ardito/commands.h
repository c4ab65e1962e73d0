#pragma once

// The commands of D.I.A.N.A. Ardito (200..299), its modes and the names of its nodes. See
// idl/commands.h.

#include <cstdint>

#include "idl/angles.h"
#include "idl/commands.h"

namespace lss::ardito {

inline constexpr int kDriveWheels = 6;    // 1 LF, 2 RF, 3 LM, 4 RM, 5 LR, 6 RR
inline constexpr int kSteeredWheels = 4;  // of wheels 1, 2, 5, 6
inline constexpr int kBusNodes = 12;  // wheel drives 1..6, steering drives 7..10, I/O 11, IMU 12
inline constexpr int kIoNode = 11, kImuNode = 12;

inline constexpr const char* kNodeNames[kBusNodes] = {
    "LF",       "RF",       "LM",       "RM",       "LR", "RR",
    "steer-LF", "steer-RF", "steer-LR", "steer-RR", "IO", "IMU"};

// States of the link to a node and of a drive (CiA 402), as the telemetry numbers them.
inline constexpr const char* kLinkNames[] = {
    "off",      "booting",     "missing", "identifying", "wrong",       "configuring", "refuses",
    "starting", "operational", "lost",    "rebooted",    "fallen back", "babbling"};
inline constexpr const char* kDriveNames[] = {
    "unknown",     "not ready",         "switch-on disabled", "ready to switch on",
    "switched on", "operation enabled", "quick stop",         "fault reaction",
    "fault"};

// Modes of the state Operational (Ardito thesis 10, 11; the last five: its decision logic).
enum class Mode : std::uint8_t {
  none = 0,      // not Operational
  warning,       // the beacon runs before anything else; then to stopped
  stopped,       // wheels at zero, steering where it is
  steering,      // standing: the steering drives go to their angles
  running,       // driving along an arc
  parking,       // turning on the spot
  decelerating,  // wheels slow down
};
inline constexpr const char* kModeNames[] = {"none",    "Warning", "Stopped",     "Steering",
                                             "Running", "Parking", "Decelerating"};

enum class CommandKind : std::uint16_t {
  drive = 201,
  park = 202,
  halt = 203,
};

// Strategies of error solving; numbers as in the events strategy_begun and strategy_ended.
enum class StrategyKind : std::uint8_t {
  none = 0,
  reconnect,    // wait until everything answers again
  reset_fault,  // reset the faults of drives
  reset_node,   // reset the nodes at fault and configure them again
  retest,       // forget the diagnosis, close the clutches one at a time, and diagnose again
  isolate,      // go on with five wheels
};
inline constexpr const char* kStrategyNames[] = {"none",       "reconnect", "reset_fault",
                                                 "reset_node", "retest",    "isolate"};

// Speed limits of a whole operation (Ardito thesis 10.1: the rules of two competitions).
enum class SpeedLimit : std::uint8_t { erc, urc };
inline constexpr const char* kSpeedLimits[] = {"erc", "urc"};
inline constexpr double kSpeedLimits_m_s[] = {0.5, 1.0};

inline constexpr const char* kDrivers[] = {"manual", "autonomous"};

inline constexpr double kMaxHeading_rad = 5 * kDegree;  // Ardito thesis 11.2

// The parameters of each command.
struct Start {
  SpeedLimit limit;
  double speed_m_s;
  static constexpr ParameterInfo kParameters[] = {
      {"limit", "choice", 0, 1, 0, kSpeedLimits,
       "of the speed until the next start: erc 0.5 m/s, urc 1 m/s"},
      {"speed", "m/s", 0, 1, 0, nullptr,
       "that will be asked for: refused now when the vehicle may not drive it; 0: that of the "
       "limit"},
  };
};
struct Drive {
  double speed_m_s, heading_rad;
  bool correction, autonomous;
  static constexpr ParameterInfo kParameters[] = {
      {"speed", "m/s", -1, 1, kRequired, nullptr, "of the middle of the rover; negative: backward"},
      {"heading", "rad", -kMaxHeading_rad, kMaxHeading_rad, 0, nullptr,
       "direction of the motion, positive: to the right; 5 deg is a radius of 0.8 m"},
      {"correction", "choice", 0, 1, 1, kOffOn, "of the wheels' speeds for uneven ground"},
      {"driver", "choice", 0, 1, 0, kDrivers,
       "autonomous: begins after the lamp flashed for autonomy_s, stops when the IMU is lost"},
  };
};
struct Park {
  double speed_m_s;
  static constexpr ParameterInfo kParameters[] = {
      {"speed", "m/s", -1, 1, kRequired, nullptr, "of the corner wheels; positive: to the right"},
  };
};
inline constexpr ParameterInfo kResetParameters[] = {
    {"node", "", -1, kBusNodes, -1, nullptr,
     "1..6 a wheel drive, 7..10 a steering drive, 11 I/O, 12 IMU, 0 all, -1 the controller itself",
     true},
};

inline constexpr CommandInfo kCommands[] = {
    {1, "start", Access::holder, true,
     "beacon on, then the motors; from here on the link to the OBC is supervised",
     Start::kParameters},
    {2, "stop", Access::holder, false, "come to a safe stop, motors off", kNoParameters, true},
    {5, "reset", Access::holder, false, "reset a node, all nodes, or the controller",
     kResetParameters},
    {201, "drive", Access::holder, true, "drive along an arc until another command",
     Drive::kParameters, false, true},
    {202, "park", Access::holder, true, "turn on the spot until another command", Park::kParameters,
     false, true},
    {203, "halt", Access::holder, true, "stand still, ready to go on"},
};

}  // namespace lss::ardito
