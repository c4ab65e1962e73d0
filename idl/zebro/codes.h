#pragma once

// Reject reasons, faults and events of Lunar Zebro itself (idl/codes.h). Pure data.

#include "idl/codes.h"

// number, name, text, advice
#define LSS_ZEBRO_REASONS(X)                                                                      \
  X(15, panel_deployed, "the solar panel is deployed", "retract it first: lss-cli panel retract") \
  X(17, fault_latched, "a module stopped by itself and was not reset since",                      \
    "lss-cli reset MODULE")                                                                       \
  X(25, panel_moving, "the solar panel is moving", "wait for it to end")                          \
  X(28, too_fast, "faster than a leg may turn", "give it more time")                              \
  X(32, not_stable, "too few legs would be left to stand and walk on",                            \
    "repair a leg and restore it first")                                                          \
  X(39, solved_too_often, "the same fault was solved again and again without healthy operation",  \
    "repair the cause, then: lss-cli reset controller, lss-cli solve")                            \
  X(500, panel_answers, "the panel's module answers and knows where the panel is",                \
    "retract it: lss-cli panel retract")                                                          \
  X(501, leg_blocked, "the leg did not come to its position, its motor is off again",             \
    "free it by hand")

// number, name, severity (of lss.idl: 0 info, 1 warning, 2 error, 3 fatal), text, advice
#define LSS_ZEBRO_FAULTS(X)                                                                        \
  X(6, module_driver_fault, 3, "module stopped by a motor-driver fault",                           \
    "lss-cli solve resets it")                                                                     \
  X(7, module_watchdog, 3, "module stopped by its own watchdog",                                   \
    "check the bus, then: lss-cli solve")                                                          \
  X(10, current_limit, 3, "current above the software limit",                                      \
    "free what blocks it, then: lss-cli solve")                                                    \
  X(13, not_calibrated, 1, "module did not pass its calibration sensor",                           \
    "walking goes on with less precision; check the sensor")                                       \
  X(18, motion_timeout, 3, "a motion did not end in its time",                                     \
    "free what blocks it, then: lss-cli solve")                                                    \
  X(500, report_impossible, 3, "module reports what cannot be",                                    \
    "lss-cli solve resets it; a leg that goes on so is taken out of service")                      \
  X(501, position_jumps, 3, "module's reported position jumps",                                    \
    "lss-cli solve resets it; a leg that goes on so is taken out of service")                      \
  X(502, leg_still, 3, "leg does not move as ordered: its sensor stands still, or its motor does", \
    "lss-cli solve moves it; a leg that stays so is taken out of service")                         \
  X(503, gear_slips, 3,                                                                            \
    "leg was not where it counted when it passed its sensor: its gear slips, or its count drifts", \
    "lss-cli solve takes it out of service; repair it, then: lss-cli restore")                     \
  X(504, current_sum, 3, "all motors together draw more than the limit",                           \
    "free what blocks them, then: lss-cli solve")

// number, name, severity, text ({0}..{3}: arguments)
#define LSS_ZEBRO_EVENTS(X)                                           \
  X(9, module_online, 0, "module answers")                            \
  X(10, module_calibrated, 0, "module passed its calibration sensor") \
  X(17, module_resent, 1, "commands re-sent to module, {0} so far")   \
  X(500, report_refused, 1, "a report was refused: {0}, allowed {1}") \
  X(501, leg_switched_off, 1, "a leg out of service did not come to its position: motor off")

namespace lss::zebro {
LSS_OWN_CODES(LSS_ZEBRO_REASONS, LSS_ZEBRO_FAULTS, LSS_ZEBRO_EVENTS)
}  // namespace lss::zebro
