// Telemetry contains the reports of the modules, in SI units. The replies are the golden frames of
// docs/icd-zebro.md.

#include <gtest/gtest.h>

#include "world.h"

namespace lss::zebro {
namespace {

// [O-Int-3] [O-Int-4]
TEST(Telemetry, HasWhatAModuleReportsInSiUnits) {
  World w;
  w.run(0.2);
  const auto reply = [&](Code code, const std::array<std::uint8_t, 8>& data) {
    w.in_.samples[w.in_.sample_count++] = {.time_ns = w.time_ns_ + 1,
                                           .module = 2,
                                           .code = static_cast<std::uint8_t>(code),
                                           .data = data};
  };
  w.in_.sample_count = w.in_.request_count = 0;
  reply(Code::status, {0x00, 0x07, 0x23, 0x28, 0xFB, 0x50, 0x00, 0x96});
  reply(Code::health, {0xFB, 0xE6, 0x2E, 0xE0, 0x23, 0x28, 0x02, 0xEE});
  reply(Code::identity, {0x01, 0x02, 0x03, 0x07, 0x00, 0x01, 0xE2, 0x40});
  w.in_.time_ns = w.time_ns_ + 2;
  cycle(w.vehicle_, w.supervisor_, w.in_, w.out_, [](Stage) {});

  const lss_ZebroModule& m = w.out_.telemetry.modules[2];
  EXPECT_EQ(m.id, 3);
  EXPECT_EQ(m.flags, 0x0007);
  EXPECT_TRUE(m.online && m.calibrated && m.motion_control && m.moving);
  EXPECT_NEAR(m.position_rad, 1.570796, 1e-6);
  EXPECT_NEAR(m.velocity_rad_s, -2.094395, 1e-6);
  EXPECT_NEAR(m.current_A, 0.150, 1e-9);
  EXPECT_NEAR(m.temperature_degC, -10.50, 1e-9);
  EXPECT_NEAR(m.supply_V, 12.0, 1e-9);
  EXPECT_NEAR(m.set_point_rad, 1.570796, 1e-6);
  EXPECT_NEAR(m.time_left_s, 0.750, 1e-9);
  EXPECT_EQ(m.firmware_major, 1);
  EXPECT_EQ(m.firmware_minor, 2);
  EXPECT_EQ(m.reset_cause, 3);
  EXPECT_EQ(m.dropped_frames, 7);
  EXPECT_NEAR(m.uptime_s, 123.456, 1e-9);
}

TEST(Telemetry, WhatWasHeardAfterTheBoundaryWasHeardNow) {
  World w;
  w.run(0.2);
  w.in_.request_count = 0;
  w.in_.sample_count = 1;
  w.in_.samples[0] = {.time_ns = w.time_ns_ + 5 * kMillisecond,
                      .module = 2,
                      .code = static_cast<std::uint8_t>(Code::status),
                      .data = {0x00, 0x07, 0x23, 0x28, 0xFB, 0x50, 0x00, 0x96}};
  w.in_.time_ns = w.time_ns_ + 2 * kMillisecond;
  cycle(w.vehicle_, w.supervisor_, w.in_, w.out_, [](Stage) {});
  EXPECT_EQ(w.out_.telemetry.modules[2].age_ms, 0u);
}

}  // namespace
}  // namespace lss::zebro
