// The publish thread with its DDS face, over loopback.

#include "daemon/publish/publisher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "tests/dds/dds_support.h"

namespace lss {
namespace {

using namespace testing_support;

// A client knows by the newest status which event is the last one.
TEST(Publisher, TheStatusCountsAFailureToSaveAtOnce) {
  config::Config config;
  config.vehicle = "zebro";
  config.vehicle_id = "v1";
  config.domain = test_domain();
  config.period_ns = 20 * kMillisecond;
  config.shared_memory = false;
  const Publisher::Threads threads;
  std::atomic<bool> fails = false;
  constexpr std::array kModes{""};
  Publisher publisher(config, Logic{}, Vocabulary{.modes = kModes, .modules = {}, .strategies = {}},
                      "{}");
  ASSERT_TRUE(publisher.open([](const Request&, std::uint64_t) {}));
  publisher.start(threads, {.newest_telemetry = [] { return nullptr; },
                            .telemetry_missed = [] { return 0; },
                            .commands_refused = [] { return 0; },
                            .log_event = [](EventId&) { return false; },
                            .log_dropped = [] { return 0; },
                            .recording = [] { return false; },
                            .parameters_saved =
                                [&](SaveResult& result) {
                                  result.error = 27;
                                  return fails.exchange(false);
                                }});
  Client client(test_domain(), "v1");
  // The next one would be due a second after this.
  ASSERT_TRUE(eventually([&] { return client.connected() && client.statuses().size() > 1; }));
  fails = true;
  publisher.wake();
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
  publisher.stop();
}

}  // namespace
}  // namespace lss
