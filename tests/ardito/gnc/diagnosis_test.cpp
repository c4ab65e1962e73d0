// The decision table, row by row and as a whole.

#include "gnc/ardito/diagnosis.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <map>
#include <set>

namespace lss::gnc::ardito::test {
namespace {

constexpr double kRpm = kRadPerSecondPerRpm;
const Parameters kParameters;

// The states of docs/gnc-ardito.md, written down once more; -1 hold, -2 inconclusive.
constexpr int kHold = -1;
constexpr int kInconclusive = -2;
struct Row {
  int at_zero, below_two, below_five, above;  // of rho, rpm
};
struct Rows {
  Row engaged, open;
};
constexpr Row all(int state) { return {state, state, state, state}; }
const std::map<unsigned, Rows> kTable = {
    {0b000000, {all(0), all(0)}},
    {0b101100, {all(1), all(1)}},
    {0b011010, {all(1), all(1)}},
    {0b000111, {{2, 4, 4, 5}, {4, 4, 4, 5}}},
    {0b110001, {all(3), {4, 4, 3, 3}}},
    {0b110110, {all(6), all(kHold)}},
    {0b101011, {all(6), all(6)}},
    {0b011101, {all(6), all(6)}},
    {0b101111, {{6, 4, 4, 7}, {6, 4, 4, 7}}},
    {0b011111, {{6, 4, 4, 7}, {6, 4, 4, 7}}},
    {0b111110, {all(6), all(6)}},
    {0b110111, {all(3), all(kHold)}},
    {0b111011, {all(3), {4, 4, 3, 3}}},
    {0b111101, {all(3), {4, 4, 3, 3}}},
};

int state_of(const WheelVerdict& verdict) {
  if (verdict.outcome == Outcome::hold) return kHold;
  if (verdict.outcome == Outcome::inconclusive) return kInconclusive;
  return static_cast<int>(verdict.failure);
}

int expected(unsigned flags, bool engaged, double rho_rpm, double nearest_rpm) {
  if (flags == 0b111111) return nearest_rpm < 2 ? 6 : 8;
  const auto rows = kTable.find(flags);
  if (rows == kTable.end()) return kInconclusive;
  const Row& row = engaged ? rows->second.engaged : rows->second.open;
  if (rho_rpm == 0) return row.at_zero;
  if (rho_rpm < 2) return row.below_two;
  return rho_rpm < 5 ? row.below_five : row.above;
}

TEST(DecisionTable, EveryPatternClutchAndSpeedHasTheOneOutcomeOfTheTable) {
  int inconclusive = 0;
  for (unsigned flags = 0; flags < 64; ++flags) {
    for (const bool engaged : {true, false}) {
      for (const double rho_rpm : {0.0, 0.5, 1.999, 2.0, 3.0, 4.999, 5.0, 20.0}) {
        for (const double nearest_rpm : {0.0, 1.9, 2.1, 50.0}) {
          const WheelVerdict verdict =
              diagnose_wheel(flags, engaged, rho_rpm * kRpm, nearest_rpm * kRpm, kParameters);
          ASSERT_EQ(state_of(verdict), expected(flags, engaged, rho_rpm, nearest_rpm))
              << flags << " clutch " << engaged << " rho " << rho_rpm;
          if (verdict.outcome == Outcome::inconclusive) {
            ++inconclusive;
            ASSERT_EQ(verdict.parts, 0U);
          }
        }
      }
    }
  }
  EXPECT_EQ(inconclusive, 49 * 2 * 8 * 4);  // 15 of the 64 are consistent
}

TEST(DecisionTable, PartsGiveTheStateThatTheyStandFor) {
  for (unsigned flags = 0; flags < 64; ++flags) {
    for (const double rho : {0.0, 3 * kRpm, 20 * kRpm}) {
      for (const bool engaged : {true, false}) {
        const WheelVerdict v = diagnose_wheel(flags, engaged, rho, 10, kParameters);
        if (v.parts != 0) {
          EXPECT_EQ(failure_of(v.parts), v.failure);
        }
      }
    }
  }
}

TEST(DecisionTable, LostPartsNeverLookBetterWhenMoreAreLost) {
  // how bad a state is; the numbers are the thesis' and in another order
  const std::map<WheelFailure, int> rank = {{WheelFailure::none, 0},
                                            {WheelFailure::motor_sensor, 1},
                                            {WheelFailure::reduction_encoder, 1},
                                            {WheelFailure::two_sensors, 2},
                                            {WheelFailure::clutch, 3},
                                            {WheelFailure::clutch_and_sensor, 4},
                                            {WheelFailure::motor, 5},
                                            {WheelFailure::reduction, 6},
                                            {WheelFailure::all_sensors, 7}};
  for (std::uint32_t parts = 0; parts < 64; ++parts) {
    for (std::uint32_t part = 0; part < 6; ++part) {
      EXPECT_LE(rank.at(failure_of(parts)), rank.at(failure_of(parts | only(part))));
    }
  }
}

unsigned flags_of(double c, double m, double h, double r) {
  const auto rpm = [](double value) { return Sensor{value * kRpm, true}; };
  return wheel_flags({c * kRpm, c * kRpm}, {rpm(m), rpm(h), rpm(r)}, kParameters);
}

TEST(Flags, PatternsOfTheThesis) {
  EXPECT_EQ(flags_of(30, 30, 30, 30), 0b000000U);
  EXPECT_EQ(flags_of(30, 0, 30, 30), 0b101100U);
  EXPECT_EQ(flags_of(30, 30, 0, 30), 0b011010U);
  EXPECT_EQ(flags_of(30, 30, 30, 0), 0b000111U);
  EXPECT_EQ(flags_of(30, 0, 0, 0), 0b110001U);
  EXPECT_EQ(flags_of(30, 0, 0, 30), 0b110110U);
  EXPECT_EQ(flags_of(30, 0, 0, 15), 0b110111U);
  EXPECT_EQ(flags_of(30, 0, 30, 0), 0b101011U);
}

// E21: printed, the differences keep their sign
RC_GTEST_PROP(Flags, BackwardIsForwardMirrored, ()) {
  const auto any = [] { return *rc::gen::inRange(-640, 641) * 0.1; };
  const double c = any(), m = any(), h = any(), r = any();
  RC_ASSERT(flags_of(c, m, h, r) == flags_of(-c, -m, -h, -r));
}

// E24
RC_GTEST_PROP(Flags, AgreementGoesBothWaysAndSmallDifferencesAreNone, ()) {
  const double a = *rc::gen::inRange(-6400, 6401) * 0.01 * kRpm;
  const double b = *rc::gen::inRange(-6400, 6401) * 0.01 * kRpm;
  RC_ASSERT(agree(a, b, kParameters) == agree(b, a, kParameters));
  if (std::abs(a - b) < 1.99 * kRpm) RC_ASSERT(agree(a, b, kParameters));
  if (std::abs(a - b) > 13 * kRpm && std::abs(a) < 64 * kRpm) {
    RC_ASSERT(!agree(a, b, kParameters) ||
              std::abs(a - b) < 0.2 * std::max(std::abs(a), std::abs(b)));
  }
}

TEST(Flags, AnythingBetweenTheLastOrdersIsObedience) {
  const auto rpm = [](double value) { return Sensor{value * kRpm, true}; };
  const WheelSensors s{rpm(25), rpm(25), rpm(25)};
  EXPECT_EQ(wheel_flags({10 * kRpm, 40 * kRpm}, s, kParameters), 0U);
  EXPECT_EQ(wheel_flags({40 * kRpm, 10 * kRpm}, s, kParameters), 0U);
  EXPECT_EQ(wheel_flags({35 * kRpm, 40 * kRpm}, s, kParameters), 0b110001U);
}

RC_GTEST_PROP(Flags, SensorsThatCannotBeUsedDisagreeWithEverything, ()) {
  const auto any = [] {
    return Sensor{*rc::gen::inRange(-60, 61) * kRpm, *rc::gen::arbitrary<bool>()};
  };
  const WheelSensors s{any(), any(), any()};
  const unsigned flags = wheel_flags({20 * kRpm, 20 * kRpm}, s, kParameters);
  if (!s.motor.usable) RC_ASSERT((flags & 0b101100U) == 0b101100U);
  if (!s.hall.usable) RC_ASSERT((flags & 0b011010U) == 0b011010U);
  if (!s.reduction.usable) RC_ASSERT((flags & 0b000111U) == 0b000111U);
}

// The 15 ways in which four values fall into groups give 15 patterns, the ones of the table.
TEST(Flags, EveryWayToAgreeIsInTheTable) {
  std::set<unsigned> seen;
  const double groups[] = {10, 25, 40, 60};
  for (const double c : groups) {
    for (const double m : groups) {
      for (const double h : groups) {
        for (const double r : groups) seen.insert(flags_of(c, m, h, r));
      }
    }
  }
  EXPECT_EQ(seen.size(), 15U);
  for (const unsigned flags : seen) EXPECT_TRUE(flags == 0b111111 || kTable.count(flags) == 1);
}

TEST(Steering, EveryPatternHasTheOutcomeOfTheTable) {
  const auto is = [](unsigned flags, SteeringFailure failure) {
    const SteeringVerdict v = diagnose_steering(flags);
    return v.outcome == Outcome::failure && v.failure == failure;
  };
  EXPECT_TRUE(is(0b000, SteeringFailure::none));
  EXPECT_TRUE(is(0b110, SteeringFailure::motor_encoder));
  EXPECT_TRUE(is(0b011, SteeringFailure::reduction_encoder));
  EXPECT_TRUE(is(0b101, SteeringFailure::critical));
  EXPECT_TRUE(is(0b111, SteeringFailure::both_encoders));
  for (const unsigned flags : {0b100U, 0b010U, 0b001U}) {
    EXPECT_EQ(diagnose_steering(flags).outcome, Outcome::inconclusive);
  }
}

// E14: printed, the third flag is the first one again and E-SRG can never be detected
TEST(Steering, ThirdFlagIsOfTheReductionEncoder) {
  const auto flags = [](double c, double m, double r) {
    return steering_flags({c, c}, {m, true}, {r, true}, kParameters);
  };
  EXPECT_EQ(flags(0.3, 0.3, 0.3), 0b000U);
  EXPECT_EQ(flags(0.3, 0.1, 0.3), 0b110U);
  EXPECT_EQ(flags(0.3, 0.3, 0.1), 0b011U);
  EXPECT_EQ(flags(0.3, 0.1, 0.1), 0b101U);
  EXPECT_EQ(flags(0.3, 0.1, 0.2), 0b111U);
  EXPECT_EQ(flags(0.3, 0.27, 0.33), 0b010U);
}

TEST(Steering, AnEncoderThatStandsWhileTheGearTurnsIsFoundInAFrame) {
  using S = SteeringFailure;
  EXPECT_EQ(standing_encoder(0, 0.03, 0.05, kParameters), S::motor_encoder);
  EXPECT_EQ(standing_encoder(-0.03, 0.001, -0.05, kParameters), S::reduction_encoder);
  EXPECT_EQ(standing_encoder(0.03, 0.028, 0.05, kParameters), S::none);
  EXPECT_EQ(standing_encoder(0, 0.03, -0.05, kParameters), S::none);  // differs from the order
  EXPECT_EQ(standing_encoder(0, 0.03, 0, kParameters), S::none);
  EXPECT_EQ(standing_encoder(0, 0.015, 0.05, kParameters), S::none);  // too little for a decision
}

}  // namespace
}  // namespace lss::gnc::ardito::test
