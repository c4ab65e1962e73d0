// The registry with a fleet on a DDS domain of its own, on which a test speaks for vehicles, word
// by word.

#include "tools/lss-ground/client_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "idl/codes.h"
#include "tests/support/eventually.h"
#include "tests/support/own_domain.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::ground {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::Gt;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::uint16_t kEstop = 3, kLand = 313;

// A participant of the domain that sends the messages of a test.
class Talker {
 public:
  explicit Talker(int domain)
      : participant_(cli::checked(dds::Participant::create({.domain = domain}))),
        status_(writer(dds::Kind::status)),
        acks_(writer(dds::Kind::command_ack)),
        dictionary_(writer(dds::Kind::dictionary)),
        commands_(cli::checked(
            dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::command)))) {}

  void say(const std::string& id, const std::function<void(lss_Status&)>& change = {},
           const char* vehicle = "zebro") {
    lss_Status status{};
    cli::put(status.vehicle_id, id);
    cli::put(status.vehicle, vehicle);
    if (change) change(status);
    dds_write(status_.get(), &status);
  }
  void answer(const lss_Command& command, const std::string& id, lss_Phase phase,
              Reason reason = Reason::none) {
    lss_CommandAck ack{};
    cli::put(ack.vehicle_id, id);
    cli::put(ack.source, cli::text(command.source));
    ack.seq = command.seq;
    ack.kind = command.kind;
    ack.phase = phase;
    ack.reason = static_cast<std::uint16_t>(reason);
    dds_write(acks_.get(), &ack);
  }
  void describe(const std::string& id, std::string dictionary) {
    lss_Dictionary sample{};
    cli::put(sample.vehicle_id, id);
    sample.json = dictionary.data();
    dds_write(dictionary_.get(), &sample);
  }
  // All that came so far.
  const std::vector<lss_Command>& heard() {
    lss_Command command{};
    void* samples[1] = {&command};
    dds_sample_info_t info{};
    while (dds_take(commands_.get(), samples, &info, 1, 1) == 1) {
      if (info.valid_data) heard_.push_back(command);
    }
    return heard_;
  }

 private:
  dds::Entity writer(dds::Kind kind) {
    return cli::checked(dds::create_writer(participant_.get(), dds::common_topic(kind)));
  }

  dds::Participant participant_;
  dds::Entity status_, acks_, dictionary_, commands_;
  std::vector<lss_Command> heard_;
};

class ClientRegistryTest : public testing::Test {
 protected:
  // As the server does.
  void turn() {
    fleet_->take();
    registry_->tick();
    for (auto& [client, messages] : said_) {
      while (!client->outbox.empty()) {
        const FramePtr frame = client->outbox.pop(Clock::now());
        if (frame->binary()) {
          ++samples_;
        } else {
          messages.push_back(json::parse(frame->text(), frame->text() + frame->size()));
        }
      }
    }
  }
  testing::AssertionResult until(const std::function<bool()>& condition,
                                 Clock::duration limit = testing_support::kHung) {
    const Clock::time_point end = Clock::now() + limit;
    while (!condition()) {
      if (Clock::now() > end) return testing::AssertionFailure() << "it did not come";
      turn();
      ::usleep(2000);
    }
    return testing::AssertionSuccess();
  }
  void pass(Clock::duration time) {
    const Clock::time_point end = Clock::now() + time;
    (void)until([&] { return Clock::now() >= end; });
  }

  Client& client(Client::Line line) { return enter(line, ""); }
  Client& enter(Client::Line line, const std::string& key) {
    Client& c = registry_->enter(
        line, [] {}, [] {});
    said_[&c];
    json hello = {{"type", "hello"}, {"session", "0123456789abcdef"}};
    if (!key.empty()) hello["key"] = key;
    registry_->receive(c, hello.dump());
    return c;
  }
  std::vector<json> said(Client& client, const std::string& type) {
    std::vector<json> list;
    for (const json& m : said_[&client]) {
      if (m["type"] == type) list.push_back(m);
    }
    return list;
  }
  std::vector<std::string> phases(Client& client) {
    std::vector<std::string> list;
    for (const json& m : said(client, "ack"))
      list.push_back(m["phase"].get<std::string>() + (m["final"] == true ? ", final" : ""));
    return list;
  }
  // Vehicles that have a place in the gateway.
  std::vector<std::string> fleet() {
    std::vector<std::string> list;
    for (const auto& [id, craft] : fleet_->crafts()) list.push_back(id);
    return list;
  }
  bool has(const std::string& id) { return fleet_->find(id) != nullptr; }

