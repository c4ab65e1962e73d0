// Lunar Zebro with some of its legs in soil that carries little, the others on regolith; and from
// regolith into it with all of them. Which cases run: tests/support/everything.h. The figures in
// docs/soil.md are of all of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "idl/angles.h"
#include "idl/zebro/codes.h"
#include "tests/support/everything.h"
#include "tests/zebro/chain/chain.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

constexpr unsigned kSeeds = 20;

struct Pace {
  const char* name = "high";
  gnc::zebro::Speed speed = gnc::zebro::Speed::high;
  bool forward = true;
  double slope_deg = 0;
  double cycle_s = 6.6;  // docs/gait-zebro.md
};

Chain::Options on_regolith_with(const std::string& patch, double gravity_m_s2, unsigned seed) {
  Chain::Options options{.seed = seed, .terrain = {.gravity_m_s2 = gravity_m_s2}};
  options.terrain.soil = sim::soil::parse_soil("regolith");
  if (!patch.empty()) options.terrain.patches.push_back(sim::zebro::parse_patch(patch));
  return options;
}

// Since a state: the way ahead by the heading then.
double ahead_m(const Chain& chain, const sim::zebro::BodyState& from) {
  return (from.attitude.conjugate() * (chain.body().position_m - from.position_m)).x();
}

double yaw_deg(const Chain& chain, const sim::zebro::BodyState& from) {
  const Eigen::Matrix3d turned =
      (from.attitude.conjugate() * chain.body().attitude).toRotationMatrix();
  return std::atan2(turned(1, 0), turned(0, 0)) / kDegree;
}

