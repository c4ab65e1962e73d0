// Where the panel is, when its module knows it and when it does not.

#include <gtest/gtest.h>

#include "daemon/record/state.h"
#include "idl/zebro/codes.h"
#include "world.h"

namespace lss::zebro {
namespace {

constexpr std::uint16_t kPanelNumber = 7;

IdealModule& panel(World& w) { return w.modules[kPanelNumber - 1]; }

Reason start(World& w) {
  w.send(lss::CommandKind::start, {0});
  w.step();
  return w.state() == State::operational ? Reason::none : w.acks.back().verdict.reason;
}

bool move(World& w, bool deploy) {
  w.send(CommandKind::panel, {deploy ? 1.0 : 0.0});
  w.step();
  const auto moving = [&] { return w.supervisor_.state().active.kind != 0; };
  return w.run_until([&] { return !moving(); }, 40) && w.acks.back().phase == Phase::completed;
}

// The same modules and another daemon.
World restarted(const World& before) {
  World w;
  w.modules = before.modules;
  w.time_ns_ = before.time_ns_;
  for (IdealModule& m : w.modules) m.serial = ~0u;
  w.run(0.2);
  return w;
}

// [Func-5]
TEST(Panel, WithoutCalibrationAndAwayFromItsSensorItIsOut) {
  World w;
  w.run(0.2);
  ASSERT_TRUE(move(w, true));
  panel(w).restart_count();
  w.run(0.2);
  EXPECT_EQ(w.vehicle_.modules()[6].status.position_rad, 0) << "so it says";
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_EQ(start(w), reasons::panel_deployed);
  World other = restarted(w);
  EXPECT_EQ(start(other), reasons::panel_deployed) << "a daemon that knows nothing of before";
  ASSERT_TRUE(move(other, false));
  EXPECT_NEAR(std::remainder(panel(other).true_deg(), 360), 0, 1);
  EXPECT_TRUE(panel(other).flags & kFlagCalibrated) << "it went over its sensor";
  EXPECT_TRUE(other.stand());
}

TEST(Panel, ThatDrawsTooMuchWhileItMovesIsAnEmergency_P_Int_1) {
  World w;
  panel(w).current_mA = 1300;
  w.run(0.5);
  EXPECT_EQ(w.state(), State::idle) << "its motor is off";
  w.send(CommandKind::panel, {1});
  ASSERT_TRUE(w.run_until(State::fatal_error, 1));
  EXPECT_TRUE(w.has(faults::current_limit, kPanelNumber));
  EXPECT_TRUE(w.all_stopped());
}

TEST(Panel, WithoutCalibrationAtItsSensorItIsIn_Func_5) {
  World w;
  panel(w).position_deg = 1.5;
  w.run(0.2);
  ASSERT_FALSE(panel(w).flags & kFlagCalibrated);
  EXPECT_TRUE(w.stand());
}

TEST(Panel, DeployingAPanelOfUnknownPlaceBeginsAtItsSensor) {
  World w;
  w.run(0.2);
  ASSERT_TRUE(move(w, true));
  panel(w).position_deg = 60;  // somebody turned it
  panel(w).restart_count();
  w.run(0.2);
  ASSERT_TRUE(move(w, true));
  EXPECT_TRUE(panel(w).flags & kFlagCalibrated);
  EXPECT_NEAR(panel(w).true_deg(), 110, 1);
}

TEST(Panel, AResetWhileItIsRetractedEndsItAndItIsStillOut_Func_5) {
  for (const double after_s : {0.1, 2.0, 6.0, 9.0}) {
    SCOPED_TRACE(after_s);
    World w;
    w.run(0.2);
    ASSERT_TRUE(move(w, true));
    panel(w).restart_count();  // so that its retracting begins with looking for the sensor
    w.run(0.1);
    w.send(CommandKind::panel, {0});
    w.run(after_s);
    panel(w).restart_count();
    ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 0.1));
    EXPECT_TRUE(w.has(FaultId::module_reset, kPanelNumber));
    EXPECT_EQ(w.last(Phase::failed)->verdict.reason, Reason::emergency);
    w.send(lss::CommandKind::solve);
    ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 15));
    EXPECT_EQ(start(w), reasons::panel_deployed);
    ASSERT_TRUE(move(w, false));
    EXPECT_NEAR(std::remainder(panel(w).true_deg(), 360), 0, 1);
    EXPECT_TRUE(w.stand());
  }
}

