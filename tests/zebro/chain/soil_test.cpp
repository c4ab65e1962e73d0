// Lunar Zebro on soil: where its belly lies in it, that is noticed within two strides, and rowing
// gets on better; where it walks on its legs there is no alarm. Which cases run:
// tests/support/everything.h. The figures in docs/soil.md are of all of them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "gnc/zebro/sinking.h"
#include "idl/angles.h"
#include "idl/zebro/codes.h"
#include "tests/support/everything.h"
#include "tests/zebro/chain/chain.h"

namespace lss::zebro {
namespace {

using gnc::zebro::Speed;

constexpr const char* kSoils[] = {"hard", "loam", "regolith", "sand"};
constexpr double kGravities_m_s2[] = {sim::soil::kEarth_m_s2, sim::soil::kMoon_m_s2};
struct Way {
  const char* name;
  Speed speed;
  bool forward;
  double heading_deg;
  double cycle_s;  // docs/gait-zebro.md
};
constexpr Way kWays[] = {{"high", Speed::high, true, 0, 6.6},
                         {"high, backward", Speed::high, false, 0, 6.6},
                         {"medium", Speed::medium, true, 0, 9.9},
                         {"low", Speed::low, true, 0, 19.8},
                         {"high, on the spot", Speed::high, true, 90, 6.6},
                         {"high, curve", Speed::high, true, 30, 6.6}};

Chain::Options on(const std::string& soil, double gravity_m_s2, unsigned seed) {
  Chain::Options options{.seed = seed, .terrain = {.gravity_m_s2 = gravity_m_s2}};
  if (soil != "hard") options.terrain.soil = sim::soil::parse_soil(soil);
  return options;
}

bool begin(Chain& chain, const Way& way) {
  return chain.stand() && chain.walk(way.forward, way.heading_deg * kDegree, way.speed);
}

// The way that the body makes in this time in the direction asked for, by its heading.
double speed_m_s(Chain& chain, const Way& way, double seconds) {
  const sim::zebro::BodyState from = chain.body();
  chain.run(seconds);
  const Eigen::Vector3d moved =
      from.attitude.conjugate() * (chain.body().position_m - from.position_m);
  return (way.forward ? moved.x() : -moved.x()) / seconds;
}

// What the vehicle feels, from its telemetry: the largest share that two strides in a row exceed.
class Feeler {
 public:
  void look(const Chain& chain) {
    gnc::zebro::PerLeg<gnc::zebro::Sinking::Leg> legs;
    for (std::size_t i = 0; i < kLegs; ++i) {
      const lss_ZebroModule& module = chain.telemetry().modules[i];
      legs[i] = {-module.position_rad, module.current_A, module.calibrated, module.swing};
    }
    if (!sinking_.update(legs)) return;
    largest_ = std::max(largest_, std::min(last_, sinking_.share()));
    last_ = sinking_.share();
  }
  double largest() const { return largest_; }

 private:
  gnc::zebro::Sinking sinking_{gnc::zebro::lowered_rad(0.025, 0.053)};
  double last_ = 0, largest_ = 0;
};

// The belly lies in the soil in each of them. Without turning, rowing is at least twice as fast.
TEST(BellyInSoil, IsNoticedWithinTwoStridesAndRowingGetsOnBetter) {
  unsigned seed = 0;
  for (const double gravity_m_s2 : kGravities_m_s2) {
    for (const Way& way : kWays) {
      for (int run = 0; run < 2; ++run) {
        if (!testing_support::in_sample(++seed, 8)) continue;
        SCOPED_TRACE(std::string(way.name) + ", seed " + std::to_string(seed));
        Chain chain(on("sand:0.25", gravity_m_s2, seed));
        ASSERT_TRUE(begin(chain, way));
        chain.run(3.8);  // the first group has landed
        const double walks_m_s = speed_m_s(chain, way, way.cycle_s);
        ASSERT_TRUE(chain.run_until([&] { return chain.has(faults::belly_in_soil); }, way.cycle_s));
        EXPECT_EQ(chain.telemetry().steps, 2U);
        chain.run(10);  // it lands, and begins to row
        const double rows_m_s = speed_m_s(chain, way, 33);
        EXPECT_EQ(chain.mode(), Mode::walking);
        EXPECT_FALSE(chain.has_fatal());
        std::printf("%s, %.2f m/s2, seed %u: walks %.2f mm/s, rows %.2f mm/s\n", way.name,
                    gravity_m_s2, seed, walks_m_s * 1e3, rows_m_s * 1e3);
        if (way.heading_deg != 90) {
          EXPECT_GT(rows_m_s, 0.002);
          EXPECT_GT(rows_m_s, 2 * walks_m_s);
        }
      }
    }
  }
}

TEST(BellyInSoil, ThereIsNoAlarmWhereItWalksOnItsLegs) {
  unsigned seed = 0;
  for (const char* soil : kSoils) {
    for (const double gravity_m_s2 : kGravities_m_s2) {
      for (const Way& way : kWays) {
        if (!testing_support::in_sample(++seed, 12)) continue;
        SCOPED_TRACE(std::string(soil) + ", " + way.name + ", seed " + std::to_string(seed));
        Chain chain(on(soil, gravity_m_s2, seed));
        ASSERT_TRUE(begin(chain, way));
        Feeler feeler;
        const bool alarm = chain.run_until(
            [&] {
              feeler.look(chain);
              return chain.has(faults::belly_in_soil);
            },
            4 + 3 * way.cycle_s);
        EXPECT_FALSE(alarm);
        EXPECT_GE(chain.telemetry().steps, 3U);
        std::printf("%s, %.2f m/s2, %s, seed %u: share %.3f\n", soil, gravity_m_s2, way.name, seed,
                    feeler.largest());
      }
    }
  }
}

}  // namespace
}  // namespace lss::zebro