  const int domain_ = testing_support::own_domain();
  Door door_;
  std::unique_ptr<Fleet> fleet_ = std::move(*Fleet::create(domain_, "", [] {}));
  std::unique_ptr<ClientRegistry> registry_ =
      std::make_unique<ClientRegistry>(*fleet_, door_, 2000);
  std::map<Client*, std::vector<json>> said_;
  std::size_t samples_ = 0;  // of Foxglove
};

std::string dictionary_of(const char* command) {
  json all = json::parse(R"({"schema_version": 2, "vehicle": "hover", "states": ["Idle"],
      "subjects": ["fan"], "parameters": [], "faults": [], "reasons": [], "events": [],
      "telemetry": {}, "commands": [{"kind": 401, "summary": "go up", "access": "holder",
      "leased": true, "ends_motion": false, "endless": true, "parameters": [],
      "allowed": [{"where": "Idle", "when": []}]}]})");
  all["commands"][0]["name"] = command;
  return all.dump();
}

TEST_F(ClientRegistryTest, AVehicleThatIsNotOnTheRosterIsCommandedByItsDictionary) {
  Talker daemon(domain_);
  Client& page = client(Client::Line::data);
  const auto says_until = [&](const std::function<bool()>& condition) {
    return until([&] {
      daemon.say("hover-1", {}, "hover");
      return condition();
    });
  };
  daemon.describe("hover-1", "{\"commands\": 7}");
  daemon.say("zebro-1");
  ASSERT_TRUE(says_until([&] { return has("zebro-1"); }));
  EXPECT_FALSE(has("hover-1"));

  daemon.describe("hover-1", dictionary_of("hover"));
  ASSERT_TRUE(says_until([&] { return has("hover-1"); }));
  const json vehicle = said(page, "vehicle").back();
  EXPECT_EQ(vehicle["vehicle"], "hover");
  registry_->receive(
      page, R"({"type":"command","id":1,"vehicle":"hover-1","command":"hover","whole":true})");
  ASSERT_TRUE(until([&] { return !daemon.heard().empty(); }));
  EXPECT_EQ(daemon.heard().back().kind, 401);

  // Another daemon of that name, while its command has no answer.
  page.driven.clear();
  daemon.describe("hover-1", dictionary_of("climb"));
  ASSERT_TRUE(says_until([&] {
    const std::vector<json> all = said(page, "vehicle");
    return all.size() > 2 && all.back()["commands"].back()["name"] == "climb";
  }));
  ASSERT_TRUE(until([&] { return !phases(page).empty(); }));
  EXPECT_THAT(phases(page), ElementsAre("unanswered, final"));
}

TEST_F(ClientRegistryTest, FoxgloveHearsOfVehiclesThatComeAndGo) {
  Talker daemon(domain_);
  Client& viewer = registry_->enter(
      Client::Line::foxglove, [] {}, [] {});
  said_[&viewer];
  registry_->show(viewer, "");
  const auto last = [&](const char* op) {
    for (auto m = said_[&viewer].rbegin(); m != said_[&viewer].rend(); ++m) {
      if (m->at("op") == op) return *m;
    }
    return json::object();
  };
  const auto channels = [&] {
    std::vector<json> ids;
    const json all = last("advertise").value("channels", json::array());
    for (const json& c : all) ids.push_back(c["id"]);
    return ids;
  };
  const auto says_until = [&](const std::function<bool()>& condition) {
    return until([&] {
      daemon.say("hover-1", {}, "hover");
      return condition();
    });
  };
  daemon.describe("hover-1", dictionary_of("hover"));
  ASSERT_TRUE(says_until([&] { return !channels().empty(); }));
  const std::vector<json> first = channels();
  EXPECT_THAT(first, SizeIs(3)) << "without telemetry";
  EXPECT_EQ(last("advertise")["channels"][0]["topic"], "lss/status");
  const json wanted = {{"op", "subscribe"},
                       {"subscriptions", {{{"id", 7}, {"channelId", first[0]}}}}};
  registry_->receive(viewer, wanted.dump());
  ASSERT_TRUE(says_until([&] { return samples_ > 1; }));

  daemon.describe("hover-1", dictionary_of("climb"));  // of another daemon
  ASSERT_TRUE(says_until([&] { return channels() != first; }));
  EXPECT_EQ(last("unadvertise")["channelIds"], json(first));
  EXPECT_THAT(viewer.subscriptions, IsEmpty());
  EXPECT_GT(channels()[0], first[2]) << "ids are not used again";
}

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

