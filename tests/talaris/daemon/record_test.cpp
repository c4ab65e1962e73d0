// Records of TALARIS as people see them; more in tests/safety/records.h.
#include <gtest/gtest.h>

#include "daemon/record/json.h"
#include "daemon/vehicles/talaris/vehicle.h"

namespace lss::talaris {
namespace {

using Frame = record::FrameRecord<Vehicle>;

TEST(TalarisRecord, MembersAreShownByTheirNames) {
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
  const auto json = record::to_json(*frame);
  EXPECT_EQ(json["in"]["samples"][0]["reading"]["count"], 77);
  EXPECT_EQ(json["in"]["samples"][1]["reading"]["range_m"], 1.5);
  EXPECT_EQ(json["in"]["bus"]["can"]["status"]["link"][2]["node"]["emcy_code"], 0x8130);
  EXPECT_EQ(json["in"]["bus"]["edges"]["counters"]["pulses"][7], 12);
  EXPECT_EQ(json["in"]["bus"]["imu"]["status"]["counters"]["parity"], 4);
  EXPECT_EQ(json["command"]["pulse"][5]["on_ns"], 40);
  EXPECT_EQ(json["command"]["fan_us"][3], 1500);
  EXPECT_EQ(json["telemetry"]["script_id"], 4'000'000'000u);
}

}  // namespace
}  // namespace lss::talaris
