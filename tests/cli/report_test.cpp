// Reports of recordings from others: topics without the fields that a report is made of, two types
// under one name, times and values without measure. A page must still be made.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/support/temp_folder.h"
#include "tools/lss-cli/recording/mcap_writer.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/chart.h"
#include "tools/lss-cli/report/common.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/report/series.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::report {
namespace {

namespace fs = std::filesystem;
using recording::bytes_of;
using recording::McapWriter;

class HostileReport : public testing::Test {
 protected:
  // `count` messages of a topic; their bytes are all `fill`.
  static void write(McapWriter& writer, const std::string& topic, const std::string& idl,
                    std::size_t size, char fill, int count = 3) {
    const auto id = writer.channel(topic, {"A", "omgidl", idl}, "cdr", {});
    const std::string data = std::string("\0\1\0\0", 4) + std::string(size, fill);
    for (std::int64_t i = 0; i < count; ++i)
      writer.write({id, 1, i * 1'000'000'000, 0, bytes_of(data)});
  }
  std::string page() const {
    const auto recording = recording::open(path_);
    Page page("a", "b");
    for (const Overlay* overlay : overlays()) overlay->add_report(*recording, page);
    add_states(*recording, page);
    add_events(*recording, page);
    add_commands(*recording, nullptr, page);
    add_timing(*recording, page);
    add_topics(*recording, page);
    return page.html();
  }

  testing_support::TempFolder folder_;
  std::string path_ = (folder_ / "a.mcap").string();
};

TEST_F(HostileReport, FieldsThatAreNotThereAreLeftOut) {
  McapWriter writer = McapWriter::create(path_, "lss-cli test");
  for (const char* topic : {"lss/telemetry/z", "lss/status", "lss/event", "lss/command",
                            "lss/command_ack", "lss/timing"})
    write(writer, topic, "struct A { octet x; };", 1, 0);
  writer.close();
  EXPECT_THAT(page(), testing::HasSubstr("</html>"));
  const auto recording = recording::open(path_);
  const Table table(*recording, "telemetry", {"x"});
  EXPECT_EQ(table["x"].size(), 3u);
  ASSERT_EQ(table["mode"].size(), 3u);
  EXPECT_TRUE(std::isnan(table["mode"][2]));
}

TEST_F(HostileReport, TwoTypesUnderOneNameAreReportedApart) {
  McapWriter writer = McapWriter::create(path_, "lss-cli test");
  for (const char* topic : {"lss/telemetry/z", "lss/status"}) {
    write(writer, topic, "struct A { octet x; double mode[1000]; double y; };", 8 + 8008, 0);
    write(writer, topic, "struct A { octet x; };", 1, 1, 5);
    const auto raw = writer.channel(topic, {"A", "protobuf", "-"}, "protobuf", {});
    writer.write({raw, 1, 0, 0, {}});
  }
  writer.close();
  EXPECT_THAT(page(), testing::HasSubstr("</html>"));
  const auto recording = recording::open(path_);
  EXPECT_EQ(Table(*recording, "telemetry", {"y"}).size(), 3u);
}

TEST_F(HostileReport, TimesAndNumbersMayBeAnything) {
  McapWriter writer = McapWriter::create(path_, "lss-cli test");
  write(writer, "lss/timing",
        "struct A { unsigned long long frame; long long boundary_ns, woken_ns, read_ns, "
        "navigated_ns, ready_ns, released_ns, offset_ns; };",
        64, '\x7f');
  write(writer, "lss/event", "struct A { double severity; char text[4]; };", 12, '\xff');
  write(writer, "lss/command", "struct A { double kind; double flags; };", 16, '\x7e');
  writer.close();
  EXPECT_THAT(page(), testing::HasSubstr("</html>"));
}

// So far from zero a step of the grid is too small to be added.
TEST_F(HostileReport, GridsFarFromZeroHaveAnEnd) {
  for (const double at : {1e16, 1e300, -1e16, 0.0, 1e-300}) {
    for (const double wide : {0.0, 4.0, 1e10}) {
      LineChart chart{"a", "b", "c", {{"d", {at, at + wide}, {at, at + wide}, 0, false}}, {}};
      EXPECT_THAT(figure(chart), testing::HasSubstr("</figure>"));
      chart.equal = true;
      EXPECT_THAT(figure(chart), testing::HasSubstr("</figure>"));
      EXPECT_THAT(figure(RowChart{"a", "b", {}, {at, at + wide}, {}}),
                  testing::HasSubstr("</figure>"));
    }
  }
  constexpr double kHuge = std::numeric_limits<double>::max();
  EXPECT_TRUE(bars_of({0, 1}, {kHuge, -kHuge}, {{"c0", "a"}}).empty());
}

}  // namespace
}  // namespace lss::cli::report
