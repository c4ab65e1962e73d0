#pragma once

// Faults, reject reasons and events of Lunar Zebro itself, numbered from kFirstOwnCode on
// (idl/codes.h). Pure data.

#include "idl/codes.h"

namespace lss::zebro {

inline constexpr FaultId kReportImpossible{500}, kPositionJumps{501}, kLegStill{502},
    kGearSlips{503}, kCurrentSum{504};
inline constexpr Reason kPanelAnswers{500}, kLegBlocked{501};
inline constexpr EventId kReportRefused{500}, kLegSwitchedOff{501};

inline constexpr CodeInfo kOwnFaults[] = {
    {500, "report_impossible", 3, "module reports what cannot be",
     "lss-cli solve resets it; a leg that goes on so is taken out of service"},
    {501, "position_jumps", 3, "module's reported position jumps",
     "lss-cli solve resets it; a leg that goes on so is taken out of service"},
    {502, "leg_still", 3,
     "leg does not move as ordered: its sensor stands still, or its motor does",
     "lss-cli solve moves it; a leg that stays so is taken out of service"},
    {503, "gear_slips", 3,
     "leg was not where it counted when it passed its sensor: its gear slips, or its count drifts",
     "lss-cli solve takes it out of service; repair it, then: lss-cli restore"},
    {504, "current_sum", 3, "all motors together draw more than the limit",
     "free what blocks them, then: lss-cli solve"},
};

inline constexpr CodeInfo kOwnReasons[] = {
    {500, "panel_answers", 1, "the panel's module answers and knows where the panel is",
     "retract it: lss-cli panel retract"},
    {501, "leg_blocked", 1, "the leg did not come to its position, its motor is off again",
     "free it by hand"},
};

inline constexpr CodeInfo kOwnEvents[] = {
    {500, "report_refused", 1, "a report was refused: {0}, allowed {1}", ""},
    {501, "leg_switched_off", 1, "a leg out of service did not come to its position: motor off",
     ""},
};

inline constexpr OwnCodes kOwnCodes{
    .faults = kOwnFaults, .reasons = kOwnReasons, .events = kOwnEvents};

}  // namespace lss::zebro
