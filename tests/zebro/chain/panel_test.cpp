// The panel's module may be reset at any moment, also while the panel is out: then it counts from
// where it is. Regardless of its report, nothing operates until the panel has moved over its sensor
// and in.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "idl/angles.h"
#include "idl/zebro/codes.h"
#include "tests/zebro/chain/chain.h"
#include "tests/zebro/chain/wire_check.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

using sim::zebro::PlantKind;

constexpr double kIn_deg = 3, kOut_deg = 107;
constexpr double kMove_s = 30;  // over the sensor and back
constexpr std::uint16_t kPanelNumber = 7;

double panel_deg(Chain& chain) { return chain.world().panel_rad() / kDegree; }
bool calibrated(const Chain& chain) { return chain.telemetry().modules[6].calibrated; }

bool ended(const Chain& chain, std::uint64_t sequence) {
  const Ack* ack = chain.last_ack(sequence);
  return ack != nullptr && ack->phase != Phase::accepted && ack->phase != Phase::executing;
}

Phase move(Chain& chain, bool deploy) {
  const auto sequence = chain.send(CommandKind::panel, {deploy ? 1.0 : 0.0});
  chain.run_until([&] { return ended(chain, sequence); }, kMove_s);
  chain.run(0.1);
  return chain.last_ack(sequence)->phase;
}

void expect_start_refused(Chain& chain) {
  const auto sequence = chain.send(lss::CommandKind::start, {1});
  chain.run(0.1);
  EXPECT_EQ(chain.last_ack(sequence)->phase, Phase::rejected);
  EXPECT_EQ(chain.last_ack(sequence)->verdict.reason, reasons::panel_deployed);
  EXPECT_EQ(chain.state(), State::idle);
}

void expect_retracts_and_stands(Chain& chain) {
  ASSERT_EQ(move(chain, false), Phase::completed);
  EXPECT_LT(std::abs(panel_deg(chain)), kIn_deg);
  EXPECT_TRUE(calibrated(chain)) << "it went over its sensor";
  EXPECT_TRUE(chain.stand());
}

class ZebroPanel : public testing::Test {
 protected:
  void SetUp() override { chain_.run(1); }
  void reset() {
    chain_.inject("module-reset:7");
    chain_.run(0.5);
  }

  Chain chain_{{.seed = 7, .plant = PlantKind::kinematic}};
};

// [Func-5] [P-Int-2]
TEST_F(ZebroPanel, ThatIsOutWhenItsModuleIsResetInIdleIsStillOut) {
  ASSERT_EQ(move(chain_, true), Phase::completed);
  ASSERT_GT(panel_deg(chain_), kOut_deg);
  reset();
  EXPECT_EQ(chain_.state(), State::idle);
  EXPECT_FALSE(calibrated(chain_));
  EXPECT_NEAR(chain_.telemetry().modules[6].position_rad, 0, 0.01) << "so it says";
  expect_start_refused(chain_);
  expect_retracts_and_stands(chain_);
}

// The new daemon does not know of the reset.
TEST_F(ZebroPanel, ThatIsOutAndWasResetIsOutForANewDaemon_Func_5) {
  ASSERT_EQ(move(chain_, true), Phase::completed);
  reset();
  auto world = chain_.take_world();
  Chain next({.seed = 8, .vehicle = [&](const auto&) { return std::move(world); }});
  next.run(1);
  ASSERT_EQ(next.state(), State::idle);
  expect_start_refused(next);
  expect_retracts_and_stands(next);
}

// Also a reset of everything by error solving (mission of seed 74).
TEST_F(ZebroPanel, ThatErrorSolvingResetWhileItWasOutIsStillOut_Func_5) {
  ASSERT_EQ(move(chain_, true), Phase::completed);
  chain_.inject("module-dead:2");
  chain_.run(1);
  ASSERT_EQ(chain_.state(), State::fatal_error);
  chain_.send(lss::CommandKind::emergency_stop);
  chain_.run(0.1);
  ASSERT_TRUE(chain_.solve());
  ASSERT_FALSE(calibrated(chain_));
  expect_start_refused(chain_);
  expect_retracts_and_stands(chain_);
}

// [Func-5] [P-Int-2]
TEST_F(ZebroPanel, ThatIsResetOnItsWayStopsAndIsOut) {
  for (const bool known : {true, false}) {
    for (const double after_s : {0.3, 2.0, 5.0, 8.0, 9.5}) {
      SCOPED_TRACE(testing::Message() << after_s << " s, calibrated " << known);
      ASSERT_EQ(move(chain_, true), Phase::completed);
      if (!known) reset();
      const auto retract = chain_.send(CommandKind::panel, {0});
      chain_.run(after_s);
      chain_.inject("module-reset:7");
      ASSERT_TRUE(chain_.run_until(State::fatal_error, 0.340));
      EXPECT_TRUE(chain_.has(FaultId::module_reset, kPanelNumber));
      EXPECT_EQ(chain_.last_ack(retract)->phase, Phase::failed);
      EXPECT_EQ(chain_.last_ack(retract)->verdict.reason, Reason::emergency);
      const double stopped_deg = panel_deg(chain_);
      chain_.run(1);
      EXPECT_NEAR(panel_deg(chain_), stopped_deg, 0.5);
      const TimeNs begin_ns = chain_.now();
      ASSERT_TRUE(chain_.solve());
      EXPECT_EQ(harmless(chain_.wire(), begin_ns, chain_.now()), "");
      ASSERT_GT(panel_deg(chain_), kIn_deg);
      expect_start_refused(chain_);
      ASSERT_EQ(move(chain_, false), Phase::completed);
      EXPECT_LT(std::abs(panel_deg(chain_)), kIn_deg);
      EXPECT_TRUE(calibrated(chain_));
      chain_.forget();
    }
  }
}

