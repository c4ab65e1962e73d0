// Modules out of service by command: a leg isolated, restored, turned clear; a panel whose module
// is dead. [Conf-3] [Func-5]

#include <gtest/gtest.h>

#include "idl/zebro/codes.h"
#include "world.h"

namespace lss::zebro {
namespace {

std::uint16_t isolated(const World& w) { return w.supervisor_.controller().isolated; }

TEST(Service, ALegIsIsolatedByCommandInIdleAndTheOthersWalk_Conf_3) {
  World w;
  w.run(0.2);
  EXPECT_EQ(w.why(CommandKind::isolate, {3}), Reason::none);
  EXPECT_EQ(isolated(w), 1u << 2);
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::walk, {1, 0, 2});
  ASSERT_TRUE(w.run_until(Mode::walking, 5));
  w.run(20);
  EXPECT_EQ(w.mode(), Mode::walking);
  EXPECT_EQ(w.why(CommandKind::isolate, {5}), Reason::not_in_state);
}

TEST(Service, ALegIsIsolatedByCommandInFatalErrorAndSolveLeadsToIdle_Conf_3) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].alive = false;
  ASSERT_TRUE(w.run_until(State::fatal_error, 1));
  EXPECT_EQ(w.why(CommandKind::isolate, {3}), Reason::none);
  EXPECT_FALSE(w.has(FaultId::module_silent, 3));
  const TimeNs begun = w.time_ns_;
  ASSERT_TRUE(w.solve(40));
  EXPECT_LT(w.time_ns_ - begun, 3 * kSecond) << "nothing is tried on it";
  EXPECT_TRUE(w.stand());
}

TEST(Service, TooFewLegsAreNotIsolated_Conf_3) {
  World w;
  w.run(0.2);
  EXPECT_EQ(w.why(CommandKind::isolate, {3}), Reason::none);
  EXPECT_EQ(w.why(CommandKind::isolate, {3}), Reason::isolated);
  EXPECT_EQ(w.why(CommandKind::isolate, {1}), reasons::not_stable) << "neighbours";
  EXPECT_EQ(w.why(CommandKind::isolate, {4}), Reason::none);
  EXPECT_EQ(w.why(CommandKind::isolate, {6}), reasons::not_stable) << "three";
  EXPECT_EQ(isolated(w), 0b1100);
}

// The centre of mass is 3 mm ahead: without one leg it creeps, without 1 and 4 it cannot even row.
TEST(Service, TwoLegsIsolatedInOneFrameAreJudgedTogether) {
  Parameters p;
  for (double& x_m : p.locomotion.hips.x_m) x_m -= 0.003;
  ASSERT_TRUE(gnc::zebro::can_walk_without(0b0001, p.locomotion));
  ASSERT_TRUE(gnc::zebro::can_walk_without(0b1000, p.locomotion));
  ASSERT_FALSE(gnc::zebro::can_walk_without(0b1001, p.locomotion));
  World w(p);
  w.send(CommandKind::isolate, {1});
  EXPECT_EQ(w.why(CommandKind::isolate, {4}), reasons::not_stable) << "in the first frame";
  EXPECT_EQ(isolated(w), 0b0001);
  w.run(0.2);
  w.send(CommandKind::restore_leg, {1});
  w.send(CommandKind::isolate, {4});
  EXPECT_EQ(w.why(CommandKind::isolate, {1}), reasons::not_stable);
  EXPECT_EQ(isolated(w), 0b1000);
}

TEST(Service, OneLegIsRestoredAndTheOtherIsNot_Conf_3) {
  World w;
  w.run(0.2);
  w.why(CommandKind::isolate, {3});
  w.why(CommandKind::isolate, {4});
  EXPECT_EQ(w.why(CommandKind::restore_leg, {4}), Reason::none);
  EXPECT_EQ(isolated(w), 1u << 2);
  w.run(0.1);
  EXPECT_TRUE(w.stand());
}

TEST(Service, ALegThatIsDeadAtBootIsIsolatedByCommand_Conf_3) {
  World w;
  w.modules[5].alive = false;
  w.run(1);
  EXPECT_EQ(w.why(lss::CommandKind::start, {0, 1, 0, 0}), Reason::never_heard);
  EXPECT_EQ(w.why(CommandKind::isolate, {6}), Reason::none);
  EXPECT_TRUE(w.stand());
}

void start_without_leg_3(World& w) {
  w.run(0.2);
  w.why(CommandKind::isolate, {3});
  w.send(lss::CommandKind::start, {0});
  w.run(0.5);
}

