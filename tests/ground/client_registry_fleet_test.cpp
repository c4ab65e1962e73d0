// The fleet that clients see: vehicles that come and go, large fleets, invented names.

#include <algorithm>
#include <set>

#include "tests/ground/talker.h"

namespace lss::ground {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

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

TEST_F(ClientRegistryTest, FoxgloveGetsTheChannelsOfAFleetAsFastAsItReads) {
  Talker daemons(domain_);
  ASSERT_TRUE(until([&] {
    for (const char* name : {"zebro-1", "zebro-2"}) daemons.say(name);
    return fleet().size() == 2;
  }));
  Client& viewer = registry_->enter(
      Client::Line::foxglove, [] {}, [] {});
  said_[&viewer];
  constexpr std::size_t kLeft = 1000;  // less than the channels of a vehicle take
  viewer.outbox.push(std::make_shared<Frame>(std::string(Outbox::kBytes - kLeft, 'x'), true),
                     Clock::now());
  registry_->show(viewer, "");
  EXPECT_FALSE(viewer.doomed) << viewer.why;
  const auto told = [&] {
    return std::ranges::count_if(said_[&viewer], [](const json& m) {
      return m["op"] == "advertise" && !m["channels"].empty();
    });
  };
  EXPECT_TRUE(until([&] { return told() == 2; }));
  EXPECT_FALSE(viewer.doomed) << viewer.why;
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

TEST_F(ClientRegistryTest, APageGetsEveryVehicleOfAFleetThatIsLargerThanItsOutbox) {
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

// At rest its status comes seldom. A heartbeat of a client is none of the daemon.
TEST_F(ClientRegistryTest, TheHeartbeatOfADaemonShowsThatItLives) {
  Client& page = client(Client::Line::data);
  Talker daemon(domain_);
  daemon.say("zebro-1");
  ASSERT_TRUE(until([&] { return has("zebro-1"); }));
  const auto age_ms = [&](const char* of) {
    const auto all = said(page, "pulse");
    return all.empty() ? -1 : all.back()["crafts"]["zebro-1"][of].get<int>();
  };
  ASSERT_TRUE(until([&] {
    daemon.beat("zebro-1", "somebody");
    return age_ms("daemon_age_ms") > 700;
  }));
  ASSERT_TRUE(until([&] {
    daemon.beat("zebro-1");
    return age_ms("daemon_age_ms") < 500;
  }));
  EXPECT_GT(age_ms("status_age_ms"), 700);
}

TEST_F(ClientRegistryTest, AStatusNamesBothDaemonsOfOneNameAndWhetherTheVehicleFlies) {
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
