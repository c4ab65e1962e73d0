// The publish thread with its DDS face, over loopback.

#include "daemon/publish/publisher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <optional>

#include "tests/dds/dds_support.h"

namespace lss {
namespace {

using namespace testing_support;

struct Running {
  Running() {
    config.vehicle = "zebro";
    config.vehicle_id = "v1";
    config.domain = test_domain();
    config.period_ns = 20 * kMillisecond;
    config.shared_memory = false;
  }
  void start(std::function<bool(SaveResult&)> saved) {
    static constexpr std::array kModes{""};
    publisher.emplace(config, Logic{}, Vocabulary{.modes = kModes, .modules = {}, .strategies = {}},
                      "{}");
    ASSERT_TRUE(publisher->open([](const Request&, std::uint64_t) {}));
    publisher->start(threads, {.newest_telemetry = [] { return nullptr; },
                               .telemetry_missed = [] { return 0; },
                               .commands_refused = [] { return 0; },
                               .log_event = [](EventId&) { return false; },
                               .log_dropped = [] { return 0; },
                               .recording = [] { return false; },
                               .parameters_saved = std::move(saved)});
  }
  config::Config config;
  const Publisher::Threads threads;
  std::optional<Publisher> publisher;
};

// A client knows by the newest status which event is the last one.
TEST(Publisher, TheStatusCountsAFailureToSaveAtOnce) {
  std::atomic<bool> fails = false;
  Running running;
  running.start([&](SaveResult& result) {
    result.error = 27;
    return fails.exchange(false);
  });
  Client client(test_domain(), "v1");
  // The next one would be due a second after this.
  ASSERT_TRUE(eventually([&] { return client.connected() && client.statuses().size() > 1; }));
  fails = true;
  running.publisher->wake();
  const auto failure = [&]() -> const lss_Event* {
    const auto found = std::ranges::find_if(client.events(), [](const lss_Event& e) {
      return e.id == static_cast<std::uint16_t>(EventId::parameters_not_saved);
    });
    return found == client.events().end() ? nullptr : &*found;
  };
  ASSERT_TRUE(eventually([&] { return failure() != nullptr; }));
  const lss_Event event = *failure();
  const auto counts = [&](const lss_Status& s) { return s.events >= event.index; };
  ASSERT_TRUE(eventually([&] { return std::ranges::any_of(client.statuses(), counts); }));
  const lss_Status status = *std::ranges::find_if(client.statuses(), counts);
  EXPECT_LT(status.time_ns - event.time_ns, kSecond / 2);
  running.publisher->stop();
}

// Each heartbeat goes to every daemon of the domain, and a status to every client.
TEST(Publisher, AtRestAHeartbeatIsSentOnceASecondAndTheStatusEveryEight) {
  Running running;
  running.start([](SaveResult&) { return false; });
  Client client(test_domain(), "v1");
  // Of a new daemon more come, for five seconds.
  ASSERT_TRUE(eventually([&] {
    return !client.statuses().empty() &&
           client.statuses().back().time_ns - client.statuses().front().time_ns >= 5 * kSecond;
  }));
  const std::uint64_t first = client.heartbeats().back().counter;
  const std::size_t statuses = client.statuses().size();
  ASSERT_TRUE(eventually([&] { return client.statuses().size() > statuses; }));
  const TimeNs after_ns =
      client.statuses().back().time_ns - client.statuses()[statuses - 1].time_ns;
  EXPECT_GE(after_ns, StatusPace::kAtRest);
  EXPECT_LE(client.heartbeats().back().counter - first,
            static_cast<std::uint64_t>(after_ns / kSecond) + 1);
  running.publisher->answer({}, {});
  ASSERT_TRUE(eventually([&] { return client.statuses().size() > statuses + 1; }));
  EXPECT_LT(client.statuses().back().time_ns - client.statuses()[statuses].time_ns, 3 * kSecond);
  running.publisher->stop();
}

}  // namespace
}  // namespace lss
