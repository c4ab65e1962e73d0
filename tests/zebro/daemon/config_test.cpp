#include "daemon/vehicles/zebro/config.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "daemon/vehicles/zebro/tunables.h"
#include "tests/support/config_file.h"

namespace lss::zebro {
namespace {

const testing_support::ConfigFile<Parameters> kFile("zebro", read_parameters);

void expect_refused(const std::string& as_shipped, const std::string& altered, const char* why) {
  Parameters p;
  const auto config = kFile.load(kFile.altered(as_shipped, altered), p);
  ASSERT_FALSE(config);
  EXPECT_NE(config.error().find(why), std::string::npos) << config.error();
}

TEST(ZebroConfig, TheExampleContainsTheDefaults) {
  const auto [config, p] = kFile.defaults(tuning(), "motion.arrived_deg");
  const Parameters d;
  EXPECT_EQ(p.bus.address, d.bus.address);
  EXPECT_EQ(p.bus.stale_after_ns, d.bus.stale_after_ns);
  EXPECT_EQ(p.solver.order, d.solver.order);
  EXPECT_NEAR(p.locomotion.sweep_rad, d.locomotion.sweep_rad, 1e-12);
  EXPECT_DOUBLE_EQ(p.locomotion.leg_diameter_m, d.locomotion.leg_diameter_m);
}

TEST(ZebroConfig, AGaitThatWouldNotSynchroniseIsRefusedWithItsLine) {
  expect_refused("stance_min_s = 3.3", "stance_min_s = 30.0", "zebro_altered_");
}

// [S-Int-1]
TEST(ZebroConfig, TwoModulesOfOneAddressAreRefused) {
  expect_refused("[1, 2, 3, 4, 5, 6, 7]", "[1, 2, 3, 4, 5, 6, 6]", "same address");
}

// [Conf-3]
TEST(ZebroConfig, StrategiesAreTakenInTheirOrderAndUnknownOnesAreRefused) {
  Parameters p;
  const std::string as_shipped = "[\"move_free\", \"cool_down\", \"isolate\"]";
  ASSERT_TRUE(kFile.load(kFile.altered(as_shipped, "[\"isolate\", \"move_free\"]"), p));
  const StrategyList wanted{StrategyKind::isolate, StrategyKind::move_free};
  EXPECT_EQ(p.solver.order[static_cast<std::size_t>(FaultClass::current)], wanted);
  expect_refused(as_shipped, "[\"pray\"]", "\"pray\" is no strategy: use reconnect");
  expect_refused(as_shipped, "[]", "between one and");
}

// [Prod-4]
TEST(ZebroConfig, TheSoftwareCurrentLimitStaysBelowTheHardwares_P_Int_1) {
  Parameters p;
  EXPECT_FALSE(kFile.load(kFile.altered("current_A = 1.2", "current_A = 2.0"), p));
  EXPECT_FALSE(kFile.load(kFile.altered("current_A = 1.2", "current_A = 1.7"), p));
  EXPECT_FALSE(kFile.load(kFile.altered("total_A = 6.0", "total_A = 8.0"), p));
  EXPECT_TRUE(kFile.load(kFile.altered("power_A = 8.0", "power_A = 6.7"), p));
  EXPECT_FALSE(kFile.load(kFile.altered("power_A = 8.0", "power_A = 6.0"), p));
}

// Half duplex: an emergency stop waits for a reply that is not coming.
TEST(ZebroConfig, AReplyIsAwaitedForAFrameAtMost) {
  Parameters p;
  ASSERT_TRUE(kFile.load(kFile.altered("reply_timeout_ms = 5", "reply_timeout_ms = 40"), p));
  EXPECT_EQ(p.bus.reply_timeout_ns, 40 * kMillisecond);
  expect_refused("reply_timeout_ms = 5", "reply_timeout_ms = 41", "reply_timeout_ms");
}

TEST(ZebroConfig, APanelThatTurnsFasterThanALegMayIsRefused) {
  Parameters p;
  const auto config = kFile.load(kFile.altered("move_s = 10.0", "move_s = 1.0"), p);
  EXPECT_TRUE(config) << config.error();
  const std::string as_shipped =
      "deployed_deg = 110.0  # position of the motor when deployed\nmove_s = 10.0";
  expect_refused(as_shipped, "deployed_deg = 300.0\nmove_s = 2.0", "make move_s longer");
}

// Without a heartbeat it lies down after the lease, of 2 s by most clients, and this takes 10 s
// with the shipped times.
TEST(ZebroConfig, ASilentOBCDoesNotBreakOffTheSafeStopOfItsLease) {
  for (const auto& [obc_timeout_s, wrong] : {std::pair{"11.9", true}, {"12", false}}) {
    Parameters p;
    const auto config = kFile.load(
        kFile.altered("obc_timeout_s = 30", std::string("obc_timeout_s = ") + obc_timeout_s), p);
    ASSERT_TRUE(config) << config.error();
    p = with_link(p, *config);
    EXPECT_EQ(check_stop(p) != nullptr, wrong) << obc_timeout_s;
    EXPECT_EQ(tuning().check(p) != nullptr, wrong) << obc_timeout_s;
  }
  const auto [config, p] = kFile.defaults(tuning(), "motion.arrived_deg");
  EXPECT_EQ(with_link(p, config).obc_timeout_ns, Parameters{}.obc_timeout_ns);
  EXPECT_EQ(with_link(p, config).lease_min_ns, Parameters{}.lease_min_ns);
}

// [S-Int-2]
TEST(ZebroConfig, HipsAndCentreOfMassSayWithoutWhichLegsItWalks_S_Int_2) {
  Parameters p;
  ASSERT_TRUE(kFile.load(kFile.altered("vehicle_id", "vehicle_id"), p));
  EXPECT_TRUE(gnc::zebro::can_walk_without(1u << 0, p.locomotion));
  // Ahead: without a front leg it falls.
  const std::string as_shipped = "centre_of_mass_mm = [0.0, 0.0]";
  ASSERT_TRUE(kFile.load(kFile.altered(as_shipped, "centre_of_mass_mm = [15.0, 0.0]"), p));
  EXPECT_NEAR(p.locomotion.hips.x_m[0], 0.065, 1e-12);
  EXPECT_FALSE(gnc::zebro::can_walk_without(1u << 0, p.locomotion));
  EXPECT_FALSE(kFile.load(kFile.altered("hip_y_mm = [65.0, -65.0", "hip_y_mm = [-65.0, 65.0"), p))
      << "sides exchanged";
  EXPECT_FALSE(
      kFile.load(kFile.altered("hip_x_mm = [80.0, 80.0, 0.0", "hip_x_mm = [80.0, 80.0, 90.0"), p));
  // Further ahead: it falls with all legs.
  expect_refused(as_shipped, "centre_of_mass_mm = [60.0, 0.0]", "in gait tripod");
  expect_refused(as_shipped, "centre_of_mass_mm = [0.0, -60.0]", "at least 2 mm are needed");
}

}  // namespace
}  // namespace lss::zebro
