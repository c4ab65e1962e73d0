// Failures in flight in short: one or two hops each; campaigns.h has all of them.

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "tests/talaris/chain/campaigns.h"

namespace lss::talaris {
namespace {

bool told(const Flown& flown, FaultId id) {
  return std::ranges::find(flown.faults, id) != flown.faults.end();
}

void expect_down(const char* fault, double after_s, FaultId latched, double most_m_s) {
  const Flown flown = fly({.faults = {fault}, .fault_s = after_s}, 1);
  SCOPED_TRACE(flown.text());
  EXPECT_TRUE(flown.upright());
  EXPECT_TRUE(told(flown, latched));
  EXPECT_LT(flown.down_m_s, most_m_s);
}

TEST(TalarisFailures, WithoutAltimeterItComesDownByDeadReckoning) {
  expect_down("altimeter-silent", 9, faults::altitude_lost, 1.5);
}

TEST(TalarisFailures, WithoutTheValveNodeTheFansAreTheParachute) {
  expect_down("node-silent:0x20", 9, FaultId::module_silent, 1.8);
}

TEST(TalarisFailures, WithLessGasThanPlannedItComesDownInTime) {
  expect_down("gas:12", 5, faults::gas_low, 1.6);
}

}  // namespace
}  // namespace lss::talaris
