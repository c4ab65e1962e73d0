#pragma once

// Lunar Zebro's own commands (100..199), its modes and the names of its modules. See
// idl/commands.h.

#include <cstdint>

#include "idl/commands.h"

namespace lss::zebro {

inline constexpr int kLegs = 6;
inline constexpr int kModules = 7;  // six legs and the solar-panel motor

inline constexpr const char* kModuleNames[kModules] = {"LF", "RF", "LM", "RM", "LH", "RH", "panel"};

// Modes of the state Operational; `none` in the other states. Exits besides the emergency to
// FatalError and the safe stop towards Idle are named.
enum class Mode : std::uint8_t {
  none = 0,     // not Operational
  holding,      // motion control on, legs hold where they are; to standing_up, lying_down, stowing,
                // bridge
  standing_up,  // to standing
  standing,     // to walking, lying_down, stowing, bridge
  walking,      // to finishing_step
  finishing_step,  // walks on until all legs stand, then to standing or on towards the goal
  lying_down,      // to lying
  lying,           // belly on the ground; to standing_up, stowing, bridge
  stowing,         // to stowed
  stowed,          // legs along the body for storage; to standing_up, lying_down, bridge
  bridge,  // legs are moved one by one by direct command; to standing_up, lying_down, stowing
};
inline constexpr const char* kModeNames[] = {"none",    "Holding",       "StandingUp", "Standing",
                                             "Walking", "FinishingStep", "LyingDown",  "Lying",
                                             "Stowing", "Stowed",        "Bridge"};

enum class CommandKind : std::uint16_t {
  stand = 101,
  lay_down = 102,
  stow = 103,
  walk = 104,
  panel = 105,
  leg = 106,
  isolate = 107,
  panel_is_in = 108,
  restore_leg = 109,
};

// Strategies of error solving; numbers as in the events strategy_begun and strategy_ended.
enum class StrategyKind : std::uint8_t {
  none = 0,
  reconnect,     // reset the faulty modules
  reset_module,  // reset what is at fault
  move_free,     // move a blocked leg a little, back and forth
  cool_down,     // wait until it is cool, then reset it
  isolate,       // take legs out of service and go on without them
  reset_all,     // reset all modules
};
inline constexpr const char* kStrategyNames[] = {
    "none", "reconnect", "reset_module", "move_free", "cool_down", "isolate", "reset_all"};

enum class WalkSpeed : std::uint8_t { zero, low, medium, high };
enum class FollowUp : std::uint8_t { none, stand, walk };
inline constexpr const char* kSpeeds[] = {"zero", "low", "medium", "high"};
inline constexpr const char* kFollowUps[] = {"none", "stand", "walk"};
inline constexpr const char* kDirections[] = {"backward", "forward"};
inline constexpr const char* kPanelMoves[] = {"retract", "deploy"};

inline constexpr double kHalfPi = 1.57079632679489661923;

// The parameters of each command.
struct Walk {
  bool forward;
  double heading_rad;
  WalkSpeed speed;
  static constexpr ParameterInfo kParameters[] = {
      {"direction", "choice", 0, 1, 1, kDirections, "which way"},
      {"heading", "rad", -kHalfPi, kHalfPi, 0, nullptr,
       "turn, clockwise positive; 90 deg turns on the spot"},
      {"speed", "choice", 0, 3, 2, kSpeeds,
       "low: wave, medium: tetrapod, high: tripod; zero stands still"},
  };
};
struct Start {
  FollowUp then;
  bool forward;  // as of walk, for the follow-up walk
  double heading_rad;
  WalkSpeed speed;
  static constexpr ParameterInfo kParameters[] = {
      {"then", "choice", 0, 2, 0, kFollowUps, "go on by itself to stand or walk"},
      Walk::kParameters[0],
      Walk::kParameters[1],
      Walk::kParameters[2],
  };
};
struct SafeStop {
  bool lay_down;
  static constexpr ParameterInfo kParameters[] = {
      {"lay-down", "choice", 0, 1, 1, kNoYes, "lie down before the motors go off"},
  };
};
struct MovePanel {
  bool deploy;
  static constexpr ParameterInfo kParameters[] = {
      {"move", "choice", 0, 1, kRequired, kPanelMoves,
       "only in Idle; a deployed panel forbids operation"},
  };
};
struct MoveLeg {
  unsigned leg;
  double position_rad, duration_s;
  bool forward;
  static constexpr ParameterInfo kParameters[] = {
      {"leg", "", 1, 6, kRequired, nullptr, "1 LF, 2 RF, 3 LM, 4 RM, 5 LH, 6 RH", true},
      {"position", "rad", 0, 6.283185307179586, kRequired, nullptr,
       "0 = straight down, growing with forward rotation"},
      {"duration", "s", 0.5, 60, 3, nullptr, "time of the movement"},
      {"direction", "choice", 0, 1, 1, kDirections, "way round"},
  };
};

// Of isolate and restore-leg.
struct OneLeg {
  unsigned leg;
  static constexpr ParameterInfo kParameters[] = {
      {"leg", "", 1, kLegs, kRequired, nullptr, "1 LF, 2 RF, 3 LM, 4 RM, 5 LH, 6 RH", true},
  };
};
inline constexpr ParameterInfo kResetParameters[] = {
    {"module", "", -1, kModules, -1, nullptr,
     "1..6 a leg, 7 the panel, 0 all of them, -1 the controller itself", true},
};

inline constexpr CommandInfo kCommands[] = {
    {1, "start", Access::holder, true,
     "motion control on; from here on the link to the OBC is supervised", Start::kParameters},
    {2, "stop", Access::holder, false,
     "come to a safe stop: finish the motion, lie down if asked, motors off", SafeStop::kParameters,
     true},
    {5, "reset", Access::holder, false, "reset a module, all modules, or the controller",
     kResetParameters},
    {101, "stand", Access::holder, true, "stand up"},
    {102, "lay-down", Access::holder, true, "lie down on the belly"},
    {103, "stow", Access::holder, true, "lie down and put the legs along the body for storage"},
    {104, "walk", Access::holder, true, "walk until another command", Walk::kParameters, false,
     true},
    {105, "panel", Access::holder, false, "deploy or retract the solar panel",
     MovePanel::kParameters},
    {106, "leg", Access::holder, true,
     "bridge: move one leg by direct command, also one out of service", MoveLeg::kParameters},
    {107, "isolate", Access::holder, false, "take a leg out of service and go on without it",
     OneLeg::kParameters},
    {108, "panel-is-in", Access::holder, false,
     "the panel's module is dead and the operator answers for the panel being in"},
    {109, "restore-leg", Access::holder, false, "put one leg into service again",
     OneLeg::kParameters},
};

}  // namespace lss::zebro
