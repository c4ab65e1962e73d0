// MCAP files of ours: written, read, torn at every place, gone on with, and on a full disk. That
// others read them too: tests/e2e/test_mcap.py.

#include "tools/lss-cli/recording/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "tests/support/temp_folder.h"
#include "tools/lss-cli/recording/mcap_writer.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli::recording {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing_support::content;

constexpr const char* kIdl = R"(
module lss { /* two types */
  enum State { STATE_IDLE, STATE_BUSY };
  struct Part { octet id; double angle_rad; };   // 1, then 8 of 8
  @final struct Sample {
    @key char vehicle_id[16];
    unsigned long long frame;
    State state;
    boolean on;
    unsigned short flags;
    long age_ms, other[2];
    Part parts[2];
  };
};)";

// As CDR puts a Sample down.
std::string sample(std::uint64_t frame, double angle_rad) {
  Writer out;
  out.raw(bytes_of(std::string_view("\0\1\0\0", 4)));
  std::string id = "z-1";
  id.resize(16);
  out.raw(bytes_of(id));
  out.number(frame);
  out.number(std::uint32_t{1});
  out.number(std::uint8_t{1});
  out.number(std::uint8_t{0});  // up to the next even place
  out.number(std::uint16_t{7});
  for (const std::int32_t value : {-5, 1, 2}) out.number(value);
  // A byte, padding to the next multiple of 8, a double: from 44 on, and from 56 on.
  out.number(std::uint32_t{1});
  out.number(angle_rad);
  out.number(std::uint64_t{2});
  out.number(angle_rad * 2);
  return out.str();
}

class RecordingTest : public testing::Test {
 protected:
  static constexpr std::int64_t kStart_ns = 1'900'000'000'000'000'000;

  // `count` messages, three to a chunk.
  static void write(McapWriter& writer, std::uint64_t first, std::uint64_t count) {
    const std::uint16_t channel =
        writer.channel("lss/telemetry/z", {"lss::Sample", "omgidl", kIdl}, "cdr", {{"a", "b"}});
    for (std::uint64_t frame = first; frame < first + count; ++frame) {
      const std::string data = sample(frame, static_cast<double>(frame) / 10);
      const std::int64_t at_ns = kStart_ns + static_cast<std::int64_t>(frame) * 20'000'000;
      writer.write(
          {channel, static_cast<std::uint32_t>(frame), at_ns, at_ns - 1000, bytes_of(data)});
      if (frame % 3 == 2) writer.end_chunk();
    }
  }
  void write_file(std::uint64_t count) const {
    McapWriter writer = McapWriter::create(path_, "lss-cli test");
    writer.metadata("lss", {{"vehicle", "z"}});
    write(writer, 0, count);
    writer.close();
  }
  static std::vector<std::uint64_t> frames(const std::string& path) {
    std::vector<std::uint64_t> list;
    const auto recording = open(path);
    recording->each({}, [&](const Message& message) {
      const Layout& layout = *message.topic.layout;
      list.push_back(layout.json(*layout.find("frame"), message.data).get<std::uint64_t>());
    });
    return list;
  }
  static std::vector<std::uint64_t> numbers(std::uint64_t first, std::uint64_t count) {
    std::vector<std::uint64_t> list(count);
    for (std::uint64_t i = 0; i < count; ++i) list[i] = first + i;
    return list;
  }
  void put_content(const std::string& text) const { testing_support::put_content(path_, text); }

  testing_support::TempFolder folder_;
  std::string path_ = (folder_ / "a.mcap").string();
};

TEST_F(RecordingTest, WhatIsWrittenIsReadWithItsTypes) {
  write_file(10);
  const auto recording = open(path_);
  EXPECT_EQ(recording->complaint(), "");
  EXPECT_EQ(recording->about().at("vehicle"), "z");
  EXPECT_EQ(recording->span().messages, 10u);
  ASSERT_EQ(recording->topics().size(), 1u);
  EXPECT_EQ(recording->topics().front().type_name, "lss::Sample");
  EXPECT_EQ(recording->topics().front().gaps, 0u);
  std::uint64_t frame = 0;
  recording->each({}, [&](const Message& message) {
    const auto json = message.topic.layout->json(message.data);
    EXPECT_EQ(json.at("vehicle_id"), "z-1");
    EXPECT_EQ(json.at("frame"), frame);
    EXPECT_EQ(json.at("state"), 1);
    EXPECT_EQ(json.at("on"), true);
    EXPECT_EQ(json.at("flags"), 7);
    EXPECT_EQ(json.at("age_ms"), -5);
    EXPECT_EQ(json.at("other"), nlohmann::json({1, 2}));
    EXPECT_EQ(json.at("parts")[1].at("id"), 2);
    EXPECT_EQ(json.at("parts")[1].at("angle_rad"), static_cast<double>(frame) / 10 * 2);
    EXPECT_EQ(message.topic.layout->text(*message.topic.layout->find("state"), message.data),
              "STATE_BUSY");
    ++frame;
  });
  EXPECT_EQ(frame, 10u);
}

