// The chain itself: it drives and stops, and the same options give the same run.

#include "tests/ardito/chain/chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "idl/ardito/codes.h"
#include "tests/support/everything.h"

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

// A step of 150 mm is not climbed: in physics, with all noise.
TEST(ArditoChain, ABlockedRoverStopsWithinThreeSecondsAndSaysWhy) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    if (!testing_support::in_sample(seed, 3)) continue;
    SCOPED_TRACE(seed);
    Chain::Options options = with_short_lamp(seed);
    options.rover.step_height_m = 0.150;
    Chain chain(options);
    ASSERT_TRUE(chain.start());
    ASSERT_TRUE(chain.drive(0.3));
    const auto at_m = [&] { return chain.world().rover().body().position_m.x(); };
    const auto rests = [&] { return chain.world().rover().body().velocity_m_s.norm() < 0.03; };
    ASSERT_TRUE(chain.run_until([&] { return at_m() > 0.5 && rests(); }, 20)) << "against the step";
    const double blocked_s = chain.seconds();
    ASSERT_TRUE(chain.run_until(Mode::stopped, 3));
    EXPECT_LT(chain.seconds() - blocked_s, 3);
    EXPECT_TRUE(chain.has(faults::rover_stuck));
    EXPECT_FALSE(chain.has(faults::imu_lost, kImuNode)) << "it is right";
    EXPECT_EQ(chain.state(), State::operational);
    EXPECT_NEAR(chain.telemetry().distance_m, at_m(), 0.1);
    const auto failed = [&](const Ack& ack) {
      return ack.phase == Phase::failed && ack.verdict.reason == reasons::stuck;
    };
    EXPECT_TRUE(std::ranges::any_of(chain.acks, failed));
    ASSERT_TRUE(chain.drive(-0.3)) << "back is free";
    chain.run(3);
    EXPECT_LT(chain.telemetry().distance_m, at_m() + 0.2);
    EXPECT_FALSE(chain.has(faults::rover_stuck));
    EXPECT_EQ(chain.mode(), Mode::running);
  }
}

// A drive that loses operation enabled and is enabled again at once: invisible but for these.
TEST(ArditoChain, ADriveThatDropsOutAgainAndAgainIsAFault) {
  Chain::Options options = with_short_lamp(1);
  options.rover.plant = sim::ardito::PlantKind::kinematic;
  Chain chain(options);
  ASSERT_TRUE(chain.start());
  ASSERT_TRUE(chain.drive(0.3));
  const auto told = [&] {
    return std::ranges::count_if(chain.events, [](const EventRecord& e) {
      return e.id == static_cast<std::uint16_t>(EventId::drive_dropped_out);
    });
  };
  for (int n = 1; n <= 3; ++n) {
    chain.inject("drive-drop:0x02");
    chain.run(1.25);
    EXPECT_EQ(told(), n);
    EXPECT_EQ(chain.state(), State::operational);
  }
  chain.inject("drive-drop:0x02");
  EXPECT_TRUE(chain.run_until(State::fatal_error, 1));
  EXPECT_TRUE(chain.has(FaultId::drive_drops_out, 2));
}

// CiA 301: 0x1029 and 0x1015 are optional.
TEST(ArditoChain, AWheelWithoutAnOptionalObjectDrives) {
  for (const char* lacks : {"no-object:1:0x1029", "no-object:1:0x1015"}) {
    SCOPED_TRACE(lacks);
    Chain::Options options = with_short_lamp(1);
    options.rover.plant = sim::ardito::PlantKind::kinematic;
    Chain chain(options);
    chain.inject(lacks);
    ASSERT_TRUE(chain.start());
    EXPECT_TRUE(chain.drive(0.3));
  }
}

// One that refuses what is needed was heard.
TEST(ArditoChain, AWheelThatRefusesItsConfigurationIsNotCalledUnheard) {
  Chain::Options options = with_short_lamp(1);
  options.rover.plant = sim::ardito::PlantKind::kinematic;
  Chain chain(options);
  chain.inject("no-object:2:0x6007");
  chain.run(8);
  chain.send(lss::CommandKind::start, {0});
  chain.run(0.2);
  ASSERT_FALSE(chain.acks.empty());
  EXPECT_EQ(chain.acks.back().verdict.reason, Reason::not_configured);
  EXPECT_EQ(chain.acks.back().verdict.subject, 2);
  EXPECT_TRUE(chain.has(FaultId::node_refuses, 2));
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
