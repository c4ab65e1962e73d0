// The recorder on a folder of its own, called as the log thread calls it; time is data.
#include "daemon/record/recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace lss::record {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using End = RecordingReader::End;

class RecorderTest : public testing::Test {
 protected:
  std::unique_ptr<Recorder> recorder(std::uint64_t file = 100'000, std::uint64_t total = 400'000) {
    auto made = std::make_unique<Recorder>(RecorderSettings{.folder = folder_,
                                                            .vehicle_id = "v-1",
                                                            .name = "v",
                                                            .file_bytes = file,
                                                            .total_bytes = total,
                                                            .sync = false,
                                                            .header = {{"vehicle", "v"}}},
                                           [this](EventId id) { told_.push_back(id); });
    made->begin();
    return made;
  }
  // A frame of 1 kB, and the state when it is asked for, as the frame thread does.
  void frame(Recorder& recorder, std::uint64_t dropped = 0) {
    const std::vector<std::uint8_t> record(1000, static_cast<std::uint8_t>(++number_));
    now_ += 20 * kMillisecond;
    recorder.put_frame(record, now_, dropped, now_);
    if (recorder.wants_state()) recorder.put_state(std::vector<std::uint8_t>{7}, dropped, now_);
    recorder.turn(now_);
  }
  struct Read {
    nlohmann::ordered_json header;
    std::vector<Item> kinds{};
    std::vector<std::uint64_t> lost{};
    End end = End::none;
    std::size_t frames() const {
      return static_cast<std::size_t>(std::ranges::count(kinds, Item::frame));
    }
  };
  static Read read(const fs::path& path) {
    auto reader = RecordingReader::open(path);
    EXPECT_TRUE(reader) << reader.error();
    Read read{.header = reader->header()};
    Item kind;
    std::span<const std::uint8_t> bytes;
    while (reader->next(kind, bytes)) {
      read.kinds.push_back(kind);
      if (kind == Item::lost) {
        std::uint64_t lost = 0;
        std::memcpy(&lost, bytes.data(), sizeof lost);
        read.lost.push_back(lost);
      }
    }
    read.end = reader->end();
    return read;
  }

  const testing_support::TempFolder folder_;
  TimeNs now_ = 100 * kSecond;
  unsigned number_ = 0;
  std::vector<EventId> told_;
};