TEST_F(ClientRegistryTest, AStopIsRepeatedUntilItIsCompletedWhateverElseIsAnswered) {
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

TEST_F(ClientRegistryTest, InventedNamesDoNotHideTheVehicleNorDropThePage) {
  Client& page = client(Client::Line::data);
  Talker liar(domain_), daemon(domain_);
  const auto lie = [&](int round) {
    for (int i = 0; i < 100; ++i) liar.say("g" + std::to_string(round) + "-" + std::to_string(i));
  };
  liar.say("*");  // a source with this name would stop all
  for (int round = 0; round < 5; ++round) {
    lie(round);
    turn();
  }
  ASSERT_TRUE(until([&] { return fleet().size() == Places::kMost && fleet_->crowded(); }));
  daemon.say("zebro-1");
  ASSERT_TRUE(until([&] { return has("zebro-1"); }));
  EXPECT_EQ(fleet().size(), Places::kMost);
  EXPECT_FALSE(has("*"));
  for (int round = 5; round < 30; ++round) {
    lie(round);
    turn();
    ASSERT_TRUE(has("zebro-1"));
  }
  ASSERT_TRUE(until([&] { return !said(page, "gone").empty(); }));
  EXPECT_FALSE(page.doomed) << page.why;
  EXPECT_LE(said(page, "vehicle").size(), Places::kMost + 3);
  ASSERT_TRUE(until([&] { return !said(page, "pulse").empty(); }));
  EXPECT_EQ(said(page, "pulse").back()["crowded"], true);
}

TEST_F(ClientRegistryTest, APageIsToldOfAFleetThatIsLargerThanItsOutbox) {
  constexpr std::size_t kVehicles = 75, kEach = 60'000;
  static_assert(kVehicles * kEach > Outbox::kBytes);
  Talker daemons(domain_);
  json field, dictionary = json::parse(dictionary_of("hover"));
  field["name"] = std::string(kEach, 'x');
  dictionary["telemetry"]["fields"].push_back(field);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kVehicles; ++i) names.push_back("hover-" + std::to_string(i));
  for (const std::string& name : names) daemons.describe(name, dictionary.dump());
  ASSERT_TRUE(until([&] {
    for (const std::string& name : names) daemons.say(name, {}, "hover");
    return fleet().size() == kVehicles;
  }));
  Client& page = client(Client::Line::data);
  EXPECT_TRUE(until([&] {
    std::set<std::string> told;
    for (const json& m : said_[&page]) {
      if (m["type"] == "vehicle") told.insert(m["id"].get<std::string>());
    }
    return told.size() == kVehicles || page.doomed;
  }));
  EXPECT_FALSE(page.doomed) << page.why;
}

TEST_F(ClientRegistryTest, AStatusTellsTwoDaemonsOfOneNameAndWhetherItFlies) {
  Client& page = client(Client::Line::data);
  Talker one(domain_), other(domain_);
  const auto speak = [](Talker& who, int pid) {
    who.say(
        "talaris-1",
        [&](lss_Status& s) {
          s.instance.pid = pid;
          s.instance.started_utc_ns = pid * 1'000'000'000LL;
          cli::put(s.instance.host, "obc");
          s.airborne = true;
          s.stop_in_flight = pid == 1 ? lss_STOP_FALLS : lss_STOP_LANDS;
        },
        "talaris");
  };
  const auto hear = [&](Talker& who, int pid, const char* stop) {
    speak(who, pid);
    return until([&] {
      const auto all = said(page, "status");
      return !all.empty() && all.back()["stop_in_flight"] == stop;
    });
  };
  ASSERT_TRUE(hear(one, 1, "falls"));
  EXPECT_EQ(said(page, "status").back()["airborne"], true);
  EXPECT_THAT(said(page, "status").back()["daemons"], IsEmpty());
  ASSERT_TRUE(hear(other, 2, "lands"));
  EXPECT_THAT(said(page, "status").back()["daemons"], IsEmpty()) << "it may have been restarted";
  ASSERT_TRUE(hear(one, 1, "falls"));
  const json daemons = said(page, "status").back()["daemons"];
  ASSERT_THAT(daemons, SizeIs(2));
  EXPECT_EQ(daemons[1], json({{"host", "obc"}, {"pid", 2}, {"started_utc_ns", 2'000'000'000LL}}));
}

}  // namespace
}  // namespace lss::ground
