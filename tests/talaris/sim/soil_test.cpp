// TALARIS on soil: how deep its footpads sink, how far they slide, and that nothing of it gives
// energy. Constants and formulas are written down here once more.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "idl/angles.h"
#include "tests/support/cpu_time.h"
#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::sim::talaris {
namespace {

const Vector3 kNoPush = Vector3::Zero();
constexpr double kWeight_N = 45 * kGravity_m_s2;
constexpr double kRadius_m = 0.05, kPad_m2 = std::numbers::pi * kRadius_m * kRadius_m;

void run(Plant& plant, double seconds, const Wrench& wrench = {}, const Vector3& push = kNoPush) {
  for (int i = 0; i < std::lround(seconds / kStep_s); ++i) plant.step(wrench, 0, push);
}

// As docs/soil.md prints them, kilo and milli resolved; gravity where they are valid.
struct Constants {
  const char* name;
  double n, kc, kphi, cohesion_Pa, phi_deg, shear_m, gravity_m_s2;
  double factor = 1;

  double stiffness() const {
    return factor * (kc / kRadius_m + kphi * kGravity_m_s2 / gravity_m_s2);
  }
  double depth_m(double load_N) const { return std::pow(load_N / kPad_m2 / stiffness(), 1 / n); }
  // Of the whole vehicle on four pads.
  double strength_N() const {
    return 4 * kPad_m2 * factor * cohesion_Pa + kWeight_N * std::tan(phi_deg * kDegree);
  }
};
constexpr Constants kConstants[] = {
    {"sand", 1.1, 990, 1'528'430, 1'040, 28, 0.025, 9.81},
    {"loam", 0.7, 5'270, 1'515'040, 1'720, 29, 0.025, 9.81},
    {"regolith", 1.0, 1'400, 820'000, 170, 35, 0.0178, 1.625},
    {"sand:0.25", 1.1, 990, 1'528'430, 1'040, 28, 0.025, 9.81, 0.25},
};
std::ostream& operator<<(std::ostream& out, const Constants& c) { return out << c.name; }

class TalarisOnSoil : public testing::TestWithParam<Constants> {
 protected:
  PlantOptions on(double height_m = 0) const {
    return {.height_m = height_m, .soil = soil::parse_soil(GetParam().name)};
  }
  double rest_m() const { return GetParam().depth_m(kWeight_N / 4); }
};
INSTANTIATE_TEST_SUITE_P(Soils, TalarisOnSoil, testing::ValuesIn(kConstants), [](const auto& soil) {
  std::string name = soil.param.name;
  std::ranges::replace_if(
      name, [](char c) { return c == ':' || c == '.'; }, '_');
  return name;
});

TEST_P(TalarisOnSoil, AWeightThatComesSlowlyPressesItsPadsInAsBekkerSays) {
  Plant plant(on(rest_m() + 0.005));
  EXPECT_FALSE(plant.contact());
  constexpr int kSteps = 20'000;
  for (int i = 0; i < kSteps; ++i)
    plant.step({.force_N = {kWeight_N * (1 - (i + 1.0) / kSteps), 0, 0}}, 0, kNoPush);
  run(plant, 1);
  for (std::size_t foot = 0; foot < Plant::kFeet; ++foot)
    EXPECT_NEAR(plant.sinkage_m(foot), rest_m(), 0.02 * rest_m()) << foot;
  // where it stood from the beginning, the origin
  EXPECT_NEAR(plant.body().position_m.x(), 0, 0.02 * rest_m() + 1e-5);
}

TEST_P(TalarisOnSoil, StandsFromTheBeginningAsDeepAndStill) {
  Plant plant(on());
  for (int i = 0; i < 3'000; ++i) {
    run(plant, kStep_s);
    ASSERT_LT(plant.body().velocity_m_s.norm(), 1e-4);
  }
  EXPECT_LT(plant.body().position_m.norm(), 1e-5);
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-9);
  EXPECT_NEAR(plant.body().force_B_m_s2.x(), kGravity_m_s2, 1e-6);
  EXPECT_NEAR(plant.sinkage_m(0), rest_m(), 1e-3 * rest_m());
  EXPECT_NEAR(plant.clearance_m(), -rest_m() - kWeight_N / 160e3, 1e-5);
  EXPECT_TRUE(plant.contact());
}

TEST_P(TalarisOnSoil, DropsInDeeperThanItStandsAndStaysThere) {
  Plant plant(on(0.15 + rest_m()));
  run(plant, 2);
  const double depth_m = plant.sinkage_m(0);
  EXPECT_GT(depth_m, 1.5 * rest_m());
  // The work of the soil, deeper by what the leg takes: no more than was there to fall.
  const Constants& c = GetParam();
  const double work_J = 4 * kPad_m2 * c.stiffness() * std::pow(depth_m, c.n + 1) / (c.n + 1);
  const double fallen_J = kWeight_N * (0.15 + depth_m);
  EXPECT_LT(work_J, fallen_J);
  run(plant, 2);
  EXPECT_EQ(plant.sinkage_m(0), depth_m);
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-6);
  EXPECT_NEAR(-plant.clearance_m(), depth_m + kWeight_N / 160e3, 1e-5);
}

TEST_P(TalarisOnSoil, EnergyDoesNotGrow) {
  for (const double tilt_rad : {0.0, 0.12}) {
    PlantOptions options = on(0.3);
    options.tilt_rad = tilt_rad;
    options.cg_m = {0.01, 0.01, -0.01};
    Plant plant(options);
    run(plant, 0.15, {.torque_Nm = {5, 0, 0}}, {0, 60, 80});  // it comes down turning and sideways
    double least_J = plant.energy_J();
    const double before_J = least_J;
    for (int i = 0; i < 4'000; ++i) {
      run(plant, kStep_s);
      ASSERT_LT(plant.energy_J(), least_J + 5e-3) << tilt_rad << " rad, " << i << " ms";
      least_J = std::min(least_J, plant.energy_J());
    }
    EXPECT_LT(plant.energy_J(), before_J - 0.15 * kWeight_N);
    EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-4);
    EXPECT_LT(plant.body().rate_B_rad_s.norm(), 1e-4);
  }
}

