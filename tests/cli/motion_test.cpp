// Attached motion: heartbeat, Ctrl-C, sequences, against a stand-in for the daemon.

#include <csignal>

#include "tests/cli/program_test.h"
#include "tools/lss-cli/session/link.h"

namespace lss::cli::test {
namespace {

using zebro::Mode;

class MotionTest : public ProgramTest {
 protected:
  // A program that makes the vehicle walk, which it does.
  struct Walk {
    explicit Walk(const std::vector<std::string>& words) : program(domain(), words) {
      EXPECT_TRUE(await([this] { return daemon.mode() == Mode::walking; }));
    }
    FakeDaemon daemon{domain()};
    Program program;
  };
};

TEST_F(MotionTest, AWalkFromIdleStartsStandsWalksAndStopsLyingDown) {
  FakeDaemon daemon(domain());
  const Ended ended = run({"walk", "forward", "--speed", "high", "--for", "1s", "--lease", "700"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(daemon.kinds(), ElementsAre(kStart, kStand, kWalk, kStop));
  EXPECT_EQ(daemon.last(kStop).parameter[0], 1);  // lies down
  EXPECT_EQ(daemon.last(kWalk).parameter[0], 1);
  EXPECT_EQ(daemon.last(kWalk).parameter[2], 3);
  EXPECT_EQ(daemon.last(kWalk).lease_ms, 700U);
  EXPECT_THAT(std::string(text(daemon.last(kWalk).source)), StartsWith("lss-cli:"));
  EXPECT_EQ(daemon.state(), lss_STATE_IDLE);
  EXPECT_GE(daemon.heartbeats(), 4U);  // five a second
}

TEST_F(MotionTest, AWalkThatShallStayEndsStandingAndReportsItsDistance) {
  FakeDaemon daemon(domain());
  const Ended ended = run({"--json", "walk", "--for", "500ms", "--stay"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const json walked = json::parse(ended.out)["documents"][0];
  EXPECT_GT(walked["distance_m"].get<double>(), 0);
  EXPECT_NEAR(walked["duration_s"].get<double>(), 0.5, 0.4);
  EXPECT_EQ(daemon.mode(), Mode::standing);
}

TEST_F(MotionTest, CtrlCIsASafeStopAndTheProperEndOfAWalkWithoutOne) {
  Walk walk({"walk", "backward"});
  walk.program.signal(SIGINT);
  EXPECT_EQ(walk.program.wait().code, 0);
  EXPECT_THAT(walk.daemon.kinds(), ElementsAre(kStart, kStand, kWalk, kStop));
  EXPECT_EQ(walk.daemon.state(), lss_STATE_IDLE);
}

TEST_F(MotionTest, CtrlCBeforeTheTimeIsOverIsASafeStopAndAFailure) {
  Walk walk({"walk", "--for", "10min"});
  walk.program.signal(SIGTERM);
  const Ended ended = walk.program.wait();
  EXPECT_EQ(ended.code, 6);
  EXPECT_THAT(ended.err, HasSubstr("stopped safely"));
  EXPECT_EQ(walk.daemon.state(), lss_STATE_IDLE);
}

TEST_F(MotionTest, AWalkForCenturiesGoesOn) {
  Walk walk({"walk", "--for", "1e10s"});
  const auto before = walk.daemon.heartbeats();
  ASSERT_TRUE(await([&] { return walk.daemon.heartbeats() >= before + 3; }));
  EXPECT_EQ(walk.daemon.mode(), Mode::walking);
  EXPECT_THAT(walk.daemon.kinds(), ElementsAre(kStart, kStand, kWalk));
  walk.program.signal(SIGINT);
  EXPECT_EQ(walk.program.wait().code, 6);  // before its time
}

TEST_F(MotionTest, ASecondCtrlCLeavesAtOnceAndSaysThatTheLeaseStopsTheVehicle) {
  FakeDaemon daemon(domain());
  daemon.trouble(kStop, {Trouble::Kind::never_ends});
  Program program(domain(), {"walk"});
  ASSERT_TRUE(await([&] { return daemon.mode() == Mode::walking; }));
  program.signal(SIGINT);
  ASSERT_TRUE(await([&] { return daemon.last(kStop).kind == kStop; }));
  program.signal(SIGINT);
  const Ended ended = program.wait();
  EXPECT_EQ(ended.code, 7);
  EXPECT_THAT(ended.err, HasSubstr("without a heartbeat"));
}

TEST_F(MotionTest, AHeldVerbStaysAttachedUntilCtrlC) {
  FakeDaemon daemon(domain());
  Program program(domain(), {"stand", "--hold"});
  ASSERT_TRUE(await([&] { return daemon.mode() == Mode::standing; }));
  const std::uint64_t before = daemon.heartbeats();
  EXPECT_TRUE(await([&] { return daemon.heartbeats() >= before + 3; }));
  program.signal(SIGINT);
  EXPECT_EQ(program.wait().code, 0);
  EXPECT_EQ(daemon.state(), lss_STATE_IDLE);
}

TEST_F(MotionTest, AVerbThatEndsSaysThatItsHeartbeatEndsToo) {
  FakeDaemon daemon(domain());
  EXPECT_THAT(run({"stand"}).err, HasSubstr("--hold"));
}

TEST_F(MotionTest, AnEmergencyWhileWalkingEndsWith6) {
  Walk walk({"walk"});
  walk.daemon.latch(FaultId::module_reset, 5);
  walk.daemon.emergency();
  const Ended ended = walk.program.wait();
  EXPECT_EQ(ended.code, 6);
  EXPECT_THAT(ended.err, HasSubstr("LH: module was reset"));
}

TEST_F(MotionTest, WhatIsDetachedIsOfLssCliAndCanBeStoppedByAnotherRun) {
  FakeDaemon daemon(domain());
  const Ended ended = run({"--detach", "walk", "forward"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("without a heartbeat of lss-cli for 2"));
  EXPECT_EQ(daemon.mode(), Mode::walking);
  EXPECT_EQ(daemon.last(kWalk).flags, 0);
  EXPECT_STREQ(daemon.last(kWalk).source, "lss-cli");
  EXPECT_EQ(run({"stop"}).code, 0);  // authority is of lss-cli, not of the run that ended
  EXPECT_EQ(daemon.state(), lss_STATE_IDLE);
}

TEST_F(MotionTest, ProgramsThatActUnderOneNameDoNotUseUpEachOthersSequenceNumbers) {
  FakeDaemon daemon(domain());
  Program first(domain(), {"--source", "ground", "run", "-e", "walk; wait 1s; stow"});
  ASSERT_TRUE(await([&] { return daemon.mode() == Mode::walking; }));
  EXPECT_EQ(run({"--source", "ground", "data"}).code, 0);
  EXPECT_EQ(first.wait().code, 0);
}

TEST_F(MotionTest, AStopKeepsUpTheHeartbeatUntilItIsCompleted) {
  FakeDaemon daemon(domain());
  daemon.set_state(lss_STATE_OPERATIONAL, Mode::walking);
  daemon.trouble(kStop, {Trouble::Kind::never_ends});
  EXPECT_EQ(run({"--timeout", kFoundBy, "stop"}).code, 7);
  EXPECT_GE(daemon.heartbeats(), 4U);
}

TEST_F(MotionTest, TheHeartbeatVerbBeatsForItsTime) {
  FakeDaemon daemon(domain());
  EXPECT_EQ(run({"heartbeat", "--for", "1s"}).code, 0);
  EXPECT_GE(daemon.heartbeats(), 4U);
  EXPECT_LE(daemon.heartbeats(), 7U);
  EXPECT_EQ(daemon.heart(), "lss-cli") << "of what was or will be detached";
  EXPECT_THAT(daemon.kinds(), IsEmpty());
}

TEST_F(MotionTest, ASequenceGoesOnFromWhereItIsUnderOneSourceAndStopsAtItsEnd) {
  FakeDaemon daemon(domain());
  const Ended ended = run(
      {"run", "-e", "start; stand; walk forward; wait 300ms; walk backward --for 200ms; status"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(daemon.kinds(), ElementsAre(kStart, kStand, kWalk, kWalk, kStand, kStop));
  EXPECT_EQ(text(daemon.last(kStart).source), text(daemon.last(kStop).source));
  EXPECT_EQ(daemon.state(), lss_STATE_IDLE);
}

TEST_F(MotionTest, ASequenceThatFailsSaysWhereAndStopsTheVehicle) {
  FakeDaemon daemon(domain());
  daemon.trouble(kStow, {Trouble::Kind::reject, Reason::module_silent});
  const Ended ended = run({"run", "-"}, "stand\n\nstow\nwalk forward\n");
  EXPECT_EQ(ended.code, 5);
  EXPECT_THAT(ended.err, HasSubstr("-:3: stow rejected"));
  EXPECT_THAT(daemon.kinds(), ElementsAre(kStart, kStand, kStow, kStop));
  EXPECT_EQ(daemon.state(), lss_STATE_IDLE);
}

TEST_F(MotionTest, AnEmergencyWhileASequenceWaitsEndsIt) {
  Walk walk({"run", "-e", "walk forward; wait 10min; walk backward"});
  walk.daemon.emergency();
  EXPECT_EQ(walk.program.wait().code, 6);
  EXPECT_THAT(walk.daemon.kinds(), ElementsAre(kStart, kStand, kWalk));
}

TEST_F(MotionTest, TheShellTakesLinesGoesOnAfterMistakesAndStopsTheVehicleWhenItEnds) {
  FakeDaemon daemon(domain());
  const Ended ended = run({"shell"}, "stand\nwlak\nstow\n");
  EXPECT_EQ(ended.code, 4) << ended.err;  // of the mistake
  EXPECT_THAT(ended.err, HasSubstr("did you mean walk?"));
  EXPECT_THAT(daemon.kinds(), ElementsAre(kStart, kStand, kStow, kStop));
}

TEST_F(MotionTest, AShellThatReadsAPipeEndsWithTheCodeOfItsFirstLineThatFailed) {
  FakeDaemon daemon(domain());
  EXPECT_EQ(run({"shell"}, "stand\nstow\n").code, 0);
  daemon.trouble(kStow, {Trouble::Kind::reject, Reason::module_silent});
  EXPECT_EQ(run({"shell"}, "stand\nstow\nwlak\nstand\n").code, 5);
}

TEST_F(MotionTest, CtrlCInTheAirSaysThatItLands) {
  FakeDaemon daemon(domain());
  Program program(domain(), {"stand", "--hold"});
  ASSERT_TRUE(await([&] { return daemon.mode() == Mode::standing; }));
  daemon.take_off();
  // The progress of the next status is received before the signal is handled.
  const std::uint64_t before = daemon.heartbeats();
  ASSERT_TRUE(await([&] { return daemon.heartbeats() >= before + 2; }));
  program.signal(SIGINT);
  const Ended ended = program.wait();
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.err, HasSubstr("interrupted: landing"));
  EXPECT_EQ(daemon.kinds().back(), kStop);
}

TEST_F(MotionTest, AStreamOfJsonHasALineForEachAcknowledgementAndTheEnd) {
  FakeDaemon daemon(domain());
  const Ended ended = run({"--jsonl", "stand"});
  std::vector<json> lines;
  for (std::size_t begin = 0; begin < ended.out.size();) {
    const std::size_t end = ended.out.find('\n', begin);
    lines.push_back(json::parse(ended.out.substr(begin, end - begin)));
    begin = end + 1;
  }
  ASSERT_EQ(lines.size(), 7U);  // accepted, executing, completed, of start and stand; the end
  EXPECT_EQ(lines[0]["phase"], "accepted");
  EXPECT_EQ(lines[5]["phase"], "completed");
  EXPECT_EQ(lines[6]["exit_code"], 0);
}

}  // namespace
}  // namespace lss::cli::test
