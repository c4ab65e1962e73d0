#include "gnc/talaris/actuator_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/allocations.h"

namespace lss::gnc::talaris {
namespace {

// A vehicle that hovers and turns as its actuators say: wrench in, rates and specific force out.
class Bench {
 public:
  explicit Bench(unsigned seed = 1) : random(seed), watch(parameters) { watch.begin(); }

  // One frame with these pulses; `really`: forces of the valves and fans, mean of the frame.
  void frame(const std::array<double, kValves>& open_s, Forces really, bool fresh = false) {
    const Vector3 inertia(parameters.body.inertia_x_kg_m2, parameters.body.inertia_y_kg_m2,
                          parameters.body.inertia_z_kg_m2);
    WatchFrame f;
    f.measured = f.speeds = true;
    f.fresh = fresh;
    f.mass_kg = parameters.body.mass_kg;
    f.open_s = open_s;
    f.rpm = f.rpm_before = f.rpm_expected = rpm;
    const WrenchB wrench = effect_of(parameters.thrusters, parameters.fans) * really + disturbance;
    const auto noise = [&](double sigma) {
      return std::normal_distribution<double>(0, sigma)(random);
    };
    // what it turned is taken out again at once: rates stay small
    f.rate_before_B_rad_s.setZero();
    for (int i = 0; i < 3; ++i)
      f.rate_B_rad_s[i] = kFrame_s * wrench[2 + i] / (inertia[i] * inertia_share) + noise(0.005);
    const Vector3 mean = f.rate_B_rad_s / 2;
    f.rate_B_rad_s -=
        kFrame_s * mean.cross(inertia.cwiseProduct(mean).eval()).cwiseQuotient(inertia);
    f.force_B_m_s2 = Vector3(wrench[kLiftRow], 0, wrench[kSideRow]) / f.mass_kg +
                     Vector3(noise(0.05), 0, noise(0.05));
    const std::uint64_t before = testing_support::allocations();
    watch.step(f);
    EXPECT_EQ(testing_support::allocations(), before);
    last = f;
  }
  Forces as_ordered(const std::array<double, kValves>& open_s) const {
    Forces force;
    for (std::size_t i = 0; i < kValves; ++i)
      force[static_cast<Eigen::Index>(i)] = parameters.thrusters.force_N * open_s[i] / kFrame_s;
    for (std::size_t i = 0; i < kFans; ++i)
      force[static_cast<Eigen::Index>(kValves + i)] =
          parameters.fans.thrust_N_per_rpm2 * rpm[i] * rpm[i];
    return force;
  }
  // Pulses as in flight: lift valves about 65 ms, one pair of jets now and then.
  std::array<double, kValves> any_pulses() {
    std::array<double, kValves> open_s{};
    std::uniform_real_distribution<double> lift(0.045, 0.085), side(0.040, 0.150);
    for (std::size_t i = 0; i < kValves; i += 2) open_s[i] = lift(random);
    const int pair = std::uniform_int_distribution<int>(0, 2)(random);
    if (pair == 1) open_s[1] = open_s[7] = side(random);
    if (pair == 2) open_s[3] = open_s[5] = side(random);
    return open_s;
  }
  void settle(int frames = 20) {
    for (int n = 0; n < frames; ++n) {
      const auto open_s = any_pulses();
      frame(open_s, as_ordered(open_s), n < 5);
    }
  }

