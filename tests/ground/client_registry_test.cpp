// Commands, scripts and emergency stops of clients.

#include "tests/ground/talker.h"

namespace lss::ground {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::uint16_t kEstop = 3, kLand = 313;

TEST_F(ClientRegistryTest, AnAnswerIsWaitedForInSimulatedTimeWhereThereIsOne) {
  struct Case {
    bool simulated;
    double rate;  // of the daemon's time
    Clock::duration least, most;
  };
  for (const Case& c :
       {Case{false, 0.25, seconds(2), seconds(7)}, Case{true, 0.25, seconds(7), seconds(19)}}) {
    SCOPED_TRACE(c.rate);
    Talker daemon(domain_);
    Client& page = client(Client::Line::data);
    const Clock::time_point begin = Clock::now();
    Clock::time_point next{};
    const auto says_until = [&](const std::function<bool()>& condition) {
      return until([&] {
        if (const Clock::time_point now = Clock::now(); now >= next) {
          next = now + milliseconds(50);
          daemon.say("zebro-1", [&](lss_Status& status) {
            const std::chrono::nanoseconds passed = now - begin;
            status.simulated_time = c.simulated;
            status.time_ns =
                static_cast<std::int64_t>(c.rate * static_cast<double>(passed.count()));
          });
        }
        return condition();
      });
    };
    ASSERT_TRUE(says_until([&] { return has("zebro-1"); }));
    registry_->receive(page, R"({"type":"command","id":1,"vehicle":"zebro-1","command":"start"})");
    const Clock::time_point sent = Clock::now();
    ASSERT_TRUE(says_until([&] { return !phases(page).empty(); }));
    const Clock::duration waited = Clock::now() - sent;
    EXPECT_THAT(phases(page), ElementsAre("unanswered, final"));
    EXPECT_GE(waited, c.least);
    EXPECT_LE(waited, c.most);
  }
}

constexpr const char* kScript =
    R"({"type":"script","id":1,"vehicle":"talaris-1","text":"0s valves 1 for 1s"})";

TEST_F(ClientRegistryTest, AMotionMayAskForAShorterLeaseAndForNoLongerOne) {
  Client& page = client(Client::Line::data);
  Talker daemon(domain_);
  daemon.say("zebro-1");
  ASSERT_TRUE(until([&] { return has("zebro-1"); }));
  for (const auto& [wanted, lease_ms] :
       {std::pair{"", 2000u}, {R"(,"lease_ms":500)", 500u}, {R"(,"lease_ms":9000)", 2000u}}) {
    SCOPED_TRACE(wanted);
    const std::size_t before = daemon.heard().size();
    registry_->receive(
        page, std::string(R"({"type":"command","id":1,"vehicle":"zebro-1","command":"walk")") +
                  wanted + "}");
    ASSERT_TRUE(until([&] { return daemon.heard().size() > before; }));
    EXPECT_EQ(daemon.heard().back().lease_ms, lease_ms);
  }
}

TEST_F(ClientRegistryTest, AScriptIsOfThoseWhoMayCommand) {
  door_ = *Door::parse(
      "look look-look-look-look\nstop stop-stop-stop-stop\ncommand command-command-command\n",
      "keys");
  Talker daemon(domain_);
  daemon.say("talaris-1", {}, "talaris");
  ASSERT_TRUE(until([&] { return has("talaris-1"); }));
  for (const std::string key :
       {"look-look-look-look", "stop-stop-stop-stop", "command-command-command"}) {
    SCOPED_TRACE(key);
    Client& page = enter(Client::Line::data, key);
    registry_->receive(page, kScript);
    if (page.role == Role::command) {
      EXPECT_TRUE(until([&] { return !daemon.heard().empty(); }));
    } else {
      turn();
      ASSERT_THAT(phases(page), ElementsAre("rejected, final"));
      EXPECT_EQ(said(page, "ack").back()["reason"]["text"], "this key may not command");
      pass(milliseconds(200));
      EXPECT_THAT(daemon.heard(), IsEmpty());
    }
  }
}

TEST_F(ClientRegistryTest, OfAClientThatLeftNothingMoreIsSent) {
  Talker daemon(domain_);
  daemon.say("talaris-1", {}, "talaris");
  ASSERT_TRUE(until([&] { return has("talaris-1"); }));
  for (const bool leaves : {false, true}) {
    Client& page = client(Client::Line::data);
    const std::size_t before = daemon.heard().size();
    registry_->receive(page, kScript);  // of several commands
    ASSERT_TRUE(until([&] { return daemon.heard().size() > before; }));
    if (leaves) {
      said_.erase(&page);
      registry_->leave(page);
    }
    daemon.answer(daemon.heard().back(), "talaris-1", lss_PHASE_COMPLETED);
    const auto next = [&] { return daemon.heard().size() > before + 1; };
    EXPECT_EQ(static_cast<bool>(until(next, leaves ? milliseconds(500) : testing_support::kHung)),
              !leaves);
  }
}

TEST_F(ClientRegistryTest, ACommandThatWaitedInAnOldConnectionOfAPageIsRefused) {
  Talker daemon(domain_);
  daemon.say("talaris-1", {}, "talaris");
  ASSERT_TRUE(until([&] { return has("talaris-1"); }));
  Client& old = client(Client::Line::data);
  Client& page = client(Client::Line::data);  // of the same session
  constexpr const char* kStart =
      R"({"type":"command","id":1,"vehicle":"talaris-1","command":"start"})";
  registry_->receive(old, kStart);
  registry_->receive(old, kScript);
  turn();
  EXPECT_THAT(phases(old), ElementsAre("rejected, final", "rejected, final"));
  registry_->receive(page, kStart);
  ASSERT_TRUE(until([&] { return !daemon.heard().empty(); }));
  EXPECT_THAT(daemon.heard(), SizeIs(1));
}

TEST_F(ClientRegistryTest, AnEndOfMotionThatWaitedInAnOldConnectionIsObeyed) {
  Talker daemon(domain_);
  daemon.say("talaris-1", {}, "talaris");
  ASSERT_TRUE(until([&] { return has("talaris-1"); }));
  Client& old = client(Client::Line::data);
  client(Client::Line::data);  // of the same session
  registry_->receive(old, R"({"type":"command","id":1,"vehicle":"talaris-1","command":"stop"})");
  ASSERT_TRUE(until([&] { return !daemon.heard().empty(); }));
  EXPECT_EQ(daemon.heard().front().kind, 2);
}

TEST_F(ClientRegistryTest, AStopLeavesForANameThatTheGatewayNeverHeardAgainAndAgain) {
  Talker ghost(domain_);
  Client& line = client(Client::Line::stop);
  registry_->receive(line, R"({"type":"stop","id":1,"vehicle":"ghost-1"})");
  ASSERT_TRUE(until([&] { return ghost.heard().size() >= 3; }));
  std::uint64_t before = 0;
  for (const lss_Command& command : ghost.heard()) {
    EXPECT_EQ(cli::text(command.vehicle_id), "ghost-1");
    EXPECT_EQ(command.kind, kEstop);
    EXPECT_GT(command.seq, before);
    before = command.seq;
  }
  EXPECT_THAT(phases(line), IsEmpty()) << "nothing was heard, nothing is said";
  ASSERT_TRUE(until([&] { return !phases(line).empty(); }));
  EXPECT_THAT(phases(line), ElementsAre("unanswered")) << "it goes on";
  const std::size_t sent = ghost.heard().size();
  ASSERT_TRUE(until([&] { return ghost.heard().size() > sent; }));
  ghost.answer(ghost.heard().back(), "ghost-1", lss_PHASE_COMPLETED);
  ASSERT_TRUE(until([&] { return phases(line).size() == 2; }));
  EXPECT_THAT(phases(line), ElementsAre("unanswered", "completed, final"));
}

TEST_F(ClientRegistryTest, AStopIsRepeatedAfterAnyAnswerButCompleted) {
  Talker daemon(domain_);
  daemon.say("zebro-1");
  Client& line = client(Client::Line::stop);
  ASSERT_TRUE(until([&] { return has("zebro-1"); }));
  registry_->receive(line, R"({"type":"stop","id":1,"vehicle":"zebro-1"})");
  std::size_t answers = 0, commands = 0;
  for (const auto& [phase, reason] : {std::pair{lss_PHASE_REJECTED, Reason::busy},
                                      {lss_PHASE_FAILED, Reason::busy},
                                      {lss_PHASE_REJECTED, Reason::stale_sequence},
                                      {lss_PHASE_SUPERSEDED, Reason::superseded},
                                      {lss_PHASE_ACCEPTED, Reason::none},
                                      {lss_PHASE_EXECUTING, Reason::none}}) {
    ASSERT_TRUE(until([&] { return daemon.heard().size() > commands; })) << phase;
    commands = daemon.heard().size();
    daemon.answer(daemon.heard().back(), "zebro-1", phase, reason);
    ASSERT_TRUE(until([&] { return phases(line).size() > answers; })) << phase;
    answers = phases(line).size();
    EXPECT_THAT(phases(line).back(), testing::Not(testing::HasSubstr("final")));
  }
  ASSERT_TRUE(until([&] { return daemon.heard().size() > commands; }));
  daemon.answer(daemon.heard().front(), "zebro-1", lss_PHASE_COMPLETED);  // to any of them
  ASSERT_TRUE(until([&] { return phases(line).back() == "completed, final"; }));
  commands = daemon.heard().size();
  pass(milliseconds(400));
  EXPECT_LE(daemon.heard().size(), commands + 1) << "one may have been under way";
}

TEST_F(ClientRegistryTest, StopAllGoesToEverybodyAtOnceAndSaysWhatEachSaid) {
  Talker one(domain_), other(domain_), unknown(domain_);
  Client& line = client(Client::Line::stop);
  one.say("zebro-1");
  other.say("zebro-2");
  ASSERT_TRUE(until([&] { return has("zebro-1") && has("zebro-2"); }));
  registry_->receive(line, R"({"type":"stop","id":9})");
  ASSERT_TRUE(until([&] { return !one.heard().empty() && !unknown.heard().empty(); }));
  const lss_Command command = one.heard().front();
  EXPECT_EQ(cli::text(command.vehicle_id), "*");
  EXPECT_EQ(command.kind, kEstop);
  one.answer(command, "zebro-1", lss_PHASE_ACCEPTED);
  one.answer(command, "zebro-1", lss_PHASE_COMPLETED);
  unknown.answer(unknown.heard().front(), "ghost-1", lss_PHASE_COMPLETED);
  ASSERT_TRUE(until([&] { return said(line, "ack").size() >= 3; }));
  for (const json& ack : said(line, "ack")) {
    EXPECT_EQ(ack["request"], 9);
    EXPECT_EQ(ack["final"], false);
  }
  // The stop of a silent vehicle continues, by its own name; a stopped one may be started again.
  ASSERT_TRUE(until([&] { return cli::text(other.heard().back().vehicle_id) == "zebro-2"; }));
  ASSERT_TRUE(until([&] { return phases(line).back() == "unanswered"; }));
  EXPECT_THAT(said(line, "ack").back()["silent"], ElementsAre("zebro-2"));
  const std::size_t sent = other.heard().size();
  ASSERT_TRUE(until([&] { return other.heard().size() > sent; }));
  for (std::size_t i = sent; i < other.heard().size(); ++i)
    EXPECT_EQ(cli::text(other.heard()[i].vehicle_id), "zebro-2");
  other.answer(other.heard().back(), "zebro-2", lss_PHASE_COMPLETED);
  ASSERT_TRUE(until([&] { return phases(line).back() == "completed, final"; }));
  EXPECT_THAT(said(line, "ack").back()["silent"], IsEmpty());
}

TEST_F(ClientRegistryTest, ALandingIsOrderedUntilItIsAcceptedAndItsEndIsReported) {
  Talker daemon(domain_);
  daemon.say(
      "talaris-1", [](lss_Status& s) { s.airborne = true; }, "talaris");
  Client& line = client(Client::Line::stop);
  ASSERT_TRUE(until([&] { return has("talaris-1"); }));
  const auto land = [&](int id) {
    const json message = {{"type", "stop"}, {"id", id}, {"vehicle", "talaris-1"}, {"land", true}};
    registry_->receive(line, message.dump());
  };
  land(1);
  ASSERT_TRUE(until([&] { return daemon.heard().size() >= 2; }));
  EXPECT_EQ(daemon.heard().back().kind, kLand);
  daemon.answer(daemon.heard().back(), "talaris-1", lss_PHASE_REJECTED, Reason::busy);
  std::size_t commands = daemon.heard().size();
  ASSERT_TRUE(until([&] { return daemon.heard().size() > commands; }));
  daemon.answer(daemon.heard().back(), "talaris-1", lss_PHASE_ACCEPTED);
  ASSERT_TRUE(until([&] { return phases(line).back() == "accepted"; }));
  commands = daemon.heard().size();
  pass(milliseconds(400));
  EXPECT_LE(daemon.heard().size(), commands + 1);
  daemon.answer(daemon.heard().back(), "talaris-1", lss_PHASE_COMPLETED);
  ASSERT_TRUE(until([&] { return phases(line).back() == "completed, final"; }));

  commands = daemon.heard().size();
  land(2);
  ASSERT_TRUE(until([&] { return daemon.heard().size() > commands; }));
  daemon.answer(daemon.heard().back(), "talaris-1", lss_PHASE_REJECTED, Reason::not_in_flight);
  ASSERT_TRUE(until([&] { return phases(line).back() == "rejected, final"; }));
  EXPECT_EQ(said(line, "ack").back()["reason"]["name"], "not_in_flight");
  EXPECT_EQ(said(line, "ack").back()["command"], "land");
}

TEST_F(ClientRegistryTest, ALandingIsTheCommandOfTheVehiclesDictionary) {
  Talker daemon(domain_);
  Client& line = client(Client::Line::stop);
  daemon.describe("hover-1", dictionary_of("land"));
  daemon.describe("hover-2", dictionary_of("climb"));
  ASSERT_TRUE(until([&] {
    daemon.say("hover-1", {}, "hover");
    daemon.say("hover-2", {}, "hover");
    return has("hover-1") && has("hover-2");
  }));
  const auto land = [&](int id, const char* vehicle) {
    const json message = {{"type", "stop"}, {"id", id}, {"vehicle", vehicle}, {"land", true}};
    registry_->receive(line, message.dump());
  };
  const auto ordered = [&](std::string_view vehicle) {
    for (const lss_Command& command : daemon.heard()) {
      if (cli::text(command.vehicle_id) == vehicle) return command.kind;
    }
    return std::uint16_t{0};
  };
  land(1, "hover-1");
  ASSERT_TRUE(until([&] { return ordered("hover-1") != 0; }));
  EXPECT_EQ(ordered("hover-1"), 401);
  land(2, "ghost-1");
  ASSERT_TRUE(until([&] { return ordered("ghost-1") != 0; }));
  EXPECT_EQ(ordered("ghost-1"), kLand) << "of this build: the gateway never heard of it";
  land(3, "hover-2");
  ASSERT_TRUE(until([&] { return !phases(line).empty(); }));
  EXPECT_THAT(phases(line), ElementsAre("rejected, final"));
  EXPECT_EQ(said(line, "ack").back()["reason"]["text"], "this vehicle has no command 'land'");
}

}  // namespace
}  // namespace lss::ground
