// Parameters, hop planner and gas budget against the figures of the TALARIS thesis 2.3.3.

#include "gnc/talaris/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "gnc/talaris/fans.h"
#include "gnc/talaris/gas.h"

namespace lss::gnc::talaris {
namespace {

Parameters with_force(double force_N) {
  Parameters p;
  p.thrusters.force_N = force_N;
  return p;
}

PlanRequest request(Program program) {
  PlanRequest r;
  r.program = program;
  return r;
}

TEST(TalarisParameters, DefaultsAreUsableAndWhatIsWrongIsNamed) {
  EXPECT_EQ(check(Parameters{}), nullptr);
  Parameters p;
  p.thrusters.min_on_s = 0.2;
  EXPECT_STREQ(check(p), "thrusters: 0 < min_on < max_on <= long_on <= 0.2 s does not hold");
  p = {};
  p.body.mass_kg = kNaN;
  EXPECT_STREQ(check(p), "body: mass must be 1 to 1000 kg");
  p = {};
  p.gains[0].attitude_ki_1_s3 = 4.99;
  p.gains[0].attitude_zeta = 0.5;
  EXPECT_STREQ(check(p),
               "gains: attitude_ki is too large for wn and zeta: the loop would not be stable");
  p = {};
  p.gain_sets = 9;
  EXPECT_STREQ(check(p), "gains: there must be 1 to 8 sets");
  p = {};
  p.gain_sets = 2;
  p.gains[1].height_kd_1_s = -1;
  EXPECT_NE(check(p), nullptr);
}

TEST(TalarisPlan, AHopOf30MetresTakesItsTimesAndGas) {
  const PlanResult result = make_plan({}, Parameters{}, 44);
  ASSERT_TRUE(result.feasible());
  EXPECT_NEAR(result.plan.climb_s, 4.0, 0.01);
  EXPECT_NEAR(result.plan.traverse_s, 10.0, 0.1);
  EXPECT_NEAR(result.plan.descend_s, 4.0, 0.02);
  EXPECT_GT(result.plan.gas_s, 34);
  EXPECT_LT(result.plan.gas_s, 36.5);
  EXPECT_NEAR(fan_thrust_N(result.plan.fan_rpm, Parameters{}.fans), 367.9 / 4, 0.2);
}

TEST(TalarisPlan, HoverTakesTheThrustersOfTheThesis) {
  Parameters p;
  p.gas.attitude_N = 0;
  EXPECT_NEAR(hover_thrusters(p), 1.27, 0.005);
  p.thrusters.force_N = 40;
  EXPECT_NEAR(hover_thrusters(p), 1.84, 0.005);
}

TEST(TalarisPlan, WithThrustersOf40NewtonTheHopIsRejectedWithItsNumbers) {
  const PlanResult result = make_plan({}, with_force(40), 44);
  EXPECT_EQ(result.guard, Guard::gas);
  EXPECT_NEAR(result.plan.traverse_s, 12.0, 0.1);
  EXPECT_GT(result.measured, 51);
  EXPECT_LT(result.measured, 55);  // a second of touchdown more than the profile without one
  EXPECT_DOUBLE_EQ(result.limit, 44 - Parameters{}.gas.reserve_s);
}

TEST(TalarisPlan, GasThatIsSpentIsNotPlannedWith) {
  EXPECT_TRUE(make_plan({}, Parameters{}, 40).feasible());
  const PlanResult result = make_plan({}, Parameters{}, 38);
  EXPECT_EQ(result.guard, Guard::gas);
  EXPECT_DOUBLE_EQ(result.limit, 35);
}

TEST(TalarisPlan, LeavesItsReserveAndNoMore) {
  for (const double reserve_s : {3.0, 5.0}) {
    Parameters p;
    p.gas.reserve_s = reserve_s;
    const double needs_s = make_plan({}, p, 44).plan.gas_s + reserve_s;
    EXPECT_TRUE(make_plan({}, p, needs_s + 0.01).feasible()) << reserve_s;
    EXPECT_EQ(make_plan({}, p, needs_s - 0.01).guard, Guard::gas) << reserve_s;
  }
}

TEST(TalarisPlan, EveryGuardSaysWhatItSawAndAllows) {
  PlanRequest r;
  r.height_m = 0.05;
  PlanResult result = make_plan(r, Parameters{}, 44);
  EXPECT_EQ(result.guard, Guard::height);
  EXPECT_DOUBLE_EQ(result.measured, 0.05);
  EXPECT_DOUBLE_EQ(result.limit, 0.1);

  r = {};
  r.time_s = 5;  // 30 m in 5 s
  result = make_plan(r, Parameters{}, 44);
  EXPECT_EQ(result.guard, Guard::lateral);
  EXPECT_NEAR(result.measured, 7.2, 1e-9);
  EXPECT_NEAR(result.limit, 2 * 58 * 0.8 / 45, 1e-9);

  EXPECT_EQ(make_plan({}, with_force(100), 44).guard, Guard::hover_on_time);  // too strong to hover
  EXPECT_EQ(make_plan({}, with_force(25), 1e3).guard, Guard::hover_on_time);  // too weak
  EXPECT_EQ(make_plan({}, with_force(30), 1e3).guard, Guard::climb);

  Parameters p;
  p.limits.altimeter_max_m = 2;
  EXPECT_EQ(make_plan({}, p, 44).guard, Guard::altimeter);
  p = {};
  p.fans.max_rpm = 25000;
  EXPECT_EQ(make_plan({}, p, 44).guard, Guard::fan_thrust);
  p = {};
  p.fans.max_run_s = 20;
  EXPECT_EQ(make_plan({}, p, 44).guard, Guard::run_time);

  r = request(Program::traverse);
  r.distance_m = 2;
  r.range_m = 2.2;
  result = make_plan(r, Parameters{}, 44);
  EXPECT_EQ(result.guard, Guard::wall);
  EXPECT_NEAR(result.limit, 1.9, 1e-9);

  r = {};
  r.height_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(make_plan(r, Parameters{}, 44).guard, Guard::request);
  r = {};
  r.program = static_cast<Program>(77);
  EXPECT_EQ(make_plan(r, Parameters{}, 44).guard, Guard::request);
}

TEST(TalarisPlan, FansAloneNeedMoreThanTheWeight) {
  PlanRequest r = request(Program::fan_altitude);
  r.height_m = 0.3;
  EXPECT_TRUE(make_plan(r, Parameters{}, 44).feasible());
  Parameters p;  // 100 N each, TALARIS thesis 2.3.2: 400 N of 441 N
  p.fans.thrust_N_per_rpm2 = 100.0 / (33000.0 * 33000.0);
  const PlanResult result = make_plan(r, p, 44);
  EXPECT_EQ(result.guard, Guard::fan_thrust);
  EXPECT_NEAR(result.measured, 450.1, 0.1);
  EXPECT_NEAR(result.limit, 400, 1e-6);
}

TEST(TalarisGas, PulsesAndPressureAreCountedAndTheWorseIsBelieved) {
  GasBudget gas;
  std::array<Pulse, kValves> pulses{};
  pulses[0].on_s = pulses[7].on_s = 0.1;
  for (int n = 0; n < 50; ++n) gas.count(pulses);
  EXPECT_NEAR(gas.used_s(), 10, 1e-9);
  EXPECT_NEAR(gas.left_s(), 34, 1e-9);
  EXPECT_NEAR(gas.mass_kg(45), 45 - 2 * 10.0 / 44, 1e-9);
  const Gas g;
  gas.pressure(g.empty_kPa + (g.full_kPa - g.empty_kPa) / 2);
  EXPECT_NEAR(gas.left_s(), 22, 1e-9);
  gas.pressure(g.full_kPa);
  EXPECT_NEAR(gas.left_s(), 34, 1e-9);
  gas.pressure(kNaN);
  EXPECT_NEAR(gas.left_s(), 34, 1e-9);
  gas.count(std::array<double, kValves>{kNaN, -1, 5, 0.2});
  EXPECT_NEAR(gas.used_s(), 10.2, 1e-9);
  gas.refuel();
  EXPECT_DOUBLE_EQ(gas.left_s(), 44);
}

}  // namespace
}  // namespace lss::gnc::talaris
