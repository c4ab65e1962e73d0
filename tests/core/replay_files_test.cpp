// lssd --replay on files from others, with every checksum right: each is refused or replayed, and
// the program goes on. Real recordings: tests/campaign/replay_test.cpp.
#include "daemon/replay/replay_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <charconv>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>

#include "daemon/record/limits.h"
#include "daemon/record/recording.h"
#include "daemon/replay/records.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/recording/record_layout.h"

namespace lss::record {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;
using Json = nlohmann::ordered_json;
using testing::HasSubstr;

struct ToReplay {
  Item kind = Item::frame;
  Bytes bytes{};
};

class HostileReplay : public testing::Test {
 protected:
  static Json header(const std::string& vehicle) {
    const auto records = vehicle_records(vehicle);
    return {
        {"lss", "recording"},
        {"vehicle", vehicle},
        {"start", true},
        {"config", fmt::format("vehicle = '{}'\n[[port]]\nname = 'a'\npath = 'sim:a'\n", vehicle)},
        {"state_layout", records->state_layout()},
        {"schema", records->schema()}};
  }
  fs::path path() const { return folder_ / "v-1-000001-x.lssrec"; }
  void write(const Json& header, const std::vector<ToReplay>& items) {
    fs::remove(path());
    RecordingWriter writer;
    EXPECT_EQ(writer.begin(path(), header, 0), 0);
    for (const ToReplay& item : items) writer.add(item.kind, item.bytes);
    EXPECT_EQ(writer.end(), 0);
    said_.clear();
  }
  Replayed replay(const Json& header, const std::vector<ToReplay>& items) {
    write(header, items);
    return replay_files({path()}, [this](const std::string& line) { said_ += line; });
  }
  // As replay(), but in this process, so that a sanitizer sees it.
  Replayed replay_here(const Json& header, const std::vector<ToReplay>& items) {
    write(header, items);
    return replay_file(path(), [this](const std::string& line) { said_ += line; });
  }
  static std::vector<std::string> built() {
    std::vector<std::string> names;
    for (const char* name : {"zebro", "ardito", "talaris"})
      if (vehicle_records(name)) names.emplace_back(name);
    return names;
  }

  const testing_support::TempFolder folder_;
  std::string said_;
};

TEST_F(HostileReplay, HeadersOfOtherTypesAreRefused) {
  const std::string vehicle = built().front();
  for (const char* name :
       {"utc_ns", "start", "vehicle", "build", "config", "parameters", "schema"}) {
    Json bad = header(vehicle);
    bad[name] = Json::array({1});
    EXPECT_EQ(replay_here(bad, {}), Replayed::unreadable) << name;
    EXPECT_THAT(said_, HasSubstr(fmt::format("a header in which {} is not", name)));
  }
}

TEST_F(HostileReplay, AConfigurationThatIsTooLargeIsRefused) {
  const std::string vehicle = built().front();
  Json bad = header(vehicle);
  bad["config"] = fmt::format("vehicle = '{}'\n[[port]]\nname = 'a'\npath = '/dev/{}'\n", vehicle,
                              std::string(200'000, 'x'));
  EXPECT_EQ(replay_here(bad, {}), Replayed::foreign);
  EXPECT_THAT(said_, HasSubstr("at most 1000 are read"));
  std::string key = "a";
  for (int i = 0; i < 50'000; ++i) key += ".a";
  bad["config"] = key + " = 1\n";
  EXPECT_EQ(replay_here(bad, {}), Replayed::foreign);
  EXPECT_THAT(said_, HasSubstr("has a key of more than 16 parts"));
}

// The limits are for foreign files: those of lssd are far below.
TEST_F(HostileReplay, RecordsOfVehiclesAreFarBelowTheLimits) {
  for (const std::string& vehicle : built()) {
    const auto records = vehicle_records(vehicle);
    const std::string schema = records->schema();
    EXPECT_LT(schema.size() * 10, most::kSchemaBytes) << vehicle;
    EXPECT_LT(cli::recording::parse_schema(schema)->fields * 5, most::kFields) << vehicle;
    cli::recording::RecordLayout layout(schema);
    EXPECT_GT(layout.columns().size(), 100u) << vehicle;
  }
}

// Inputs that no bus gives: numbers of modules, times and counts that are not.
TEST_F(HostileReplay, AnyFrameIsExecutedOrRefused) {
  std::mt19937 random(20'301'103);
  const auto begin = std::chrono::steady_clock::now();
  for (const std::string& vehicle : built()) {
    const Json good = header(vehicle);
    for (int i = 0; i < 100; ++i) {
      Bytes frame(8'000, 0);
      if (i % 3 != 0) {
        frame[16] = static_cast<std::uint8_t>(1 + random() % 4);  // samples
        for (int k = 0; k < 40; ++k)
          frame[20 + random() % 200] = static_cast<std::uint8_t>(random());
      } else {
        for (int k = 0; k < 10; ++k)
          frame[random() % frame.size()] = static_cast<std::uint8_t>(random());
      }
      const Replayed result = replay_here(good, {{Item::frame, frame}});
      ASSERT_TRUE(result == Replayed::different || result == Replayed::equal) << said_;
    }
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(took.count(), 120);
}

// As many bytes as the vehicle remembers, and other ones.
TEST_F(HostileReplay, AnyMemoryIsExecutedOrRefused) {
#ifdef LSS_SANITIZED
  GTEST_SKIP() << "a sanitizer ends the process that executes such memory, by a code of its own";
#endif
  std::mt19937 random(20'301'104);
  for (const std::string& vehicle : built()) {
    Json middle = header(vehicle);
    middle["start"] = false;
    std::size_t size = 0;
    const std::string layout = middle["state_layout"];
    for (const char* at = layout.data(); at < layout.data() + layout.size();) {
      std::size_t member = 0;
      const auto [end, error] = std::from_chars(at, layout.data() + layout.size(), member);
      size += error == std::errc{} ? member : 0;
      at = error == std::errc{} ? end : at + 1;
    }
    for (int i = 0; i < 20; ++i) {
      Bytes memory(size, static_cast<std::uint8_t>(i == 0 ? 0xff : 0));
      if (i > 0)
        for (std::uint8_t& byte : memory) byte = static_cast<std::uint8_t>(random());
      const Replayed result =
          replay(middle, {{Item::state, memory}, {Item::frame, Bytes(8'000, 0)}});
      ASSERT_TRUE(result == Replayed::different || result == Replayed::damaged) << said_;
    }
  }
}

TEST_F(HostileReplay, WhatEndsTheProcessIsRefused) {
  const auto print = [this](const std::string& line) { said_ += line; };
  const auto ends = [] {
    std::signal(SIGTERM, SIG_DFL);
    std::raise(SIGTERM);
    return Replayed::equal;
  };
  EXPECT_EQ(apart(ends, print), Replayed::damaged);
  EXPECT_THAT(said_, HasSubstr("refused: executing it ended with signal 15"));
  EXPECT_EQ(apart([] { return Replayed::incomplete; }, print), Replayed::incomplete);
}

}  // namespace
}  // namespace lss::record
