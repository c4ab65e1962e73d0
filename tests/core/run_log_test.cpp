// The log that runs, on a folder and sockets of its own; time is data. Records are a number each.
#include "daemon/record/run_log.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <rapidcheck.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>

#include "tests/support/temp_folder.h"

namespace lss::record {
namespace {

namespace fs = std::filesystem;
using config::bit;
using config::LogPart;
using config::LogPreset;
using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::json;

constexpr TimeNs kFrame = 20 * kMillisecond;
constexpr TimeNs kBegin = 1000 * kSecond;

class RunLogTest : public testing::Test {
 protected:
  LogPreset everything() const {
    return {.name = "all",
            .what = config::kAllLogParts,
            .every_ns = 0,
            .file_bytes = 10'000,
            .total_bytes = 50'000};
  }
  std::unique_ptr<RunLog> begin(const LogPreset& preset) {
    const auto to_json = [this](std::span<const std::uint8_t> bytes) {
      std::uint32_t number = 0;
      std::memcpy(&number, bytes.data(), sizeof number);
      if (number == bad_) throw std::runtime_error("out of memory");
      nlohmann::ordered_json json = {{"in", {{"frame", number}}}};
      for (const char* part : {"command", "outbox", "state", "timing"}) json[part] = number;
      json["telemetry"] = std::string(length_, 'x');
      return json;
    };
    return std::make_unique<RunLog>(preset, folder_, "v-1",
                                    nlohmann::ordered_json{{"vehicle", "v"}}, to_json,
                                    [this](EventId id) { told_.push_back(id); });
  }
  // Everything, to who listens there.
  std::unique_ptr<RunLog> begin_at(const std::string& address) {
    LogPreset preset = everything();
    preset.address = address;
    return begin(preset);
  }
  // Frame `number` at its time.
  void put(RunLog& log, std::uint32_t number, bool events = false, std::uint64_t dropped = 0) {
    std::array<std::uint8_t, sizeof number> bytes;
    std::memcpy(bytes.data(), &number, sizeof number);
    const TimeNs time_ns = kBegin + number * kFrame;
    log.put({.events = events, .time_ns = time_ns}, bytes, dropped, time_ns);
  }
  std::vector<fs::path> files(const std::string& suffix = LogFiles::kSuffix) const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder_))
      if (entry.path().string().ends_with(suffix)) found.push_back(entry.path());
    std::ranges::sort(found);
    return found;
  }
  static std::vector<Json> lines(const fs::path& path) {
    std::ifstream file(path);
    std::vector<Json> all;
    for (std::string line; std::getline(file, line);) all.push_back(Json::parse(line));
    return all;
  }
  // The numbers of all frames in all files, without the first lines.
  std::vector<std::uint32_t> frames() const {
    std::vector<std::uint32_t> numbers;
    for (const fs::path& file : files()) {
      const auto all = lines(file);
      for (std::size_t i = 1; i < all.size(); ++i) numbers.push_back(all[i]["frame"]);
    }
    return numbers;
  }
  std::uint64_t total() const {
    std::uint64_t sum = 0;
    for (const fs::path& file : files()) sum += fs::file_size(file);
    return sum;
  }

  const testing_support::TempFolder folder_;
  std::uint32_t bad_ = 0;
  std::size_t length_ = 10;
  std::vector<EventId> told_;
};

std::vector<std::uint32_t> numbers(std::uint32_t from, std::uint32_t to) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = from; i <= to; ++i) all.push_back(i);
  return all;
}

// Files may not exceed `bytes`, as on a full disk.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : ignored_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit tiny{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &tiny);
  }
  ~FileLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, ignored_);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  void (*ignored_)(int);
  rlimit before_{};
};

TEST_F(RunLogTest, ContainsAHeaderAndTheChosenPartsAtTheirPeriod) {
  const auto log = begin({.name = "mine",
                          .what = bit(LogPart::state) | bit(LogPart::telemetry),
                          .every_ns = 100 * kMillisecond});
  for (const std::uint32_t i : numbers(1, 20)) put(*log, i, true);
  ASSERT_EQ(files().size(), 1u);
  EXPECT_THAT(files()[0].filename().string(),
              testing::MatchesRegex("v-1-000001-.*Z-mine.log.jsonl"));
  const auto all = lines(files()[0]);
  EXPECT_EQ(all[0]["lss"], "log");
  EXPECT_EQ(all[0]["vehicle"], "v");
  EXPECT_EQ(all[0]["preset"], "mine");
  EXPECT_EQ(all[0]["what"], (Json{"state", "telemetry"}));
  EXPECT_EQ(all[0]["every_ms"], 100);
  EXPECT_THAT(frames(), ElementsAre(1, 5, 10, 15, 20));  // whole tenths of a second
  std::vector<std::string> keys;
  for (const auto& [key, value] : all[1].items()) keys.push_back(key);
  EXPECT_THAT(keys, ElementsAre("frame", "state", "telemetry", "time_ns", "utc_ns"));
  EXPECT_EQ(all[2]["time_ns"], kBegin + 5 * kFrame);
}

