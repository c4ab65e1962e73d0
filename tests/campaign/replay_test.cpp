// Flight recordings of the campaigns' runs, with faults, commands out of place and error solving:
// executed again to the bit by the shipping replay, each file alone, and all but the first of a run
// begin in its middle, with the vehicle's stored state there. An altered build does not give the
// same.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>

#include "daemon/record/recording.h"
#include "daemon/replay/cycle_cost.h"
#include "daemon/replay/records.h"
#include "daemon/replay/replay_files.h"
#include "tests/campaign/campaign.h"
#include "tests/support/everything.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/recording/flight.h"

namespace lss::campaign {
namespace {

namespace fs = std::filesystem;
using cli::recording::Flight;
using record::Replayed;
using testing::HasSubstr;

class Folder : public testing_support::TempFolder {
 public:
  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(*this)) found.push_back(entry.path());
    std::ranges::sort(found);
    return found;
  }
};

const Subject& subject(const std::string& vehicle) {
  return *std::ranges::find(subjects(), vehicle, &Subject::vehicle);
}
bool is_built(const std::string& vehicle) {
  return std::ranges::find(subjects(), vehicle, &Subject::vehicle) != subjects().end();
}

constexpr std::size_t kSample = 5;

// Some scenarios of a vehicle, of which a sample runs.
struct Batch {
  const char* vehicle;
  unsigned first, count;

  friend void PrintTo(const Batch& batch, std::ostream* to) {
    *to << batch.vehicle << " " << batch.first << " to " << batch.first + batch.count - 1;
  }
};

class CampaignReplay : public testing::TestWithParam<Batch> {};

TEST_P(CampaignReplay, IsEqualToTheBitAlsoFromTheMiddle) {
  const Batch& batch = GetParam();
  if (!is_built(batch.vehicle)) GTEST_SKIP() << "not of this build";
  std::uint64_t frames = 0, middles = 0, faults = 0;
  double covered_s = 0, took_s = 0;
  unsigned runs = 0;
  for (unsigned number = batch.first; number < batch.first + batch.count; ++number) {
    // Each tenth has rigid bodies and takes longest: not all of them in one sample.
    if (!testing_support::in_sample(number + number / 10, kSample)) continue;
    ++runs;
    SCOPED_TRACE(fmt::format("{} {}", batch.vehicle, number));
    const Folder folder;
    const campaign::Run run = subject(batch.vehicle).record(number, folder);
    faults += run.faults;
    std::uint64_t recorded = 0;
    for (const fs::path& path : folder.files()) {
      const Flight flight(path.string());
      EXPECT_STREQ(flight.end_name(), "ended");
      recorded += flight.frames();
      covered_s += flight.duration_s();
      if (!flight.header().at("start").get<bool>()) ++middles;
      std::string said;
      const auto begin = std::chrono::steady_clock::now();
      const Replayed replayed =
          record::replay_file(path, [&](const std::string& line) { said += line; });
      took_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      EXPECT_EQ(replayed, Replayed::equal) << said;
    }
    EXPECT_EQ(recorded, run.cycles) << "every frame is in a file";
    frames += recorded;
  }
  std::cout << fmt::format(
      "{}: {} runs with {} faults, {} frames, {:.0f} s, {} files from the middle; replayed {:.0f} "
      "times as fast\n",
      batch.vehicle, runs, faults, frames, covered_s, middles, covered_s / took_s);
  EXPECT_GE(faults, runs);
  EXPECT_GE(middles, runs);
}

INSTANTIATE_TEST_SUITE_P(Vehicles, CampaignReplay,
                         testing::Values(Batch{"zebro", 1, 20}, Batch{"zebro", 21, 20},
                                         Batch{"talaris", 1, 20}, Batch{"talaris", 21, 20},
                                         Batch{"ardito", 1, 20}, Batch{"ardito", 21, 20}),
                         [](const auto& batch) {
                           return fmt::format("{}_from_{}", batch.param.vehicle, batch.param.first);
                         });

class CampaignRecording : public testing::TestWithParam<const char*> {
 protected:
  struct Ended {
    int code = -1;
    std::string out;
  };
  static Ended run(std::string command, const std::vector<fs::path>& paths) {
    Ended ended;
    for (const fs::path& path : paths) command += " '" + path.string() + "'";
    std::FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return ended;
    char some[4096];
    while (const std::size_t got = std::fread(some, 1, sizeof some, pipe))
      ended.out.append(some, got);
    const int status = ::pclose(pipe);
    ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return ended;
  }
};

