// Records of Ardito as people see them; more in tests/safety/records.h.
#include <gtest/gtest.h>

#include "daemon/record/frame_record.h"
#include "daemon/record/json.h"
#include "daemon/vehicles/ardito/vehicle.h"

namespace lss::ardito {
namespace {

using Frame = record::FrameRecord<Vehicle>;

TEST(ArditoRecord, MembersAreShownByTheirNames) {
  auto frame = std::make_unique<Frame>();
  frame->in.sample_count = 2;
  frame->in.samples[0] = {.time_ns = 5, .reading = Imu{.Vtan_mm_s = 7, .sigma_rad = 0.1}};
  frame->in.samples[1] = {.time_ns = 6, .reading = WheelMotion{.wheel = 3, .motor_rpm = -9}};
  frame->in.bus.status.link[11].node.emcy_code = 0x8130;
  frame->in.bus.port.bus_offs = 2;
  frame->command.wheel[5].motor_rpm = 4.5;
  frame->telemetry.steering[2].target_rad = -0.25;
  const auto json = record::to_json(*frame);
  EXPECT_EQ(json["in"]["samples"][0]["reading"]["Vtan_mm_s"], 7);
  EXPECT_EQ(json["in"]["samples"][1]["reading"]["wheel"], 3);
  EXPECT_EQ(json["in"]["bus"]["status"]["link"][11]["node"]["emcy_code"], 0x8130);
  EXPECT_EQ(json["command"]["wheel"][5]["motor_rpm"], 4.5);
}

}  // namespace
}  // namespace lss::ardito