// The middle of the sensor is at the mechanical stop: pressed into it at the speed of the way
// there, the module tripped at one place out of hundreds. A new order right after the end of one is
// obeyed.
TEST(ZebroPanelAtItsStop, ThatLooksForItsSensorNeverPressesHardIntoIt) {
  constexpr double kHalfOfTheTrip_A = 0.85;
  double most_A = 0;
  for (unsigned i = 0; i < 40; ++i) {
    SCOPED_TRACE(i);
    Chain chain({.seed = i, .plant = PlantKind::kinematic});
    chain.run(1);
    ASSERT_EQ(move(chain, true), Phase::completed);
    chain.send(CommandKind::panel, {0});
    chain.run(0.4 + 0.213 * i);
    chain.inject("module-reset:7");
    if (!chain.run_until(State::fatal_error, 0.340)) continue;  // it was in
    ASSERT_TRUE(chain.solve());
    const auto retract = chain.send(CommandKind::panel, {0});
    chain.run_until(
        [&] {
          most_A = std::max(most_A, std::abs(chain.telemetry().modules[6].current_A));
          return ended(chain, retract);
        },
        kMove_s);
    ASSERT_EQ(chain.last_ack(retract)->phase, Phase::completed);
    ASSERT_EQ(move(chain, true), Phase::completed);
  }
  EXPECT_LT(most_A, kHalfOfTheTrip_A);
  EXPECT_GT(most_A, 0.01) << "it moved";
}

// The panel is in: its module is at the sensor and may be believed.
TEST_F(ZebroPanel, ThatIsResetInOperationalStopsEverythingAndIsStillIn_Func_5) {
  ASSERT_EQ(move(chain_, true), Phase::completed);
  ASSERT_EQ(move(chain_, false), Phase::completed);
  ASSERT_TRUE(chain_.stand());
  chain_.inject("module-reset:7");
  ASSERT_TRUE(chain_.run_until(State::fatal_error, 0.340));
  EXPECT_TRUE(chain_.has(FaultId::module_reset, kPanelNumber));
  ASSERT_TRUE(chain_.solve());
  EXPECT_TRUE(chain_.stand());
}

TEST_F(ZebroPanel, OfUnknownPlaceIsDeployedFromItsSensor) {
  ASSERT_EQ(move(chain_, true), Phase::completed);
  reset();
  double least_deg = 180;
  const auto deploy = chain_.send(CommandKind::panel, {1});
  chain_.run_until(
      [&] {
        least_deg = std::min(least_deg, panel_deg(chain_));
        return ended(chain_, deploy);
      },
      kMove_s);
  EXPECT_EQ(chain_.last_ack(deploy)->phase, Phase::completed);
  EXPECT_LT(least_deg, 1);
  EXPECT_GT(panel_deg(chain_), kOut_deg);
  expect_start_refused(chain_);
}

TEST_F(ZebroPanel, WhoseSensorIsLostStaysOutForGood_Func_5) {
  ASSERT_EQ(move(chain_, true), Phase::completed);
  chain_.inject("hall-lost:7");
  reset();
  EXPECT_EQ(move(chain_, false), Phase::failed);
  EXPECT_EQ(chain_.state(), State::fatal_error);
  ASSERT_TRUE(chain_.solve());
  expect_start_refused(chain_);
}

// [Oper-4]
TEST_F(ZebroPanel, AResetOfTheControllerStopsItOnItsWayAndSaysSo) {
  const auto deploy = chain_.send(CommandKind::panel, {1});
  chain_.run(4);
  chain_.send(lss::CommandKind::reset, {-1});
  chain_.run(0.2);
  EXPECT_EQ(chain_.last_ack(deploy)->phase, Phase::superseded);
  EXPECT_EQ(chain_.last_ack(deploy)->verdict.reason, Reason::superseded);
  EXPECT_EQ(chain_.state(), State::idle);
  const double stopped_deg = panel_deg(chain_);
  EXPECT_GT(stopped_deg, 20);
  EXPECT_LT(stopped_deg, 80);
  chain_.run(2);
  EXPECT_NEAR(panel_deg(chain_), stopped_deg, 0.5);
  expect_start_refused(chain_);
  expect_retracts_and_stands(chain_);
}

}  // namespace
}  // namespace lss::zebro
