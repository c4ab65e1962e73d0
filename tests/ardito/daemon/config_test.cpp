#include "daemon/vehicles/ardito/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/vehicles/ardito/tunables.h"
#include "tests/support/config_file.h"

namespace lss::ardito {
namespace {

using testing::HasSubstr;

const testing_support::ConfigFile<Parameters> kFile("ardito", read_parameters);

TEST(ArditoConfig, TheExampleContainsTheDefaults) {
  const auto [config, p] = kFile.defaults(tuning());
  EXPECT_EQ(config.period_ns, 100 * kMillisecond);
  const Parameters d;
  EXPECT_EQ(p.bus.wheel_node, d.bus.wheel_node);
  EXPECT_EQ(p.bus.steering_node, d.bus.steering_node);
  EXPECT_EQ(p.bus.io_node, d.bus.io_node);
  EXPECT_EQ(p.bus.imu_node, d.bus.imu_node);
  EXPECT_EQ(p.bus.sync_lead_ns, d.bus.sync_lead_ns);
  EXPECT_EQ(p.bus.stale_after_ns, d.bus.stale_after_ns);
  EXPECT_EQ(p.bus.heartbeat_timeout_ns, d.bus.heartbeat_timeout_ns);
  EXPECT_DOUBLE_EQ(p.bus.wheel_acceleration_rpm_s, d.bus.wheel_acceleration_rpm_s);
  EXPECT_DOUBLE_EQ(p.bus.steering_speed_rad_s, d.bus.steering_speed_rad_s);
  EXPECT_DOUBLE_EQ(p.mobility.geometry.a_m, d.mobility.geometry.a_m);
  EXPECT_DOUBLE_EQ(p.mobility.geometry.f_m, d.mobility.geometry.f_m);
  EXPECT_DOUBLE_EQ(p.mobility.geometry.gear_ratio, d.mobility.geometry.gear_ratio);
  EXPECT_EQ(p.mobility.no_load_rad_s, d.mobility.no_load_rad_s);
  EXPECT_EQ(p.mobility.no_load_current, d.mobility.no_load_current);
  EXPECT_EQ(p.solver.order, d.solver.order);
}

TEST(ArditoConfig, EachSignOfTheCorrectionInItsRangeIsTaken) {
  for (const char* sign : {"-1", "0", "1"})
    EXPECT_EQ(kFile.error_of("correction_sign = 1", std::string("correction_sign = ") + sign), "");
  EXPECT_THAT(kFile.error_of("correction_sign = 1", "correction_sign = 2"),
              HasSubstr("out of range -1 to 1"));
}

TEST(ArditoConfig, NoLoadCurrentsAreFiveAtRisingSpeeds) {
  EXPECT_EQ(kFile.error_of("[0.05, 0.06, 0.07, 0.09, 0.13]", "[0.04, 0.05, 0.05, 0.06, 0.08]"), "");
  EXPECT_THAT(kFile.error_of("[0.05, 0.06, 0.07, 0.09, 0.13]", "[0.05, 0.06]"),
              HasSubstr("a list of 5 numbers"));
  EXPECT_THAT(kFile.error_of("[0.0, 1.0, 2.0, 4.0, 8.0]", "[0.0, 2.0, 1.0, 4.0, 8.0]"),
              HasSubstr("must rise"));
}

TEST(ArditoConfig, ASinkLimitOutOfItsRangeOrThatIsNoNumberIsRefused) {
  const auto error_of = [](const std::string& value) {
    return kFile.error_of("sink_limit_m = 0.06", "sink_limit_m = " + value);
  };
  for (const char* inside : {"0.03", "0.1", "0.5"}) EXPECT_EQ(error_of(inside), "") << inside;
  for (const char* outside : {"0.029", "0.51", "-0.06", "nan"})
    EXPECT_THAT(error_of(outside), HasSubstr("sink_limit_m")) << outside;
  EXPECT_THAT(error_of("\"deep\""), HasSubstr("sink_limit_m"));
}

// 3183 rpm/s are 1 m/s2 at the ground.
TEST(ArditoConfig, ARampOfTheDrivesThatMakesAQuickStopLongIsRefused) {
  const std::string as_shipped = "wheel_acceleration_rpm_s = 8000.0";
  for (const char* flat : {"100.0", "3100.0"})
    EXPECT_THAT(kFile.error_of(as_shipped, std::string("wheel_acceleration_rpm_s = ") + flat),
                HasSubstr("a quick stop takes too long"));
  EXPECT_EQ(kFile.error_of(as_shipped, "wheel_acceleration_rpm_s = 3200.0"), "");
  EXPECT_THAT(kFile.error_of("gear_ratio = 50.0", "gear_ratio = 200.0"),
              HasSubstr("make it larger"));
  Parameters p;
  p.bus.wheel_acceleration_rpm_s = 3200;
  EXPECT_EQ(tuning().check(p), nullptr);
  p.mobility.deceleration_m_s2 = 1.1;
  EXPECT_NE(tuning().check(p), nullptr) << "quick stops would brake less than others";
}

TEST(ArditoConfig, TwoNodesOfOneNumberAreRefused) {
  EXPECT_THAT(kFile.error_of("io_node = 32", "io_node = 3"), HasSubstr("node 3 is there twice"));
}

TEST(ArditoConfig, ADescriptionThatIsNotThereOrWrongIsReportedWithItsFile) {
  const auto described = [](const std::string& name) {
    return kFile.error_of("wheel_description = \"\"", "wheel_description = \"" + name + "\"");
  };
  EXPECT_EQ(described(LSS_DEVICES "/ardito-wheel.dcf"), "");
  EXPECT_THAT(described("nowhere.dcf"), HasSubstr("nowhere.dcf\" cannot be read"));
  EXPECT_THAT(described(LSS_DEVICES "/ardito-imu.dcf"),
              HasSubstr("signal HallVelocity is missing"));
  const std::string broken = testing::TempDir() + "broken.dcf";
  std::ofstream(broken) << "[1000\n";
  EXPECT_THAT(described(broken), HasSubstr("line 1: \"[1000\" is no section"));
}

TEST(ArditoConfig, AnUnknownStrategyIsRefusedWithTheOnesThereAre) {
  EXPECT_THAT(kFile.error_of("[\"retest\", \"isolate\"]", "[\"pray\"]"),
              HasSubstr("\"pray\" is no strategy"));
}

TEST(ArditoConfig, AWrongUnitIsReportedWithTheRightOne) {
  EXPECT_THAT(kFile.error_of("sync_lead_ms = 10", "sync_lead_s = 0.01"), HasSubstr("sync_lead_ms"));
}

}  // namespace
}  // namespace lss::ardito