// Of some runs, the least and the most.
struct Span {
  double least = 1e9, most = -1e9;
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

struct Figures {
  int runs = 0, alarms = 0;
  Span speed_mm_s, yaw_deg_s, tilt_deg, depth_mm, current_A;
};

// Three cycles after the first group has landed.
void walk(const std::string& patch, double gravity_m_s2, unsigned seed, Figures& figures,
          const Pace& pace = {}) {
  SCOPED_TRACE(patch + ", " + pace.name + ", seed " + std::to_string(seed));
  Chain::Options options = on_regolith_with(patch, gravity_m_s2, seed);
  options.terrain.slope_rad = pace.slope_deg * kDegree;
  Chain chain(options);
  ASSERT_TRUE(chain.stand() && chain.walk(pace.forward, 0, pace.speed));
  chain.run(3.8);
  const sim::zebro::BodyState from = chain.body();
  const double walk_s = 3 * pace.cycle_s;
  double tilt_deg = 0, depth_m = 0, current_A = 0;
  const bool alarm = chain.run_until(
      [&] {
        const double up = chain.body().attitude.toRotationMatrix()(2, 2);
        tilt_deg = std::max(tilt_deg, std::acos(std::min(1.0, up)) / kDegree);
        for (std::size_t i = 0; i < kLegs; ++i) {
          depth_m = std::max(depth_m, chain.world().robot().legs_in_soil()[i].sinkage_m);
          current_A = std::max(current_A, chain.telemetry().modules[i].current_A);
        }
        return chain.supervisor().fault_count != 0;
      },
      walk_s);
  EXPECT_EQ(chain.mode(), Mode::walking);
  ++figures.runs;
  figures.alarms += alarm ? 1 : 0;
  figures.speed_mm_s.add((pace.forward ? 1 : -1) * ahead_m(chain, from) / walk_s * 1e3);
  figures.yaw_deg_s.add(std::abs(yaw_deg(chain, from)) / walk_s);
  figures.tilt_deg.add(tilt_deg);
  figures.depth_mm.add(depth_m * 1e3);
  figures.current_A.add(current_A);
}

void print(const std::string& what, const Figures& f) {
  std::printf(
      "%s: %d runs, %d alarms, %.1f to %.1f mm/s, yaw %.2f deg/s, tilt %.1f to %.1f deg, "
      "depth %.0f mm, %.2f A\n",
      what.c_str(), f.runs, f.alarms, f.speed_mm_s.least, f.speed_mm_s.most, f.yaw_deg_s.most,
      f.tilt_deg.least, f.tilt_deg.most, f.depth_mm.most, f.current_A.most);
  std::fflush(stdout);
}

// Each leg in turn. On regolith alone it walks 11.3 to 12.5 mm/s.
TEST(SoftSoil, UnderOneLegDoesNotHinderTheOthers) {
  for (const char* soil : {"sand:0.25", "sand:0.05"}) {
    for (const double gravity_m_s2 : {sim::soil::kEarth_m_s2, sim::soil::kMoon_m_s2}) {
      Figures figures;
      for (unsigned seed = 1; seed <= kSeeds; ++seed) {
        if (!testing_support::in_sample(seed, 20)) continue;
        walk(soil + ("@" + std::to_string(1 + seed % kLegs)), gravity_m_s2, seed, figures);
      }
      print(std::string(soil) + " under one leg, " + std::to_string(gravity_m_s2), figures);
      EXPECT_GT(figures.speed_mm_s.least, 10);
      EXPECT_EQ(figures.alarms, 0);
    }
  }
}

TEST(SoftSoil, UnderOneLegDoesNotHinderOtherWalksEither) {
  constexpr Pace kPaces[] = {{"high, backward", gnc::zebro::Speed::high, false, 0, 6.6},
                             {"medium", gnc::zebro::Speed::medium, true, 0, 9.9},
                             {"low", gnc::zebro::Speed::low, true, 0, 19.8},
                             {"high, 10 deg uphill", gnc::zebro::Speed::high, true, 10, 6.6}};
  unsigned number = 0;
  for (const Pace& pace : kPaces) {
    for (const double gravity_m_s2 : {sim::soil::kEarth_m_s2, sim::soil::kMoon_m_s2}) {
      if (!testing_support::in_sample(++number, 8)) continue;
      Figures figures, without;
      walk("", gravity_m_s2, 1, without, pace);
      for (unsigned leg = 1; leg <= kLegs; ++leg)
        walk("sand:0.05@" + std::to_string(leg), gravity_m_s2, leg, figures, pace);
      const std::string name = std::string(pace.name) + ", " + std::to_string(gravity_m_s2);
      print(name + " without", without);
      print(name + " under one leg", figures);
      EXPECT_GT(figures.speed_mm_s.least, without.speed_mm_s.least / 2);
      EXPECT_EQ(figures.alarms, 0);
    }
  }
}

// The body's edge lies in the soil on that side.
TEST(SoftSoil, UnderTheLegsOfOneSideIsNoticedInThreeStridesAndRowingGetsOn) {
  unsigned number = 0;
  for (const double gravity_m_s2 : {sim::soil::kEarth_m_s2, sim::soil::kMoon_m_s2}) {
    for (const bool left : {true, false}) {
      int noticed = 0, runs = 0;
      Span walks_mm_s, rows_mm_s, yaw_deg_s;
      for (unsigned seed = 1; seed <= kSeeds; ++seed) {
        if (!testing_support::in_sample(++number, 40)) continue;
        SCOPED_TRACE((left ? "left, seed " : "right, seed ") + std::to_string(seed));
        Chain chain(on_regolith_with(left ? "sand:0.1@135" : "sand:0.1@246", gravity_m_s2, seed));
        ASSERT_TRUE(chain.stand() && chain.walk());
        chain.run(3.8);
        sim::zebro::BodyState from = chain.body();
        chain.run(6.6);
        walks_mm_s.add(ahead_m(chain, from) / 6.6 * 1e3);
        ++runs;
        ASSERT_TRUE(chain.run_until([&] { return chain.supervisor().fault_count != 0; }, 15));
        EXPECT_TRUE(chain.has(left ? faults::left_in_soil : faults::right_in_soil));
        EXPECT_EQ(chain.telemetry().steps, 3U);
        EXPECT_GT(chain.telemetry().soil_share[left ? 0 : 1], 0.32);
        EXPECT_LT(chain.telemetry().soil_share[left ? 1 : 0], 0.32);
        ++noticed;
        if (seed > 3) continue;
        chain.run(10);  // it lands, and begins to row
        from = chain.body();
        chain.run(20);
        rows_mm_s.add(ahead_m(chain, from) / 20 * 1e3);
        yaw_deg_s.add(yaw_deg(chain, from) / 20);
        EXPECT_EQ(chain.mode(), Mode::walking);
        EXPECT_TRUE(chain.telemetry().rows);
        EXPECT_EQ(chain.supervisor().fault_count, 1U);
      }
      if (runs == 0) continue;
      std::printf(
          "sand:0.1 under the %s side, %.2f m/s2: noticed %d of %d, walks %.1f to %.1f mm/s, rows "
          "%.1f to %.1f mm/s, yaw %.1f to %.1f deg/s\n",
          left ? "left" : "right", gravity_m_s2, noticed, runs, walks_mm_s.least, walks_mm_s.most,
          rows_mm_s.least, rows_mm_s.most, yaw_deg_s.least, yaw_deg_s.most);
      std::fflush(stdout);
      EXPECT_GT(rows_mm_s.least, 2 * walks_mm_s.most);
    }
  }
}

// From 0.2 m ahead of the start on, under all legs.
TEST(SoftSoil, AheadIsNoticedWhenTheBellyIsInItAndRowingGetsOn) {
  for (const double gravity_m_s2 : {sim::soil::kEarth_m_s2, sim::soil::kMoon_m_s2}) {
    for (unsigned seed = 1; seed <= 2; ++seed) {
      if (!testing_support::in_sample(seed, 2)) continue;
      Chain chain(on_regolith_with("sand:0.25@123456@0.2..100", gravity_m_s2, seed));
      ASSERT_TRUE(chain.stand() && chain.walk());
      ASSERT_TRUE(chain.run_until([&] { return chain.has(faults::belly_in_soil); }, 120));
      const double at_m = chain.body().position_m.x();
      chain.run(10);
      const sim::zebro::BodyState from = chain.body();
      chain.run(30);
      std::printf("%.2f m/s2, seed %u: noticed at %.2f m after %.0f s, rows %.1f mm/s\n",
                  gravity_m_s2, seed, at_m, chain.seconds() - 40, ahead_m(chain, from) / 30 * 1e3);
      EXPECT_EQ(chain.mode(), Mode::walking);
      EXPECT_GT(ahead_m(chain, from), 0.1);
    }
  }
}

}  // namespace
}  // namespace lss::zebro
