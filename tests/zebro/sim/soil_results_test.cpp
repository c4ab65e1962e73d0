// Writes how Lunar Zebro walks on each soil into docs/soil.md when LSS_WRITE_RESULTS is set.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "tests/support/section.h"
#include "tests/support/stamp.h"
#include "tests/zebro/sim/robot_driver.h"
#include "tools/lss-sim/zebro/motor.h"

namespace lss::sim::zebro {
namespace {

constexpr int kCycles = 2;

struct Walked {
  double standing_m = 0, speed_m_s = 0, sinkage_m = 0, torque_Nm = 0, tilt_deg = 0;
};

// Whole cycles after the first one; depth of the deepest leg on average, the largest torque of all.
Walked walk(const TerrainOptions& terrain, const Groups& groups) {
  RobotDriver driver(terrain);
  driver.stand_up();
  Walked walked;
  walked.standing_m = 0.053 - driver.body().position_m.z();
  driver.walk(groups, 1, +1, +1);
  const BodyState from = driver.body();
  const double began_s = driver.now_s();
  long steps = 0;
  driver.after_step = [&] {
    double deepest_m = 0;
    for (const LegInSoil& leg : driver.zebro().robot().legs_in_soil())
      deepest_m = std::max(deepest_m, leg.sinkage_m);
    for (const ShaftState& shaft : driver.zebro().robot().shafts())
      walked.torque_Nm = std::max(walked.torque_Nm, std::abs(shaft.torque_Nm));
    walked.sinkage_m += deepest_m;
    walked.tilt_deg = std::max(walked.tilt_deg, driver.moved(from).tilt_deg);
    ++steps;
  };
  driver.walk(groups, kCycles, +1, +1);
  walked.sinkage_m /= static_cast<double>(steps);
  walked.speed_m_s = driver.moved(from).ahead_m / (driver.now_s() - began_s);
  return walked;
}

TEST(SoilResults, Zebro) {
  if (std::getenv("LSS_WRITE_RESULTS") == nullptr)
    GTEST_SKIP() << "LSS_WRITE_RESULTS=1 writes docs/soil.md";
  std::string text =
      "Measured " + testing_support::stamp(LSS_SOIL_DOCUMENT) +
      " by\n`LSS_WRITE_RESULTS=1 zebro_soil_results_test`: open-loop script, seed 4, level ground, "
      "two cycles. Of tripod,\ntetrapod-B, wave: speed, depth of the deepest leg (mean), largest "
      "current and tilt; *standing*: depth of all legs.\n\n"
      "| soil, gravity | speed, mm/s | depth, mm | standing, mm | current, A | tilt, deg |\n"
      "|---|---|---|---|---|---|\n";
  const auto add = [](std::string& list, double value, int digits) {
    char number[40];
    std::snprintf(number, sizeof number, "%s%.*f", list.empty() ? "" : ", ", digits, value);
    list += number;
  };
  for (const char* soil : {"hard", "loam", "regolith", "regolith:0.25", "sand", "sand:0.25"}) {
    for (const double gravity_m_s2 : {soil::kEarth_m_s2, soil::kMoon_m_s2}) {
      const bool hard = soil == std::string("hard");
      std::string speed, depth, standing, current, tilt;
      for (const Groups* groups : {&kTripod, &kTetrapod, &kWave}) {
        TerrainOptions terrain{.gravity_m_s2 = gravity_m_s2, .seed = 4};
        if (!hard) terrain.soil = soil::parse_soil(soil);
        const Walked w = walk(terrain, *groups);
        EXPECT_TRUE(w.speed_m_s > 0.001) << soil;
        add(speed, w.speed_m_s * 1e3, 1);
        add(depth, w.sinkage_m * 1e3, 0);
        add(current, motor::current_A(w.torque_Nm, 0), 2);
        add(tilt, w.tilt_deg, 1);
        if (standing.empty()) add(standing, w.standing_m * 1e3, 0);
      }
      if (hard) depth = standing = "-";
      const std::string row = std::string("| ") + soil + (gravity_m_s2 > 5 ? ", Earth" : ", Moon") +
                              " | " + speed + " | " + depth + " | " + standing + " | " + current +
                              " | " + tilt + " |\n";
      text += row;
      std::printf("%s", row.c_str());
      std::fflush(stdout);
    }
  }
  testing_support::write_section(LSS_SOIL_DOCUMENT, "Lunar Zebro on soil", text);
}

}  // namespace
}  // namespace lss::sim::zebro