TEST(Panel, AResetInTheFirstFrameOfAReplayFromMidRunEndsItsMovement) {
  World w;
  w.run(0.2);
  w.send(CommandKind::panel, {1});
  w.run(3);
  record::StateWriter size({});
  size(w.vehicle_, w.supervisor_);
  std::vector<std::uint8_t> state(size.size());
  record::StateWriter writer(state);
  writer(w.vehicle_, w.supervisor_);
  w.restart(Parameters{});
  record::StateReader reader(state);
  reader(w.vehicle_, w.supervisor_);
  ASSERT_TRUE(reader.good());
  w.send(lss::CommandKind::reset, {kPanelNumber});
  w.step();
  EXPECT_FALSE(w.supervisor_.controller().flags & kPanelMoving);
  EXPECT_TRUE(w.supervisor_.controller().flags & kPanelOut);
  const Ack* ended = w.answer(CommandKind::panel, Phase::failed);
  ASSERT_NE(ended, nullptr);
  EXPECT_EQ(ended->verdict.reason, Reason::superseded);
}

TEST(Panel, WhoseSensorSeesNothingIsNeverBelievedToBeIn_Func_5) {
  World w;
  w.run(0.2);
  ASSERT_TRUE(move(w, true));
  panel(w).restart_count();
  panel(w).hall_broken = true;
  w.run(0.2);
  w.send(CommandKind::panel, {0});
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 20));
  EXPECT_TRUE(w.has(faults::motion_timeout, kPanelNumber));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 60));
  EXPECT_EQ(start(w), reasons::panel_deployed);
}

// It had no order to move: it is stopped like everything else, and stays out until it is retracted.
TEST(Panel, ThatIsOutWhileLegsMoveIsAnEmergency_Func_5) {
  for (const bool calibrated : {true, false}) {
    World w;
    panel(w).flags = calibrated ? kFlagCalibrated : 0;
    ASSERT_TRUE(w.stand());
    panel(w).position_deg = 15;
    w.step();
    EXPECT_EQ(w.state(), State::fatal_error);
    EXPECT_TRUE(w.all_stopped()) << "in the frame that saw it";
    EXPECT_TRUE(w.has(FaultId::module_disobeys, kPanelNumber));
    w.send(lss::CommandKind::solve);
    ASSERT_TRUE(w.run_until([&] { return w.state() != State::solve_errors; }, 60));
    ASSERT_EQ(w.state(), State::idle);
    EXPECT_EQ(start(w), reasons::panel_deployed);
    ASSERT_TRUE(move(w, false));
    EXPECT_TRUE(w.stand());
  }
}

// An event in FatalError is known in the first frame of Idle.
TEST(Panel, ThatIsMovedWhileErrorsAreSolvedIsOutInTheFrameAfterIt_Func_5) {
  for (const bool calibrated : {true, false}) {
    World w;
    w.run(0.2);
    w.send(lss::CommandKind::emergency_stop);
    w.run(0.2);
    panel(w).flags = calibrated ? kFlagCalibrated : 0;
    panel(w).position_deg = 60;
    w.send(lss::CommandKind::solve);
    ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 15));
    EXPECT_EQ(start(w), reasons::panel_deployed);
  }
}

// A module may answer before it has reported its position.
TEST(Panel, NothingStartsBeforeItsFirstStatus_Func_5) {
  World w;
  panel(w).position_deg = 110;
  panel(w).sensor_deg = 0;
  panel(w).says_status = false;
  w.run(0.2);
  EXPECT_EQ(start(w), Reason::never_heard);
  panel(w).says_status = true;
  w.step();
  EXPECT_EQ(start(w), reasons::panel_deployed);
}

