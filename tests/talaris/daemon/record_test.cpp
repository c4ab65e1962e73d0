// Records of TALARIS' frames: a written record is read back unchanged, for any bytes.
#include "daemon/vehicles/talaris/record.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "daemon/record/json.h"

namespace lss::talaris {
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

TEST(TalarisRecord, WhatIsWrittenIsReadBack) {
  auto frame = std::make_unique<Frame>();
  frame->in.sample_count = 4;
  frame->in.samples[0] = {.time_ns = 5,
                          .reading = ImuPacket{.rate_rad_s = {0.1, 0.2, 0.3}, .count = 77}};
  frame->in.samples[1] = {.time_ns = 6, .reading = Range{.range_m = 1.5, .error = 0}};
  frame->in.samples[2] = {.time_ns = 7, .reading = GasState{.tank_Pa = 3e7}};
  frame->in.samples[3] = {.time_ns = 8,
                          .reading = ImuStatus{.kind = ImuStatus::Kind::scale, .value = 3}};
  frame->in.bus.can.status.link[2].node.emcy_code = 0x8130;
  frame->in.bus.edges.counters.pulses[7] = 12;
  frame->in.bus.imu.status.counters.parity = 4;
  frame->command.pulse[5] = {.delay_ns = 20, .on_ns = 40};
  frame->command.hold[1] = {true, 99};
  frame->command.fan_us[3] = 1500;
  frame->telemetry.valves[2].on_s = 0.25;
  frame->telemetry.script_id = 4'000'000'000u;
  const std::vector<std::uint8_t> bytes = written(*frame);
  auto read = std::make_unique<Frame>();
  record::Reader reader(bytes);
  fields(reader, *read);
  ASSERT_TRUE(reader.good());
  EXPECT_TRUE(reader.at_end());
  const auto json = record::to_json(*read);
  EXPECT_EQ(json.dump(), record::to_json(*frame).dump());
  EXPECT_EQ(json["in"]["samples"][0]["reading"]["count"], 77);
  EXPECT_EQ(json["in"]["samples"][1]["reading"]["range_m"], 1.5);
  EXPECT_EQ(json["in"]["bus"]["can"]["status"]["link"][2]["node"]["emcy_code"], 0x8130);
  EXPECT_EQ(json["in"]["bus"]["edges"]["counters"]["pulses"][7], 12);
  EXPECT_EQ(json["in"]["bus"]["imu"]["status"]["counters"]["parity"], 4);
  EXPECT_EQ(json["command"]["pulse"][5]["on_ns"], 40);
  EXPECT_EQ(json["command"]["fan_us"][3], 1500);
  EXPECT_EQ(json["telemetry"]["script_id"], 4'000'000'000u);
  EXPECT_EQ(written(*read), bytes);
  EXPECT_EQ(read->command, frame->command);
}

TEST(TalarisRecord, BrokenBytesAreNoRecordAndNothingWorse) {
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
}  // namespace lss::talaris
