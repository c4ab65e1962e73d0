// Failures in flight in short: one or two hops each; campaigns.h has all of them.

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "tests/talaris/chain/campaigns.h"

namespace lss::talaris {
namespace {

bool told(const Flown& flown, FaultId id) {
  return std::ranges::find(flown.faults, id) != flown.faults.end();
}

Flown struck(const char* fault, double after_s, unsigned seed = 1) {
  return fly({.faults = {fault}, .fault_s = after_s}, seed);
}

TEST(TalarisFailures, WithoutAltimeterItComesDownByDeadReckoning) {
  const Flown flown = struck("altimeter-silent", 9);
  SCOPED_TRACE(flown.text());
  EXPECT_TRUE(flown.upright());
  EXPECT_TRUE(told(flown, faults::altitude_lost));
  EXPECT_LT(flown.down_m_s, 1.5);
}

TEST(TalarisFailures, WithoutTheValveNodeTheFansAreTheParachute) {
  const Flown flown = struck("node-silent:0x20", 9);
  SCOPED_TRACE(flown.text());
  EXPECT_TRUE(flown.upright());
  EXPECT_TRUE(told(flown, FaultId::module_silent));
  EXPECT_LT(flown.down_m_s, 1.8);
}

TEST(TalarisFailures, WithLessGasThanPlannedItComesDownInTime) {
  const Flown flown = struck("gas:12", 5);
  SCOPED_TRACE(flown.text());
  EXPECT_TRUE(flown.upright());
  EXPECT_TRUE(told(flown, faults::gas_low));
  EXPECT_LT(flown.down_m_s, 1.6);
}

}  // namespace
}  // namespace lss::talaris
