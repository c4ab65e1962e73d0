// Files of the flight recorder: every change of their bytes is detected, and complete parts are
// read. Records are a few bytes here; their content belongs to the vehicles.
#include "daemon/record/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <iterator>
#include <thread>

#include "daemon/record/files.h"
#include "daemon/record/limits.h"
#include "tests/support/temp_folder.h"

namespace lss::record {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;
using End = RecordingReader::End;

struct Read {
  bool opened = false;
  End end = End::none;
  std::uint64_t whole = 0;  // bytes
  std::vector<Bytes> items{};
};

class RecordingTest : public testing::Test {
 protected:
  fs::path path() const { return folder_ / "v-1-000001-x.lssrec"; }
  static Bytes record(std::uint8_t number) { return Bytes(number % 7u + 1u, number); }

  // Three chunks of two frames each, ended or not.
  Bytes make(bool ended, std::uint64_t allocate = 0) {
    fs::remove(path());
    RecordingWriter writer;
    EXPECT_EQ(writer.begin(path(), {{"lss", "recording"}, {"vehicle", "v"}}, allocate), 0);
    for (std::uint8_t i = 1; i <= 6; ++i) {
      writer.add_frame(record(i), i * 10);
      if (i % 2 == 0) {
        EXPECT_EQ(writer.flush(), 0);
        ends_.push_back(writer.size());
      }
    }
    if (!ended) return content();  // as a daemon that is killed leaves it
    EXPECT_EQ(writer.end(), 0);
    return content();
  }
  Bytes content() const {
    std::ifstream file(path(), std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(file), {});
  }
  Read read(const Bytes& bytes) const {
    std::ofstream(path(), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return read();
  }
  Read read() const {
    auto reader = RecordingReader::open(path());
    if (!reader) return {};
    Read read{.opened = true};
    Item kind;
    std::span<const std::uint8_t> item;
    while (reader->next(kind, item)) read.items.emplace_back(item.begin(), item.end());
    read.end = reader->end();
    read.whole = reader->offset();
    return read;
  }

  const testing_support::TempFolder folder_;
  std::vector<std::uint64_t> ends_;  // of the chunks with frames
};

TEST_F(RecordingTest, TheChecksumIsTheOneOfTheStandard) {
  const std::string_view digits = "123456789";
  EXPECT_EQ(crc32c({reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()}),
            0xE3069283u);
}

TEST_F(RecordingTest, WhatIsWrittenIsReadBackAndTheEndSaysWhatThereIs) {
  const Read read = this->read(make(true, 100'000));
  ASSERT_TRUE(read.opened);
  EXPECT_EQ(read.end, End::whole);
  ASSERT_EQ(read.items.size(), 6u);
  for (std::uint8_t i = 0; i < 6; ++i)
    EXPECT_EQ(read.items[i], record(static_cast<std::uint8_t>(i + 1)));
  RecordingEnd end;
  const auto reader = RecordingReader::open(path());
  EXPECT_EQ(reader->header().at("vehicle"), "v");
  ASSERT_TRUE(reader->last_words(end));
  EXPECT_EQ(end.frames, 6u);
  EXPECT_EQ(end.first_ns, 10);
  EXPECT_EQ(end.last_ns, 60);
  EXPECT_LT(content().size(), 1000u) << "what was allocated in vain is given back";
}

#ifdef LSS_SANITIZED
constexpr std::size_t kStride = 13;  // bits; all of them take too long
#else
constexpr std::size_t kStride = 1;
#endif

// Any single bit, of an ended file and of one that was not.
TEST_F(RecordingTest, EveryBitThatIsFlippedIsNoticed) {
  for (const bool ended : {true, false}) {
    const Bytes good = make(ended);
    for (std::size_t bit = 0; bit < good.size() * 8; bit += kStride) {
      Bytes bad = good;
      bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1u << bit % 8));
      const Read read = this->read(bad);
      ASSERT_TRUE(!read.opened || read.end == End::damaged) << "bit " << bit << ", ended " << ended;
    }
  }
}

TEST_F(RecordingTest, WhereverItIsCutTheWholeChunksAreRead) {
  const Bytes good = make(true);
  for (std::size_t size = 0; size < good.size(); size += kStride) {
    // Cut, and cut with the room that was allocated behind it.
    for (const std::size_t room : {std::size_t{0}, std::size_t{300}}) {
      Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
      cut.resize(size + room);
      const Read read = this->read(cut);
      const auto chunks =
          std::ranges::count_if(ends_, [&](std::uint64_t end) { return end <= size; });
      if (!read.opened) {
        ASSERT_EQ(chunks, 0) << size;
        continue;
      }
      ASSERT_EQ(read.items.size(), 2 * static_cast<std::size_t>(chunks)) << size;
      ASSERT_TRUE(read.end == End::torn || read.end == End::open) << size;
      const auto whole = cut_recording(path());
      ASSERT_TRUE(whole) << whole.error();
      const Read after = this->read();
      ASSERT_EQ(after.end, End::open) << size;
      ASSERT_EQ(after.items, read.items) << size;
      ASSERT_EQ(fs::file_size(path()), after.whole);
    }
  }
}

// Its daemon has the same folder and vehicle_id as the one that begins.
TEST_F(RecordingTest, AFileThatIsBeingWrittenIsNotCut) {
  constexpr std::uint64_t kRoom = 100'000;
  RecordingWriter writer;
  ASSERT_EQ(writer.begin(path(), {{"lss", "recording"}, {"vehicle", "v"}}, kRoom), 0);
  writer.add_frame(record(1), 10);
  ASSERT_EQ(writer.flush(), 0);
  ASSERT_EQ(fs::file_size(path()), kRoom);
  const auto cut = cut_recording(path());
  ASSERT_TRUE(cut) << cut.error();
  EXPECT_EQ(*cut, 0u);
  EXPECT_EQ(fs::file_size(path()), kRoom) << "the next chunk would leave a hole before it";
  writer.abandon();
  ASSERT_TRUE(cut_recording(path()));
  EXPECT_EQ(read().items.size(), 1u);
}

TEST_F(RecordingTest, ChunksThatAreMissingOrTwiceThereAreDamage) {
  const Bytes good = make(true);
  const auto at = [&](std::uint64_t offset) {
    return good.begin() + static_cast<std::ptrdiff_t>(offset);
  };
  Bytes without(good.begin(), at(ends_[0]));
  without.insert(without.end(), at(ends_[1]), good.end());
  EXPECT_EQ(read(without).end, End::damaged);
  Bytes twice(good.begin(), at(ends_[1]));
  twice.insert(twice.end(), at(ends_[0]), good.end());
  EXPECT_EQ(read(twice).end, End::damaged);
  Bytes more = good;
  more.push_back('x');
  EXPECT_EQ(read(more).end, End::damaged);
}

// As a power cut leaves a file whose sectors the disk wrote in another order.
TEST_F(RecordingTest, ChunksBehindDamageAreReadAndThoseThatAreMissingAreCounted) {
  for (const bool ended : {true, false}) {
    ends_.clear();
    Bytes bad = make(ended);
    std::fill(bad.begin() + static_cast<std::ptrdiff_t>(ends_[0] + 10),
              bad.begin() + static_cast<std::ptrdiff_t>(ends_[1]), std::uint8_t{0});
    const Read read = this->read(bad);
    EXPECT_EQ(read.end, End::damaged);
    const Bytes unknown(8, 0);
    EXPECT_EQ(read.items, (std::vector{record(1), record(2), unknown, record(5), record(6)}));
    auto reader = RecordingReader::open(path());
    Item kind;
    std::span<const std::uint8_t> item;
    while (reader->next(kind, item)) {
    }
    EXPECT_THAT(reader->trouble(), testing::HasSubstr("damaged in the chunk that begins at byte " +
                                                      std::to_string(ends_[0])));
    EXPECT_THAT(reader->trouble(), testing::HasSubstr("chunks that are missing: 1"));
    EXPECT_FALSE(cut_recording(path())) << "it is left as it is";
    EXPECT_EQ(content(), bad);
  }
}

// The hole is not looked through for each of them, or this would take minutes.
TEST_F(RecordingTest, BehindEveryDamageTheWholeChunksAreReadAlsoBeforeALongHole) {
  std::vector<std::uint64_t> damages;
  std::vector<Bytes> expected;
  RecordingWriter writer;
  ASSERT_EQ(writer.begin(path(), {{"lss", "recording"}, {"vehicle", "v"}}, 0), 0);
  for (std::uint8_t i = 1; i <= 200; ++i) {
    if (i % 2 == 0) damages.push_back(writer.size() + 24);
    expected.push_back(i % 2 == 0 ? Bytes(8, 0) : record(i));
    writer.add_frame(record(i), i * 10);
    ASSERT_EQ(writer.flush(), 0);
  }
  ASSERT_EQ(writer.end(), 0);
  Bytes bad = content();
  for (const std::uint64_t at : damages) bad[at] ^= 1;
  EXPECT_EQ(read(bad).items, expected);
  fs::resize_file(path(), 500'000'000);
  const Read read = this->read();
  EXPECT_EQ(read.end, End::damaged);
  EXPECT_EQ(read.items, expected);
}

TEST_F(RecordingTest, OtherFilesAndOtherFormatsAreRefusedByName) {
  std::ofstream(path()) << "{\"lss\": \"log\"}\n";
  EXPECT_THAT(RecordingReader::open(path()).error(), testing::HasSubstr("is no recording"));
  EXPECT_THAT(RecordingReader::open(folder_).error(), testing::HasSubstr("is no recording"));
  EXPECT_THAT(RecordingReader::open(folder_ / "none").error(), testing::HasSubstr("No such file"));
  Bytes other = make(true);
  other[8] = 2;
  const std::uint32_t crc = crc32c(std::span(other).first(12));
  std::memcpy(&other[12], &crc, sizeof crc);
  read(other);
  EXPECT_THAT(RecordingReader::open(path()).error(), testing::HasSubstr("has format 2"));
}

TEST_F(RecordingTest, AFileThatIsBeingWrittenIsReadAsFarAsItGoes) {
  RecordingWriter writer;
  ASSERT_EQ(writer.begin(path(), {{"vehicle", "v"}}, 100'000), 0);
  EXPECT_EQ(read().end, End::open);
  writer.add_frame(record(1), 1);
  writer.add_lost(3);
  EXPECT_EQ(read().items.size(), 0u);
  ASSERT_EQ(writer.flush(), 0);
  EXPECT_EQ(read().items.size(), 2u);
  EXPECT_EQ(read().end, End::open);
}

// The recorder is in the middle of a chunk.
TEST_F(RecordingTest, AChunkThatIsBeingWrittenIsNotTorn) {
  const Bytes whole = make(true);
  fs::remove(path());
  RecordingWriter writer;
  ASSERT_EQ(writer.begin(path(), {{"lss", "recording"}, {"vehicle", "v"}}, 0), 0);
  const auto half = static_cast<std::ptrdiff_t>(ends_[0] - 5);
  std::ofstream(path(), std::ios::binary | std::ios::in | std::ios::out)
      .write(reinterpret_cast<const char*>(whole.data()), half);
  EXPECT_EQ(read().end, End::open);
  writer.abandon();
  read(Bytes(whole.begin(), whole.begin() + half));
  EXPECT_EQ(read().end, End::torn) << "nobody writes it";
}

// It was opened in the middle of a chunk, which was complete when it was looked at again.
TEST_F(RecordingTest, ARecorderThatEndsWhileItIsReadLeavesAWholeFile) {
  const Bytes whole = make(true);
  for (const std::uint64_t from : {ends_[0] - 5, ends_[1] + 3, ends_[2] + 5}) {
    const auto half = static_cast<std::ptrdiff_t>(from);
    read(Bytes(whole.begin(), whole.begin() + half));
    auto reader = RecordingReader::open(path());
    ASSERT_TRUE(reader);
    std::ofstream(path(), std::ios::binary | std::ios::app)
        .write(reinterpret_cast<const char*>(whole.data()) + half,
               static_cast<std::ptrdiff_t>(whole.size()) - half);
    Item kind;
    std::span<const std::uint8_t> item;
    int items = 0;
    while (reader->next(kind, item)) ++items;
    EXPECT_EQ(reader->end(), End::whole) << from;
    EXPECT_EQ(items, 6) << from;
  }
}

// Looked at again and again while its recorder writes: there is no damage, and nothing is torn.
TEST_F(RecordingTest, AFileThatIsBeingWrittenIsNeverDamaged) {
  for (const std::uint64_t allocate : {std::uint64_t{4'000'000}, std::uint64_t{0}}) {
    fs::remove(path());
    RecordingWriter writer;
    ASSERT_EQ(writer.begin(path(), {{"vehicle", "v"}}, allocate), 0);
    std::atomic<bool> ended = false;
    std::thread recorder([&] {
      const Bytes frame(100, 7);
      for (int i = 0; i < 20'000; ++i) {
        writer.add_frame(frame, i);
        if (writer.flush() != 0) break;
      }
      writer.end();
      ended = true;
    });
    while (!ended) {
      const Read now = read();
      ASSERT_TRUE(now.opened);
      EXPECT_TRUE(now.end == End::open || now.end == End::whole)
          << static_cast<int>(now.end) << " after " << now.items.size();
      if (HasFailure()) break;
    }
    recorder.join();
    EXPECT_EQ(read().items.size(), 20'000u);
  }
}

// Files made to exhaust a reader, with all checksums correct.
class HostileRecording : public RecordingTest {
 protected:
  std::string why_not(const nlohmann::ordered_json& header) const {
    fs::remove(path());
    RecordingWriter writer;
    EXPECT_EQ(writer.begin(path(), header, 0), 0);
    writer.abandon();
    const auto reader = RecordingReader::open(path());
    return reader ? "was read" : reader.error();
  }
};

TEST_F(HostileRecording, AHeaderOfOtherTypesIsRefused) {
  using Json = nlohmann::ordered_json;
  const Json wrong = Json::array({1});
  for (const char* name :
       {"utc_ns", "time_ns", "run_utc_ns", "start", "vehicle", "vehicle_id", "version", "build",
        "period_ns", "config", "parameters", "state_layout", "schema"})
    EXPECT_THAT(why_not({{name, wrong}}),
                testing::HasSubstr(std::string("a header in which ") + name + " is not"));
  EXPECT_THAT(why_not({{"build", {{"id", 5}}}}), testing::HasSubstr("build.id is not a text"));
  EXPECT_THAT(why_not({{"utc_ns", -5}}), testing::HasSubstr("utc_ns is not a time"));
  EXPECT_THAT(why_not({{"utc_ns", 1e300}}), testing::HasSubstr("utc_ns is not a time"));
}

TEST_F(HostileRecording, AHeaderIsOnlySoLargeAndNestsOnlySoDeep) {
  EXPECT_THAT(why_not({{"config", std::string(5'000'000, 'x')}}),
              testing::HasSubstr("at most 4000000 are read"));
  EXPECT_TRUE(parse_json(R"({"a": "[[[[\"[[", "b": [[1]]})").is_object());
  const std::string deep = R"({"a": )" + std::string(200'000, '[');
  EXPECT_TRUE(parse_json(deep + "1" + std::string(200'000, ']') + "}").is_discarded());
}

TEST_F(HostileRecording, AFileOfManyZerosTakesNoMemory) {
  make(true);
  fs::resize_file(path(), most::kFileBytes + 1);
  EXPECT_THAT(RecordingReader::open(path()).error(), testing::HasSubstr("at most 2000000000"));
  make(false);
  fs::resize_file(path(), 500'000'000);
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  EXPECT_EQ(read().end, End::open);
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100'000) << "kB";
}

TEST_F(HostileRecording, AChunkThatIsTooLargeIsDamage) {
  make(true);
  fs::remove(path());
  RecordingWriter writer;
  ASSERT_EQ(writer.begin(path(), {{"vehicle", "v"}}, 0), 0);
  writer.add(Item::frame, Bytes(most::kChunkBytes, 1));
  ASSERT_EQ(writer.flush(), 0);
  ASSERT_EQ(writer.end(), 0);
  auto reader = RecordingReader::open(path());
  ASSERT_TRUE(reader);
  Item kind;
  std::span<const std::uint8_t> item;
  ASSERT_TRUE(reader->next(kind, item));
  EXPECT_EQ(kind, Item::lost);
  EXPECT_FALSE(reader->next(kind, item));
  EXPECT_EQ(reader->end(), End::damaged);
  EXPECT_THAT(reader->trouble(), testing::HasSubstr("at most 16000000 are read"));
}

// Many heads of large chunks, none of which is one.
TEST_F(HostileRecording, WhatIsBehindDamageIsSearchedOnlySoLong) {
  const Bytes good = make(true);
  const Bytes before(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(ends_[0]));
  Bytes head(good.begin() + static_cast<std::ptrdiff_t>(ends_[0]),
             good.begin() + static_cast<std::ptrdiff_t>(ends_[0]) + 16);
  head[8 + 3] = 1;  // its index, far beyond
  const std::uint32_t size = 4'000'000;
  std::memcpy(&head[12], &size, sizeof size);
  const std::uint32_t crc = crc32c(head);
  head.insert(head.end(), reinterpret_cast<const std::uint8_t*>(&crc),
              reinterpret_cast<const std::uint8_t*>(&crc) + sizeof crc);
  Bytes bad = before;
  bad.push_back('x');
  for (int i = 0; i < 100'000; ++i) bad.insert(bad.end(), head.begin(), head.end());
  bad.resize(bad.size() + size, 'x');
  bad.insert(bad.end(), good.begin() + static_cast<std::ptrdiff_t>(ends_[1]), good.end());
  EXPECT_EQ(read(bad).end, End::damaged);
  EXPECT_EQ(read(bad).items.size(), 2u) << "given up";
}

TEST_F(HostileRecording, APipeIsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(path().c_str(), 0600), 0);
  EXPECT_THAT(RecordingReader::open(path()).error(), testing::HasSubstr("is no recording"));
}

}  // namespace
}  // namespace lss::record
