// The log thread on a folder of its own. Records are a number each; their content is the vehicles'
// matter.
#include "daemon/record/frame_log.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>

#include "drivers/file.h"
#include "tests/support/temp_folder.h"

namespace lss::record {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

class FrameLogTest : public testing::Test {
 protected:
  FrameLogSettings settings(std::size_t files = 32) const {
    return {.folder = folder_, .files = files, .vehicle_id = "v-1", .header = {{"vehicle", "v"}}};
  }
  static nlohmann::ordered_json to_json(std::span<const std::uint8_t> bytes) {
    std::uint32_t number = 0;
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  static void put(FrameLog& log, std::uint32_t number, FaultId fault = FaultId::none) {
    std::array<std::uint8_t, sizeof number> bytes;
    std::memcpy(bytes.data(), &number, sizeof number);
    log.put({.fault = fault}, bytes);
  }
  // As long as the log thread did not take them, records are in the ring: stop() empties it.
  static std::vector<nlohmann::json> lines(const fs::path& path) {
    std::ifstream file(path);
    std::vector<nlohmann::json> all;
    for (std::string line; std::getline(file, line);) all.push_back(nlohmann::json::parse(line));
    return all;
  }
  static std::vector<EventId> told(FrameLog& log) {
    std::vector<EventId> events;
    for (EventId event; log.pop(event);) events.push_back(event);
    return events;
  }

  const testing_support::TempFolder folder_;
};

TEST_F(FrameLogTest, KeepsTheLastFramesOfAFaultOldestFirst) {
  FrameLog log(settings(), to_json);
  log.start();
  for (std::uint32_t i = 1; i < 100; ++i) put(log, i);
  put(log, 100, FaultId::port_lost);
  log.stop();
  ASSERT_EQ(folder_.files().size(), 1u);
  EXPECT_THAT(folder_.files()[0].filename().string(),
              testing::MatchesRegex("v-1-000001-.*Z-port_lost.crash.jsonl"));
  const auto all = lines(folder_.files()[0]);
  ASSERT_EQ(all.size(), 1 + FrameLog::kFrames);
  EXPECT_EQ(all[0]["vehicle"], "v");
  EXPECT_EQ(all[0]["frames"], FrameLog::kFrames);
  EXPECT_EQ(all[1], 37);
  EXPECT_EQ(all.back(), 100);
  EXPECT_THAT(told(log), ElementsAre(EventId::frames_kept));
}

TEST_F(FrameLogTest, WithoutAFaultNothingIsWritten) {
  FrameLog log(settings(), to_json);
  log.start();
  for (std::uint32_t i = 1; i < 300; ++i) put(log, i);
  log.stop();
  EXPECT_TRUE(folder_.files().empty());
}

TEST_F(FrameLogTest, AStormOfFaultsLosesNoFrameAndWritesNoneTwice) {
  FrameLog log(settings(), to_json);
  log.start();
  for (std::uint32_t i = 1; i <= 200; ++i) put(log, i, FaultId::bus_noise);
  log.stop();
  std::vector<int> frames;
  for (const fs::path& file : folder_.files()) {
    const auto all = lines(file);
    for (std::size_t i = 1; i < all.size(); ++i) frames.push_back(all[i]);
  }
  std::ranges::sort(frames);
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  EXPECT_EQ(frames.size(), 200u);
  EXPECT_LE(folder_.files().size(), 5u);
}

TEST_F(FrameLogTest, TheNewestFilesAreKeptAndTheFirstSinceTheStart) {
  const auto touch = [&](const char* name) { std::ofstream(folder_ / name) << "old\n"; };
  touch("v-1-000007-20300101T000000Z-port_lost.crash.jsonl");  // the clock was ahead then
  touch("v-1-000008-20300101T000000Z-port_lost.crash.jsonl.part");
  touch("v-1-2-000009-20300101T000000Z-port_lost.crash.jsonl");  // vehicle v-1-2
  FrameLog log(settings(3), to_json);
  log.start();
  for (std::uint32_t i = 1; i <= 64 * 6; ++i) put(log, i, FaultId::bus_noise);
  log.stop();
  std::vector<std::string> names;
  for (const fs::path& file : folder_.files())
    names.push_back(file.filename().string().substr(0, 11));
  EXPECT_THAT(names, ElementsAre("v-1-000008-", "v-1-000013-", "v-1-000014-", "v-1-2-00000"));
  EXPECT_EQ(lines(folder_.files()[0]).back(), 1) << "the one that began it";
  EXPECT_EQ(lines(folder_.files()[2]).back(), 64 * 6);
}

TEST_F(FrameLogTest, APartialFileThatAnotherDaemonWritesStays) {
  const fs::path part = folder_ / "v-1-000008-20300101T000000Z-port_lost.crash.jsonl.part";
  const auto start = [&] {
    FrameLog log(settings(), to_json);
    log.start();
    log.stop();
  };
  std::optional<File> other(std::in_place, ::open(part.c_str(), O_WRONLY | O_CREAT, 0644));
  ASSERT_TRUE(*other);
  mark_being_written(other->get());
  start();
  EXPECT_TRUE(fs::exists(part));
  other.reset();
  start();
  EXPECT_FALSE(fs::exists(part)) << "its daemon was killed";
}

TEST_F(FrameLogTest, ASecondFaultIsWrittenAlsoWhenFramesEndAfterIt) {
  FrameLog log(settings(), to_json);
  log.start();
  put(log, 1, FaultId::bus_noise);
  put(log, 2, FaultId::port_lost);
  while (folder_.files().size() < 2 || folder_.files()[1].extension() == ".part")
    std::this_thread::yield();
  EXPECT_THAT(folder_.files()[1].string(), testing::HasSubstr("port_lost"));
  log.stop();
}

TEST_F(FrameLogTest, FramesAreKeptWhenTheFrameThreadStandsStill) {
  FrameLog log(settings(), to_json);
  log.start();
  for (std::uint32_t i = 1; i <= 10; ++i) put(log, i);
  while (log.turns() < 2) std::this_thread::yield();
  log.keep();
  while (folder_.files().empty() || folder_.files()[0].extension() == ".part")
    std::this_thread::yield();
  EXPECT_EQ(lines(folder_.files()[0]).back(), 10);
}

TEST_F(FrameLogTest, TextThatIsNoUtf8IsWrittenToo) {
  FrameLog log(settings(), [](std::span<const std::uint8_t>) {
    return nlohmann::ordered_json{{"source", "\xff\xfe"}};
  });
  log.start();
  put(log, 1, FaultId::emergency_stop);
  log.stop();
  ASSERT_EQ(folder_.files().size(), 1u);
  EXPECT_EQ(lines(folder_.files()[0]).size(), 2u);
}

TEST_F(FrameLogTest, AFullDiskIsReportedOnceAndLeavesNoHalfFile) {
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit tiny{16, limit.rlim_max};
  FrameLog log(settings(), to_json);
  ::setrlimit(RLIMIT_FSIZE, &tiny);
  log.start();
  for (std::uint32_t i = 1; i <= 64 * 3; ++i) put(log, i, FaultId::bus_noise);
  log.stop();
  ::setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, before);
  EXPECT_TRUE(folder_.files().empty());
  EXPECT_THAT(told(log), ElementsAre(EventId::log_failed));
}

TEST_F(FrameLogTest, FramesThatTheLogMissedAreReportedOnceAndCountedWhereTheyAreMissing) {
  FrameLogSettings with_log = settings();
  with_log.presets = {{.name = "all", .what = config::kAllLogParts, .every_ns = 0}};
  FrameLog log(with_log, [](std::span<const std::uint8_t> bytes) {
    nlohmann::ordered_json json = {{"in", {{"frame", to_json(bytes)}}}};
    for (const char* part : {"command", "outbox", "state", "telemetry", "timing"}) json[part] = 0;
    return json;
  });
  std::vector<std::uint8_t> record(10'000);
  const auto fill = [&](std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t number = from; number <= to; ++number) {
      std::memcpy(record.data(), &number, sizeof number);
      log.put({}, record);
    }
  };
  fill(1, 60);  // the thread does not run yet
  const auto missing = static_cast<std::uint32_t>(log.dropped());
  log.start();
  while (log.turns() < 1) std::this_thread::yield();
  fill(61, 70);
  log.stop();
  ASSERT_EQ(folder_.files().size(), 1u);
  const auto all = lines(folder_.files()[0]);
  ASSERT_EQ(all.size(), 1 + 70 - missing);
  ASSERT_GT(missing, 0u);
  EXPECT_EQ(all[60 - missing]["frame"], 60 - missing);
  EXPECT_FALSE(all[60 - missing].contains("lost_frames"));
  EXPECT_EQ(all[61 - missing]["frame"], 61);
  EXPECT_EQ(all[61 - missing]["lost_frames"], missing);
  EXPECT_FALSE(all[62 - missing].contains("lost_frames"));
  EXPECT_THAT(told(log), ElementsAre(EventId::log_lost));
}

TEST_F(FrameLogTest, ALogThatIsNotEmptiedDropsAndCounts) {
  FrameLog log(settings(), to_json);  // never started
  const std::vector<std::uint8_t> record(10'000);
  for (int i = 0; i < 100; ++i) log.put({}, record);
  EXPECT_EQ(log.dropped(), 100u - (1u << 19) / 10'032);
}

}  // namespace
}  // namespace lss::record
