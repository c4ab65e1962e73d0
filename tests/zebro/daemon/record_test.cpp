// Records of frames: a written record is read back unchanged, for any bytes.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "daemon/record/frame_record.h"
#include "daemon/record/json.h"
#include "daemon/record/run_log.h"
#include "daemon/vehicles/zebro/vehicle.h"
#include "tests/support/temp_folder.h"

namespace lss::zebro {
namespace {

using Frame = record::FrameRecord<Vehicle>;

TEST(Record, MembersAreShownByTheirNames) {
  auto frame = std::make_unique<Frame>();
  frame->in.sample_count = 2;
  frame->in.samples[1] = {.time_ns = 5, .module = 3, .code = 64, .data = {1, 2, 3}};
  frame->in.request_count = 1;
  frame->in.requests[0].source = {'m', 'e'};
  frame->in.requests[0].parameter[7] = std::numeric_limits<double>::quiet_NaN();
  frame->in.bus.counters.module[6].resends = 9;
  frame->command.module[5].serial = 4;
  frame->state.controller.state = State::fatal_error;
  frame->state.faults[0].id = FaultId::port_lost;
  frame->telemetry.modules[2].current_A = 0.5;
  frame->timing.margin_ns = -3;
  const auto json = record::to_json(*frame);
  EXPECT_EQ(json["in"]["samples"].size(), 2u);
  EXPECT_EQ(json["in"]["samples"][1]["module"], 3);
  EXPECT_EQ(json["in"]["requests"][0]["source"], "me");
  EXPECT_EQ(json["in"]["bus"]["counters"]["module"][6]["resends"], 9);
  EXPECT_EQ(json["command"]["module"][5]["serial"], 4);
  EXPECT_EQ(json["state"]["controller"]["state"], "FatalError");
  EXPECT_EQ(json["state"]["faults"][0]["id"], "port_lost");
  EXPECT_EQ(json["telemetry"]["modules"][2]["current_A"], 0.5);
  EXPECT_EQ(json["timing"]["margin_ns"], -3);
  EXPECT_NE(json["in"]["requests"][0]["parameter"].dump().find("null"), std::string::npos);
}

std::vector<std::uint8_t> written(const Frame& frame) {
  std::vector<std::uint8_t> bytes(sizeof(Frame));
  record::Writer writer(bytes);
  fields(writer, frame);
  EXPECT_TRUE(writer.fits());
  bytes.resize(writer.size());
  return bytes;
}

// Fills every member with a valid value.
class Randomiser {
 public:
  explicit Randomiser(std::uint32_t seed) : x_(seed) {}
  template <class T>
  void operator()(const char*, T& x) {
    fill(x);
  }
  template <class T, std::size_t N>
  void list(const char*, std::array<T, N>& x, std::uint32_t& count) {
    count = next() % static_cast<std::uint32_t>(N + 1);
    for (std::uint32_t i = 0; i < count; ++i) fill(x[i]);
  }

 private:
  std::uint32_t next() { return x_ = x_ * 1664525 + 1013904223; }
  template <class T>
  void fill(T& x) {
    if constexpr (std::same_as<T, bool>) {
      x = (next() >> 31) != 0;
    } else if constexpr (record::Number<T>) {
      std::array<std::uint8_t, sizeof(T)> bytes;
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(next() >> 24);
      std::memcpy(&x, bytes.data(), sizeof x);
    } else {
      record::visit(*this, x);
    }
  }
  template <record::Array T>
  void fill(T& x) {
    for (auto& element : x) fill(element);
  }
  std::uint32_t x_;
};

TEST(Record, AnyRecordIsReadBackTheSame) {
  EXPECT_TRUE(rc::check([](std::uint32_t seed) {
    auto frame = std::make_unique<Frame>();
    Randomiser random(seed);
    fields(random, *frame);
    const std::vector<std::uint8_t> bytes = written(*frame);
    auto read = std::make_unique<Frame>();
    record::Reader reader(bytes);
    fields(reader, *read);
    RC_ASSERT(reader.good());
    RC_ASSERT(reader.at_end());
    RC_ASSERT(written(*read) == bytes);
  }));
}

// The whole way of a frame into a file of the log that runs.
TEST(Record, AnyRecordGoesThroughTheLogPartByPart) {
  const testing_support::TempFolder folder;
  const auto to_json = [](std::span<const std::uint8_t> bytes) {
    auto frame = std::make_unique<Frame>();
    record::Reader reader(bytes);
    fields(reader, *frame);
    return record::to_json(*frame);
  };
  EXPECT_TRUE(rc::check([&](std::uint32_t seed, std::uint8_t chosen) {
    auto frame = std::make_unique<Frame>();
    Randomiser random(seed);
    fields(random, *frame);
    const std::vector<std::uint8_t> bytes = written(*frame);

    const unsigned what = chosen & config::kAllLogParts;
    RC_PRE(what != 0);
    bool trouble = false;
    record::RunLog log({.name = "any", .what = what, .every_ns = 0}, folder, "z",
                       nlohmann::ordered_json::object(), to_json, [&](EventId) { trouble = true; });
    log.put({.events = true, .time_ns = 5}, bytes, 0, 5);
    RC_ASSERT(!trouble);

    std::filesystem::path path;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) path = entry.path();
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    const auto first = nlohmann::ordered_json::parse(line);
    RC_ASSERT(first["what"].size() == static_cast<std::size_t>(std::popcount(what)));
    std::getline(file, line);
    std::filesystem::remove(path);
    auto logged = nlohmann::ordered_json::parse(line);
    RC_ASSERT(logged["frame"] == frame->in.frame);
    // As it is in the record; a second dump takes bytes that are no text, and NaN, as the first
    // did.
    using Json = nlohmann::ordered_json;
    Json whole = Json::parse(record::line_of(record::to_json(*frame)));
    whole.erase("data_requested");  // of no part: replay does not compare the log
    std::size_t parts = 0;
    for (const auto& [key, part] : whole.items()) {
      if (!logged.contains(key)) continue;
      RC_ASSERT(logged[key] == part);
      ++parts;
    }
    RC_ASSERT(parts == first["what"].size());
    if (what == config::kAllLogParts) RC_ASSERT(parts == whole.size());
  }));
}

TEST(Record, ABufferThatIsTooSmallIsReportedAndNotOverrun) {
  auto frame = std::make_unique<Frame>();
  std::array<std::uint8_t, 100> bytes{};
  record::Writer writer(std::span<std::uint8_t>(bytes.data(), 50));
  fields(writer, *frame);
  EXPECT_FALSE(writer.fits());
  for (std::size_t i = 50; i < bytes.size(); ++i) EXPECT_EQ(bytes[i], 0);
}

}  // namespace
}  // namespace lss::zebro
