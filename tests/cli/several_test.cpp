// Several daemons on one domain: no verb takes the wrong one, and two of one name are reported.

#include <random>

#include "tests/cli/program_test.h"
#include "tests/support/temp_folder.h"

namespace lss::cli::test {
namespace {

using std::chrono::milliseconds;
using zebro::Mode;

using Several = ProgramTest;

// The first vehicle found must not be taken for the only one.
TEST_F(Several, NoVerbTakesTheOneThatIsHeardFirst) {
  FakeDaemon first(domain(), "zebro-1");
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    const milliseconds late_by(random() % 900);
    const auto late = i % 2 == 0 ? Birth::Late::status : Birth::Late::topics;
    FakeDaemon second(domain(), Birth{.vehicle_id = "zebro-2", .late = late, .late_by = late_by});
    ASSERT_TRUE(await([&] { return first.others() == 1; }));
    const Ended ended = run({"--timeout", "20s", i % 4 < 2 ? "start" : "status"});
    EXPECT_EQ(ended.code, 2) << "late by " << late_by.count() << " ms: " << ended.out;
    EXPECT_THAT(ended.err, AllOf(HasSubstr("zebro-1, zebro-2"), HasSubstr("LSS_VEHICLE")));
    ASSERT_THAT(first.kinds(), IsEmpty());
    ASSERT_THAT(second.kinds(), IsEmpty());
  }
}

TEST_F(Several, AVehicleIsNotTakenForTheOnlyOneNextToADaemonThatDoesNotSayItsName) {
  FakeDaemon first(domain(), "zebro-1");
  FakeDaemon second(domain(), Birth{.vehicle_id = "zebro-2", .late_by = std::chrono::hours(1)});
  const Ended ended = run({"--timeout", kFoundBy, "start"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("did not say its name"));
  EXPECT_EQ(run({"--vehicle", "zebro-1", "start"}).code, 0);
}

TEST_F(Several, AVehicleIsNotTakenForTheOnlyOneWhenItKnowsAnotherThatIsNotHeard) {
  FakeDaemon first(domain(), Birth{.vehicle_id = "zebro-1", .mark = "lssd 1"});
  const Ended ended = run({"--timeout", kFoundBy, "start"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("zebro-1 is not alone on this domain"));
  EXPECT_THAT(first.kinds(), IsEmpty());
  EXPECT_EQ(run({"--vehicle", "zebro-1", "start"}).code, 0);
}

TEST_F(Several, TheEnvironmentNamesTheVehicleAndTheCommandLineWins) {
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  const Variable variable("LSS_VEHICLE", "zebro-2");
  EXPECT_EQ(run({"start"}).code, 0);
  EXPECT_THAT(first.kinds(), IsEmpty());
  EXPECT_THAT(second.kinds(), ElementsAre(kStart));
  EXPECT_EQ(json::parse(run({"--vehicle", "zebro-1", "--json", "status"}).out)["vehicle_id"],
            "zebro-1");
}

TEST_F(Several, AreALineEachInFleet) {
  EXPECT_EQ(run({"--timeout", "1s", "fleet"}).code, 3);
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  const Ended ended = run({"fleet"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, testing::MatchesRegex("zebro-1 +zebro .*nobody commands.*\n"
                                               "zebro-2 +zebro .*nobody commands.*\n"));
  const json all = json::parse(run({"--json", "fleet"}).out)["vehicles"];
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0]["vehicle_id"], "zebro-1");
  EXPECT_EQ(all[1]["fault_count"], 0);
}

TEST_F(Several, ADaemonThatDoesNotSayItsNameIsCountedInFleet) {
  FakeDaemon first(domain(), "zebro-1");
  FakeDaemon second(domain(), Birth{.vehicle_id = "zebro-2", .late_by = std::chrono::hours(1)});
  const Ended ended = run({"--timeout", kFoundBy, "--json", "fleet"});
  EXPECT_EQ(json::parse(ended.out)["without_status"], 1);
}

TEST_F(Several, AFileOfOneVehicleIsNotContinuedWithAnother) {
  FakeDaemon first(domain(), "zebro-1"), second(domain(), "zebro-2");
  const testing_support::TempFolder folder;
  const std::string path = (folder / "a.mcap").string();
  const auto record = [&](const char* vehicle) {
    return run({"--vehicle", vehicle, "record", "--append", "--for", "200ms", "--out", path});
  };
  ASSERT_EQ(record("zebro-1").code, 0);
  const Ended other = record("zebro-2");
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("is of zebro-1, not of zebro-2"));
  const json listed = json::parse(run({"--json", "log", "list", path}).out);
  EXPECT_EQ(listed["whole"], true) << listed["complaint"];
  EXPECT_EQ(listed["about"]["vehicle_id"], "zebro-1");
  EXPECT_EQ(record("zebro-1").code, 0);
}

class TwoOfOneName : public ProgramTest {
 protected:
  FakeDaemon first{domain(), Birth{.pid = 1001}}, second{domain(), Birth{.pid = 1002}};
};

TEST_F(TwoOfOneName, AreBothNamedByStatusAndHealth) {
  const Ended ended = run({"status"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, AllOf(HasSubstr("2 daemons have the name zebro-1"),
                               HasSubstr("obc, pid 1001, since 2030-03-17"),
                               HasSubstr("obc, pid 1002, since 2030-03-17")));
  EXPECT_EQ(json::parse(run({"--json", "status"}).out)["daemons"].size(), 2U);
  const Ended health = run({"--vehicle", "zebro-1", "health"});
  EXPECT_EQ(health.code, 6);
  EXPECT_THAT(health.out, HasSubstr("pid 1002"));
}

TEST_F(TwoOfOneName, AreNotMovedButStopped) {
  const Ended refused = run({"stand"});
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("pid 1001"), HasSubstr("pid 1002"), HasSubstr("vehicle_id")));
  EXPECT_THAT(first.kinds(), IsEmpty());
  EXPECT_THAT(second.kinds(), IsEmpty());
  first.set_state(lss_STATE_OPERATIONAL, Mode::standing);
  second.set_state(lss_STATE_OPERATIONAL, Mode::standing);
  const Ended stopped = run({"stop"});
  EXPECT_EQ(stopped.code, 0) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("pid 1002"));
  // The answer of one ends the verb; the other one may receive it later.
  EXPECT_TRUE(await([&] { return !first.kinds().empty() && !second.kinds().empty(); }));
  EXPECT_THAT(first.kinds(), ElementsAre(kStop));
  EXPECT_THAT(second.kinds(), ElementsAre(kStop));
}

