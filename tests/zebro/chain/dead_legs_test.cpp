// Legs fail in the middle of a walk and stay where they are; error solving takes them out of
// service, and the others walk on. The place where the legs failed is random: in the air, or on the
// ground, where they drag and prop the body up. docs/gait-zebro.md has figures of these runs.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "idl/angles.h"
#include "tests/support/everything.h"
#include "tests/zebro/chain/chain.h"
#include "tests/zebro/chain/legs.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

constexpr double kLeast_m_s = 1e-3;   // Zebro thesis [Oper-8]
constexpr double kMostTilt_deg = 20;  // a body on its belly and two dead legs: 12
constexpr double kStroke_s = 5;       // a cycle of rowing is shorter, one of creeping longer

double tilt_deg(const sim::zebro::BodyState& body) {
  return std::acos(std::min(1.0, body.attitude.toRotationMatrix()(2, 2))) / kDegree;
}

double yaw_deg(const sim::zebro::BodyState& from, const sim::zebro::BodyState& to) {
  const Eigen::Matrix3d turned = (from.attitude.conjugate() * to.attitude).toRotationMatrix();
  return std::atan2(turned(1, 0), turned(0, 0)) / kDegree;
}

class DeadLegs : public testing::TestWithParam<Legs> {
 protected:
  // Runs until so many steps more are done; false when the walk ends before. Watches the attitude.
  bool walk_steps(Chain& chain, unsigned count) {
    const std::uint32_t end = chain.telemetry().steps + count;
    return chain.run_until(
               [&] {
                 tilted_deg_ = std::max(tilted_deg_, tilt_deg(chain.body()));
                 return chain.telemetry().steps >= end || chain.mode() != Mode::walking;
               },
               60) &&
           chain.mode() == Mode::walking;
  }

  double tilted_deg_ = 0;
};

TEST_P(DeadLegs, OthersWalkOnAfterSolving) {
  const Legs& dead = GetParam();
  LSS_SKIP_OUTSIDE_SAMPLE(static_cast<std::size_t>(dead.legs.front() + dead.legs.back()), 5);
  unsigned seed = 20;  // of this run: which moment, and where the legs are at boot
  for (const int leg : dead.legs) seed = seed * 7 + static_cast<unsigned>(leg);
  Chain chain({.seed = seed});
  ASSERT_TRUE(chain.stand());
  ASSERT_TRUE(chain.walk());
  std::mt19937 random(seed);
  chain.run(std::uniform_real_distribution<double>(3, 15)(random));
  for (const int leg : dead.legs) chain.inject("module-dead:" + std::to_string(leg));
  ASSERT_TRUE(chain.run_until(State::fatal_error, 2));
  ASSERT_TRUE(chain.solve());
  for (const int leg : dead.legs) {
    EXPECT_TRUE(chain.telemetry().modules[static_cast<std::size_t>(leg - 1)].isolated);
    const double hangs_rad =
        -chain.world().robot().shafts()[static_cast<std::size_t>(leg - 1)].angle_rad;
    RecordProperty("hangs_deg_" + std::to_string(leg),
                   static_cast<int>(std::lround(std::remainder(hangs_rad / kDegree, 360))));
  }

  ASSERT_TRUE(chain.stand());
  ASSERT_TRUE(chain.walk());
  const sim::zebro::BodyState ahead = chain.body();
  ASSERT_TRUE(walk_steps(chain, 1));
  const sim::zebro::BodyState from = chain.body();
  const double began_s = chain.seconds();
  do {
    ASSERT_TRUE(walk_steps(chain, 1));  // whole cycles
  } while (chain.seconds() - began_s < kStroke_s);
  const double lasted_s = chain.seconds() - began_s;
  const Eigen::Vector3d way =
      ahead.attitude.conjugate() * (chain.body().position_m - from.position_m);
  const double speed_m_s = way.x() / lasted_s;
  RecordProperty("speed_mm_s", std::to_string(speed_m_s * 1e3));
  RecordProperty("yaw_deg_per_s", std::to_string(yaw_deg(from, chain.body()) / lasted_s));
  RecordProperty("tilted_deg", std::to_string(tilted_deg_));
  EXPECT_GE(speed_m_s, kLeast_m_s);
  EXPECT_LT(tilted_deg_, kMostTilt_deg);
  EXPECT_FALSE(chain.has_fatal());
}

INSTANTIATE_TEST_SUITE_P(Robot, DeadLegs, one_or_two_legs(), name_of_legs);

}  // namespace
}  // namespace lss::zebro
