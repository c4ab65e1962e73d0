// The chain itself: it drives and stops, and the same options give the same run.

#include "tests/ardito/chain/chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace lss::ardito {
namespace {

Chain::Options with_short_lamp(unsigned seed) {
  return {.seed = seed, .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }};
}

TEST(ArditoChain, StartsDrivesAndComesToASafeStop) {
  Chain chain(with_short_lamp(1));
  ASSERT_TRUE(chain.start());
  ASSERT_TRUE(chain.drive(0.5));
  chain.run(3);
  const sim::ardito::BodyState body = chain.world().rover().body();
  EXPECT_NEAR(body.velocity_m_s.norm(), 0.5, 0.02);
  EXPECT_NEAR(chain.telemetry().measured_m_s, 0.5, 0.02);
  EXPECT_NEAR(chain.telemetry().distance_m, body.position_m.x(), 0.05);
  chain.send(lss::CommandKind::stop);
  ASSERT_TRUE(chain.run_until(State::idle, 10));
  chain.run(0.5);
  EXPECT_LT(chain.world().rover().body().velocity_m_s.norm(), 0.01);
  EXPECT_EQ(chain.supervisor().fault_count, 0u);
}

// Frames last 100 ms; the drives brake with 1.7 m/s2.
TEST(ArditoChain, AnEmergencyStopBrakesBeforeTheNextFrame) {
  Chain chain(with_short_lamp(1));
  ASSERT_TRUE(chain.start());
  ASSERT_TRUE(chain.drive(0.5));
  chain.run(3);
  const std::uint64_t frame = chain.frames();
  ASSERT_TRUE(chain.run_until([&] { return chain.frames() != frame; }, 1));
  chain.run(0.01);  // its orders are released
  const auto speed = [&] { return chain.world().rover().body().velocity_m_s.norm(); };
  const double before_m_s = speed();
  const std::uint64_t at = chain.frames();
  chain.send(lss::CommandKind::emergency_stop);
  chain.run(0.08);
  EXPECT_EQ(chain.frames(), at);
  EXPECT_LT(speed(), before_m_s - 0.05);
  chain.run(1);
  EXPECT_EQ(chain.state(), State::fatal_error);
  EXPECT_LT(speed(), 0.02);
  EXPECT_FALSE(chain.has(FaultId::stop_not_followed));
  chain.send(lss::CommandKind::solve);
  ASSERT_TRUE(chain.run_until(State::idle, 30));
  ASSERT_TRUE(chain.start());
  EXPECT_TRUE(chain.drive(0.5)) << "orders pass again";
}

TEST(ArditoChain, TheSameSeedGivesTheSameRunToTheBit) {
  const auto run = [](unsigned seed) {
    Chain chain(with_short_lamp(seed));
    chain.inject("noise:0.001");
    EXPECT_TRUE(chain.start());
    EXPECT_TRUE(chain.drive(0.4, 0.03));
    chain.run(0.7123);
    chain.inject("E-TM:3");
    chain.run(0.5);
    const Eigen::Vector3d at = chain.world().rover().body().position_m;
    return std::tuple(at.x(), at.y(), at.z(), chain.telemetry().wheels[5].current_A,
                      chain.telemetry().bus_frames_received);
  };
  const auto first = run(5);
  EXPECT_EQ(first, run(5));
  EXPECT_NE(first, run(6));
}

// It has driven, and is in Idle.
struct AtRest {
  AtRest() {
    EXPECT_TRUE(chain.start());
    chain.send(lss::CommandKind::stop);
    EXPECT_TRUE(chain.run_until(State::idle, 10));
  }
  static Chain::Options rolling() {
    Chain::Options options = with_short_lamp(1);
    options.rover.plant = sim::ardito::PlantKind::kinematic;
    return options;
  }
  Chain chain{rolling()};
};

// The button is pressed at standstill and released again, or the battery is changed: drives are in
// fault then, for want of voltage.
TEST(ArditoChain, MotorPowerThatWasAwayAtRestDoesNotKeepItFromStarting) {
  for (const char* fault : {"power-bad", "e-stop-button"}) {
    SCOPED_TRACE(fault);
    AtRest rover;
    rover.chain.inject(fault);
    rover.chain.run(3);
    EXPECT_EQ(rover.chain.state(), State::idle);
    rover.chain.inject(std::string("clear:") + fault);
    rover.chain.run(1);
    EXPECT_TRUE(rover.chain.start());
    EXPECT_TRUE(rover.chain.drive(0.3));
    EXPECT_FALSE(rover.chain.has(FaultId::module_disobeys, 1));
  }
}

// So a start resets no unreported fault.
TEST(ArditoChain, AFaultOfADriveItselfIsAnEmergencyAtRestToo) {
  AtRest rover;
  rover.chain.inject("drive-fault:0x03");
  EXPECT_TRUE(rover.chain.run_until(State::fatal_error, 1));
  EXPECT_TRUE(rover.chain.has(FaultId::drive_fault, 3));
}

}  // namespace
}  // namespace lss::ardito