TEST_F(RecorderTest, AFileBeginsWithTheStartAndTheNextOnesWithAState) {
  auto recorder = this->recorder();
  for (int i = 0; i < 200; ++i) frame(*recorder);
  recorder->end();
  ASSERT_EQ(folder_.files().size(), 3u);
  std::size_t frames = 0;
  for (const fs::path& path : folder_.files()) {
    const Read file = read(path);
    EXPECT_EQ(file.end, End::whole);
    EXPECT_EQ(file.header["start"], frames == 0);
    EXPECT_EQ(file.header["lost_before"], 0);
    EXPECT_EQ(file.kinds.front(), frames == 0 ? Item::frame : Item::state);
    EXPECT_LE(fs::file_size(path), 100'000u);
    frames += file.frames();
  }
  EXPECT_EQ(frames, 200u) << "none is lost where a file ends";
  EXPECT_FALSE(recorder->in_trouble());
  EXPECT_THAT(told_, IsEmpty());
}

TEST_F(RecorderTest, ARunThatEndsWhereAFileDoesLeavesNoFileWithoutFrames) {
  auto recorder = this->recorder();
  int frames = 0;
  for (; folder_.files().size() < 2; ++frames) frame(*recorder);
  recorder->end();
  ASSERT_EQ(folder_.files().size(), 1u);
  EXPECT_EQ(read(folder_.files()[0]).frames(), static_cast<std::size_t>(frames));
}

TEST_F(RecorderTest, TheOldestFilesGoAndOthersAreNotTouched) {
  std::ofstream(folder_ / "notes.txt") << "mine";
  std::ofstream(folder_ / "v-10-000001-x.lssrec") << "of another vehicle";
  auto recorder = this->recorder();
  for (int i = 0; i < 1000; ++i) {
    frame(*recorder);
    std::uintmax_t total = 0;
    for (const fs::path& path : folder_.files())
      if (path.filename().string().starts_with("v-1-")) total += fs::file_size(path);
    ASSERT_LE(total, 400'000u);
  }
  recorder->end();
  const auto left = folder_.files();
  ASSERT_EQ(left.size(), 2u + 4u);
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
  EXPECT_TRUE(fs::exists(folder_ / "v-10-000001-x.lssrec"));
  EXPECT_GT(read(left[1]).header["file"], 1);
}

TEST_F(RecorderTest, AFileThatAnotherDaemonWritesStays) {
  const auto slow = recorder(100'000, 200'000);
  frame(*slow);
  const fs::path file = folder_.files().at(0);
  const auto fast = recorder(100'000, 200'000);
  for (int i = 0; i < 400; ++i) frame(*fast);
  ASSERT_TRUE(fs::exists(file)) << "although it is the oldest";
  frame(*slow);
  slow->end();
  EXPECT_EQ(read(file).frames(), 2u);
  for (int i = 0; i < 200; ++i) frame(*fast);
  EXPECT_FALSE(fs::exists(file)) << "nobody writes it any more";
  EXPECT_THAT(told_, IsEmpty());
}

TEST_F(RecorderTest, AGapIsSaidAndFollowedByAState) {
  auto recorder = this->recorder();
  frame(*recorder);
  frame(*recorder, 5);
  frame(*recorder, 5);
  recorder->end();
  const Read file = read(folder_.files().at(0));
  EXPECT_THAT(file.kinds,
              ElementsAre(Item::frame, Item::lost, Item::frame, Item::state, Item::frame));
  EXPECT_THAT(file.lost, ElementsAre(5));
}

TEST_F(RecorderTest, EachTurnLeavesAReadableFile) {
  auto recorder = this->recorder();
  for (int i = 0; i < 10; ++i) {
    frame(*recorder);
    const Read file = read(folder_.files().at(0));
    EXPECT_EQ(file.frames(), static_cast<std::size_t>(i + 1));
    EXPECT_EQ(file.end, End::open);
  }
}

TEST_F(RecorderTest, ATornTailIsCutAtTheNextStartAndReported) {
  {
    auto recorder = this->recorder();
    for (int i = 0; i < 5; ++i) frame(*recorder);
    fs::copy_file(folder_.files().at(0), folder_ / "copy");  // as it would be after kill -9
  }
  const fs::path path = folder_.files().at(1);
  fs::rename(folder_ / "copy", path);
  ASSERT_EQ(fs::file_size(path), 100'000u) << "with the room that was allocated";
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(5500);  // the disk got half of a chunk
    file << "LSSc and some of what follows";
  }
  auto again = recorder();
  EXPECT_THAT(told_, ElementsAre(EventId::recording_cut));
  EXPECT_EQ(read(path).frames(), 5u);
  EXPECT_LT(fs::file_size(path), 6000u);
  frame(*again);
  again->end();
  ASSERT_EQ(folder_.files().size(), 2u) << "a new file";
  told_.clear();
  recorder();
  EXPECT_THAT(told_, IsEmpty());
}

TEST_F(RecorderTest, AFullDiskIsReportedAndItGoesOnWhenThereIsRoom) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  auto recorder = this->recorder();
  for (int i = 0; i < 5; ++i) frame(*recorder);
  const rlimit small{.rlim_cur = 8000, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  for (int i = 0; i < 400; ++i) frame(*recorder);  // 8 s: it tries again, in vain
  EXPECT_TRUE(recorder->in_trouble());
  EXPECT_THAT(told_, ElementsAre(EventId::recording_failed)) << "once";
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  for (int i = 0; i < 300; ++i) frame(*recorder);
  EXPECT_FALSE(recorder->in_trouble());
  recorder->end();
  const auto left = folder_.files();
  ASSERT_GE(left.size(), 2u);
  std::size_t frames = 0;
  std::uint64_t lost = 0;
  for (const fs::path& path : left) {
    const Read file = read(path);
    EXPECT_NE(file.end, End::torn) << path;
    EXPECT_NE(file.end, End::damaged) << path;
    frames += file.frames();
    lost += file.header["lost_before"].get<std::uint64_t>();
  }
  EXPECT_EQ(frames + lost, 705u) << "every frame is there or counted";
  EXPECT_EQ(read(left[1]).kinds.front(), Item::state);
}

TEST_F(RecorderTest, AFolderThatCannotBeWrittenIsReported) {
  if (::geteuid() == 0) {  // root ignores permissions: no folder at all
    fs::remove_all(folder_);
    std::ofstream(folder_) << "a file";
  } else {
    ::chmod(folder_.c_str(), 0500);
  }
  auto recorder = this->recorder();
  for (int i = 0; i < 10; ++i) frame(*recorder);
  EXPECT_TRUE(recorder->in_trouble());
  EXPECT_THAT(told_, ElementsAre(EventId::recording_failed));
  ::chmod(folder_.c_str(), 0700);
}

TEST_F(RecorderTest, AFileThatSomebodyRemovedIsFollowedByAnother) {
  auto recorder = this->recorder();
  for (int i = 0; i < 5; ++i) frame(*recorder);
  fs::remove(folder_.files().at(0));
  for (int i = 0; i < 5; ++i) frame(*recorder);
  recorder->end();
  ASSERT_EQ(folder_.files().size(), 1u);
  const Read file = read(folder_.files()[0]);
  EXPECT_EQ(file.kinds.front(), Item::state);
  EXPECT_EQ(file.frames() + file.header["lost_before"].get<std::uint64_t>(), 5u)
      << "every frame since then is there or counted";
}

TEST_F(RecorderTest, FramesThatWereDroppedAreCountedWhenTheirFileIsGone) {
  auto recorder = this->recorder();
  frame(*recorder);
  fs::remove(folder_.files().at(0));
  for (int i = 0; i < 3; ++i) frame(*recorder, 5);
  recorder->end();
  ASSERT_EQ(folder_.files().size(), 1u);
  const Read file = read(folder_.files()[0]);
  EXPECT_THAT(file.lost, IsEmpty());
  EXPECT_EQ(file.frames() + file.header["lost_before"].get<std::uint64_t>(), 3u + 5u);
}

TEST_F(RecorderTest, FramesThatWereDroppedAreCountedWhenTheDiskIsFull) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  auto recorder = this->recorder();
  frame(*recorder);
  const rlimit small{.rlim_cur = 1000, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  frame(*recorder, 5);
  EXPECT_TRUE(recorder->in_trouble());
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  now_ += Recorder::kRetry;
  for (int i = 0; i < 2; ++i) frame(*recorder, 5);
  recorder->end();
  ASSERT_EQ(folder_.files().size(), 2u);
  const Read first = read(folder_.files()[0]), second = read(folder_.files()[1]);
  EXPECT_THAT(first.lost, IsEmpty());
  EXPECT_EQ(first.frames() + second.frames() + second.header["lost_before"].get<std::uint64_t>(),
            4u + 5u)
      << "every frame is there or counted";
}

}  // namespace
}  // namespace lss::record
