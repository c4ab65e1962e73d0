// Files of the flight recorder: whatever happens to their bytes is noticed, and what is whole is
// read. Records are a few bytes here; what they hold is the vehicles' matter.
#include "daemon/record/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

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
  RecordingTest() {
    std::string name = (fs::temp_directory_path() / "lss-recording-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~RecordingTest() override { fs::remove_all(folder_); }

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

  fs::path folder_;
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

}  // namespace
}  // namespace lss::record
