// Output and exit code of lss-cli for each end of a command or query, against a stand-in for the
// daemon.

#include "idl/zebro/codes.h"
#include "tests/cli/program_test.h"

namespace lss::cli::test {
namespace {

using Answers = ProgramTest;

TEST_F(Answers, ADaemonWithAnotherTypeOfCommandsIsNamedAndNothingIsSent) {
  FakeDaemon daemon(domain(), Birth{.earlier = true});
  const Ended ended = run({"--timeout", "10s", "stand"});
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.err, HasSubstr("zebro-1 was built with other types of commands"));
  EXPECT_THAT(ended.err, HasSubstr("take the lss-cli of its version"));
  EXPECT_THAT(daemon.kinds(), IsEmpty());
}

TEST_F(Answers, WithoutADaemonEveryQuestionEndsWith3AndSaysWhatToCheck) {
  for (const char* verb : {"status", "health", "stand", "estop", "events", "timing", "heartbeat"}) {
    const Ended ended = run({"--timeout", "300ms", verb});
    EXPECT_EQ(ended.code, 3) << verb;
    EXPECT_THAT(ended.err, HasSubstr("lssd"));
  }
}

TEST_F(Answers, StatusAsJsonHasTheKeysThatProgramsRelyOn) {
  FakeDaemon daemon(domain());
  daemon.latch(FaultId::module_silent, 4);
  const Ended ended = run({"--json", "status"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json status = json::parse(ended.out);
  for (const char* key : {"schema_version", "vehicle", "vehicle_id", "state", "mode", "faults",
                          "authority", "link", "frame", "realtime", "shared_memory", "telemetry"}) {
    EXPECT_TRUE(status.contains(key)) << key;
  }
  for (const char* key :
       {"policy", "granted", "memory_locked", "page_faults_since_start", "mallocs_since_start"}) {
    EXPECT_TRUE(status["realtime"].contains(key)) << key;
  }
  for (const char* key : {"index", "period_ns", "overruns"})
    EXPECT_TRUE(status["frame"].contains(key)) << key;
  ASSERT_EQ(status["telemetry"]["modules"].size(), 7U);
  for (const char* key :
       {"id", "online", "calibrated", "position_rad", "current_A", "temperature_degC"}) {
    EXPECT_TRUE(status["telemetry"]["modules"][0].contains(key)) << key;
  }
  EXPECT_EQ(status["state"], "Idle");
  EXPECT_EQ(status["link"]["obc_age_ms"], 12);
  EXPECT_TRUE(status["authority"].is_null());
  ASSERT_EQ(status["faults"].size(), 1U);
  for (const char* key : {"id", "name", "subject", "count", "text", "advice"}) {
    EXPECT_TRUE(status["faults"][0].contains(key)) << key;
  }
  EXPECT_EQ(status["faults"][0]["name"], "module_silent");
  EXPECT_EQ(status["faults"][0]["subject_name"], "RM");
}

TEST_F(Answers, StatusSaysWhatIsWrongFirstAndWhatToDo) {
  FakeDaemon daemon(domain());
  daemon.latch(FaultId::module_over_current, 2);
  daemon.set_state(lss_STATE_FATAL_ERROR);
  const Ended ended = run({"status"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, HasSubstr("FatalError"));
  EXPECT_THAT(ended.out, HasSubstr("RF: module stopped by over-current"));
  EXPECT_THAT(ended.out, HasSubstr("lss-cli solve"));
  EXPECT_LT(ended.out.find("over-current"), ended.out.find("leg    link"));
  EXPECT_THAT(ended.out, Not(HasSubstr("\x1b")));  // no colours into a pipe
}

TEST_F(Answers, StatusAsksForASampleWhenTelemetryDoesNotComeByItself) {
  FakeDaemon daemon(domain());
  daemon.telemetry_on_request();
  const Ended ended = run({"--json", "status"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(json::parse(ended.out)["telemetry"]["modules"].size(), 7U);
  EXPECT_THAT(daemon.kinds(), ElementsAre(kData));
}

TEST_F(Answers, HealthIs0WhenAllIsWellAnd6WithTheReasonOtherwise) {
  FakeDaemon daemon(domain());
  EXPECT_EQ(run({"health"}).code, 0);
  daemon.silence_module(3);
  const Ended silent = run({"health"});
  EXPECT_EQ(silent.code, 6);
  EXPECT_THAT(silent.out, HasSubstr("LM"));
  const Ended machine = run({"--json", "health"});
  EXPECT_FALSE(json::parse(machine.out)["healthy"].get<bool>());
}

TEST_F(Answers, ARejectedCommandEndsWith5TheReasonAndTheAdvice) {
  FakeDaemon daemon(domain());
  daemon.trouble(kStart, {Trouble::Kind::reject, zebro::reasons::panel_deployed});
  const Ended ended = run({"walk", "forward"});
  EXPECT_EQ(ended.code, 5);
  EXPECT_THAT(ended.err, HasSubstr("solar panel is deployed"));
  EXPECT_THAT(ended.err, HasSubstr("lss-cli panel retract"));
  EXPECT_THAT(daemon.kinds(), ElementsAre(kStart));
}

TEST_F(Answers, ACommandThatFailsEndsWith6) {
  FakeDaemon daemon(domain());
  daemon.trouble(kStand, {Trouble::Kind::fail, Reason::over_current});
  const Ended ended = run({"stand"});
  EXPECT_EQ(ended.code, 6);
  EXPECT_THAT(ended.err, HasSubstr("draws too much current"));
}

TEST_F(Answers, ACommandThatIsNotAcknowledgedOrNotCompletedEndsWith7) {
  FakeDaemon daemon(domain());
  daemon.trouble(kPanel, {Trouble::Kind::no_answer});
  EXPECT_EQ(run({"panel", "deploy"}).code, 7);
  daemon.trouble(kPanel, {Trouble::Kind::never_ends});
  const Ended ended = run({"--timeout", kFoundBy, "panel", "deploy"});
  EXPECT_EQ(ended.code, 7);
  EXPECT_THAT(ended.err, HasSubstr("outcome unknown"));
}

TEST_F(Answers, WithoutAuthorityACommandEndsWith8AndNamesTheHolder) {
  FakeDaemon daemon(domain());
  daemon.set_state(lss_STATE_OPERATIONAL, zebro::Mode::standing);
  daemon.set_authority("ground");
  const Ended ended = run({"stop"});
  EXPECT_EQ(ended.code, 8);
  EXPECT_THAT(ended.err, HasSubstr("ground"));
  EXPECT_EQ(run({"--source", "ground", "stop"}).code, 0);
}

TEST_F(Answers, AnEmergencyStopIsTakenFromAnyone) {
  FakeDaemon daemon(domain());
  daemon.set_state(lss_STATE_OPERATIONAL, zebro::Mode::walking);
  daemon.set_authority("ground");
  EXPECT_EQ(run({"estop"}).code, 0);
  EXPECT_EQ(daemon.state(), lss_STATE_FATAL_ERROR);
  EXPECT_EQ(run({"solve"}).code, 0);
}

TEST_F(Answers, ADryRunAsksAndDoesNothing) {
  FakeDaemon daemon(domain());
  const Ended ended = run({"--dry-run", "walk", "forward"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("start"));
  EXPECT_THAT(ended.out, HasSubstr("walk forward"));
  EXPECT_THAT(daemon.kinds(), IsEmpty());
  daemon.trouble(kStart, {Trouble::Kind::reject, Reason::module_silent});
  EXPECT_EQ(run({"--dry-run", "stand"}).code, 5);
  EXPECT_THAT(daemon.kinds(), IsEmpty());
}

TEST_F(Answers, OneOfSeveralVehiclesMustBeNamed) {
  FakeDaemon first(domain(), "zebro-1");
  FakeDaemon second(domain(), "zebro-2");
  const Ended ended = run({"status"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("zebro-1, zebro-2"));
  EXPECT_EQ(run({"--vehicle", "zebro-2", "stand"}).code, 0);
  EXPECT_THAT(first.kinds(), IsEmpty());
  EXPECT_THAT(second.kinds(), ElementsAre(kStart, kStand));
  const Ended unknown = run({"--vehicle", "zebro-3", "status", "--timeout", kFoundBy});
  EXPECT_EQ(unknown.code, 4);
  EXPECT_THAT(unknown.err, HasSubstr("zebro-"));
}

TEST_F(Answers, JsonOfACommandHasEveryAcknowledgementAlsoWhenItFails) {
  FakeDaemon daemon(domain());
  const json good = json::parse(run({"--json", "stand"}).out);
  EXPECT_EQ(good["schema_version"], 2);
  EXPECT_EQ(good["exit_code"], 0);
  ASSERT_EQ(good["commands"].size(), 2U);
  EXPECT_EQ(good["commands"][1]["command"], "stand");
  EXPECT_EQ(good["commands"][1]["phase"], "completed");

  daemon.set_authority("");
  daemon.trouble(kStow, {Trouble::Kind::reject, Reason::module_silent});
  const Ended ended = run({"--json", "stow"});
  const json bad = json::parse(ended.out);
  EXPECT_EQ(bad["exit_code"], ended.code);
  EXPECT_EQ(bad["commands"].back()["reason"]["name"], "module_silent");
  EXPECT_FALSE(bad["error"]["advice"].get<std::string>().empty());
}

TEST_F(Answers, EventsShowTheHistoryInOrder) {
  FakeDaemon daemon(domain());
  for (const char* text : {"first", "second", "third"}) daemon.event(EventId::started, text);
  const json all = json::parse(run({"--json", "events"}).out)["events"];
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0]["text"], "first");
  EXPECT_EQ(all[2]["index"], 3);
  const Ended last = run({"events", "--last", "1"});
  EXPECT_THAT(last.out, HasSubstr("third"));
  EXPECT_THAT(last.out, Not(HasSubstr("second")));
}

TEST_F(Answers, EventsShowTheNewestReportOfASeries) {
  FakeDaemon daemon(domain());
  daemon.event(EventId::port_closed, "the cause", 1);
  for (std::uint32_t count = 1; count <= 40; ++count)
    daemon.event(EventId::frame_late, "late", count);
  const json all = json::parse(run({"--json", "events"}).out)["events"];
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0]["text"], "the cause");
  EXPECT_EQ(all[1]["index"], 41);
  EXPECT_EQ(all[1]["count"], 40);
}

TEST_F(Answers, TimingShowsTheStatisticsOfTheDaemon) {
  FakeDaemon daemon(domain());
  TimingStatistics statistics{.frames = 1000, .overruns = 3, .offset_ns = 5'000'000};
  for (int i = 0; i < 990; ++i) statistics.series[4].add(50'000);
  for (int i = 0; i < 10; ++i) statistics.series[4].add(6'000'000);
  daemon.timing(statistics);
  const json all = json::parse(run({"--json", "timing"}).out);
  EXPECT_EQ(all["frames"], 1000);
  EXPECT_EQ(all["missed"]["overruns"], 3);
  const json& command = all["points"]["command"];
  EXPECT_NEAR(command["p50_us"].get<double>(), 50, 4);
  EXPECT_NEAR(command["mean_us"].get<double>(), 0.99 * 50 + 0.01 * 6000, 0.01);
  EXPECT_EQ(command["max_us"], 6000);
  EXPECT_EQ(command["histogram"].size(), 2U);
  EXPECT_EQ(all["margin"]["min_us"], -1000);
  EXPECT_FALSE(all["points"].contains("wake-up")) << "nothing of it was collected";
  EXPECT_THAT(run({"timing"}).out, HasSubstr("3 of 1000 commands late"));
  EXPECT_EQ(run({"timing", "--histogram", "bogus"}).code, 2);
  EXPECT_EQ(run({"timing", "--reset"}).code, 0);
  EXPECT_EQ(daemon.kinds().back(), static_cast<std::uint16_t>(CommandKind::reset_timing));
}

TEST_F(Answers, ADaemonThatFallsSilentWhileSomethingIsAwaitedLeavesTheOutcomeUnknown) {
  FakeDaemon daemon(domain());
  daemon.trouble(kStart, {Trouble::Kind::never_ends});
  Program program(domain(), {"stand"});
  ASSERT_TRUE(await([&] { return !daemon.kinds().empty(); }));
  daemon.fall_silent();
  const Ended ended = program.wait();
  EXPECT_EQ(ended.code, 7);
  EXPECT_THAT(ended.err, HasSubstr("went away"));
}

}  // namespace
}  // namespace lss::cli::test