// docs/gait-zebro.md: the operator has to turn it clear of the ground.
TEST(Service, AnIsolatedLegIsTurnedClearByDirectCommandAndItsMotorGoesOffAgain_Miss_3) {
  World w;
  start_without_leg_3(w);
  EXPECT_FALSE(w.modules[2].flags & kFlagMotionControl);
  const auto others = w.modules;
  w.send(CommandKind::leg, {3, 3.14159265, 4, 1});
  ASSERT_TRUE(
      w.run_until([&] { return w.answer(CommandKind::leg, Phase::completed) != nullptr; }, 8));
  w.run(0.1);
  EXPECT_NEAR(w.modules[2].position_deg, 180, 0.5);
  EXPECT_FALSE(w.modules[2].flags & kFlagMotionControl);
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (i == 2) continue;
    EXPECT_NEAR(w.modules[i].position_deg, others[i].position_deg, 0.1);
  }
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
  w.send(CommandKind::stand);
  EXPECT_TRUE(w.run_until(Mode::standing, 40));
}

TEST(Service, AnIsolatedLegThatJamsIsNoEmergency_Miss_3) {
  World w;
  start_without_leg_3(w);
  w.send(CommandKind::leg, {3, 3.14159265, 4, 1});
  w.run(1);
  w.modules[2].current_mA = 1500;
  ASSERT_TRUE(w.run_until([&] { return w.answer(CommandKind::leg, Phase::failed) != nullptr; }, 1));
  EXPECT_EQ(w.answer(CommandKind::leg, Phase::failed)->verdict.reason, reasons::leg_blocked);
  w.run(0.1);
  EXPECT_FALSE(w.modules[2].flags & kFlagMotionControl);
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
}

TEST(Service, ADeadPanelModuleIsForgoneWhenTheOperatorAnswersForIt_Func_5) {
  World w;
  w.run(0.2);
  EXPECT_EQ(w.why(CommandKind::panel_is_in), reasons::panel_answers);
  w.modules[6].alive = false;
  ASSERT_TRUE(w.run_until(State::fatal_error, 1));
  EXPECT_FALSE(w.solve(60)) << "no strategy can help";
  EXPECT_EQ(w.why(CommandKind::panel_is_in), Reason::none);
  EXPECT_EQ(isolated(w), 1u << 6);
  ASSERT_TRUE(w.solve(60));
  EXPECT_EQ(w.why(CommandKind::panel, {1}), Reason::isolated);
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::walk, {1, 0, 3});
  ASSERT_TRUE(w.run_until(Mode::walking, 5));
  w.run(5);
  EXPECT_EQ(w.mode(), Mode::walking);
}

// Commands of a restarted daemon itself, for the next frame.
void isolate_as_before(World& w, std::initializer_list<unsigned> modules) {
  for (const unsigned module : modules) {
    Request request = isolation_of(module);
    request.source = source("lssd");
    request.flags = kFlagSaved;
    w.put(request);
  }
}

TEST(Service, ARestartedDaemonIsolatesThemAgainByCommandsOfItsOwn_Conf_3) {
  World w;
  w.modules[2].alive = w.modules[6].alive = false;
  isolate_as_before(w, {3, 7});
  w.heartbeat_ = false;
  w.step();
  EXPECT_EQ(isolated(w), 1u << 2 | 1u << 6);
  EXPECT_NE(w.supervisor_.controller().links & lc::kObcSilent, 0) << "it is no OBC";
  w.heartbeat_ = true;
  w.run(1);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_TRUE(w.stand());
}

// The centre of mass of the configuration is 15 mm further ahead than when the leg was isolated.
TEST(Service, ALegThatTheOthersCannotDoWithoutStaysIsolatedAndNothingStarts) {
  Parameters p;
  for (double& x_m : p.locomotion.hips.x_m) x_m -= 0.015;
  ASSERT_FALSE(gnc::zebro::can_walk_without(0b0001, p.locomotion));
  World w(p);
  isolate_as_before(w, {1});
  w.run(1);
  EXPECT_EQ(isolated(w), 0b0001);
  EXPECT_TRUE(w.out_.telemetry.modules[0].isolated);
  const Verdict v = w.ask(lss::CommandKind::start, {1});
  EXPECT_EQ(v.reason, reasons::not_stable);
  EXPECT_EQ(v.subject, 1);
  EXPECT_EQ(w.why(CommandKind::isolate, {1}), Reason::isolated);
  EXPECT_EQ(w.why(CommandKind::restore_leg, {1}), Reason::none) << "a person's decision";
  EXPECT_EQ(isolated(w), 0);
  EXPECT_TRUE(w.stand());
}

TEST(Service, AfterCommandsOfItsOwnTheDaemonStillAnswersOthersAtOnce) {
  World w;
  isolate_as_before(w, {3});
  w.step();
  ASSERT_EQ(isolated(w), 1u << 2);
  w.use_port();
  w.acks.clear();
  w.send(lss::CommandKind::solve);
  ASSERT_EQ(w.acks.size(), 1u) << "without a frame";
  EXPECT_EQ(w.acks[0].verdict.reason, Reason::not_in_state);
}

}  // namespace
}  // namespace lss::zebro