TEST_F(RunLogTest, EventsAreWrittenWhenTheyHappenWithAnyPeriod) {
  const auto log = begin({.name = "mine",
                          .what = bit(LogPart::state) | bit(LogPart::events),
                          .every_ns = 3600 * kSecond});
  for (const std::uint32_t i : numbers(1, 50)) put(*log, i, i == 7 || i == 8);
  EXPECT_THAT(frames(), ElementsAre(1, 7, 8));
  const auto all = lines(files()[0]);
  EXPECT_FALSE(all[1].contains("outbox"));
  EXPECT_EQ(all[2]["outbox"], 7);
  EXPECT_FALSE(all[2].contains("state"));
}

TEST_F(RunLogTest, WithoutEventsAPresetOfEventsWritesNoFile) {
  const auto log = begin({.name = "quiet", .what = bit(LogPart::events)});
  for (const std::uint32_t i : numbers(1, 50)) put(*log, i);
  EXPECT_TRUE(files().empty());
}

TEST_F(RunLogTest, AFullFileIsFollowedByTheNextWithoutAGap) {
  const auto log = begin(everything());
  for (const std::uint32_t i : numbers(1, 150)) put(*log, i);
  EXPECT_GE(files().size(), 3u);
  for (const fs::path& file : files()) {
    EXPECT_LE(fs::file_size(file), everything().file_bytes);
    EXPECT_EQ(lines(file)[0]["lss"], "log");
  }
  EXPECT_EQ(frames(), numbers(1, 150));
}

TEST_F(RunLogTest, ALineLongerThanAFileHasAFileOfItsOwn) {
  const auto log = begin(everything());
  length_ = 20'000;
  put(*log, 1);
  put(*log, 2);
  EXPECT_EQ(files().size(), 2u);
  EXPECT_EQ(frames(), numbers(1, 2));
}

TEST_F(RunLogTest, AStartBeginsANewFileAfterTheNewestAlsoWithAClockThatWasSetBack) {
  std::ofstream(folder_ / "v-1-000041-20990101T000000Z-quiet.log.jsonl") << "{}\n";
  for (const std::uint32_t i : numbers(1, 2)) put(*begin(everything()), i);
  ASSERT_EQ(files().size(), 3u);
  EXPECT_THAT(files()[1].string(), HasSubstr("v-1-000042-"));
  EXPECT_THAT(files()[2].string(), HasSubstr("v-1-000043-"));
}

TEST_F(RunLogTest, TheOldestFilesOfThisVehicleGoAndNothingElse) {
  const auto touch = [&](const char* name) {
    std::ofstream(folder_ / name) << std::string(9000, 'x');
  };
  touch("v-1-000007-20300101T000000Z-quiet.log.jsonl");  // another preset: of this vehicle, too
  const std::vector<const char*> others = {"v-1-000001-20200101T000000Z-port_lost.crash.jsonl",
                                           "v-1-2-000001-20200101T000000Z-all.log.jsonl",
                                           "w-000001-20200101T000000Z-all.log.jsonl",
                                           "v-1-notes.log.jsonl", "v-1-000001.log.jsonl"};
  for (const char* name : others) touch(name);
  const auto log = begin(everything());
  for (const std::uint32_t i : numbers(1, 2000)) put(*log, i);
  for (const char* name : others) {
    EXPECT_EQ(fs::file_size(folder_ / name), 9000u) << name;
    fs::remove(folder_ / name);
  }
  EXPECT_LE(total(), everything().total_bytes);
  EXPECT_GE(total(), everything().total_bytes - 2 * everything().file_bytes);
  EXPECT_GT(frames().front(), 1u);
  EXPECT_EQ(frames(), numbers(frames().front(), 2000));
}

