// Records of Ardito's frames: a written record is read back unchanged, for any bytes.
#include "daemon/vehicles/ardito/record.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "daemon/record/json.h"

namespace lss::ardito {
namespace {

using Frame = record::FrameRecord<Vehicle>;

std::vector<std::uint8_t> written(const Frame& f) {
  std::vector<std::uint8_t> bytes(sizeof(Frame));
  record::Writer writer(bytes);
  fields(writer, record::FrameView<Vehicle>{f.in, f.command, f.outbox, f.state, f.telemetry,
                                            f.data_requested, f.timing});
  EXPECT_TRUE(writer.fits());
  bytes.resize(writer.size());
  return bytes;
}

TEST(ArditoRecord, WhatIsWrittenIsReadBack) {
  auto frame = std::make_unique<Frame>();
  frame->in.sample_count = 2;
  frame->in.samples[0] = {.time_ns = 5, .reading = Imu{.Vtan_mm_s = 7, .sigma_rad = 0.1}};
  frame->in.samples[1] = {.time_ns = 6, .reading = WheelMotion{.wheel = 3, .motor_rpm = -9}};
  frame->in.bus.status.link[11].node.emcy_code = 0x8130;
  frame->in.bus.port.bus_offs = 2;
  frame->command.wheel[5].motor_rpm = 4.5;
  frame->telemetry.steering[2].target_rad = -0.25;
  const std::vector<std::uint8_t> bytes = written(*frame);
  auto read = std::make_unique<Frame>();
  record::Reader reader(bytes);
  fields(reader, *read);
  ASSERT_TRUE(reader.good());
  EXPECT_TRUE(reader.at_end());
  const auto json = record::to_json(*read);
  EXPECT_EQ(json.dump(), record::to_json(*frame).dump());
  EXPECT_EQ(json["in"]["samples"][0]["reading"]["Vtan_mm_s"], 7);
  EXPECT_EQ(json["in"]["samples"][1]["reading"]["wheel"], 3);
  EXPECT_EQ(json["in"]["bus"]["status"]["link"][11]["node"]["emcy_code"], 0x8130);
  EXPECT_EQ(json["command"]["wheel"][5]["motor_rpm"], 4.5);
  EXPECT_EQ(written(*read), bytes);
}

TEST(ArditoRecord, BrokenBytesAreNoRecordAndNothingWorse) {
  auto frame = std::make_unique<Frame>();
  frame->in.sample_count = 3;
  const std::vector<std::uint8_t> good = written(*frame);
  EXPECT_TRUE(rc::check([&] {
    std::vector<std::uint8_t> bytes = good;
    bytes.resize(*rc::gen::inRange<std::size_t>(0, good.size()));
    for (int i = 0; i < 10 && !bytes.empty(); ++i)
      bytes[*rc::gen::inRange<std::size_t>(0, bytes.size())] = *rc::gen::arbitrary<std::uint8_t>();
    record::Reader reader(bytes);
    fields(reader, *frame);
    RC_ASSERT(!reader.good() || reader.at_end());
  }));
}

}  // namespace
}  // namespace lss::ardito
