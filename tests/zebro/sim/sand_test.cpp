// The computed effect of sand on Lunar Zebro: how deep a leg sinks (Bekker, as the Zebro thesis has
// it in B.3.2), what the soil that it compacts takes, and how far the leg slips until the soil
// gives that much thrust (Janosi and Hanamoto). Arithmetic with the real motor and gait, and no
// walk: soil_walk_test.cpp has those.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "gnc/zebro/gait.h"
#include "gnc/zebro/leg.h"
#include "tools/lss-sim/soil/soil.h"
#include "tools/lss-sim/zebro/motor.h"

namespace lss::sim::zebro {
namespace {

using gnc::zebro::kPi;
using gnc::zebro::Partition;

constexpr double kMass_kg = 1.5;
constexpr double kDiameter_m = 0.053;
constexpr double kWidth_m = 0.02;         // of a leg as built (Zebro thesis B.3.2)
constexpr double kMostSinkage_m = 0.010;  // that the leg was designed for, there too
constexpr double kSweep_rad = 40 * kPi / 180;
constexpr gnc::zebro::GaitTimes kTimes{3.0, 3.3, 0.3};

using soil::Soil;

double stiffness(const Soil& soil, double width_m) {
  return soil.cohesive / width_m + soil.frictional;
}

// A leg is taken for a wheel: the chord that the surface cuts off it.
double footprint_m2(double sinkage_m, double width_m) {
  return width_m * 2 * std::sqrt(sinkage_m * (kDiameter_m - sinkage_m));
}

double sinkage_m(const Soil& soil, double load_N, double width_m) {
  double above = 0, below = kDiameter_m / 2;
  for (int i = 0; i < 60; ++i) {
    const double z = (above + below) / 2;
    const double carried_N =
        footprint_m2(z, width_m) * stiffness(soil, width_m) * std::pow(z, soil.exponent);
    (carried_N < load_N ? above : below) = z;
  }
  return above;
}

// Work of pressing the rut down, per way.
double compaction_N(const Soil& soil, double sinkage_m, double width_m) {
  return width_m * stiffness(soil, width_m) * std::pow(sinkage_m, soil.exponent + 1) /
         (soil.exponent + 1);
}

TEST(Sinkage, IsThatOfTheThesis) {
  // B.3.2: a leg 0.55 cm wide that carries all of Lunar Zebro on the Moon sinks in by 1 cm.
  EXPECT_NEAR(sinkage_m(soil::parse_soil("regolith"), kMass_kg * soil::kMoon_m_s2, 0.0055), 0.010,
              0.0002);
}

struct Case {
  Soil soil;
  const char* gait;
  Partition partition;
  int standing;  // legs on the ground at least
};

class Sand : public testing::TestWithParam<Case> {};

// [Oper-8] [Ver-1]
TEST_P(Sand, LeavesTorqueAndThrustForAMillimetrePerSecond) {
  const Case& c = GetParam();
  const double load_N = kMass_kg * c.soil.measured_m_s2 / c.standing;
  const double depth_m = sinkage_m(c.soil, load_N, kWidth_m);
  EXPECT_LT(depth_m, kMostSinkage_m);

  // At the hip: the soil at the lowest point of the leg, and the weight at the foot furthest ahead
  // or behind.
  const double resistance_N = compaction_N(c.soil, depth_m, kWidth_m);
  const double cycle_s = gnc::zebro::cycle_time_s(c.partition, kTimes);
  const double stance_s = cycle_s - kTimes.flight_s;
  const double torque_Nm =
      resistance_N * kDiameter_m + load_N * kDiameter_m * std::sin(kSweep_rad / 2);
  EXPECT_LT(torque_Nm, 0.5 * motor::torque_limit_Nm(kSweep_rad / stance_s));
  EXPECT_LT(motor::current_A(torque_Nm, kSweep_rad / stance_s), 1.2)
      << "below the software limit of the current";

  const double strength_N =
      footprint_m2(depth_m, kWidth_m) * c.soil.cohesion_Pa + load_N * std::tan(c.soil.friction_rad);
  ASSERT_LT(resistance_N, strength_N) << "the leg digs itself in";
  const double slip_m = -c.soil.shear_m * std::log(1 - resistance_N / strength_N);
  const double speed_m_s = (gnc::zebro::stride_m(kSweep_rad, kDiameter_m) - slip_m) / stance_s;
  std::printf("%s %s: sinks %.1f mm, resists %.2f N of %.2f N, %.0f mN m, %.2f mm/s\n",
              c.soil.name.data(), c.gait, depth_m * 1e3, resistance_N, strength_N, torque_Nm * 1e3,
              speed_m_s * 1e3);
  EXPECT_GT(speed_m_s, 0.001);
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Soil& soil : soil::soils()) {
    all.push_back({soil, "Tripod", gnc::zebro::kTripod, 3});
    all.push_back({soil, "Tetrapod", gnc::zebro::kTetrapodB, 4});
    all.push_back({soil, "Wave", gnc::zebro::kWave, 5});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Soils, Sand, testing::ValuesIn(cases()), [](const auto& test) {
  return std::string(test.param.soil.name) + "_" + test.param.gait;
});

}  // namespace
}  // namespace lss::sim::zebro