  Parameters parameters;
  std::mt19937 random;
  ActuatorWatch watch;
  PerFan rpm{29400, 29400, 29400, 29400};
  WrenchB disturbance = WrenchB::Zero();
  double inertia_share = 1;  // true, of the parameters'
  WatchFrame last;
};

// Frames until the verdict on this failure; 0: another verdict, or none in eight seconds.
int frames_until(Bench& bench, std::size_t actuator, Health health) {
  for (int n = 1; n <= 40; ++n) {
    auto open_s = bench.any_pulses();
    Forces really = bench.as_ordered(open_s);
    const auto at = static_cast<Eigen::Index>(actuator);
    if (health == Health::open) really[at] = bench.parameters.thrusters.force_N;
    if (health == Health::shut || health == Health::weak) really[at] = 0;
    bench.frame(open_s, really);
    const ActuatorVerdict& v = bench.watch.verdict();
    if (v.health == Health::good) continue;
    return v.actuator == actuator && v.health == health ? n : 0;
  }
  return 0;
}

TEST(TalarisActuatorWatch, EachFailureOfEachValveAndFanIsFoundAndNoOther) {
  for (std::size_t i = 0; i < kActuators; ++i) {
    for (const Health health : {Health::open, Health::shut, Health::weak}) {
      if ((health == Health::weak) != (i >= kValves)) continue;
      for (unsigned seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(testing::Message() << i << ' ' << static_cast<int>(health) << ' ' << seed);
        Bench bench(seed);
        bench.disturbance << 8, 5, 0.5, 2, -1.5;
        bench.settle();
        ASSERT_TRUE(bench.watch.good());
        const int frames = frames_until(bench, i, health);
        EXPECT_GE(frames, 1);
        const bool seldom = i < kValves && i % 2 == 1 && health == Health::shut;
        EXPECT_LE(frames, seldom ? 40 : 4);
      }
    }
  }
}

// Taken for a push that lasts, they would be another failure when it turns back.
TEST(TalarisActuatorWatch, FastTurnsOfALightVehicleAfterAFailureAreNoPushThatLasts) {
  constexpr std::size_t kShut = 2;
  constexpr double kShort_s = 0.040, kLong_s = 0.160, kLittle_Nm = 1;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Bench bench(seed);
    bench.settle();
    ASSERT_GE(frames_until(bench, kShut, Health::shut), 1);
    bench.inertia_share = 0.65;
    for (int n = 0; n < 12; ++n) {
      std::array<double, kValves> open_s{};
      for (const std::size_t i : {0u, 4u, 6u}) open_s[i] = kShort_s;
      open_s[n % 2 == 0 ? 4u : 0u] = kLong_s;  // to and fro
      bench.frame(open_s, bench.as_ordered(open_s));
      EXPECT_EQ(bench.watch.verdict().health, Health::good) << n;
      EXPECT_LT(std::abs(bench.watch.unexplained()[kPitchRow]), kLittle_Nm) << n;
      EXPECT_LT(std::abs(bench.watch.unexplained()[kYawRow]), kLittle_Nm) << n;
    }
  }
}

TEST(TalarisActuatorWatch, APushThatLastsIsKnownAfterAFailureToo) {
  constexpr std::size_t kShut = 2;
  constexpr double kPush_Nm = 2;
  Bench bench;
  bench.settle();
  ASSERT_GE(frames_until(bench, kShut, Health::shut), 1);
  bench.disturbance[kPitchRow] = kPush_Nm;
  for (int n = 0; n < 50; ++n) {
    std::array<double, kValves> open_s = bench.any_pulses();
    open_s[kShut] = 0;
    bench.frame(open_s, bench.as_ordered(open_s));
  }
  EXPECT_NEAR(bench.watch.unexplained()[kPitchRow], kPush_Nm, 0.7);
}

// Frames until this is known of a valve that gives `force_N` whatever is ordered; 0: it is not.
int frames_until_known(Bench& bench, std::size_t valve, double force_N, Health health) {
  for (int n = 1; n <= 10; ++n) {
    std::array<double, kValves> open_s = bench.any_pulses();
    open_s[valve] = 0;  // it is not used
    Forces really = bench.as_ordered(open_s);
    really[static_cast<Eigen::Index>(valve)] = force_N;
    bench.frame(open_s, really);
    if (bench.watch.health()[valve] == health) return n;
  }
  return 0;
}

TEST(TalarisActuatorWatch, AValveThatWasStuckAndIsFreeAgainIsKnownAtOnce) {
  for (std::size_t i = 0; i < kValves; ++i) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(testing::Message() << i << ' ' << seed);
      Bench bench(seed);
      bench.disturbance << 8, 5, 0.5, 2, -1.5;
      bench.settle();
      ASSERT_GE(frames_until(bench, i, Health::open), 1);
      for (int times = 0; times < 2; ++times) {
        for (const Health health : {Health::shut, Health::open}) {
          const double force_N = health == Health::open ? bench.parameters.thrusters.force_N : 0;
          const int frames = frames_until_known(bench, i, force_N, health);
          EXPECT_GE(frames, 1);
          EXPECT_LE(frames, 2);
        }
      }
    }
  }
}