TEST_P(TalarisOnSoil, APushBelowTheStrengthMovesItAsFarAsTheShearBuildsUp) {
  const Constants& c = GetParam();
  const double push_N = 0.5 * c.strength_N();
  Plant plant(on());
  constexpr int kSteps = 20'000;  // faster it would overshoot
  for (int i = 0; i < kSteps; ++i) plant.step({}, 0, {0, 0, push_N * (i + 1) / kSteps});
  run(plant, 2, {}, {0, 0, push_N});
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-6);
  // the strength that it needs, and its legs
  double moved_m = 0;
  for (const double z : {-0.40, 0.40}) {
    const Vector3 foot(-0.25, 0.30, z);
    const BodyState& body = plant.body();
    moved_m += (body.position_m + body.attitude * foot - foot).z() / 2;
  }
  EXPECT_NEAR(moved_m, -c.shear_m * std::log(1 - 0.5) + push_N / 160e3, 1e-3);
}

TEST_P(TalarisOnSoil, ASlideStopsOverTheWayThatShearTakes) {
  const Constants& c = GetParam();
  const double push_N = 1.4 * c.strength_N();
  Plant plant(on());
  run(plant, 0.25, {}, {0, 0, push_N});
  const double pushed_m = plant.body().position_m.z();
  EXPECT_GT(plant.body().velocity_m_s.z(), 0.2);
  run(plant, 3);
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-6);
  // The work of the push is that of the shear: strength (d - K (1 - exp(-d/K))).
  const auto work_J = [&](double d) {
    return c.strength_N() * (d - c.shear_m * (1 - std::exp(-d / c.shear_m)));
  };
  double way_m = pushed_m;
  while (work_J(way_m) < push_N * pushed_m) way_m += 1e-5;
  EXPECT_NEAR(plant.body().position_m.z(), way_m, 0.1 * way_m);
}

TEST_P(TalarisOnSoil, AFootThatComesOutComesDownOnUntouchedGround) {
  Plant plant(on());
  run(plant, 0.3, {.force_N = {2 * kWeight_N, 0, 0}});
  ASSERT_GT(plant.clearance_m(), 0.1);
  EXPECT_FALSE(plant.contact());
  EXPECT_EQ(plant.sinkage_m(0), 0);
  run(plant, 3);
  EXPECT_GT(plant.touchdown().down_m_s, 0.5);
  EXPECT_GT(plant.sinkage_m(0), 1.5 * rest_m());
}

TEST(TalarisOnSoils, AHeavierSideSinksDeeperAndItStandsStillOnASlope) {
  Plant plant({.cg_m = {0, 0, 0.05},
               .height_m = 0.05,
               .slope_rad = 4 * kDegree,
               .soil = soil::parse_soil("sand")});
  run(plant, 4);
  EXPECT_GT(plant.sinkage_m(1), 1.1 * plant.sinkage_m(0));  // z = +0.4, -0.4
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-5);
  const double at_m = plant.body().position_m.z();
  run(plant, 20);
  EXPECT_NEAR(plant.body().position_m.z(), at_m, 1e-4);
}

