// Guards of the modes and of the stop chart, and the ratio blocks.

#include "gnc/ardito/decision.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "gnc/ardito/ratio.h"

namespace lss::gnc::ardito::test {
namespace {

const Parameters kParameters;

ModeInputs any_inputs() {
  return {.speed = *rc::gen::inRange(-100, 101) * 0.01,
          .parking = *rc::gen::arbitrary<bool>(),
          .busy = *rc::gen::arbitrary<bool>(),
          .error = *rc::gen::arbitrary<bool>(),
          .delta_sigma_rad = *rc::gen::element(0.0, 0.01)};
}

RC_GTEST_PROP(Modes, GuardsOfTheThesis, ()) {
  const ModeInputs in = any_inputs();
  const bool moves = std::abs(in.speed) > 0.01;
  const bool may_leave = moves && !in.busy && !in.error && in.delta_sigma_rad == 0;
  const Mode from_stop = next_mode(Mode::stop, in, kParameters);
  RC_ASSERT((from_stop == Mode::running) == (may_leave && !in.parking));
  RC_ASSERT((from_stop == Mode::parking) == (may_leave && in.parking));
  RC_ASSERT((next_mode(Mode::running, in, kParameters) == Mode::stop) ==
            (!moves || in.parking || in.error));
  RC_ASSERT((next_mode(Mode::parking, in, kParameters) == Mode::stop) ==
            (!moves || !in.parking || in.error));
}

RC_GTEST_PROP(Modes, RunningAndParkingAlwaysHaveAStopBetweenThem, ()) {
  const ModeInputs in = any_inputs();
  RC_ASSERT(next_mode(Mode::running, in, kParameters) != Mode::parking);
  RC_ASSERT(next_mode(Mode::parking, in, kParameters) != Mode::running);
}

TEST(StopChart, EveryTransition) {
  using P = StopPhase;
  const auto next = [](P phase, double w, double a) {
    return next_phase(phase, {w, a}, kParameters);
  };
  EXPECT_EQ(next(P::begin, 0.05, 0.01), P::rover_stop);
  EXPECT_EQ(next(P::begin, 0.05, 0.04), P::rover_steer);
  EXPECT_EQ(next(P::begin, 0.2, 0.01), P::begin);
  EXPECT_EQ(next(P::rover_stop, 0.05, 0.01), P::rover_stop);
  EXPECT_EQ(next(P::rover_stop, 0.05, 0.04), P::rover_steer);
  EXPECT_EQ(next(P::rover_stop, 0.1, 0.04), P::deceleration);
  EXPECT_EQ(next(P::rover_steer, 0.05, 0.04), P::rover_steer);
  EXPECT_EQ(next(P::rover_steer, 0.05, 0.035), P::rover_stop);
  EXPECT_EQ(next(P::deceleration, 0.1, 0.01), P::deceleration);
  EXPECT_EQ(next(P::deceleration, 0.09, 0.01), P::rover_steer);
  for (const P phase : {P::begin, P::rover_steer, P::deceleration}) EXPECT_TRUE(busy(phase));
  EXPECT_FALSE(busy(P::rover_stop));
}

RC_GTEST_PROP(RatioBlock, KeepsTheRatiosAndTheSaturation, ()) {
  PerWheel<double> errors{};
  double largest = 0;
  for (double& e : errors) {
    e = *rc::gen::inRange(-100, 101) * 0.1;
    largest = std::max(largest, std::abs(e));
  }
  const auto cut = equal_settling(errors, 3.5, 0);
  for (std::size_t i = 0; i < kWheels; ++i) {
    RC_ASSERT(std::abs(cut[i]) <= 3.5 * (1 + 1e-12));
    RC_ASSERT(std::abs(cut[i] * largest - errors[i] * std::min(largest, 3.5)) < 1e-9);
  }
}

TEST(RatioBlock, ASkippedWheelDelaysNoOtherWheel) {
  const auto cut = equal_settling(std::array<double, 3>{100, 2, 1}, 3.5, 1);
  EXPECT_EQ(cut[0], 0);
  EXPECT_EQ(cut[1], 2);
  EXPECT_EQ(cut[2], 1);
}

// 12.2: for any targets, all are reached in the same frame.
RC_GTEST_PROP(RatioBlock, AllSettleTogether, ()) {
  PerWheel<double> target{}, value{}, start{}, integral{};
  double largest = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    target[i] = *rc::gen::inRange(-60, 61) * kRadPerSecondPerRpm;
    start[i] = value[i] = integral[i] = *rc::gen::inRange(-60, 61) * kRadPerSecondPerRpm;
    largest = std::max(largest, std::abs(target[i] - start[i]));
  }
  RC_PRE(largest > 1e-9);
  for (int n = 0; n < 400; ++n) {
    PerWheel<double> errors{};
    for (std::size_t i = 0; i < kWheels; ++i) errors[i] = target[i] - value[i];
    const auto cut = equal_settling(errors, kParameters.wheel_saturation_rad_s, 0);
    for (std::size_t i = 0; i < kWheels; ++i) {
      value[i] = pi_step(cut[i], 1e9, integral[i], kParameters);
    }
    // each has the same share of its way behind it
    double share = 0;
    for (std::size_t i = 0; i < kWheels; ++i) {
      if (std::abs(target[i] - start[i]) == largest) {
        share = (target[i] - value[i]) / (target[i] - start[i]);
      }
    }
    for (std::size_t i = 0; i < kWheels; ++i) {
      RC_ASSERT(std::abs((target[i] - value[i]) - share * (target[i] - start[i])) < 1e-6);
    }
  }
  for (std::size_t i = 0; i < kWheels; ++i) RC_ASSERT(std::abs(target[i] - value[i]) < 1e-6);
}

}  // namespace
}  // namespace lss::gnc::ardito::test