TEST_F(Several, InTheAirTheAdviceIsToLand) {
  FakeDaemon daemon(domain());
  daemon.set_state(lss_STATE_OPERATIONAL, Mode::standing);
  daemon.set_authority("ground");
  EXPECT_THAT(run({"stop"}).err, HasSubstr("or: lss-cli estop zebro-1"));
  daemon.take_off();
  EXPECT_THAT(run({"stop"}).err,
              HasSubstr("or: lss-cli land (lss-cli estop zebro-1 lets it fall)"));
  daemon.take_off(lss_STOP_FALLS);
  EXPECT_THAT(run({"stop"}).err, HasSubstr("or: lss-cli estop zebro-1 (it falls)"));
}

TEST_F(Several, AnyoneMayOrderALandingWithoutAuthority) {
  FakeDaemon daemon(domain(), Birth{.vehicle_id = "hopper-1", .vehicle = "talaris"});
  daemon.set_state(lss_STATE_OPERATIONAL);
  daemon.set_authority("ground");
  daemon.take_off();
  const Ended ended = run({"land"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(daemon.kinds(), ElementsAre(kLand));
  EXPECT_EQ(daemon.last(kLand).lease_ms, 0U);
  EXPECT_EQ(daemon.heartbeats(), 0U);
}

}  // namespace
}  // namespace lss::cli::test
