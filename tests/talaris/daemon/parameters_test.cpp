// Parameters of TALARIS that change while it runs.
#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

TEST(TalarisParameters, APlanLeavesTheReserveThatWasSet) {
  World w;
  w.run(1);
  ASSERT_EQ(w.set("gas.reserve_s", 43).verdict.reason, Reason::none);
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::gnc, {0}), Reason::none);
  const double hop = static_cast<double>(Program::hop);
  EXPECT_EQ(w.why(Kind::plan, {hop, 2, 5, 0, 0}), reasons::gas_short);
}

TEST(TalarisParameters, ALowSupplyIsReportedByTheLimitThatWasSetAlsoWhileOperational) {
  World w;
  ASSERT_TRUE(w.start());
  w.run(1);
  EXPECT_FALSE(w.has(faults::supply_low, kValveModule));
  ASSERT_EQ(w.set("gas.min_voltage_V", 30).verdict.reason, Reason::none);
  w.run(1);
  EXPECT_TRUE(w.has(faults::supply_low, kValveModule));
  ASSERT_EQ(w.set("gas.min_voltage_V", 0).verdict.reason, Reason::none);  // not looked at
  w.run(1);
  EXPECT_FALSE(w.has(faults::supply_low, kValveModule));
}

TEST(TalarisParameters, NothingOfTheFlightIsChangedWhileOperational) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.set("limits.tilt_deg", 25).verdict.reason, Reason::not_in_state);
  EXPECT_EQ(w.set("gains.1.attitude_wn_rad_s", 1.5).verdict.reason, Reason::not_in_state);
}

TEST(TalarisParameters, WhatIsNotTheFlightsCostsItNoPlan) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.calibrate());
  const double hop = static_cast<double>(Program::hop);
  ASSERT_EQ(w.why(Kind::plan, {hop, 2, 5, 0, 0}), Reason::none);
  ASSERT_EQ(w.set("imu.lost_per_s", 30).verdict.reason, Reason::none);
  EXPECT_EQ(w.vehicle_.flight().phase, gnc::talaris::Phase::ready);
}

}  // namespace
}  // namespace lss::talaris