TEST_F(RecordingTest, AFileThatIsTornAnywhereKeepsItsWholeChunksAndIsGoneOnWith) {
  write_file(9);
  const std::string whole = content(path_);
  // Where each chunk ends.
  std::vector<std::uint64_t> ends;
  {
    const MappedFile file(path_);
    for (const Chunk& chunk : scan(path_, file.data()).chunks)
      ends.push_back(chunk.offset + chunk.length);
  }
  ASSERT_EQ(ends.size(), 3u);
  for (std::size_t size = kMagic.size() + kRecordHead + 1; size < whole.size(); size += 5) {
    SCOPED_TRACE(size);
    put_content(whole.substr(0, size));
    const auto kept = static_cast<std::uint64_t>(
        3 * std::ranges::count_if(ends, [&](std::uint64_t end) { return end <= size; }));
    if (kept > 0) {
      EXPECT_EQ(frames(path_), numbers(0, kept));
      EXPECT_NE(open(path_)->complaint(), "");
    }
    try {
      McapWriter writer = McapWriter::append(path_, "lss-cli test");
      write(writer, kept, 4);
      writer.close();
    } catch (const Failure& e) {  // not even its header is whole: nothing says that it is ours
      EXPECT_EQ(kept, 0u);
      EXPECT_THAT(e.what(), HasSubstr("not by lss-cli"));
      continue;
    }
    EXPECT_EQ(frames(path_), numbers(0, kept + 4));
    EXPECT_EQ(open(path_)->complaint(), "");
    // Every chunk has its indexes, and every index is where it should be.
    const MappedFile file(path_);
    for (const Chunk& chunk : scan(path_, file.data()).chunks) EXPECT_EQ(chunk.index.size(), 1u);
  }
}

TEST_F(RecordingTest, AWholeFileIsGoneOnWithAndAByteThatChangedIsFound) {
  write_file(5);
  {
    McapWriter writer = McapWriter::append(path_, "lss-cli test");
    EXPECT_EQ(writer.cut(), 0u);
    EXPECT_EQ(writer.all().messages, 5u);
    write(writer, 7, 5);
    writer.close();
  }
  const auto recording = open(path_);
  EXPECT_EQ(recording->span().messages, 10u);
  EXPECT_EQ(recording->topics().size(), 1u) << "the same channel";
  EXPECT_EQ(recording->topics().front().gaps, 2u) << "of frames 5 and 6";

  std::string changed = content(path_);
  changed[changed.find("z-1") + 20] ^= 1;  // in the first chunk
  put_content(changed);
  EXPECT_EQ(frames(path_), numbers(0, 0));
  EXPECT_THAT(open(path_)->complaint(), HasSubstr("damaged"));
}

TEST_F(RecordingTest, OneThatIsDamagedBeforeItsEndIsNotGoneOnWith) {
  write_file(9);
  const std::string whole = content(path_);
  Chunk chunk;  // the second of three
  std::size_t data_end = 0;
  {
    const MappedFile file(path_);
    const Scan scanned = scan(path_, file.data());
    chunk = scanned.chunks[1];
    data_end = scanned.end;
  }
  const auto expect_kept = [&](const std::string& damaged) {
    put_content(damaged);
    EXPECT_EQ(frames(path_), numbers(0, 3));
    try {
      McapWriter::append(path_, "lss-cli test");
      ADD_FAILURE() << "it was cut";
    } catch (const Failure& e) {
      EXPECT_THAT(e.what(), HasSubstr("is damaged at byte " + std::to_string(chunk.offset)));
      EXPECT_THAT(e.advice(), HasSubstr("--out FILE"));
    }
    EXPECT_EQ(content(path_), damaged);
  };
  std::string changed = whole;
  changed[chunk.offset + chunk.length - 1] ^= 1;  // its checksum does not fit
  expect_kept(changed);
  expect_kept(changed.substr(0, data_end));  // and it has no end
  changed = whole;
  changed[chunk.offset + 6] ^= 1;  // its length reaches beyond the file
  expect_kept(changed);
}

