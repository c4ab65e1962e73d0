// Lunar Zebro on soil: where its belly lies in it, that is noticed within two strides, and rowing
// gets on better; where it walks on its legs there is no alarm. Which cases run:
// tests/support/everything.h. The figures in docs/soil.md are of all of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

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

Chain::Options on(const std::string& soil, double gravity_m_s2, unsigned seed,
                  double slope_deg = 0) {
  Chain::Options options{
      .seed = seed, .terrain = {.gravity_m_s2 = gravity_m_s2, .slope_rad = slope_deg * kDegree}};
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

// What the vehicle feels, from its telemetry: the largest share that two strides in a row exceed,
// and that of a side which three do.
class Feeler {
 public:
  void look(const Chain& chain) {
    gnc::zebro::PerLeg<gnc::zebro::Sinking::Leg> legs;
    for (std::size_t i = 0; i < kLegs; ++i) {
      const lss_ZebroModule& module = chain.telemetry().modules[i];
      legs[i] = {-module.position_rad, module.current_A, module.calibrated, module.swing};
    }
    if (!sinking_.update(legs)) return;
    strides_.push_back(sinking_.shares());
  }
  double largest() const {
    return in_a_row(2, [](const Shares& shares) { return std::ranges::min(shares); });
  }
  double of_side() const {
    return std::max(in_a_row(3, [](const Shares& shares) { return shares[0]; }),
                    in_a_row(3, [](const Shares& shares) { return shares[1]; }));
  }

 private:
  using Shares = std::array<double, 2>;
  template <class Share>
  double in_a_row(std::size_t count, const Share& share) const {
    double largest = 0;
    for (std::size_t end = count; end <= strides_.size(); ++end) {
      double least = 1;
      for (std::size_t i = end - count; i < end; ++i) least = std::min(least, share(strides_[i]));
      largest = std::max(largest, least);
    }
    return largest;
  }

  gnc::zebro::Sinking sinking_{gnc::zebro::lowered_rad(0.025, 0.053)};
  std::vector<Shares> strides_;
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

// Four strides; no warning of any kind.
void walk_without_alarm(const std::string& soil, double gravity_m_s2, const Way& way,
                        double slope_deg, unsigned seed) {
  SCOPED_TRACE(soil + ", " + way.name + ", seed " + std::to_string(seed));
  Chain chain(on(soil, gravity_m_s2, seed, slope_deg));
  ASSERT_TRUE(begin(chain, way));
  Feeler feeler;
  const bool alarm = chain.run_until(
      [&] {
        feeler.look(chain);
        return chain.supervisor().fault_count != 0;
      },
      4 + 4 * way.cycle_s);
  EXPECT_FALSE(alarm);
  EXPECT_GE(chain.telemetry().steps, 4U);
  std::printf("%s, %.2f m/s2, %s, slope %.0f deg, seed %u: share %.3f, of a side %.3f\n",
              soil.c_str(), gravity_m_s2, way.name, slope_deg, seed, feeler.largest(),
              feeler.of_side());
  std::fflush(stdout);
}

TEST(BellyInSoil, ThereIsNoAlarmWhereItWalksOnItsLegs) {
  unsigned seed = 0;
  for (const char* soil : kSoils) {
    for (const double gravity_m_s2 : kGravities_m_s2) {
      for (const Way& way : kWays) {
        if (testing_support::in_sample(++seed, 12))
          walk_without_alarm(soil, gravity_m_s2, way, 0, seed);
      }
    }
  }
}

TEST(BellyInSoil, ThereIsNoAlarmOnSlopesEither) {
  unsigned seed = 0;
  for (const char* soil : kSoils) {
    for (const double gravity_m_s2 : kGravities_m_s2) {
      for (const double slope_deg : {-10.0, 10.0}) {
        for (const Way& way : {kWays[0], kWays[2], kWays[4]}) {
          if (testing_support::in_sample(++seed, 24))
            walk_without_alarm(soil, gravity_m_s2, way, slope_deg, seed);
        }
      }
    }
  }
}

}  // namespace
}  // namespace lss::zebro