TEST(TalarisActuatorWatch, AValveThatStaysStuckIsNotTakenForFree) {
  for (std::size_t i = 0; i < kValves; ++i) {
    for (const Health health : {Health::open, Health::shut}) {
      Bench bench(static_cast<unsigned>(i) + 1);
      bench.disturbance << 8, 5, 0.5, 2, -1.5;
      bench.settle();
      ASSERT_GE(frames_until(bench, i, health), 1);
      bench.inertia_share = 0.65;
      const double force_N = health == Health::open ? bench.parameters.thrusters.force_N : 0;
      const Health other = health == Health::open ? Health::shut : Health::open;
      for (int n = 0; n < 20; ++n) EXPECT_EQ(frames_until_known(bench, i, force_N, other), 0) << i;
    }
  }
}

// Dirt in its seat.
TEST(TalarisActuatorWatch, AValveThatIsPartlyOpenChangesItsVerdictNotAgainAndAgain) {
  for (std::size_t i = 0; i < kValves; ++i) {
    for (const double share : {0.3, 0.4, 0.5, 0.6, 0.7, 0.9}) {
      SCOPED_TRACE(testing::Message() << i << ' ' << share);
      Bench bench(static_cast<unsigned>(i) + 1);
      bench.settle();
      ASSERT_GE(frames_until(bench, i, Health::open), 1);
      int changes = 0;
      Health before = Health::open;
      for (int n = 0; n < 40; ++n) {
        auto open_s = bench.any_pulses();
        open_s[i] = 0;
        Forces really = bench.as_ordered(open_s);
        really[static_cast<Eigen::Index>(i)] = share * bench.parameters.thrusters.force_N;
        bench.frame(open_s, really);
        changes += bench.watch.health()[i] != before;
        before = bench.watch.health()[i];
      }
      EXPECT_LE(changes, 2);
    }
  }
}

TEST(TalarisActuatorWatch, NothingIsCondemnedWithoutFailure) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Bench bench(seed);
    bench.disturbance << 10, 20, 1, 4, -4;
    bench.settle(300);
    EXPECT_TRUE(bench.watch.good()) << seed;
  }
}

// The limit of a fan's speed: 1500 rpm below what is expected of it.
TEST(TalarisActuatorWatch, AFanIsDeadJustBelowItsLimitAndNotJustAbove) {
  for (std::size_t i = 0; i < kFans; ++i) {
    Bench bench;
    bench.settle();
    WatchFrame f = bench.last;
    f.rpm[i] = f.rpm_expected[i] - 1499;
    bench.watch.step(f);
    EXPECT_TRUE(bench.watch.good());
    f.rpm[i] = f.rpm_expected[i] - 1501;
    bench.watch.step(f);
    EXPECT_EQ(bench.watch.health()[kValves + i], Health::dead);
    EXPECT_EQ(bench.watch.verdict().measured, f.rpm[i]);
    EXPECT_EQ(bench.watch.verdict().limit, f.rpm_expected[i] - 1500);
  }
}

// Four fans as in the air, one of them slower than the others and told to speed up: a verdict on
// another actuator orders that at once. First order with the longest lag; orders arrive 10 ms late,
// speeds are 20 ms old.
class SpedUp {
 public:
  SpedUp(std::size_t fan, double from_rpm, double lag_s) : lag_s_(lag_s) {
    bench.settle();
    goal[fan] = from_rpm;
    for (int n = 0; n < 40; ++n) turn(-1);
    goal[fan] = bench.parameters.fans.max_rpm;
  }
  // One frame; the motor of `dead` has no torque from `dies_s` on.
  void frame(int dead, double dies_s = 0) {
    WatchFrame f = bench.last;
    f.measured = false;
    f.rpm_before = measured_;
    turn(dead, dies_s);
    f.rpm = measured_;
    f.rpm_expected = speed_.reference_rpm();
    bench.watch.step(f);
    last = f;
  }