TEST_F(RecordingTest, OneWhoseLastRecordIsDamagedIsCutThere) {
  write_file(9);
  std::string torn;
  {
    const MappedFile file(path_);
    const Chunk chunk = scan(path_, file.data()).chunks[2];
    torn = content(path_).substr(0, chunk.offset + chunk.length);
  }
  torn.back() ^= 1;
  put_content(torn);
  McapWriter writer = McapWriter::append(path_, "lss-cli test");
  EXPECT_GT(writer.cut(), 0u);
  writer.close();
  EXPECT_EQ(frames(path_), numbers(0, 6));
}

TEST_F(RecordingTest, OneThatIsThereForeignOrBeingWrittenIsRefused) {
  write_file(3);
  EXPECT_THROW(McapWriter::create(path_, "lss-cli test"), Failure);
  {
    const McapWriter first = McapWriter::append(path_, "lss-cli test");
    EXPECT_THROW(McapWriter::append(path_, "lss-cli test"), Failure);
  }
  std::string foreign = content(path_);
  foreign.replace(foreign.find("lss-cli"), 7, "another");
  put_content(foreign);
  EXPECT_THROW(McapWriter::append(path_, "lss-cli test"), Failure);
  EXPECT_EQ(content(path_), foreign) << "untouched";
  put_content("my notes");  // shorter than a header
  EXPECT_THROW(McapWriter::append(path_, "lss-cli test"), Failure);
  EXPECT_EQ(content(path_), "my notes");
  put_content("no recording at all");
  EXPECT_THROW(open(path_), Failure);
}

TEST_F(RecordingTest, AFullDiskLeavesWhatWasWrittenBefore) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{4000, before.rlim_max};
  McapWriter writer = McapWriter::create(path_, "lss-cli test");
  setrlimit(RLIMIT_FSIZE, &limit);
  try {
    write(writer, 0, 1000);
    ADD_FAILURE() << "there was room";
  } catch (const Failure& e) {
    EXPECT_EQ(e.code(), ExitCode::failed);
    EXPECT_NE(e.advice(), "");
  }
  setrlimit(RLIMIT_FSIZE, &before);
  const std::size_t kept = frames(path_).size();
  EXPECT_GT(kept, 3u);
  EXPECT_EQ(kept % 3, 0u) << "whole chunks";
  writer.close();
  EXPECT_EQ(frames(path_), numbers(0, kept));
  EXPECT_EQ(open(path_)->complaint(), "");
}

TEST_F(RecordingTest, PartsOfAFileAreCopiedByTopicAndTime) {
  write_file(50);
  const std::string part = (folder_ / "part.mcap").string();
  Filter filter;
  filter.topics = {"telemetry"};
  filter.from_s = 0.1;
  filter.until_s = 0.3;
  EXPECT_EQ(open(path_)->copy(filter, part), 11u);
  EXPECT_EQ(frames(part), numbers(5, 11));
  filter.topics = {"telemtry"};
  EXPECT_THROW(open(path_)->copy(filter, part), Failure);
  EXPECT_EQ(frames(part), numbers(5, 11)) << "what was there stays";
  const std::string other = (folder_ / "other.mcap").string();
  EXPECT_THROW(open(path_)->copy(filter, other), Failure);
  EXPECT_FALSE(fs::exists(other)) << "the next try would find it there";
}

TEST(Names, OfTopicsAndColumns) {
  EXPECT_TRUE(names("telemetry", "lss/telemetry/zebro"));
  EXPECT_TRUE(names("lss/telemetry/zebro", "lss/telemetry/zebro"));
  EXPECT_TRUE(names("tele*", "lss/telemetry/zebro"));
  EXPECT_FALSE(names("timing", "lss/timing_statistics"));
  EXPECT_TRUE(matches("modules[*].current_A", "modules[3].current_A"));
  EXPECT_FALSE(matches("modules[*].current", "modules[3].current_A"));
}

TEST(Types, ThatCannotBeReadAreReportedByName) {
  EXPECT_THROW(Types("module a { struct B { sequence<long> c; }; };"), Failure);
  EXPECT_THROW(Types("module a { struct B { Unknown c; }; };"), Failure);
  EXPECT_THROW(Types("module a { struct B { long c;"), Failure);
}

}  // namespace
}  // namespace lss::cli::recording