// tests/altered has another number in one place for each vehicle.
TEST_P(CampaignRecording, DiffersFromTheReplayOfAnAlteredBuild) {
  if (!is_built(GetParam())) GTEST_SKIP() << "not of this build";
  const Folder folder;
  subject(GetParam()).record(1, folder);
  const Ended same = run(LSSD " --replay", folder.files());
  EXPECT_EQ(same.code, static_cast<int>(Replayed::equal)) << same.out;
  EXPECT_THAT(same.out, HasSubstr("every bit of every output"));
  const Ended altered = run(LSS_ALTERED, folder.files());
  EXPECT_EQ(altered.code, static_cast<int>(Replayed::different)) << altered.out;
  EXPECT_THAT(altered.out, testing::ContainsRegex("field +(command|telemetry)\\."));
  std::cout << altered.out;
}

// lss-cli reads records by the description in their file; the daemon by its own structs.
TEST_P(CampaignRecording, IsReadByItsDescriptionAsByTheStructs) {
  if (!is_built(GetParam())) GTEST_SKIP() << "not of this build";
  const Folder folder;
  subject(GetParam()).record(2, folder);
  const auto records = vehicle_records(GetParam());
  std::uint64_t frames = 0, events = 0;
  for (const fs::path& path : folder.files()) {
    Flight flight(path.string());
    flight.layout().name_codes(own_codes);  // as lss-cli does by the vehicle's name
    flight.each({}, [&](const Flight::Frame& frame) {
      const auto ours = flight.layout().json(frame.record);
      const std::size_t told = ours.at("outbox").at("events").size();
      events += told;
      if (++frames % 7 != 0 && told == 0) return;
      ASSERT_EQ(ours.dump(), records->to_json(frame.record).dump());
    });
  }
  EXPECT_GT(frames, 100u);
  EXPECT_GT(events, 0u);
}

INSTANTIATE_TEST_SUITE_P(Vehicles, CampaignRecording, testing::Values("zebro", "ardito", "talaris"),
                         [](const auto& which) { return std::string(which.param); });

// What timing certify counts, of the first frames of a recording.
TEST(CycleCost, OfTheLongestFrameIsTheSameInEachRun) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer makes ten instructions of one, each of them a step";
#endif
  const Folder whole, begin;
  subjects().front().record(1, whole);
  constexpr std::size_t kFrames = 3;
  const fs::path path = begin / "begin.lssrec";
  {
    auto from = record::RecordingReader::open(whole.files().front());
    ASSERT_TRUE(from) << from.error();
    record::RecordingWriter to;
    ASSERT_EQ(to.begin(path, from->header(), 0), 0);
    record::Item kind;
    std::span<const std::uint8_t> bytes;
    while (to.so_far().frames < kFrames && from->next(kind, bytes)) {
      if (kind == record::Item::frame) to.add_frame(bytes, 0);
      if (kind != record::Item::frame) to.add(kind, bytes);
    }
    ASSERT_EQ(to.end(), 0);
  }
  const auto all = record::cycle_cost(path, kFrames);
  ASSERT_TRUE(all) << all.error();
  EXPECT_EQ(all->frames, kFrames);
  EXPECT_EQ(all->counted, kFrames);
  EXPECT_GT(all->instructions, 1000u);
  EXPECT_GT(all->ns_per_instruction, 0);
  const auto again = record::cycle_cost(path, 2 * kFrames);
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->instructions, all->instructions);
  EXPECT_EQ(again->frame, all->frame);
  const auto one = record::cycle_cost(path, 1);
  ASSERT_TRUE(one) << one.error();
  EXPECT_EQ(one->counted, 1u);
  EXPECT_LE(one->instructions, all->instructions);
  std::cout << fmt::format("{} instructions in frame {}, {:.2f} ns each\n", all->instructions,
                           all->frame, all->ns_per_instruction);
  EXPECT_THAT(record::cycle_cost(begin / "none.lssrec", 1).error(), HasSubstr("none.lssrec"));
}

}  // namespace
}  // namespace lss::campaign
