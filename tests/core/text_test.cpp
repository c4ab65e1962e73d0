#include "daemon/cycle/text.h"

#include <gtest/gtest.h>

namespace lss {
namespace {

constexpr const char* kModes[] = {"none", "Cruising"};
constexpr const char* kModules[] = {"front", "rear"};
constexpr const char* kPhases[] = {"none", "ascend"};
constexpr const char* kPrograms[] = {"hop"};
constexpr const char* kFindings[] = {"none", "it turns (rad/s)"};
constexpr Vocabulary kWords{kModes, kModules, {}, kPhases, kPrograms, kFindings};

EventRecord event(EventId id, double a = 0, double b = 0, std::uint16_t subject = 0) {
  return {.id = static_cast<std::uint16_t>(id), .subject = subject, .argument = {a, b, 0, 0}};
}

TEST(EventText, SaysStatesModesReasonsAndFaultsByName) {
  EXPECT_EQ(event_text(event(EventId::state_changed, 0, 2), kWords, {}),
            "state Idle to FatalError");
  EXPECT_EQ(event_text(event(EventId::mode_changed, 0, 1), kWords, {}), "mode none to Cruising");
  EXPECT_EQ(event_text(event(EventId::fault_cleared, 16), kWords, {}), "fault bus_noise cleared");
  EXPECT_EQ(event_text(event(EventId::command_rejected, 7, 12), kWords, {}),
            "command 7 rejected, reason not allowed in this state");
}

TEST(EventText, SaysHowOftenItOccurredAndInWhatTime) {
  EventRecord late = event(EventId::frame_late, 12);
  late.count = 9;
  late.first_ns = kSecond;
  late.time_ns = 3'540'000'000;
  EXPECT_EQ(event_text(late, kWords, {}), "a command was late, 12 so far (9 times in 2.5 s)");
}

TEST(EventText, SaysPhasesProgramsAndFindingsByNameAndNumbersShortly) {
  EXPECT_EQ(event_text(event(EventId::phase_changed, 0, 1), kWords, {}), "phase none to ascend");
  EXPECT_EQ(event_text(event(EventId::planned, 0, 20.969779954920366), kWords, {}),
            "planned: hop, 20.9698 s, 0 of 0 thruster-seconds");
  EXPECT_EQ(event_text(event(EventId::calibration_refused, 1, 0.25), kWords, {}),
            "calibration failed, it turns (rad/s): 0.25, allowed 0");
}

TEST(EventText, NamesAParameterWithItsUnitAndWhyNothingCouldBeSaved) {
  constexpr TunableInfo kInfos[] = {
      {"limits.current_A", "A", 0, 2, Change::always, false, "above it: emergency"}};
  EventRecord changed = event(EventId::parameter_changed, 1, 1.2);
  changed.argument[2] = 1.5;
  EXPECT_EQ(event_text(changed, kWords, kInfos), "parameter limits.current_A: 1.2 to 1.5 A");
  EXPECT_EQ(event_text(changed, kWords, {}), "parameter 1: 1.2 to 1.5");
  EXPECT_EQ(event_text(event(EventId::parameters_not_saved, 28), kWords, kInfos),
            "parameters could not be saved in both copies: No space left on device");
}

TEST(EventText, NamesTheModuleOfAFault) {
  EventRecord record;
  record.id = static_cast<std::uint16_t>(FaultId::module_over_current) + kFaultEventBase;
  record.subject = 2;
  EXPECT_EQ(event_text(record, kWords, {}), "module 2 (rear): module stopped by over-current");
}

TEST(EventText, LeavesNoPlaceholderWithAnyNumbers) {
  for (const CodeInfo& info : kEvents) {
    for (const double argument : {0.0, -1.0, 1e9}) {
      const std::string text =
          event_text(event(static_cast<EventId>(info.number), argument, argument, 99), kWords, {});
      EXPECT_EQ(text.find('{'), std::string::npos) << text;
    }
  }
}

}  // namespace
}  // namespace lss
