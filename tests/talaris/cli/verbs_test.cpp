// Parsing of TALARIS' verbs; no daemon is contacted.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/talaris/commands.h"
#include "tools/lss-cli/show/options.h"
#include "tools/lss-cli/talaris/vehicle.h"
#include "tools/lss-cli/verbs/grammar.h"

namespace lss::cli::talaris {
namespace {

using lss::talaris::CommandKind;
using lss::talaris::Mode;
using testing::HasSubstr;

Invocation read(const char* command, std::vector<std::string> words,
                const std::map<std::string, std::string>& named = {}) {
  return read_invocation(find_command(vehicle(), command), vehicle(), words, named);
}

std::vector<std::string> prepared(lss_State state, Mode mode, const Invocation& wanted) {
  lss_Status status{};
  status.state = state;
  status.mode = static_cast<std::uint8_t>(mode);
  std::vector<std::string> names;
  for (const Invocation& step : vehicle().prepare(status, wanted)) names.push_back(describe(step));
  return names;
}

std::string refusal(const std::vector<std::string>& words) {
  try {
    Grammar(Grammar::Scope::program).parse(words);
  } catch (const Failure& e) {
    return e.what();
  }
  return "was taken";
}

TEST(TalarisVerbs, ValvesAreNamedByTheirNumbers) {
  const Invocation valve = read("valve", {"1,3"}, {{"time", "500ms"}});
  EXPECT_EQ(valve.parameter[0], 0b101);
  EXPECT_EQ(valve.parameter[1], 1);
  EXPECT_DOUBLE_EQ(valve.parameter[2], 0.5);
  EXPECT_EQ(read("valve", {"all"}).parameter[0], 255);
  EXPECT_EQ(read("enable", {"none"}).parameter[0], 0);
  EXPECT_THAT(describe(valve), HasSubstr("valves 1,3"));
}

TEST(TalarisVerbs, AMotionBeginsWithWhatMustComeFirst) {
  using testing::ElementsAre;
  using testing::IsEmpty;
  const Invocation calibrate = read("gnc", {"calibrate"});
  EXPECT_THAT(prepared(lss_STATE_IDLE, Mode::none, calibrate), ElementsAre("start", "gnc standby"));
  EXPECT_THAT(prepared(lss_STATE_OPERATIONAL, Mode::standby, calibrate), IsEmpty());
  const Invocation pulse = read("pulse", {"1"}, {{"on", "80ms"}});
  EXPECT_THAT(prepared(lss_STATE_OPERATIONAL, Mode::manual, pulse), ElementsAre("duty-cycle"));
  const Invocation valve = read("valve", {"1"});
  EXPECT_THAT(prepared(lss_STATE_OPERATIONAL, Mode::duty_cycle, valve), ElementsAre("manual"));
  EXPECT_THAT(prepared(lss_STATE_FATAL_ERROR, Mode::none, valve), IsEmpty());
}

TEST(TalarisVerbs, WhatTakesLongIsWaitedForUnlessATimeIsSaid) {
  const auto waits_s = [](const Options& options, const Invocation& command) {
    return options.finish_timeout_s(vehicle().takes_s(command));
  };
  EXPECT_GE(waits_s({}, read("gnc", {"calibrate"})), 300 + 30);
  EXPECT_GE(waits_s({}, read("gnc", {"execute"})), 120 + 30);
  EXPECT_EQ(waits_s({}, read("gnc", {"standby"})), 120);
  Options said;
  said.timeout_s = 5;
  EXPECT_EQ(waits_s(said, read("gnc", {"calibrate"})), 5);
  EXPECT_EQ(Options{}.finish_timeout_s(605), 635);
}

// Any client may end it.
TEST(TalarisVerbs, AScriptIsAbortedByAnyone) {
  EXPECT_EQ(find_command(vehicle(), "script-abort").access, Access::anyone);
  EXPECT_EQ(find_command(vehicle(), "land").access, Access::anyone);
}

TEST(TalarisVerbs, WordsAreCheckedBeforeAnybodyIsAsked) {
  EXPECT_EQ(refusal({"hop", "--height", "2", "--distance", "30"}), "was taken");
  EXPECT_THAT(refusal({"hop", "--height", "200"}), HasSubstr("out of range"));
  EXPECT_THAT(refusal({"hop", "--program", "loop"}), HasSubstr("loop"));
  EXPECT_EQ(refusal({"edf", "arm"}), "was taken");
  EXPECT_EQ(refusal({"edf", "rpm", "12000", "--fans", "1,2"}), "was taken");
  EXPECT_THAT(refusal({"edf", "throttle", "1.5"}), HasSubstr("out of range"));
  EXPECT_THAT(refusal({"edf", "spin"}), HasSubstr("spin"));
  EXPECT_THAT(refusal({"script-step"}), HasSubstr("no verb"));
}

}  // namespace
}  // namespace lss::cli::talaris
