// The emergency stop as a program: its vehicles, its end, its output.

#include "tests/cli/program_test.h"
#include "tools/lss-cli/session/emergency.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::cli::test {
namespace {

using zebro::Mode;

class Estop : public ProgramTest {
 protected:
  static bool is_stopped(const FakeDaemon& daemon) {
    return daemon.state() == lss_STATE_FATAL_ERROR;
  }
};

TEST_F(Estop, WithoutANameStopsEveryVehicleOnTheDomain) {
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  first.set_state(lss_STATE_OPERATIONAL, Mode::walking);
  second.set_authority("ground");
  const Ended ended = run({"estop"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(is_stopped(first) && is_stopped(second));
  EXPECT_EQ(text(first.last(kEstop).vehicle_id), "*");
  EXPECT_THAT(ended.out, AllOf(HasSubstr("zebro-1         stopped in "),
                               HasSubstr("zebro-2         stopped in "), Not(HasSubstr("fell"))));
}

TEST_F(Estop, OfAVehicleThatIsNamedLeavesTheOthersAlone) {
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  EXPECT_EQ(run({"estop", "zebro-2"}).code, 0);
  EXPECT_TRUE(is_stopped(second));
  EXPECT_THAT(first.kinds(), IsEmpty());
  EXPECT_EQ(run({"--vehicle", "zebro-1", "estop"}).code, 0);
  EXPECT_TRUE(is_stopped(first));
  EXPECT_EQ(run({"--vehicle", "zebro-1", "estop", "zebro-2"}).code, 2);
  const Ended unknown = run({"--timeout", "500ms", "estop", "zebro-3"});
  EXPECT_EQ(unknown.code, 4);
  EXPECT_THAT(unknown.err, HasSubstr("zebro-"));
}

TEST_F(Estop, DoesNotLookAtTheVehicleOfTheEnvironment) {
  const Variable variable("LSS_VEHICLE", "zebro-2");
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  EXPECT_EQ(run({"stand"}).code, 0);
  EXPECT_THAT(first.kinds(), IsEmpty());
  EXPECT_EQ(run({"estop"}).code, 0);
  EXPECT_TRUE(is_stopped(first) && is_stopped(second));
}

TEST_F(Estop, IsSentUnderItsOwnNameWhenTheSourceDoesNotFit) {
  FakeDaemon daemon(domain());
  const Variable variable("LSS_SOURCE", "a source of more than 31 characters");
  EXPECT_EQ(run({"stand"}).code, 2);
  EXPECT_THAT(daemon.kinds(), IsEmpty());
  const Ended ended = run({"estop"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(is_stopped(daemon));
  EXPECT_THAT(std::string(text(daemon.last(kEstop).source)), StartsWith("lss-cli:"));
}

TEST_F(Estop, IsSentAgainAfterAnyAnswerButCompleted) {
  FakeDaemon daemon(domain());
  for (const Trouble& trouble : {Trouble{Trouble::Kind::reject, Reason::busy, 3},
                                 Trouble{Trouble::Kind::fail, Reason::emergency, 3},
                                 Trouble{Trouble::Kind::no_answer, Reason::none, 3},
                                 Trouble{Trouble::Kind::never_ends, Reason::none, 3}}) {
    daemon.set_state(lss_STATE_OPERATIONAL, Mode::standing);
    daemon.trouble(kEstop, trouble);
    const Ended ended = run({"estop"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_TRUE(is_stopped(daemon));
  }
}

TEST_F(Estop, IsSentHoweverLongItMayTake) {
  FakeDaemon daemon(domain());
  for (const char* timeout : {"1e10s", "99999999h", "1e300h"}) {
    daemon.set_state(lss_STATE_OPERATIONAL, Mode::walking);
    const Ended ended = run({"--timeout", timeout, "estop"});
    EXPECT_EQ(ended.code, 0) << timeout << ": " << ended.err;
    EXPECT_TRUE(is_stopped(daemon)) << timeout;
  }
}

TEST_F(Estop, NamesTheVehicleThatDidNotConfirmItAndEndsWith7) {
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2"), third(domain(), "zebro-3");
  second.trouble(kEstop, {Trouble::Kind::no_answer});
  third.trouble(kEstop, {Trouble::Kind::reject, Reason::busy});
  const Ended ended = run({"--timeout", kFoundBy, "estop"});
  EXPECT_EQ(ended.code, 7);
  EXPECT_TRUE(is_stopped(first));
  EXPECT_THAT(ended.out, AllOf(HasSubstr("zebro-1         stopped"),
                               HasSubstr("zebro-2         not confirmed"),
                               HasSubstr("rejected, request queue is full")));
  EXPECT_THAT(ended.err, AllOf(HasSubstr("2 of 3"), HasSubstr("zebro-2, zebro-3"),
                               HasSubstr("cut the power")));
}

TEST_F(Estop, ReachesADaemonWhoseStatusWasNeverHeard) {
  FakeDaemon daemon(domain(), Birth{.late_by = std::chrono::hours(1)});
  EXPECT_EQ(run({"estop", "zebro-1"}).code, 0);
  EXPECT_TRUE(is_stopped(daemon));
  EXPECT_EQ(run({"estop"}).code, 0);
}

TEST_F(Estop, ReachesADaemonWhoseTopicsComeLate) {
  FakeDaemon first(domain(), "zebro-1");
  FakeDaemon second(domain(), Birth{.vehicle_id = "zebro-2",
                                    .late = Birth::Late::topics,
                                    .late_by = std::chrono::milliseconds(800)});
  const Ended ended = run({"estop"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(is_stopped(first) && is_stopped(second));
}

TEST_F(Estop, OfADaemonThatNeverOpensItsTopicsIsNotConfirmed) {
  FakeDaemon first(domain(), "zebro-1");
  FakeDaemon second(domain(), Birth{.late = Birth::Late::topics, .late_by = std::chrono::hours(1)});
  const Ended ended = run({"--timeout", kFoundBy, "estop"});
  EXPECT_EQ(ended.code, 7);
  EXPECT_THAT(ended.err, HasSubstr("1 of 2"));
  EXPECT_TRUE(is_stopped(first));
}

TEST_F(Estop, OfADaemonThatOnlyAnotherKnowsOfIsNotConfirmed) {
  FakeDaemon first(domain(), Birth{.mark = "lssd 1"});
  const Ended ended = run({"--timeout", kFoundBy, "estop"});
  EXPECT_EQ(ended.code, 7);
  EXPECT_THAT(ended.err, HasSubstr("1 of 2"));
  EXPECT_TRUE(is_stopped(first));
  EXPECT_EQ(run({"estop", "zebro-1"}).code, 0) << "that one is not meant";
}

TEST_F(Estop, InTheAirSaysThatItFell) {
  FakeDaemon daemon(domain());
  daemon.set_state(lss_STATE_OPERATIONAL, Mode::standing);
  daemon.take_off();
  const Ended ended = run({"estop"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("it was in the air: it fell"));
}

TEST_F(Estop, AsJsonHasAnEntryForEachVehicle) {
  FakeDaemon first(domain(), Birth{.vehicle_id = "zebro-1", .pid = 12});
  FakeDaemon second(domain(), "zebro-2");
  second.trouble(kEstop, {Trouble::Kind::no_answer});
  const Ended ended = run({"--json", "--timeout", kFoundBy, "estop"});
  const json document = json::parse(ended.out);
  EXPECT_EQ(document["exit_code"], 7);
  ASSERT_EQ(document["commands"].size(), 2U);
  const json& stopped = document["commands"][0];
  EXPECT_EQ(stopped["command"], "estop");
  EXPECT_EQ(stopped["phase"], "completed");
  EXPECT_EQ(stopped["vehicle_id"], "zebro-1");
  EXPECT_EQ(stopped["instance"]["pid"], 12);
  EXPECT_TRUE(stopped["stopped"].get<bool>());
  EXPECT_FALSE(stopped["airborne"].get<bool>());
  EXPECT_GT(stopped["duration_s"].get<double>(), 0);
  EXPECT_EQ(document["commands"][1]["vehicle_id"], "zebro-2");
  EXPECT_EQ(document["commands"][1]["phase"], "unanswered");
  EXPECT_FALSE(document["commands"][1]["stopped"].get<bool>());
}

TEST_F(Estop, StopsBothDaemonsOfOneName) {
  FakeDaemon first(domain(), Birth{.pid = 1001}), second(domain(), Birth{.pid = 1002});
  const Ended ended = run({"estop", "zebro-1"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(is_stopped(first) && is_stopped(second));
  EXPECT_THAT(ended.out, AllOf(HasSubstr("pid 1001"), HasSubstr("pid 1002")));
  second.trouble(kEstop, {Trouble::Kind::no_answer});
  EXPECT_EQ(run({"--timeout", kFoundBy, "estop", "zebro-1"}).code, 7);
}

TEST_F(Estop, InASequenceIsTheSame) {
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  first.trouble(kEstop, {Trouble::Kind::reject, Reason::busy, 3});
  const Variable variable("LSS_VEHICLE", "zebro-1");
  const Ended ended = run({"--json", "run", "-e", "walk forward; estop; solve"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(is_stopped(second));
  const json document = json::parse(ended.out);
  std::vector<std::string> commands;
  for (const json& command : document["commands"]) commands.push_back(command["command"]);
  EXPECT_THAT(commands, ElementsAre("start", "stand", "walk", "estop", "estop", "solve"));
  EXPECT_EQ(first.kinds().back(), kSolve);
}

TEST_F(Estop, InAShellKeepsUpTheLeaseOfItsOwnVehicle) {
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  second.trouble(kEstop, {Trouble::Kind::no_answer});
  const Ended ended =
      run({"--vehicle", "zebro-1", "--timeout", "5s", "shell"}, "walk forward\nestop zebro-2\n");
  EXPECT_EQ(ended.code, 7);
  EXPECT_THAT(first.kinds(), ElementsAre(kStart, kStand, kWalk, kStop));
  EXPECT_GE(first.heartbeats(), 10U);  // five a second
}

// It has nobody to speak to then, and waits for somebody.
TEST_F(Estop, IsNotSentWithoutAPauseWhenTheLastVehicleLeaves) {
  Options options;
  options.domain = domain();
  Link link(options);
  link.open_emergency("");
  EmergencyStop stop(link, std::string(dds::kEveryVehicle));
  const auto turns_until = [&](auto&& done) {
    int turns = 0;
    for (const auto limit = Clock::now() + seconds(20); !done() && Clock::now() < limit; ++turns) {
      const auto next = stop.step({});
      if (!next) break;
      link.wait(*next);
    }
    return turns;
  };
  {
    FakeDaemon daemon(domain());
    daemon.trouble(kEstop, {Trouble::Kind::no_answer});
    turns_until([&] { return !link.hearers().empty(); });
    ASSERT_FALSE(link.hearers().empty());
  }
  turns_until([&] { return link.hearers().empty(); });
  ASSERT_TRUE(link.hearers().empty());
  const auto end = Clock::now() + seconds(0.5);
  EXPECT_LT(turns_until([&] { return Clock::now() >= end; }), 100);
}

}  // namespace
}  // namespace lss::cli::test