// Lines of any length: never more than the total, and the newest lines remain, all complete.
TEST_F(RunLogTest, LinesOfAnyLengthStayWithinTheTotal) {
  EXPECT_TRUE(rc::check([this](const std::vector<std::uint16_t>& lengths) {
    for (const fs::path& file : files()) fs::remove(file);
    const auto log = begin(everything());
    std::uint32_t number = 0;
    for (const std::uint16_t length : lengths) {
      length_ = length % 6000;
      put(*log, ++number);
      RC_ASSERT(total() <= everything().total_bytes);
    }
    const auto left = frames();
    if (number != 0) RC_ASSERT(!left.empty() && left == numbers(left.front(), number));
    RC_ASSERT(told_.empty());
  }));
}

TEST_F(RunLogTest, AFullDiskIsReportedOnceAndTheLogGoesOnWhenThereIsRoom) {
  const auto log = begin(everything());
  std::uint32_t i = 0;
  {
    const FileLimit full(16);  // not even the first line
    while (i < 400) put(*log, ++i);
    ASSERT_TRUE(files().empty());
    EXPECT_THAT(told_, ElementsAre(EventId::log_failed));
  }
  while (i < 600) put(*log, ++i);
  constexpr auto kTryAgain = static_cast<std::uint32_t>(LogFiles::kRetry / kFrame);
  EXPECT_EQ(frames(), numbers(1 + 2 * kTryAgain, 600));
  const auto all = lines(files()[0]);
  EXPECT_EQ(all[0]["lost_lines_since_start"], 2 * kTryAgain);
  EXPECT_EQ(all[1]["lost_lines"], 2 * kTryAgain);
  EXPECT_FALSE(all[2].contains("lost_lines"));
  EXPECT_THAT(told_, ElementsAre(EventId::log_failed));
}

TEST_F(RunLogTest, AFileThatCannotGrowEndsWithAWholeLine) {
  const auto log = begin(everything());
  {
    const FileLimit full(2000);
    for (const std::uint32_t i : numbers(1, 100)) put(*log, i);
  }
  put(*log, 1000);
  ASSERT_EQ(files().size(), 2u);
  const auto all = lines(files()[0]);  // throws at half a line
  EXPECT_GT(all.size(), 5u);
  EXPECT_LE(fs::file_size(files()[0]), 2000u);
  EXPECT_EQ(lines(files()[1])[1]["lost_lines"], 100 - (all.size() - 1));
}

TEST_F(RunLogTest, TroubleThatComesAndGoesIsReportedOnceAMinute) {
  const auto log = begin(everything());
  for (const std::uint32_t i : numbers(1, 6000)) {  // two minutes
    std::optional<FileLimit> full;
    if (i / 500 % 2 == 0) full.emplace(16);
    put(*log, i);
  }
  EXPECT_EQ(told_.size(), 2u);
}

// The status must not say that the log runs.
TEST_F(RunLogTest, TroubleThatIsNotReportedAgainIsTroubleStill) {
  const auto log = begin(everything());
  std::uint32_t i = 0;
  for (const std::uint32_t from : {0u, 600u}) {
    {
      const FileLimit full(16);
      while (i < from + 10) put(*log, ++i);
    }
    EXPECT_TRUE(log->in_trouble()) << from;
    while (i < from + 600) put(*log, ++i);  // 12 s
    EXPECT_FALSE(log->in_trouble()) << from;
  }
  EXPECT_THAT(told_, ElementsAre(EventId::log_failed)) << "once a minute";
}

TEST_F(RunLogTest, AFileThatAnotherDaemonWritesStays) {
  const auto slow = begin(everything());
  put(*slow, 1);
  const fs::path file = files().at(0);
  const auto fast = begin(everything());
  for (const std::uint32_t i : numbers(2, 2000)) put(*fast, i);
  put(*slow, 2001);
  EXPECT_EQ(lines(file).size(), 3u) << "the first line and both of its frames";
}

TEST_F(RunLogTest, AFileThatSomebodyRemovedIsBegunAgain) {
  const auto log = begin(everything());
  put(*log, 1);
  fs::remove(files().at(0));
  put(*log, 2);
  EXPECT_THAT(frames(), ElementsAre(2));
}

TEST_F(RunLogTest, AFolderThatComesLaterIsTaken) {
  fs::remove(folder_);
  const auto log = begin(everything());
  put(*log, 1);
  EXPECT_THAT(told_, ElementsAre(EventId::log_failed));
  fs::create_directory(folder_);
  put(*log, 1000);
  EXPECT_THAT(frames(), ElementsAre(1000));
}

TEST_F(RunLogTest, FramesThatNeverCameAreCountedInTheNextLine) {
  const auto log = begin(everything());
  put(*log, 1, false, 0);
  put(*log, 9, false, 7);
  put(*log, 10, false, 7);
  const auto all = lines(files().at(0));
  EXPECT_FALSE(all[1].contains("lost_frames"));
  EXPECT_EQ(all[2]["lost_frames"], 7);
  EXPECT_FALSE(all[3].contains("lost_frames"));
}

