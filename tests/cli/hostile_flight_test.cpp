// Flight recordings from others, with every checksum right: each is read or refused with a
// sentence, in bounded time and memory.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "tests/cli/hostile.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/recording/flight.h"

namespace lss::cli::recording {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using FileBytes = std::vector<std::uint8_t>;

std::string why_not(const std::string& schema) {
  return why([&] { RecordLayout layout(schema); });
}
TEST(HostileSchema, IsRefusedAboveItsLimits) {
  constexpr const char* kMost = "more than 50000 fields";
  EXPECT_THAT(why_not("a:[999999][999999]<u1>;"), HasSubstr(kMost));
  EXPECT_THAT(why_not("a:[999999][999999][999999]{};"), HasSubstr(kMost));
  EXPECT_THAT(why_not("a:[40000]u1;b:[40000]u1;"), HasSubstr(kMost));
  EXPECT_THAT(why_not("a:[1000](u1|[100]u1);"), HasSubstr(kMost));
  EXPECT_THAT(why_not("a:" + repeated("<", 1000) + "u1"), HasSubstr("nested deeper than"));
  EXPECT_THAT(why_not("a:" + repeated("[1]", 300'000) + "u1;"), HasSubstr("nested deeper than"));
  EXPECT_THAT(why_not(std::string(1000, 'a') + ":u1;"), HasSubstr("cannot be read"));
  EXPECT_THAT(why_not(std::string(2'000'000, 'a') + ":u1;"), HasSubstr("at most 1000000 are read"));
  EXPECT_THAT(why_not("a:[0]u1;"), HasSubstr("cannot be read"));
  EXPECT_THAT(why_not("a:c8;"), HasSubstr("cannot be read"));
}

TEST(HostileRecord, AListThatIsLongIsRefused) {
  // One byte for each element in the record, and a thousand fields in memory.
  RecordLayout layout("a:<[1000](u1|u2)>;");
  FileBytes record(2'000'000, 0);
  const std::uint32_t count = 1'999;
  std::memcpy(record.data(), &count, sizeof count);
  EXPECT_THAT(why([&] { layout.json(record); }), HasSubstr("more than 50000 fields"));
  // Elements that take no room: as many as are left of the record, at most.
  RecordLayout nothing("b:u1;a:<{}>;");
  const std::uint32_t many = ~std::uint32_t{0};
  std::memcpy(record.data() + 1, &many, sizeof many);
  EXPECT_THAT(why([&] { nothing.json(record); }), HasSubstr("a list of 4294967295 elements"));
}

constexpr const char* kSchema =
    "in:{frame:u8;time_ns:i8;requests:<{source:[4]c1;kind:u2;}>;};"
    "telemetry:{distance_m:f8;modules:[3]{current_A:f4;online:b1;};"
    "reading:({count:i4;}|{range_m:[2]f8;});};";

class HostileFlight : public testing::Test {
 protected:
  static nlohmann::ordered_json header(const std::string& schema) {
    return {{"lss", "recording"},  {"utc_ns", 1'900'000'000'000'000'000},
            {"time_ns", 1'000},    {"vehicle", "zebro"},
            {"vehicle_id", "z-1"}, {"period_ns", 20'000'000},
            {"schema", schema}};
  }
  static FileBytes record(std::uint64_t frame) {
    FileBytes bytes;
    const auto put = [&](auto x) {
      const auto* begin = reinterpret_cast<const std::uint8_t*>(&x);
      bytes.insert(bytes.end(), begin, begin + sizeof x);
    };
    put(frame);
    put(static_cast<std::int64_t>(frame) * 20'000'000);
    put(std::uint32_t{1});
    put(std::array{'m', 'e', '\0', '\0'});
    put(std::uint16_t{5});
    put(1.5);
    for (int i = 0; i < 3; ++i) {
      put(0.5f);
      put(std::uint8_t{1});
    }
    put(std::uint8_t{1});
    put(1.5);
    put(2.5);
    return bytes;
  }
  void write(const nlohmann::ordered_json& header, const std::vector<FileBytes>& records) const {
    fs::remove(path_);
    lss::record::RecordingWriter writer;
    ASSERT_EQ(writer.begin(path_, header, 0), 0);
    for (const FileBytes& bytes : records) {
      writer.add_frame(bytes, 0);
      ASSERT_EQ(writer.flush(), 0);
    }
    ASSERT_EQ(writer.end(), 0);
  }
  void read() const {
    Flight flight(path_);
    (void)flight.complaint();
    (void)flight.duration_s();
    std::size_t size = 0;
    flight.each({}, [&](const Flight::Frame& frame) {
      size += flight.layout()
                  .json(frame.record)
                  .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
                  .size();
    });
    EXPECT_GT(size, 0u);
    flight.layout().choose_what_is_always_there();
    (void)flight.layout().columns();
    std::vector<nlohmann::ordered_json> values;
    flight.each({},
                [&](const Flight::Frame& frame) { flight.layout().values(frame.record, values); });
  }
  std::string why_not_read() const {
    return why([this] { read(); });
  }

  testing_support::TempFolder folder_;
  std::string path_ = (folder_ / "a.lssrec").string();
};

TEST_F(HostileFlight, TimesThatAreNoneAreRefused) {
  FileBytes last = record(2);
  const auto never = std::numeric_limits<std::int64_t>::min();
  std::memcpy(&last[8], &never, sizeof never);
  write(header(kSchema), {record(1), last});
  EXPECT_THAT(why_not_read(), HasSubstr("has the time -9223372036854775808 ns"));
}

TEST_F(HostileFlight, FieldsOfTheHeaderThatAreOfAnotherTypeAreRefused) {
  for (const char* name : {"utc_ns", "time_ns", "vehicle", "build", "config", "schema"}) {
    auto bad = header(kSchema);
    bad[name] = nlohmann::ordered_json::array({1});
    write(bad, {record(1)});
    EXPECT_THAT(why_not_read(), HasSubstr(fmt::format("a header in which {} is not", name)));
  }
}

// With correct checksums: the content of a chunk is hostile, not torn.
TEST_F(HostileFlight, AnyFileIsReadOrRefused) {
  using Below = std::function<std::size_t(std::size_t)>;
  const auto change = [](auto& bytes, const Below& below) {
    using Byte = std::remove_reference_t<decltype(bytes[0])>;
    for (std::size_t changes = 1 + below(3); changes > 0 && !bytes.empty(); --changes) {
      const std::size_t at = below(bytes.size());
      const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      switch (below(4)) {
        case 0: bytes[at] = static_cast<Byte>(below(256)); break;
        case 1: bytes[at] = bytes[below(bytes.size())]; break;
        case 2: bytes.erase(place); break;
        default: bytes.insert(place, bytes[below(bytes.size())]);
      }
    }
  };
  read_or_refuse(
      1000, 20'301'102,
      [&](int i, const Below& below) {
        std::string schema = kSchema;
        std::vector<FileBytes> records = {record(1), record(2), record(3)};
        if (i % 2 == 0) change(schema, below);
        if (i % 2 == 1 || i % 3 == 0) change(records[below(3)], below);
        write(header(schema), records);
      },
      [this] { return why_not_read(); });
}

}  // namespace
}  // namespace lss::cli::recording
