#pragma once

// The commands of TALARIS (300..399), its modes and the names of its modules. See idl/commands.h.

#include <cstdint>
#include <iterator>
#include <numbers>

#include "idl/commands.h"

namespace lss::talaris {

inline constexpr int kValveCount = 8;  // 1, 3, 5, 7 lift; 2, 4, 6, 8 push sideways
inline constexpr int kFanCount = 4;
inline constexpr int kModuleCount = 5;
// Supervised modules: 1..5. Modules 3 to 5 are CANopen nodes 0x20 to 0x22.
inline constexpr int kImuModule = 1, kAltimeterModule = 2, kValveModule = 3, kFanModule = 4,
                     kLoadCellModule = 5;
inline constexpr const char* kModuleNames[kModuleCount] = {"IMU", "altimeter", "valves", "fans",
                                                           "load-cell"};
// Subjects of faults: the modules, then valves, fans and the altimeters at the corners.
inline constexpr int kFirstValve = kModuleCount + 1, kFirstFan = kFirstValve + kValveCount,
                     kFirstCorner = kFirstFan + kFanCount, kCornerCount = 4;
inline constexpr const char* kSubjectNames[] = {
    "IMU",     "altimeter", "valves",  "fans",     "load-cell", "valve-1",  "valve-2",
    "valve-3", "valve-4",   "valve-5", "valve-6",  "valve-7",   "valve-8",  "fan-1",
    "fan-2",   "fan-3",     "fan-4",   "corner-1", "corner-2",  "corner-3", "corner-4"};
static_assert(std::size(kSubjectNames) == kFirstCorner + kCornerCount - 1);

// Modes of the state Operational (TALARIS thesis 4.5.1).
enum class Mode : std::uint8_t {
  none = 0,    // not Operational
  manual,      // valves by hand, fans by throttle or speed; to any other
  duty_cycle,  // pulses of chosen length and delay in every frame
  script,      // a list of timed actuations runs; its end: manual
  standby,     // GNC on, valves shut; to calibrate
  calibrate,   // GNC flies the plan; its end: standby
  execute,     // GNC flies what was planned; its end: standby
};
inline constexpr const char* kModeNames[] = {"none",    "Manual",    "DutyCycle", "Script",
                                             "Standby", "Calibrate", "Execute"};

// Phases of the flight in Execute, as telemetry numbers them.
enum class Phase : std::uint8_t {
  none = 0,
  ready,     // planned, on the ground
  spin_up,   // fans come to their speed
  ascend,    // 1-g of the Moon is left for the cold gas
  hover,     // at height, before the traverse
  traverse,  // level, sideways
  brake,     // hover after the traverse
  descend,
  touchdown,  // contact: valves shut, fans run down
  landed,
  hold,       // a fault in flight: stays where it is for a moment
  escape,     // no cold gas: fans hold attitude and height on the way down
  parachute,  // the cold gas is gone: fans hold attitude and height on the way down
  turn,       // about the vertical: sled and hover
  keep,       // holds an attitude or a height until the next command (test stands)
};
inline constexpr const char* kPhaseNames[] = {
    "none",      "ready",  "spin-up", "ascend", "hover",     "traverse", "brake", "descend",
    "touchdown", "landed", "hold",    "escape", "parachute", "turn",     "keep"};

// Flight programs: one for each campaign of the TALARIS thesis 5.2, and the hop.
enum class Program : std::uint8_t {
  hop,            // up, sideways, down: fans carry 5/6, cold gas 1/6; six degrees of freedom
  traverse,       // sideways only, on rails; the altimeter looks at the wall
  turn,           // about the vertical only, on the sled
  turn_traverse,  // turn towards the wall, then traverse, on the sled
  attitude,       // hold the attitude about one horizontal axis
  altitude,       // up and down, holding the attitude, on the stand
  fan_altitude,   // up and down by the fans alone
  parachute,      // down by the fans alone, attitude and height controlled
};
inline constexpr const char* kProgramNames[] = {"hop",           "traverse", "turn",
                                                "turn-traverse", "attitude", "altitude",
                                                "fan-altitude",  "parachute"};

enum class CommandKind : std::uint16_t {
  manual = 301,
  duty_cycle = 302,
  valve = 303,
  pulse = 304,
  enable = 305,
  edf_arm = 306,
  edf_throttle = 307,
  edf_rpm = 308,
  gnc = 310,
  plan = 311,
  gains = 312,
  land = 313,
  script_begin = 320,
  script_step = 321,
  script_run = 322,
  script_abort = 323,
};

enum class GncStep : std::uint8_t { standby, calibrate, execute };
inline constexpr const char* kGncSteps[] = {"standby", "calibrate", "execute"};

// A step of a script.
enum class StepKind : std::uint8_t {
  pulse,     // valves open for value_a s, at the time of the step
  throttle,  // fans to value_a, 0..1
  rpm,       // fans to value_a
};
inline constexpr const char* kStepKinds[] = {"pulse", "throttle", "rpm"};
inline constexpr int kMaxScriptSteps = 256;
inline constexpr double kScriptLead_s = 5;  // before the first actuation
inline constexpr double kMaxScript_s = 600;

// Strategies of error solving; numbers as in the events strategy_begun and strategy_ended.
enum class StrategyKind : std::uint8_t {
  none = 0,
  reconnect,   // wait until everything answers again
  reset_node,  // reset the CANopen nodes at fault and configure them again
  realign,     // navigation starts again: it has to be calibrated again
};
inline constexpr const char* kStrategyNames[] = {"none", "reconnect", "reset_node", "realign"};

inline constexpr double kMinPulse_s = 0.040, kMaxPulse_s = 0.200;  // TALARIS thesis 4.2
inline constexpr double kMaxManual_s = 30;

// The parameters of each command. Sets: bit i is valve or fan i + 1.
inline constexpr const char* kArming[] = {"start-up", "done"};
struct OpenValves {
  std::uint8_t valves;
  bool open;
  double time_s;
  static constexpr ParameterInfo kParameters[] = {
      {"valves", "set", 1, 255, kRequired, nullptr, "bit i: valve i + 1", true},
      {"open", "choice", 0, 1, 1, kOffOn, "open or shut"},
      {"time", "s", 0.04, kMaxManual_s, 1, nullptr, "shut again after this time"},
  };
};
struct DutyCycle {
  std::uint8_t valves;
  double on_s, delay_s;
  int frames;
  static constexpr ParameterInfo kParameters[] = {
      {"valves", "set", 0, 255, kRequired, nullptr, "the others stay shut", true},
      {"on", "s", kMinPulse_s, kMaxPulse_s, kRequired, nullptr, "open for so long in every frame"},
      {"delay", "s", 0, kMaxPulse_s - kMinPulse_s, 0, nullptr, "after the release of the frame"},
      {"frames", "", 1, 3000, 5, nullptr, "for so many frames, then shut", true},
  };
};
struct EnableValves {
  std::uint8_t valves;
  static constexpr ParameterInfo kParameters[] = {
      {"valves", "set", 0, 255, kRequired, nullptr,
       "bit i: valve i + 1 may fire; the others always stay shut", true},
  };
};
struct ArmFans {
  bool done;
  static constexpr ParameterInfo kParameters[] = {
      {"procedure", "choice", 0, 1, 0, kArming,
       "done: they beeped already, since they were switched on; nothing is sent"},
  };
};
struct FanThrottle {
  std::uint8_t fans;
  double throttle;
  static constexpr ParameterInfo kParameters[] = {
      {"fans", "set", 1, 15, 15, nullptr, "bit i: fan i + 1", true},
      {"throttle", "", 0, 1, kRequired, nullptr, "0: 1 ms pulse, 1: 2 ms"},
  };
};
struct FanSpeed {
  std::uint8_t fans;
  double rpm, ramp_rpm_s;
  static constexpr ParameterInfo kParameters[] = {
      {"fans", "set", 1, 15, 15, nullptr, "bit i: fan i + 1", true},
      {"rpm", "rpm", 0, 40000, kRequired, nullptr, "closed loop; 0: off"},
      {"ramp", "rpm/s", 100, 40000, 4000, nullptr, "of what is commanded"},
  };
};
struct Gnc {
  GncStep step;
  static constexpr ParameterInfo kParameters[] = {
      {"step", "choice", 0, 2, kRequired, kGncSteps, "in this order: standby, calibrate, execute"},
  };
};
struct PlanFlight {
  Program program;
  double height_m, distance_m, turn_rad, time_s;
  static constexpr ParameterInfo kParameters[] = {
      {"program", "choice", 0, 7, 0, kProgramNames, "what is flown"},
      {"height", "m", 0, 10, 2, nullptr, "above where it stands"},
      {"distance", "m", -100, 100, 30, nullptr, "along +Z; level"},
      {"turn", "rad", -std::numbers::pi, std::numbers::pi, 0, nullptr, "about the vertical"},
      {"time", "s", 0, 120, 0, nullptr, "for the traverse, or to keep; 0: as the config says"},
  };
};
struct SelectGains {
  unsigned set;
  static constexpr ParameterInfo kParameters[] = {
      {"set", "", 1, 8, kRequired, nullptr, "number of the gain set in the config", true},
  };
};
struct ScriptBegin {
  std::uint32_t id;
  std::uint16_t steps;
  static constexpr ParameterInfo kParameters[] = {
      {"id", "", 1, 4294967295.0, kRequired, nullptr, "of the script, chosen by the sender", true},
      {"steps", "", 1, kMaxScriptSteps, kRequired, nullptr, "how many there will be", true},
  };
};
struct ScriptStepArguments {
  std::uint32_t id;
  std::uint16_t index;
  double at_s;
  StepKind kind;
  std::uint8_t which;
  double value;
  static constexpr ParameterInfo kParameters[] = {
      {"id", "", 1, 4294967295.0, kRequired, nullptr, "of the script", true},
      {"index", "", 0, kMaxScriptSteps - 1, kRequired, nullptr, "from 0 on, in order", true},
      {"at", "s", 0, kMaxScript_s, kRequired, nullptr,
       "after the first actuation; never backwards"},
      {"kind", "choice", 0, 2, kRequired, kStepKinds, "what is done"},
      {"which", "set", 1, 255, kRequired, nullptr, "bit i: valve or fan i + 1", true},
      {"value", "", 0, 40000, kRequired, nullptr, "s open, share of full throttle, or rpm"},
  };
};
struct ScriptRun {
  std::uint32_t id;
  static constexpr ParameterInfo kParameters[] = {
      {"id", "", 1, 4294967295.0, kRequired, nullptr, "of the script that was sent", true},
  };
};
inline constexpr ParameterInfo kResetParameters[] = {
    {"module", "", -1, kModuleCount, -1, nullptr,
     "3 valves, 4 fans, 5 load cell, 0 all three, 1 the IMU: its faults are forgotten, -1 the "
     "controller itself",
     true},
};

inline constexpr CommandInfo kCommands[] = {
    {1, "start", Access::holder, true,
     "manual control on, everything shut; from here on the link to the OBC is supervised"},
    {2, "stop", Access::holder, false, "in flight: land; then valves shut, fans off, Idle",
     kNoParameters, true},
    {5, "reset", Access::holder, false, "reset a module, all of them, or the controller",
     kResetParameters},
    {301, "manual", Access::holder, true, "valves and fans by hand"},
    {302, "duty-cycle", Access::holder, true, "pulses in every frame"},
    {303, "valve", Access::holder, true, "open or shut valves by hand", OpenValves::kParameters},
    {304, "pulse", Access::holder, true, "the pulses of the duty cycle", DutyCycle::kParameters},
    {305, "enable", Access::holder, false, "which valves may fire at all",
     EnableValves::kParameters},
    {306, "edf-arm", Access::holder, true,
     "start-up of the fans' speed controllers: full throttle for 400 ms, then none. Only when they "
     "were just switched on: otherwise the fans run at full throttle",
     ArmFans::kParameters},
    {307, "edf-throttle", Access::holder, true, "fans at a throttle", FanThrottle::kParameters},
    {308, "edf-rpm", Access::holder, true, "fans at a speed, closed loop", FanSpeed::kParameters},
    {310, "gnc", Access::holder, true, "standby, calibrate (30 s, standing still), execute",
     Gnc::kParameters},
    {311, "plan", Access::holder, false,
     "what execute shall fly; what cannot be flown is rejected with its numbers",
     PlanFlight::kParameters},
    {312, "gains", Access::holder, false, "another set of gains; between runs",
     SelectGains::kParameters},
    {313, "land", Access::anyone, false, "in flight: down, here and now, in good order",
     kNoParameters, true},
    {320, "script-begin", Access::holder, false, "a new script will be sent",
     ScriptBegin::kParameters},
    {321, "script-step", Access::holder, false, "a step of it", ScriptStepArguments::kParameters},
    {322, "script-run", Access::holder, true, "run it: 5 s later the first actuation",
     ScriptRun::kParameters},
    {323, "script-abort", Access::anyone, false, "all-stop", kNoParameters, true},
};

}  // namespace lss::talaris
