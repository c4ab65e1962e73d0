// The conversions and sentences of the DDS face, without DDS.

#include "daemon/publish/convert.h"

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/runtime/clock.h"

namespace lss::dds {
namespace {

Ack rejection(Reason reason, std::uint16_t subject = 0, double measured = kRequired,
              double limit = kRequired) {
  Ack ack;
  ack.phase = Phase::rejected;
  ack.verdict = {reason, measured, limit, subject};
  return ack;
}

constexpr TunableInfo kInfos[] = {
    {"limits.current_A", "A", 0.05, 1.7, Change::always, false, "above it: emergency"},
    {"solve.rounds", "", 1, 9, Change::at_rest, true, "how often"},
};

TEST(AckText, NamesTheParameterWithWhatCameAndWhatIsAllowed) {
  EXPECT_EQ(ack_text(rejection(Reason::parameter_range, 1, 12, 1.7), {{}, kInfos}),
            "rejected: limits.current_A: 12 A is out of range, allowed 0.05 to 1.7 A; see its "
            "range with: lss-cli param get NAME");
  EXPECT_EQ(ack_text(rejection(Reason::parameter_whole, 2, 2.5), {{}, kInfos}),
            "rejected: solve.rounds: 2.5: the parameter is a whole number; give it without a "
            "fraction");
  EXPECT_NE(ack_text(rejection(Reason::parameter_range, 3, 12, 1.7), {{}, kInfos})
                .find("measured 12, allowed 1.7"),
            std::string::npos);
}

TEST(AckText, NamesTheParameterThatThereIsNotAndSaysWhatToDo) {
  EXPECT_EQ(ack_text(rejection(Reason::no_such_parameter),
                     {.tunables = kInfos, .name = "limits.curent_A"}),
            "rejected: there is no parameter 'limits.curent_A'; list them with: lss-cli param get");
  EXPECT_EQ(ack_text(rejection(Reason::no_such_parameter)),
            "rejected: there is no parameter of this name; list them with: lss-cli param get");
}

TEST(Parameters, GoOutWithRangeAndWhatIsSaved) {
  ParameterReport report{.infos = kInfos, .present = {}, .configured = {}, .saved = {}};
  report.present = {.value = {1.5, 7}, .count = 2, .changes = 3};
  report.configured = {.value = {1.2, 7}, .count = 2};
  report.saved = {1.5, std::nan("")};
  report.number = 4;
  report.state = SavedState::one_copy;
  lss_Parameters sample;
  to_dds(report, "z-1", sample);
  EXPECT_EQ(sample.count, 2U);
  EXPECT_EQ(sample.changes, 3U);
  EXPECT_EQ(sample.save, 4U);
  EXPECT_EQ(sample.saved, lss_SAVED_ONE_COPY);
  EXPECT_EQ(read_text(sample.item[0].name), "limits.current_A");
  EXPECT_EQ(sample.item[0].value, 1.5);
  EXPECT_EQ(sample.item[0].configured, 1.2);
  EXPECT_EQ(sample.item[0].saved, 1.5);
  EXPECT_TRUE(std::isnan(sample.item[1].saved));
  EXPECT_EQ(sample.item[1].change, lss_CHANGE_AT_REST);
  EXPECT_TRUE(sample.item[1].whole);
}

TEST(AckText, NamesTheModuleTheMeasuredValueTheLimitAndWhatToDo) {
  EXPECT_EQ(ack_text(rejection(Reason::module_silent, 3, 5000, 200)),
            "rejected: module 3 does not answer (measured 5000, allowed 200); "
            "check its power and the bus, then: lss-cli solve");
  static constexpr const char* kNames[] = {"LF", "RF", "LM"};
  EXPECT_EQ(ack_text(rejection(Reason::module_silent, 3), {kNames}),
            "rejected: module 3 (LM) does not answer; "
            "check its power and the bus, then: lss-cli solve");
  EXPECT_EQ(ack_text(rejection(Reason::module_silent, 4), {kNames}),
            "rejected: module 4 does not answer; check its power and the bus, then: lss-cli solve");
}

TEST(AckText, NamesTheParameterOfTheCommandAndNoModule) {
  static constexpr ParameterInfo kParameters[] = {{"direction", "choice", 0, 1, 1, kNoYes, ""},
                                                  {"speed", "choice", 0, 3, 3, kNoYes, ""}};
  static constexpr CommandInfo kWalk{104, "walk", Access::holder, true, "", kParameters};
  static constexpr const char* kNames[] = {"LF", "RF", "LM"};
  const Subjects subjects{{kNames}, {}, {&kWalk, 1}};
  const auto text = [&](Reason reason, std::uint16_t number) {
    Ack ack = rejection(reason, number, 7, 3);
    ack.kind = 104;
    return ack_text(ack, subjects);
  };
  EXPECT_EQ(text(Reason::out_of_range, 2),
            "rejected: parameter speed is out of range (measured 7, allowed 3); see: lss-cli "
            "command describe NAME");
  EXPECT_EQ(text(Reason::not_finite, 1),
            "rejected: parameter direction is not a finite number (measured 7, allowed 3); send a "
            "number");
  EXPECT_EQ(text(Reason::not_a_choice, 2).find("rejected: parameter speed is none of"), 0U);
  EXPECT_EQ(text(Reason::unused_parameter, 3)
                .find("rejected: parameter 3 that the command does not have is not zero"),
            0U);
  EXPECT_EQ(ack_text(rejection(Reason::out_of_range, 2)).find("rejected: parameter 2 is out"), 0U);
}

TEST(AckText, NamesTheStepOfAScriptAndNoModule) {
  static constexpr const char* kNames[] = {"IMU", "altimeter", "valves"};
  const auto text = [&](Reason reason) { return ack_text(rejection(reason, 3), {kNames}); };
  EXPECT_EQ(text(Reason::script_backwards).find("rejected: the step 3 is before the one"), 0U);
  EXPECT_EQ(text(Reason::script_value).find("rejected: the value of the step 3 is out of"), 0U);
  for (const Reason reason : {Reason::script_overlap, Reason::script_too_long, Reason::script_order,
                              Reason::script_other, Reason::script_actuator}) {
    EXPECT_NE(text(reason).find("step 3"), std::string::npos) << text(reason);
    EXPECT_EQ(text(reason).find("module"), std::string::npos) << text(reason);
  }
}

TEST(AckText, IsThePhaseAloneWhenThereIsNoReason) {
  Ack ack;
  ack.phase = Phase::completed;
  EXPECT_EQ(ack_text(ack), "completed");
}

TEST(AckText, LeavesOutTheNumbersThatTheGuardDoesNotHave) {
  EXPECT_EQ(ack_text(rejection(Reason::port_closed)),
            "rejected: the bus port is not open; check the port named in the config");
  EXPECT_NE(ack_text(rejection(Reason::out_of_range, 0, 1.75)).find("(measured 1.75)"),
            std::string::npos);
}

TEST(AckText, GivesTheNumberOfAReasonThatIsNotInTheList) {
  EXPECT_EQ(ack_text(rejection(static_cast<Reason>(60'000))), "rejected: reason 60000");
}

TEST(AckText, OfEveryReasonFitsItsFieldWithTheLongestNumbers) {
  for (const CodeInfo& reason : kReasons) {
    const Ack ack =
        rejection(static_cast<Reason>(reason.number), 127, -1.23456e-100, -1.23456e-100);
    const lss_CommandAck sample = to_dds(ack, "v1");
    const auto text = read_text(sample.text);
    ASSERT_TRUE(text.has_value()) << reason.name;
    EXPECT_EQ(*text, std::string_view(ack_text(ack)).substr(0, 159)) << reason.name;
  }
}

TEST(Event, CarriesTheWallClockOfTheTimeItHappened) {
  EventRecord record;
  record.time_ns = now_ns() - 5 * kSecond;
  const std::int64_t age_ns = utc_ns() - to_dds(record, "", "v1", 1).utc_ns;
  EXPECT_NEAR(static_cast<double>(age_ns), 5e9, 1e9);
}

TEST(Request, OfAnUnterminatedSourceHasNone) {
  lss_Command command{};
  std::fill(std::begin(command.source), std::end(command.source), 'x');
  EXPECT_EQ(to_request(command, 1).source, Name{});
}

TEST(Request, HasNothingOfWhatStandsBehindTheTerminator) {
  lss_Command command{};
  copy_text("cli", command.source);
  command.source[5] = 'x';
  Name expected{};
  std::copy_n("cli", 3, expected.begin());
  EXPECT_EQ(to_request(command, 1).source, expected);
}

TEST(Request, CarriesEveryFieldOfTheCommand) {
  lss_Command command{};
  command.seq = 7;
  command.kind = 104;
  command.flags = kFlagDryRun;
  command.lease_ms = 500;
  command.parameter[0] = 1;
  command.parameter[7] = -2.5;
  std::memset(command.name, 'x', sizeof command.name);  // not terminated: the armour refuses it
  const Request request = to_request(command, 42);
  EXPECT_EQ(request.sequence, 7u);
  EXPECT_EQ(request.kind, 104);
  EXPECT_EQ(request.flags, kFlagDryRun);
  EXPECT_EQ(request.lease_ms, 500u);
  EXPECT_EQ(request.parameter.front(), 1);
  EXPECT_EQ(request.parameter.back(), -2.5);
  EXPECT_EQ(request.name.front(), 'x');
  EXPECT_EQ(request.name.back(), 'x');
  EXPECT_EQ(request.arrival_ns, 42);
}

TEST(CopyText, CutsTerminatesAndZeroesToTheEnd) {
  char field[6] = {'x', 'x', 'x', 'x', 'x', 'x'};
  copy_text("ab", field);
  EXPECT_EQ(std::string_view(field, 6), std::string_view("ab\0\0\0\0", 6));
  copy_text("abcdefgh", field);
  EXPECT_STREQ(field, "abcde");
}

}  // namespace
}  // namespace lss::dds