// What the IMU feels of a touchdown at 0.2 m/s above the lift, which carries all of the weight.
struct Felt {
  double pair_m_s2 = 0;  // as gnc/talaris/contact.h: the harder of two samples in a row, 5 ms apart
  double mean_m_s2 = 0;  // of the 200 ms after it
};
Felt touch_down(const char* ground) {
  PlantOptions options{.height_m = 0.1};
  if (ground != std::string("hard")) options.soil = soil::parse_soil(ground);
  Plant plant(options);
  run(plant, 0.2 / kGravity_m_s2);
  Felt felt;
  double before_m_s2 = 0;
  for (int i = 0, since = 0; since < 200; ++i) {
    plant.step({.force_N = {kWeight_N, 0, 0}}, 0, kNoPush);
    if (since == 0 && !plant.contact()) continue;
    ++since;
    const double more_m_s2 = plant.body().force_B_m_s2.x() - kGravity_m_s2;
    felt.mean_m_s2 += more_m_s2 / 200;
    if (i % 5 != 0) continue;
    const double harder = std::max(before_m_s2, more_m_s2);
    felt.pair_m_s2 =
        std::max(felt.pair_m_s2, std::min(harder, 2 * std::min(before_m_s2, more_m_s2)));
    before_m_s2 = more_m_s2;
  }
  return felt;
}

TEST(TalarisOnSoils, ATouchdownIsSofterAndTakesTheSameSpeedAway) {
  const Felt hard = touch_down("hard"), sand = touch_down("sand"), loose = touch_down("sand:0.25");
  EXPECT_GT(hard.pair_m_s2, 12);
  EXPECT_NEAR(sand.pair_m_s2, 4.5, 0.5);
  EXPECT_NEAR(loose.pair_m_s2, 2.5, 0.3);
  for (const Felt& felt : {hard, sand, loose}) EXPECT_NEAR(felt.mean_m_s2, 1.1, 0.1);
}

TEST(TalarisOnSoils, TheBeamMeetsTheUntouchedSurface) {
  Plant plant({.soil = soil::parse_soil("sand")});
  const Plant hard({});
  const Vector3 down(-1, 0, 0);
  EXPECT_NEAR(
      *hard.distance_m(Vector3::Zero(), down, 0.9) - *plant.distance_m(Vector3::Zero(), down, 0.9),
      kConstants[0].depth_m(kWeight_N / 4), 1e-5);
}

// The whole simulator, standing on its legs.
TEST(TalarisOnSoils, CostsAtMostThreeTimesHardGround) {
  const auto cost_s = [](const TalarisOptions& options) {
    Talaris world(options);
    return testing_support::cpu_s_of([&] {
      for (int i = 0; i < 2'000; ++i) world.step();
    });
  };
  TalarisOptions soil;
  soil.plant.soil = soil::parse_soil("regolith");
  const double hard_s = cost_s({}), soil_s = cost_s(soil);
  std::printf("a simulated second: %.0f ms on hard ground, %.0f ms on regolith\n", hard_s / 2 * 1e3,
              soil_s / 2 * 1e3);
#ifndef LSS_SANITIZED
  EXPECT_LT(soil_s, 3 * hard_s);
#endif
}

TEST(TalarisOnSoils, SoilIsForTheFreeStandOnly) {
  EXPECT_THROW(Plant({.stand = Stand::sled, .soil = soil::parse_soil("sand")}),
               std::invalid_argument);
}

TEST(TalarisOnSoils, TheSameSeedGivesTheSameBits) {
  const auto landed = [](unsigned seed) {
    TalarisOptions nominal;
    nominal.plant.height_m = 0.3;
    nominal.plant.soil = soil::parse_soil("sand");
    nominal.seed = seed;
    Talaris world(dispersed(nominal, seed, kWide));
    for (int i = 0; i < 2'000; ++i) world.step();
    return world.truth().dump();
  };
  const std::string first = landed(5);
  EXPECT_NE(first.find("\"foot_sinkage_m\":[0.0"), std::string::npos) << first;
  EXPECT_EQ(landed(5), first);
  EXPECT_NE(landed(6), first);
}

}  // namespace
}  // namespace lss::sim::talaris
