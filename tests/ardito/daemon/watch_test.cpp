// Reports of the daemon about the mobility controller, and its waits, in an ideal world.

#include <gtest/gtest.h>

#include "idl/ardito/codes.h"
#include "world.h"

namespace lss::ardito {
namespace {

// One faulty instance of the mobility controller is corrected and reported.
TEST(ArditoWatch, AnInstanceThatDisagreesIsOutvotedAndReportedUntilTheNextStart) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  gnc::ardito::Parameters wrong;
  wrong.proportional = 0.25;
  w.vehicle_.mobility().instance(1) = gnc::ardito::MobilityController(wrong);
  w.run(0.2);
  EXPECT_TRUE(w.has(faults::instance_disagreed));
  EXPECT_EQ(w.out_.telemetry.disagreeing, 2);
  EXPECT_EQ(w.out_.telemetry.disagreements, 1u);
  w.run(3);
  EXPECT_EQ(w.mode(), Mode::running);
  EXPECT_NEAR(w.out_.telemetry.measured_m_s, 0.3, 0.01);
  EXPECT_EQ(w.out_.telemetry.disagreements, 1u) << "it agrees again";
  w.send(lss::CommandKind::stop);
  ASSERT_TRUE(w.run_until(State::idle, 10));
  w.run(1);
  EXPECT_TRUE(w.has(faults::instance_disagreed));
  w.acks.clear();
  ASSERT_TRUE(w.start());
  EXPECT_FALSE(w.has(faults::instance_disagreed));
}

TEST(ArditoWatch, InstancesWithoutAMajorityAreAnEmergency) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  for (const std::size_t i : {1U, 2U}) {
    gnc::ardito::Parameters wrong;
    wrong.proportional = 0.25 * static_cast<double>(i + 2);
    w.vehicle_.mobility().instance(i) = gnc::ardito::MobilityController(wrong);
  }
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 0.3));
  EXPECT_TRUE(w.has(faults::no_majority));
  EXPECT_TRUE(w.all_stopped());
}

// Drives report their temperature once a second.
TEST(ArditoWatch, AShortBeaconWaitsUntilEveryValueWasHeard) {
  Parameters p;
  p.beacon_ns = 0;
  World w(p);
  w.distort = [&](std::vector<Reading>& readings) {
    if (w.time_ns_ < 1002 * kSecond)
      std::erase_if(readings,
                    [](const Reading& r) { return std::holds_alternative<WheelHealth>(r); });
  };
  ASSERT_TRUE(w.start());
  EXPECT_GE(w.time_ns_, 1002 * kSecond);
  w.run(1);
  EXPECT_EQ(w.state(), State::operational);
}

TEST(ArditoWatch, AValueThatNeverComesIsAFaultAfterTheBeacon) {
  Parameters p;
  p.beacon_ns = 0;
  World w(p);
  w.distort = [](std::vector<Reading>& readings) {
    std::erase_if(readings, [](const Reading& r) {
      const auto* health = std::get_if<WheelHealth>(&r);
      return health != nullptr && health->wheel == 3;
    });
  };
  w.run(0.5);
  w.send(lss::CommandKind::start, {0});
  w.run(2.5);
  EXPECT_EQ(w.mode(), Mode::warning);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 1.5));
  EXPECT_TRUE(w.has(FaultId::stale_input, 4));
}

// Nobody would hear of the button.
TEST(ArditoWatch, InputsThatNeverCameAreAnEmergencyBeforeAnythingMoves) {
  World w;
  w.distort = [](std::vector<Reading>& readings) {
    std::erase_if(readings, [](const Reading& r) { return std::holds_alternative<Inputs>(r); });
  };
  w.run(0.5);
  w.send(lss::CommandKind::start, {0});
  ASSERT_TRUE(w.run_until(State::fatal_error, 1));
  EXPECT_TRUE(w.has(FaultId::stale_input, kIoNode));
}

// A node that has just begun has not had the time to send them.
TEST(ArditoWatch, InputsOfANodeThatHasJustBegunAreAwaited) {
  World w;
  w.run(0.5);
  w.distort = [](std::vector<Reading>& readings) {
    std::erase_if(readings, [](const Reading& r) { return std::holds_alternative<Inputs>(r); });
  };
  w.run(1);
  w.node(kIo).since_ns = w.time_ns_;
  w.send(lss::CommandKind::start, {0});
  w.run(0.2);
  EXPECT_EQ(w.mode(), Mode::warning);
  w.distort = nullptr;
  ASSERT_TRUE(w.run_until(Mode::stopped, 10));
  EXPECT_FALSE(w.has(FaultId::stale_input, kIoNode));
}

// As after a stop that its drive did not take. Without it the rover would go on with a motor that
// nobody can switch off.
TEST(ArditoWatch, AWheelThatDoesNotObeyAStopHasItsNodeResetAndIsNotIsolated) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.send(lss::CommandKind::emergency_stop);
  w.run(0.5);
  w.in_.bus.status.link[4].disobeys = true;
  w.run(0.2);
  EXPECT_TRUE(w.has(FaultId::module_disobeys, 5));
  const std::uint32_t before = w.out_.command.node_reset_serial;
  w.send(lss::CommandKind::solve);
  w.step();
  ASSERT_EQ(w.state(), State::solve_errors);
  ASSERT_TRUE(w.run_until(State::fatal_error, 60));
  EXPECT_NE(w.out_.command.node_reset_serial, before);
  EXPECT_EQ(w.out_.command.reset_nodes, 1u << 4);
  EXPECT_EQ(w.supervisor_.controller().isolated, 0u);
  w.in_.bus.status.link[4].disobeys = false;
  w.send(lss::CommandKind::solve);
  EXPECT_TRUE(w.run_until(State::idle, 60));
}

TEST(ArditoWatch, AnotherMasterOnTheBusIsAWarningUntilItHasBeenSilentFor10Seconds) {
  World w;
  w.run(1);
  EXPECT_FALSE(w.has(FaultId::other_master));
  ++w.in_.bus.status.counters.master.other_masters;
  w.run(0.2);
  EXPECT_TRUE(w.has(FaultId::other_master));
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_EQ(w.out_.telemetry.bus_frames_dropped, 1u);
  w.run(9.5);
  EXPECT_TRUE(w.has(FaultId::other_master));
  w.run(1);
  EXPECT_FALSE(w.has(FaultId::other_master));
}

// The frame wakes a little after its T_k and knows of heartbeats since.
TEST(ArditoWatch, ANodeHeardAfterTheBoundaryWasHeardNow) {
  World w;
  w.run(0.5);
  w.node(3).state = canopen::NodeState::lost;  // its time stays as it is set here
  w.node(3).heartbeat_ns = w.time_ns_ + kSecond;
  w.step();
  EXPECT_EQ(w.out_.telemetry.nodes[3].age_ms, 0u);
}

}  // namespace
}  // namespace lss::ardito
