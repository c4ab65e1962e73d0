// Records of frames: what is written is read back, whatever bytes come.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstring>

#include "daemon/record/json.h"
#include "daemon/vehicles/zebro_record.h"

namespace lss::zebro {
namespace {

using Frame = record::FrameRecord<Vehicle>;

TEST(Record, WhatIsWrittenIsReadBack) {
  auto frame = std::make_unique<Frame>();
  frame->in.frame = 7;
  frame->in.sample_count = 2;
  frame->in.samples[1] = {.time_ns = 5, .module = 3, .code = 64, .data = {1, 2, 3}};
  frame->in.request_count = 1;
  frame->in.requests[0].source = {'m', 'e'};
  frame->in.requests[0].parameter[7] = std::numeric_limits<double>::quiet_NaN();
  frame->in.bus.counters.module[6].resends = 9;
  frame->command.module[5].serial = 4;
  frame->outbox.event_count = 1;
  frame->outbox.events[0].id = 1011;
  frame->state.controller.state = State::fatal_error;
  frame->state.faults[0].id = FaultId::port_lost;
  frame->telemetry.modules[2].current_A = 0.5;
  frame->timing.margin_ns = -3;

  std::vector<std::uint8_t> bytes(sizeof(Frame));
  record::Writer writer(bytes);
  fields(writer, record::FrameView<Vehicle>{frame->in, frame->command, frame->outbox, frame->state,
                                            frame->telemetry, frame->timing});
  ASSERT_TRUE(writer.fits());
  bytes.resize(writer.size());

  auto read = std::make_unique<Frame>();
  record::Reader reader(bytes);
  fields(reader, *read);
  ASSERT_TRUE(reader.good());
  EXPECT_TRUE(reader.at_end());
  const auto json = record::to_json(*read);
  EXPECT_EQ(json.dump(), record::to_json(*frame).dump());
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

// Fills every member with something that it may hold.
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
      fields(*this, x);
    }
  }
  template <class T, std::size_t N>
  void fill(std::array<T, N>& x) {
    for (T& element : x) fill(element);
  }
  std::uint32_t x_;
};

TEST(Record, AnyRecordIsReadBackTheSame) {
  EXPECT_TRUE(rc::check([](std::uint32_t seed) {
    auto frame = std::make_unique<Frame>();
    Randomiser random(seed);
    fields(random, *frame);
    const auto bytes_of = [](const Frame& f) {
      std::vector<std::uint8_t> bytes(sizeof(Frame));
      record::Writer writer(bytes);
      fields(writer, f);
      RC_ASSERT(writer.fits());
      bytes.resize(writer.size());
      return bytes;
    };
    const std::vector<std::uint8_t> bytes = bytes_of(*frame);
    auto read = std::make_unique<Frame>();
    record::Reader reader(bytes);
    fields(reader, *read);
    RC_ASSERT(reader.good());
    RC_ASSERT(reader.at_end());
    RC_ASSERT(bytes_of(*read) == bytes);
  }));
}

TEST(Record, ACutOrBrokenRecordIsNotGoodAndReadsNothingBeyondItsEnd) {
  std::vector<std::uint8_t> bytes(sizeof(Frame), 0xFF);
  for (const std::size_t size : {0u, 1u, 17u, 1000u}) {
    auto frame = std::make_unique<Frame>();
    record::Reader reader(std::span<const std::uint8_t>(bytes.data(), size));
    fields(reader, *frame);
    EXPECT_FALSE(reader.good()) << size;
    EXPECT_LE(frame->in.sample_count, frame->in.samples.size());
  }
}

TEST(Record, ABufferThatIsTooSmallIsToldAndNotOverrun) {
  auto frame = std::make_unique<Frame>();
  std::array<std::uint8_t, 100> bytes{};
  record::Writer writer(std::span<std::uint8_t>(bytes.data(), 50));
  fields(writer, *frame);
  EXPECT_FALSE(writer.fits());
  for (std::size_t i = 50; i < bytes.size(); ++i) EXPECT_EQ(bytes[i], 0);
}

}  // namespace
}  // namespace lss::zebro
