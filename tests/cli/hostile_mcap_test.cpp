// Foreign MCAP files: each is read or rejected with a sentence, with any content, in bounded time
// and memory. That a type is used after it is gone, an address sanitizer sees.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "tests/cli/hostile.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/recording/mcap_writer.h"
#include "tools/lss-cli/recording/recording.h"

namespace lss::cli::recording {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string why_not(const std::string& idl) {
  return why([&] { Types types(idl); });
}
TEST(HostileIdl, ATypeThatIsDefinedTwiceIsRefused) {
  EXPECT_THAT(why_not("struct A { long x; }; struct B { A a; }; struct A { long y; };"),
              HasSubstr("A is defined twice"));
  EXPECT_THAT(why_not("enum A { X }; enum A { Y };"), HasSubstr("A is defined twice"));
  EXPECT_THAT(why_not("struct A { long x; struct A { long y; }; };"), HasSubstr("cannot be read"));
}

TEST(HostileIdl, ATypeIsNoPartOfItself) {
  EXPECT_THAT(why_not("struct A { A a; };"), HasSubstr("no type 'A' before it is used"));
  EXPECT_THAT(why_not("struct A { B b; }; struct B { A a; };"), HasSubstr("no type 'B'"));
}

TEST(HostileIdl, NestsOnlySoDeep) {
  EXPECT_THAT(why_not(repeated("module a {", 200'000)), HasSubstr("at most 256000 are read"));
  EXPECT_THAT(why_not(repeated("module a{", 20'000)), HasSubstr("nested deeper than 16"));
  std::string chain = "struct s0 { long x; };";
  for (int i = 1; i <= 5000; ++i) chain += fmt::format("struct s{} {{ s{} x; }};", i, i - 1);
  EXPECT_THAT(why_not(chain), HasSubstr("nested deeper than 16"));
}

TEST(HostileIdl, IsRefusedAboveItsLimits) {
  std::string bomb = "struct s0 { long x[100000]; };";
  for (int i = 1; i <= 8; ++i) bomb += fmt::format("struct s{} {{ s{} x[100000]; }};", i, i - 1);
  EXPECT_THAT(why_not(bomb), HasSubstr("more than 100000 columns"));
  std::string empty = "struct s0 { };";
  for (int i = 1; i <= 8; ++i) empty += fmt::format("struct s{} {{ s{} x[100000]; }};", i, i - 1);
  EXPECT_THAT(why_not(empty), HasSubstr("s0 has no members"));
  EXPECT_THAT(why_not("struct A { long " + std::string(1000, 'x') + "; };"),
              HasSubstr("1000 characters, at most 256"));
  EXPECT_THAT(why_not("struct A { long x[99999999999999999999]; };"), HasSubstr("at most 100000"));
  EXPECT_THAT(why_not("struct A { long x" + repeated(", x", 1000) + "; };"),
              HasSubstr("more than 256 members"));
  EXPECT_THAT(why_not(repeated("@", 100'000)), HasSubstr("cannot be read"));
}

TEST(HostilePattern, ManyStarsTakeNoLonger) {
  EXPECT_FALSE(matches(repeated("*a", 100) + "b", std::string(10'000, 'a')));
  EXPECT_TRUE(matches(repeated("*a", 100) + "*", std::string(10'000, 'a')));
  EXPECT_FALSE(matches("a", std::string(2'000'000, 'a')));
}

class HostileMcap : public testing::Test {
 protected:
  void put(const Writer& content) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << content.str();
  }
  // A file that begins as it should.
  static Writer begun() {
    Writer out;
    out.raw(bytes_of(kMagic));
    Writer header;
    header.text("");
    header.text("lss-cli test");
    out.record(kHeader, header);
    return out;
  }
  static Writer schema(std::uint16_t id, const std::string& name, const std::string& idl) {
    Writer out;
    out.number(id);
    out.text(name);
    out.text("omgidl");
    out.text(idl);
    return out;
  }
  static Writer channel(std::uint16_t id, std::uint16_t schema, const std::string& topic) {
    Writer out;
    out.number(id);
    out.number(schema);
    out.text(topic);
    out.text("cdr");
    out.texts({});
    return out;
  }
  static std::string cdr(std::string_view data) {
    return std::string("\0\1\0\0", 4) + std::string(data);
  }

  // As a program reads it: everything in it, and a part into another file.
  void read() const {
    const auto recording = open(path_);
    for (const Topic& topic : recording->topics()) {
      if (topic.layout == nullptr) continue;
      for (const Column& column : topic.layout->columns())
        EXPECT_LE(column.name.size(), most::kName);
    }
    std::size_t size = 0;
    recording->each({}, [&](const Message& message) {
      (void)recording->seconds(message.publish_ns);
      const Layout* layout = message.topic.layout;
      if (layout == nullptr) return;
      size += layout->json(message.data)
                  .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
                  .size();
      for (const Column& column : layout->columns())
        size += layout->text(column, message.data).size();
    });
    const std::string part = (folder_ / "part.mcap").string();
    fs::remove(part);
    recording->copy({}, part);
  }
  std::string why_not_read() const {
    return why([this] { read(); });
  }

  testing_support::TempFolder folder_;
  std::string path_ = (folder_ / "a.mcap").string();
};

TEST_F(HostileMcap, AHeartbeatWithoutASourceIsCounted) {
  McapWriter writer = McapWriter::create(path_, "lss-cli test");
  const auto id =
      writer.channel("lss/heartbeat",
                     {"lss::Heartbeat", "omgidl",
                      "module lss { struct Heartbeat { unsigned long long counter; }; };"},
                     "cdr", {});
  for (const char count : {'\1', '\5'}) {
    const std::string data = cdr({&count, 1}) + std::string(7, '\0');
    writer.write({id, 1, 1'000, 1'000, bytes_of(data)});
  }
  writer.close();
  EXPECT_EQ(open(path_)->topics().front().gaps, 3u);
}

TEST_F(HostileMcap, TimesAreAsFarApartAsTheyLike) {
  McapWriter writer = McapWriter::create(path_, "lss-cli test");
  const auto id = writer.channel("x", {"A", "omgidl", "struct A { octet x; };"}, "cdr", {});
  constexpr auto kFirst = std::numeric_limits<std::int64_t>::min();
  constexpr auto kLast = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t ns : {kFirst, kLast})
    writer.write({id, 1, ns, kLast, bytes_of(cdr("x"))});
  writer.close();
  const auto recording = open(path_);
  EXPECT_NEAR(recording->seconds(kLast), 18'446'744'073.7, 0.1);
  EXPECT_EQ(why_not_read(), "was read");
}

TEST_F(HostileMcap, IsRefusedAboveItsLimits) {
  Writer descriptions = begun();
  for (std::uint16_t i = 1; i <= 50; ++i)
    descriptions.record(kSchema, schema(i, "A", std::string(100'000, ' ')));
  put(descriptions);
  EXPECT_THAT(why_not_read(), HasSubstr("more than 4000000 bytes"));

  Writer channels = begun();
  for (std::uint16_t i = 1; i <= 1001; ++i) channels.record(kChannel, channel(i, 0, "x"));
  put(channels);
  EXPECT_THAT(why_not_read(), HasSubstr("more than 1000 channels"));

  Writer name = begun();
  name.record(kChannel, channel(1, 0, std::string(1000, 'x')));
  put(name);
  EXPECT_THAT(why_not_read(), HasSubstr("topic has 1000 characters, at most 256"));

  Writer columns = begun();
  for (std::uint16_t i = 1; i <= 9; ++i) {
    columns.record(kSchema, schema(i, "A", fmt::format("struct A {{ octet x{}[90000]; }};", i)));
    columns.record(kChannel, channel(i, i, fmt::format("x{}", i)));
  }
  put(columns);
  EXPECT_THAT(why_not_read(), HasSubstr("topics have more than 100000 columns"));
}

TEST_F(HostileMcap, APipeIsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  EXPECT_FALSE(is_recording(path_));
  EXPECT_THAT(why_not_read(), HasSubstr(path_));
}

// Bytes, numbers and lengths that are others, in a file like those of the recorder. Checksums of
// chunks are 0, which is none, so that their content is read.
TEST_F(HostileMcap, AnyFileIsReadOrRefused) {
  constexpr const char* kIdl =
      "module lss { enum State { IDLE, BUSY }; struct Part { octet id; double angle_rad; };"
      "struct Heartbeat { @key char vehicle_id[16]; char source[32]; unsigned long long counter;"
      "State state; boolean on; Part parts[2]; char c; float f; }; };";
  Writer good = begun();
  Writer metadata;
  metadata.text("lss");
  metadata.texts({{"vehicle", "zebro"}, {"vehicle_id", "z-1"}});
  good.record(kMetadataRecord, metadata);
  good.record(kSchema, schema(1, "lss::Heartbeat", kIdl));
  good.record(kChannel, channel(1, 1, "lss/heartbeat"));
  good.record(kChannel, channel(2, 1, "lss/telemetry/z"));
  for (int i = 0; i < 3; ++i) {
    Writer records;
    for (const std::uint16_t topic : {std::uint16_t{1}, std::uint16_t{2}}) {
      Writer message;
      message.number(topic);
      message.number(std::uint32_t{7});
      message.number(std::int64_t{1'900'000'000'000'000'000} + i);
      message.number(std::int64_t{1'900'000'000'000'000'000});
      message.raw(bytes_of(cdr(std::string(112, static_cast<char>(i)))));
      records.record(kMessage, message);
    }
    Writer chunk;
    for (int k = 0; k < 2; ++k) chunk.number(std::int64_t{0});
    chunk.number(std::uint64_t{records.size()});
    chunk.number(std::uint32_t{0});
    chunk.text("");
    chunk.block(records.data());
    good.record(kChunk, chunk);
  }
  put(good);
  ASSERT_EQ(why_not_read(), "was read");

  read_or_refuse(
      1500, 20'301'101,
      [&](int, const std::function<std::size_t(std::size_t)>& below) {
        std::string bad = good.str();
        for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
          const std::size_t at = below(bad.size());
          switch (below(4)) {
            case 0: bad[at] = static_cast<char>(below(256)); break;
            case 1: {
              constexpr std::uint64_t kNumbers[] = {0, 1, 0x7fffffff, ~std::uint64_t{0}, 1u << 31};
              const std::uint64_t number = kNumbers[below(std::size(kNumbers))];
              const std::size_t size = std::min<std::size_t>(8, bad.size() - at);
              bad.replace(at, size, reinterpret_cast<const char*>(&number), size);
              break;
            }
            case 2: bad.erase(at, below(20)); break;
            default: bad.insert(at, bad.substr(below(bad.size()), below(60)));
          }
        }
        testing_support::put_content(path_, bad);
      },
      [this] { return why_not_read(); });
}

}  // namespace
}  // namespace lss::cli::recording