TEST_F(RunLogTest, AFrameThatCannotBeMadeALineOfIsLostAndCounted) {
  const auto log = begin(everything());
  bad_ = 2;
  for (const std::uint32_t i : numbers(1, 3)) put(*log, i);
  EXPECT_THAT(frames(), ElementsAre(1, 3));
  EXPECT_EQ(lines(files().at(0))[2]["lost_lines"], 1);
  EXPECT_THAT(told_, ElementsAre(EventId::log_failed));
}

// A socket that somebody listens on.
class Listener {
 public:
  explicit Listener(const fs::path& path) : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    bind(address);
  }
  Listener() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(address);
    socklen_t size = sizeof address;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { ::close(fd_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return port_; }
  // Lines received so far.
  std::vector<Json> heard() const {
    std::vector<Json> all;
    std::vector<char> bytes(100'000);
    for (ssize_t got; (got = ::recv(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT)) > 0;)
      all.push_back(Json::parse(bytes.data(), bytes.data() + got));
    return all;
  }

 private:
  template <class Address>
  void bind(const Address& address) {
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  int fd_, port_ = 0;
};

TEST_F(RunLogTest, WhoListensOnASocketMayComeLeaveAndComeBack) {
  const auto log = begin_at((folder_ / "socket").string());
  put(*log, 1);
  EXPECT_THAT(told_, ElementsAre(EventId::log_failed));
  {
    const Listener listener(folder_ / "socket");
    for (const std::uint32_t i : {101u, 102u}) put(*log, i);
    const auto all = listener.heard();
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0]["lss"], "log");
    EXPECT_EQ(all[1]["frame"], 101);
    EXPECT_EQ(all[1]["lost_lines"], 1);
    EXPECT_EQ(all[2]["frame"], 102);
  }
  put(*log, 103);
  fs::remove(folder_ / "socket");
  const Listener listener(folder_ / "socket");
  put(*log, 203);
  const auto all = listener.heard();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0]["lost_lines_since_start"], 2);
  EXPECT_EQ(all[1]["frame"], 203);
  EXPECT_TRUE(files().empty());
}

TEST_F(RunLogTest, TheFirstLineIsSentAgainForThoseWhoComeLate) {
  const Listener listener(folder_ / "socket");
  const auto log = begin_at((folder_ / "socket").string());
  std::size_t first_lines = 0;
  for (const std::uint32_t i : numbers(1, 1250)) {  // 25 s
    put(*log, i);
    for (const Json& line : listener.heard()) first_lines += line.contains("lss");
  }
  EXPECT_EQ(first_lines, 3u);
}

TEST_F(RunLogTest, WhoListensTooSlowlyLosesLinesThatAreCounted) {
  const Listener listener(folder_ / "socket");
  const auto log = begin_at((folder_ / "socket").string());
  length_ = 20'000;
  for (const std::uint32_t i : numbers(1, 400)) put(*log, i);  // returns, though nobody reads
  std::size_t heard = 0;
  for (const Json& line : listener.heard()) heard += line.contains("frame");
  EXPECT_GT(heard, 0u);
  EXPECT_LT(heard, 400u);
  put(*log, 401);
  EXPECT_EQ(listener.heard().back()["lost_lines"], 400 - heard);
  EXPECT_THAT(told_, ElementsAre(EventId::log_failed));
}

TEST_F(RunLogTest, LinesGoByUdpToo) {
  std::optional<Listener> listener(std::in_place);
  const auto log = begin_at("udp://127.0.0.1:" + std::to_string(listener->port()));
  for (const std::uint32_t i : numbers(1, 3)) put(*log, i);
  EXPECT_EQ(listener->heard().size(), 4u);
  listener.reset();
  put(*log, 4);  // not known yet
  put(*log, 5);
  EXPECT_THAT(told_, ElementsAre(EventId::log_failed));
}

TEST_F(RunLogTest, ALineThatIsTooLongForADatagramIsLostAndTheNextGoes) {
  const Listener listener;
  const auto log = begin_at("udp://127.0.0.1:" + std::to_string(listener.port()));
  length_ = 70'000;
  put(*log, 1);
  length_ = 10;
  put(*log, 2);
  EXPECT_EQ(listener.heard().back()["lost_lines"], 1);
}

}  // namespace
}  // namespace lss::record