// [Oper-4]
TEST(Panel, AResetOfTheControllerOrOfModulesEndsItsMovementAndSaysSo) {
  for (const double what : {-1.0, 0.0, 7.0}) {
    SCOPED_TRACE(what);
    World w;
    w.run(0.2);
    w.send(CommandKind::panel, {1});
    w.run(3);
    w.send(lss::CommandKind::reset, {what});
    w.run(1);
    const auto answer = [&](Phase phase) {
      for (const Ack& ack : w.acks) {
        if (ack.kind == static_cast<std::uint16_t>(CommandKind::panel) && ack.phase == phase)
          return &ack;
      }
      return static_cast<const Ack*>(nullptr);
    };
    EXPECT_EQ(answer(Phase::completed), nullptr);
    const Ack* ended = answer(what < 0 ? Phase::superseded : Phase::failed);
    ASSERT_NE(ended, nullptr);
    EXPECT_EQ(ended->verdict.reason, Reason::superseded);
    EXPECT_FALSE(panel(w).flags & kFlagMotionControl);
    EXPECT_EQ(w.state(), State::idle);
    EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
    EXPECT_EQ(start(w), reasons::panel_deployed);
  }
}

TEST(Panel, AStopEndsItsMovementWhereItIs) {
  for (const bool deploy : {true, false}) {
    for (const double lay_down : {0.0, 1.0}) {
      for (const double after_s : {0.0, 0.1, 3.0}) {
        SCOPED_TRACE(testing::Message() << deploy << ' ' << lay_down << ' ' << after_s);
        World w;
        w.run(0.2);
        ASSERT_TRUE(deploy || move(w, true));
        w.send(CommandKind::panel, {deploy ? 1.0 : 0.0});
        w.step();
        w.run(after_s);
        w.send(lss::CommandKind::stop, {lay_down});
        w.run(0.1);
        EXPECT_FALSE(panel(w).flags & kFlagMotionControl);
        const double stopped_deg = panel(w).true_deg();
        const Ack* ended = w.answer(CommandKind::panel, Phase::superseded);
        ASSERT_NE(ended, nullptr);
        EXPECT_EQ(ended->verdict.reason, Reason::superseded);
        EXPECT_NE(w.answer(lss::CommandKind::stop, Phase::completed), nullptr);
        w.run(15);
        EXPECT_NEAR(panel(w).true_deg(), stopped_deg, 0.1);
        EXPECT_EQ(w.state(), State::idle);
        EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
        EXPECT_EQ(start(w), reasons::panel_deployed);
        ASSERT_TRUE(move(w, false));
        EXPECT_TRUE(w.stand());
      }
    }
  }
}

TEST(Panel, AStopWhileItRestsDoesNotTouchIt) {
  World w;
  w.run(0.2);
  const auto order = [&] { return w.out_.command.module[kPanelNumber - 1].serial; };
  const auto before = order();
  w.send(lss::CommandKind::stop, {1});
  w.run(0.1);
  EXPECT_EQ(order(), before);
  EXPECT_NE(w.answer(lss::CommandKind::stop, Phase::completed), nullptr);
}

TEST(Panel, TheVehicleIsNotAtRestWhileItMovesOrAModuleIsReset) {
  World w;
  w.run(0.2);
  const auto rests = [&] { return at_rest(w.supervisor_.state()); };
  EXPECT_TRUE(rests());
  w.send(CommandKind::panel, {1});
  w.step();
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_FALSE(rests());
  ASSERT_TRUE(w.run_until(rests, 40));
  EXPECT_EQ(w.acks.back().phase, Phase::completed);
  w.modules[0].boot_ns = kSecond;
  w.send(lss::CommandKind::reset, {1});
  w.step();
  EXPECT_FALSE(rests());
  EXPECT_TRUE(w.run_until(rests, 5));
}

}  // namespace
}  // namespace lss::zebro
