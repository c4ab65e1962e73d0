#include "daemon/vehicles/talaris/config.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "daemon/vehicles/talaris/tunables.h"
#include "tests/support/config_file.h"

namespace lss::talaris {
namespace {

const testing_support::ConfigFile<Parameters> kFile("talaris", read_parameters);

// As a number, from any type.
template <class T>
std::vector<double> numbers(const T& x) {
  const auto* first = reinterpret_cast<const double*>(&x);
  return {first, first + sizeof x / sizeof(double)};
}

TEST(TalarisConfig, TheExampleContainsTheDefaults) {
  const auto [config, p] = kFile.defaults(tuning());
  EXPECT_EQ(config.period_ns, 200 * kMillisecond);
  const Parameters d;
  EXPECT_EQ(config.offset_ns, d.offset_ns);
  EXPECT_EQ(p.buses.imu, d.buses.imu);
  EXPECT_EQ(p.buses.can.node, d.buses.can.node);
  EXPECT_EQ(p.buses.can.stale_after_ns, d.buses.can.stale_after_ns);
  EXPECT_EQ(p.buses.valves.renew_ns, d.buses.valves.renew_ns);
  EXPECT_EQ(p.solver.order, d.solver.order);
  EXPECT_EQ(p.fan_slew_us_s, d.fan_slew_us_s);
  EXPECT_EQ(p.refuelled, d.refuelled);
  // All of them are doubles.
  EXPECT_EQ(numbers(p.flight.body), numbers(d.flight.body));
  EXPECT_EQ(numbers(p.flight.thrusters), numbers(d.flight.thrusters));
  EXPECT_EQ(numbers(p.flight.fans), numbers(d.flight.fans));
  EXPECT_EQ(numbers(p.flight.gas), numbers(d.flight.gas));
  EXPECT_EQ(numbers(p.flight.profile), numbers(d.flight.profile));
  EXPECT_EQ(numbers(p.flight.limits), numbers(d.flight.limits));
  EXPECT_EQ(numbers(p.flight.gains[0]), numbers(d.flight.gains[0]));
  EXPECT_EQ(p.flight.gain_sets, 1u);
  const auto &n = p.navigation, &m = d.navigation;
  EXPECT_EQ(n.altimeter, m.altimeter);
  EXPECT_EQ(n.range_sigma_m, m.range_sigma_m);
  EXPECT_EQ(n.ground_slope_rad, m.ground_slope_rad);
  EXPECT_EQ(n.range_min_m, m.range_min_m);
  EXPECT_EQ(n.range_max_m, m.range_max_m);
  EXPECT_EQ(n.gate_sigma, m.gate_sigma);
  EXPECT_EQ(n.gate_reopens_after, m.gate_reopens_after);
  EXPECT_EQ(n.max_tilt_rad, m.max_tilt_rad);
  EXPECT_EQ(n.imu_period_s, m.imu_period_s);
  EXPECT_EQ(n.force_noise, m.force_noise);
  EXPECT_EQ(n.rate_noise, m.rate_noise);
  EXPECT_EQ(n.force_bias_walk, m.force_bias_walk);
  EXPECT_EQ(n.rate_bias_walk, m.rate_bias_walk);
  EXPECT_EQ(n.hold_s, m.hold_s);
  EXPECT_EQ(n.lost_attitude_rad, m.lost_attitude_rad);
  EXPECT_EQ(n.calibration_s, m.calibration_s);
  EXPECT_EQ(n.calibration_restarts, m.calibration_restarts);
  EXPECT_EQ(n.still_rate_rad_s, m.still_rate_rad_s);
  EXPECT_EQ(n.still_force_m_s2, m.still_force_m_s2);
  EXPECT_EQ(n.rate_spread_rad_s, m.rate_spread_rad_s);
  EXPECT_EQ(n.force_spread_m_s2, m.force_spread_m_s2);
  EXPECT_EQ(n.max_rate_bias_rad_s, m.max_rate_bias_rad_s);
  EXPECT_EQ(n.max_force_error_m_s2, m.max_force_error_m_s2);
  EXPECT_EQ(n.max_calibration_tilt_rad, m.max_calibration_tilt_rad);
  EXPECT_EQ(n.min_samples, m.min_samples);
  EXPECT_EQ(n.min_ranges, m.min_ranges);
  EXPECT_EQ(n.range_spread_m, m.range_spread_m);
  EXPECT_EQ(n.roll_rad, m.roll_rad);
  EXPECT_EQ(n.height_m, m.height_m);
  EXPECT_EQ(n.force_bias_sigma_m_s2, m.force_bias_sigma_m_s2);
  EXPECT_EQ(n.start_position_sigma_m, m.start_position_sigma_m);
  EXPECT_EQ(n.start_velocity_sigma_m_s, m.start_velocity_sigma_m_s);
  EXPECT_EQ(n.start_heading_sigma_rad, m.start_heading_sigma_rad);
  EXPECT_EQ(n.standing_sigma_m_s, m.standing_sigma_m_s);
  EXPECT_EQ(n.standing_sigma_rad_s, m.standing_sigma_rad_s);
  EXPECT_EQ(n.standing_sigma_m_s2, m.standing_sigma_m_s2);
  EXPECT_EQ(n.standing_sigma_rad, m.standing_sigma_rad);
  EXPECT_EQ(n.stand.position_sigma_m, m.stand.position_sigma_m);
  EXPECT_EQ(n.stand.velocity_sigma_m_s, m.stand.velocity_sigma_m_s);
  EXPECT_EQ(n.stand.attitude_sigma_rad, m.stand.attitude_sigma_rad);
  EXPECT_EQ(n.gravity_m_s2, m.gravity_m_s2);
  EXPECT_EQ(n.camera, m.camera);
  EXPECT_EQ(n.corners, m.corners);
  EXPECT_EQ(n.corner_x_m, m.corner_x_m);
  EXPECT_EQ(n.corner_y_m, m.corner_y_m);
  EXPECT_EQ(n.corner_z_m, m.corner_z_m);
  EXPECT_EQ(n.flow_period_s, m.flow_period_s);
  EXPECT_EQ(n.flow_sigma_rad_s, m.flow_sigma_rad_s);
  EXPECT_EQ(n.flow_scale_sigma, m.flow_scale_sigma);
  EXPECT_EQ(n.flow_min_m, m.flow_min_m);
  EXPECT_EQ(n.flow_max_m, m.flow_max_m);
  EXPECT_EQ(p.buses.camera.counts_per_rad, d.buses.camera.counts_per_rad);
  EXPECT_EQ(p.buses.camera.least_quality, d.buses.camera.least_quality);
  EXPECT_EQ(p.camera_silent_ns, d.camera_silent_ns);
}

// Every number of [talaris...]: a value outside all limits is an error that names the key.
TEST(TalarisConfig, EveryNumberHasItsRange) {
  const std::string text = kFile.text_of(LSS_CONFIG);
  const std::size_t own = text.find("[talaris.imu]");
  ASSERT_NE(own, std::string::npos);
  const std::regex number("\n([A-Za-z_0-9]+) = (-?[0-9][-0-9.e]*)");
  int count = 0;
  for (std::sregex_iterator i(text.begin() + static_cast<std::ptrdiff_t>(own), text.end(), number),
       end;
       i != end; ++i, ++count) {
    const std::string key = (*i)[1], value = (*i)[2];
    const bool whole = value.find_first_of(".e") == std::string::npos;
    std::string altered = text;
    altered.replace(own + static_cast<std::size_t>(i->position(2)), value.size(),
                    whole ? "987654321" : "9.87e9");
    const std::string error = kFile.error_of_text(altered);
    EXPECT_NE(error.find(key), std::string::npos) << key << ": " << error;
  }
  EXPECT_GT(count, 120);
}

TEST(TalarisConfig, ACameraIsAsExactAsItsCounts) {
  EXPECT_NE(kFile.error_of("counts_per_rad = 1000.0", "counts_per_rad = 1.0").find("at least 231"),
            std::string::npos);
  EXPECT_EQ(kFile.error_of("counts_per_rad = 1000.0", "counts_per_rad = 240.0"), "");
}

TEST(TalarisConfig, AnUnknownKeyIsReportedWithTheNearest) {
  EXPECT_NE(kFile.error_of("budget_s = 44.0", "budged_s = 44.0").find("budget_s"),
            std::string::npos);
}

TEST(TalarisConfig, AWrongUnitIsReportedWithTheRightOne) {
  EXPECT_NE(kFile.error_of("stale_ms = 450", "stale_s = 0.45").find("stale_ms"), std::string::npos);
}

TEST(TalarisConfig, TwoNodesOfOneNumberAreRefused) {
  EXPECT_NE(kFile.error_of("fan_node = 33", "fan_node = 32").find("two nodes have one number"),
            std::string::npos);
}

// With that of the Moon it would be calibrated there, and take off with six times its weight.
TEST(TalarisConfig, TheGravityIsThatForWhichTheFlightComputesItsThrust) {
  const auto error_of = [](const std::string& value) {
    return kFile.error_of("gravity_m_s2 = 9.80665", "gravity_m_s2 = " + value);
  };
  for (const char* on_earth : {"9.764", "9.834"}) EXPECT_EQ(error_of(on_earth), "") << on_earth;
  for (const char* elsewhere : {"1.62", "3.71", "11.0"})
    EXPECT_NE(error_of(elsewhere).find("gravity_m_s2"), std::string::npos) << elsewhere;
}

TEST(TalarisConfig, AxesOfTheImuMayBeTurnedButNotDoubled) {
  Parameters p;
  EXPECT_EQ(kFile.error_of("axes = [\"x\", \"y\", \"z\"]", "axes = [\"-z\", \"y\", \"x\"]"), "");
  const std::string path =
      testing::TempDir() + "talaris_altered_AxesOfTheImuMayBeTurnedButNotDoubled.toml";
  ASSERT_TRUE(kFile.load(path, p));
  EXPECT_EQ(p.imu_axes[0].axis, 2);
  EXPECT_EQ(p.imu_axes[0].sign, -1);
  EXPECT_NE(
      kFile.error_of("axes = [\"x\", \"y\", \"z\"]", "axes = [\"x\", \"-x\", \"z\"]").find("axes"),
      std::string::npos);
  EXPECT_NE(kFile.error_of("axes = [\"x\", \"y\", \"z\"]", "axes = [\"x\", \"u\", \"z\"]")
                .find("no axis"),
            std::string::npos);
  EXPECT_EQ(kFile.error_of("axes = [\"x\", \"y\"]", "axes = [\"-y\", \"x\"]"), "");
  EXPECT_NE(kFile.error_of("axes = [\"x\", \"y\"]", "axes = [\"x\", \"z\"]").find("no axis"),
            std::string::npos);
}

TEST(TalarisConfig, WhatDoesNotFitTogetherIsRefusedWithTheSentenceOfTheGnc) {
  EXPECT_NE(kFile.error_of("reserve_s = 3.0", "reserve_s = 50.0").find("reserve"),
            std::string::npos);
  EXPECT_NE(kFile.error_of("settled_rpm = 400.0", "settled_rpm = 100.0").find("settled_rpm"),
            std::string::npos);
}

TEST(TalarisConfig, SetsOfGainsAreCountedAndNamedOnce) {
  const std::string two = "[[talaris.gains]]\nname = \"soft\"\nheight_kp_1_s2 = 0.5\n\n";
  EXPECT_EQ(kFile.error_of("[talaris.load_cell]", two + "[talaris.load_cell]"), "");
  Parameters p;
  ASSERT_TRUE(
      kFile.load(testing::TempDir() + "talaris_altered_SetsOfGainsAreCountedAndNamedOnce.toml", p));
  EXPECT_EQ(p.flight.gain_sets, 2u);
  EXPECT_EQ(p.flight.gains[1].height_kp_1_s2, 0.5);
  EXPECT_EQ(p.flight.gains[1].attitude_zeta, 0.9);
  EXPECT_NE(kFile.error_of("[talaris.load_cell]", two + two + "[talaris.load_cell]").find("twice"),
            std::string::npos);
  std::string many;
  for (int i = 0; i < 8; ++i)
    many += "[[talaris.gains]]\nname = \"set" + std::to_string(i) + "\"\n\n";
  EXPECT_NE(kFile.error_of("[talaris.load_cell]", many + "[talaris.load_cell]").find("at most 8"),
            std::string::npos);
}

TEST(TalarisConfig, AnUnknownStrategyIsRefusedWithTheOnesThereAre) {
  EXPECT_NE(
      kFile.error_of("[\"realign\", \"reconnect\"]", "[\"pray\"]").find("\"pray\" is no strategy"),
      std::string::npos);
}

TEST(TalarisConfig, TheFilesOfTheCampaignsCanBeRead) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(LSS_CAMPAIGNS)) {
    if (entry.path().extension() != ".toml") continue;
    ++files;
    Parameters p;
    const auto config = kFile.load(entry.path().string(), p);
    EXPECT_TRUE(config) << config.error();
  }
  EXPECT_GE(files, 9);
}

}  // namespace
}  // namespace lss::talaris