  Bench bench;
  PerFan goal = bench.rpm;
  WatchFrame last;

 private:
  void turn(int dead, double dies_s = 0) {
    const PerFan next = speed_.ramp(goal, bench.parameters.fans.max_rpm / kFrame_s, measured_);
    for (int ms = 0; ms < 200; ++ms) {
      if (ms == 10) throttle_ = next;
      for (std::size_t i = 0; i < kFans; ++i) {
        const bool turns = static_cast<int>(i) != dead || ms < dies_s * 1e3;
        const double to_rpm = turns ? throttle_[i] * bench.parameters.fans.max_rpm : 0;
        rpm_[i] += (to_rpm - rpm_[i]) * 1e-3 / lag_s_;
        if (ms == 180) measured_[i] = 200 * std::floor(rpm_[i] / 200);
      }
    }
  }

  double lag_s_;
  FanSpeed speed_{bench.parameters.fans, bench.parameters.gains[0]};
  PerFan rpm_ = bench.rpm, measured_ = bench.rpm, throttle_{};
};

TEST(TalarisActuatorWatch, AFanThatIsSlowToSpeedUpIsNotDead) {
  for (std::size_t i = 0; i < kFans; ++i) {
    double behind_rpm = 0;
    SpedUp fans(i, 15000, 0.3);
    for (int n = 0; n < 5; ++n) {
      fans.frame(-1);
      behind_rpm = std::max(behind_rpm, fans.last.rpm_expected[i] - fans.last.rpm[i]);
      EXPECT_TRUE(fans.bench.watch.good()) << i << ' ' << n;
    }
    EXPECT_GT(behind_rpm, 1500);
  }
}

// In the frame in which its motor stops.
TEST(TalarisActuatorWatch, AFanThatDiesWhileItSpeedsUpIsFoundAtOnce) {
  for (const double lag_s : {0.2, 0.3}) {
    for (std::size_t i = 0; i < kFans; ++i) {
      for (const double dies_s : {0.0, 0.05}) {
        SpedUp fans(i, 15000, lag_s);
        fans.frame(static_cast<int>(i), dies_s);
        EXPECT_EQ(fans.bench.watch.health()[kValves + i], Health::dead) << lag_s << ' ' << dies_s;
      }
    }
  }
}

TEST(TalarisActuatorWatch, SeveralSlowFansAreNoFailureOfOne) {
  Bench bench;
  bench.settle();
  WatchFrame f = bench.last;
  f.rpm = {20000, 20000, 20000, 20000};
  bench.watch.step(f);
  EXPECT_TRUE(bench.watch.good());
}

TEST(TalarisActuatorWatch, OrdersThatDidNotArriveSayNothing) {
  Bench bench;
  bench.settle();
  for (int n = 0; n < 3; ++n) {
    WatchFrame f = bench.last;
    f.unheard = true;
    f.rpm.fill(20000);
    f.rate_B_rad_s = Vector3(1, 1, 1);
    bench.watch.step(f);
  }
  WatchFrame f = bench.last;
  f.rpm.fill(25000);
  bench.watch.step(f);
  EXPECT_TRUE(bench.watch.good());
}

TEST(TalarisActuatorWatch, WhatIsNoNumberIsIgnored) {
  Bench bench;
  bench.settle();
  WatchFrame f = bench.last;
  f.rate_B_rad_s.x() = kNaN;
  bench.watch.step(f);
  f = bench.last;
  f.force_B_m_s2.x() = std::numeric_limits<double>::infinity();
  bench.watch.step(f);
  EXPECT_TRUE(bench.watch.good());
  EXPECT_TRUE(bench.watch.unexplained().allFinite());
}

}  // namespace
}  // namespace lss::gnc::talaris
