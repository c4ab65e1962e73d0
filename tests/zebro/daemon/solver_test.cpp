#include <gtest/gtest.h>

#include "idl/zebro/codes.h"
#include "tests/zebro/daemon/world.h"

// Error solving, strategy by strategy. [Conf-3] [Oper-5] [Oper-6]

namespace lss::zebro {
namespace {

bool tried(const World& w, StrategyKind kind) {
  for (const EventRecord& e : w.events) {
    if (e.id == static_cast<std::uint16_t>(EventId::strategy_begun) &&
        e.argument[0] == static_cast<double>(kind))
      return true;
  }
  return false;
}
std::uint16_t isolated(const World& w) { return w.supervisor_.controller().isolated; }

// Standing, then a leg trips and everything stops.
void trip(World& w, std::size_t leg, std::uint16_t flag) {
  ASSERT_TRUE(w.stand());
  w.modules[leg].flags |= flag;
  w.run(0.2);
  ASSERT_EQ(w.state(), State::fatal_error);
}
// To its end; `each` follows every frame.
template <class Each>
void solve_with(World& w, Each each) {
  w.send(lss::CommandKind::solve);
  w.step();
  while (w.state() == State::solve_errors) {
    w.step();
    each();
  }
}

TEST(Solver, ALegThatStaysSilentIsIsolatedAndTheOthersStandAndWalk) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].alive = false;
  w.run(1);
  ASSERT_EQ(w.state(), State::fatal_error);
  ASSERT_TRUE(w.solve(40));
  EXPECT_TRUE(tried(w, StrategyKind::reconnect));
  EXPECT_TRUE(tried(w, StrategyKind::reset_module));
  EXPECT_EQ(isolated(w), 1u << 2);
  ASSERT_TRUE(w.stand());
  const auto serial = w.out_.command.module[2].serial;
  EXPECT_EQ(w.out_.command.module[2].kind, ModuleOrder::Kind::motion_off);
  w.send(CommandKind::walk, {1, 0, 2});
  ASSERT_TRUE(w.run_until(Mode::walking, 5));
  w.run(40);
  EXPECT_EQ(w.mode(), Mode::walking);
  EXPECT_EQ(w.out_.command.module[2].serial, serial) << "nothing is asked of a leg out of service";
  EXPECT_TRUE(w.out_.telemetry.modules[2].isolated);
  EXPECT_GT(w.out_.telemetry.distance_m, 0.02);
}

TEST(Solver, ARestoredLegIsInServiceWhenItAnswersAgain) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].alive = false;
  w.run(1);
  ASSERT_TRUE(w.solve(40));
  w.send(lss::CommandKind::restore);
  w.run(0.2);
  EXPECT_EQ(isolated(w), 0);
  w.send(lss::CommandKind::start, {0});
  w.step();
  EXPECT_EQ(w.acks.back().phase, Phase::rejected);
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::module_silent);
  w.modules[2].alive = true;
  w.run(0.2);
  EXPECT_TRUE(w.stand());
}

// Without both front legs nothing walks.
TEST(Solver, OfTwoLegsThatTrippedOnlyTheOneThatDoesNotMoveIsIsolated) {
  for (const std::size_t stuck : {0u, 1u}) {
    World w;
    ASSERT_TRUE(w.stand());
    for (const std::size_t leg : {0u, 1u}) w.modules[leg].flags |= kFlagOverCurrent;
    w.run(0.2);
    ASSERT_EQ(w.state(), State::fatal_error);
    w.modules[stuck].stuck = true;
    ASSERT_TRUE(w.solve(120));
    EXPECT_EQ(isolated(w), 1u << stuck);
  }
}

// Its reports come late, so that each new order seems to be obeyed at first.
TEST(Solver, ALegWhoseDisobedienceIsHiddenByEachNewOrderIsIsolated) {
  World w;
  ASSERT_TRUE(w.stand());
  std::uint32_t serial = 0;
  TimeNs ordered_ns = 0;
  w.alter = [&](World& world) {
    if (std::exchange(serial, world.out_.command.module[2].serial) != serial)
      ordered_ns = world.time_ns_;
    world.in_.bus.counters.module[2].disobeys = world.time_ns_ - ordered_ns >= 100 * kMillisecond;
  };
  w.run(1);
  ASSERT_EQ(w.state(), State::fatal_error);
  ASSERT_TRUE(w.solve(120));
  EXPECT_TRUE(tried(w, StrategyKind::isolate));
  EXPECT_EQ(isolated(w), 1u << 2);
}

void disobey(World& w, std::size_t leg) {
  w.in_.bus.counters.module[leg].disobeys = true;
  w.run(0.1);
  w.in_.bus.counters.module[leg].disobeys = false;
}

TEST(Solver, ALegThatRelapsesIsIsolatedAlsoWhenAnotherLegOnlyHasToBeMovedFree) {
  World w;
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(isolated(w), 0);
    ASSERT_TRUE(w.stand());
    w.modules[3].flags |= kFlagOverCurrent;
    disobey(w, 2);
    ASSERT_EQ(w.state(), State::fatal_error);
    ASSERT_TRUE(w.solve(120));
  }
  EXPECT_EQ(isolated(w), 1u << 2);
}

// Without both legs in front on one side nothing walks.
TEST(Solver, ALegThatRelapsesAndCannotBeIsolatedIsTreatedAsBefore) {
  World w;
  w.run(0.2);
  ASSERT_EQ(w.why(CommandKind::isolate, {1}), Reason::none);
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(w.stand());
    disobey(w, 2);
    ASSERT_EQ(w.state(), State::fatal_error);
    w.events.clear();
    ASSERT_TRUE(w.solve(120)) << round;
    EXPECT_TRUE(tried(w, StrategyKind::reset_module));
  }
  EXPECT_EQ(isolated(w), 1u << 0);
}

// It obeys again in the middle of a strategy, when its last order was void.
TEST(Solver, AModuleThatWasDeafIsStoppedByTheBusUntilItObeysAgain) {
  World w;
  ASSERT_TRUE(w.stand());
  bool deaf = true;
  w.alter = [&](World& world) {
    if (!deaf) return;
    world.modules[2].serial = world.out_.command.module[2].serial;
    world.modules[2].flags |= kFlagMotionControl;
    world.in_.bus.counters.module[2].disobeys = true;
  };
  w.run(0.5);
  ASSERT_EQ(w.state(), State::fatal_error);
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return tried(w, StrategyKind::reset_module); }, 60));
  w.run(0.2);
  ASSERT_EQ(w.state(), State::solve_errors);
  EXPECT_EQ(w.out_.command.module[2].kind, ModuleOrder::Kind::emergency_stop);
  const auto serial = w.out_.command.module[2].serial;
  w.run(0.2);
  EXPECT_EQ(w.out_.command.module[2].serial, serial) << "once: the bus repeats it";
  deaf = false;
  w.modules[2].serial = 0;  // repeated
  w.in_.bus.counters.module[2].disobeys = false;
  w.step();
  EXPECT_FALSE(w.modules[2].flags & kFlagMotionControl);
  EXPECT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 60));
}

TEST(Solver, LegsAreIsolatedTogetherOrNotAtAll) {
  World w;
  ASSERT_TRUE(w.stand());
  for (const std::size_t leg : {0u, 1u, 2u}) w.modules[leg].alive = false;
  w.run(1);
  EXPECT_FALSE(w.solve(60));
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(tried(w, StrategyKind::isolate));
  EXPECT_EQ(isolated(w), 0);
}

// [Func-2]
TEST(Solver, AStopEndsTheMovementOfALegInItsFrame) {
  for (const double lay_down : {0.0, 1.0}) {
    World w;
    ASSERT_NO_FATAL_FAILURE(trip(w, 3, kFlagOverCurrent));
    w.send(lss::CommandKind::solve);
    ASSERT_TRUE(w.run_until([&] { return (w.modules[3].flags & kFlagMoving) != 0; }, 60));
    ASSERT_EQ(w.state(), State::solve_errors);
    w.send(lss::CommandKind::stop, {lay_down}, "another");
    w.step();
    EXPECT_EQ(w.state(), State::fatal_error);
    EXPECT_TRUE(w.all_stopped());
    EXPECT_FALSE(w.modules[3].flags & kFlagMoving);
    EXPECT_NE(w.answer(lss::CommandKind::stop, Phase::completed), nullptr);
    EXPECT_NE(w.answer(lss::CommandKind::solve, Phase::superseded), nullptr);
    EXPECT_TRUE(w.has(FaultId::module_over_current, 4)) << "it is not solved";
    EXPECT_TRUE(w.solve(90)) << "from the beginning";
  }
}

TEST(Solver, ABlockedLegIsMovedFreeAndNoOtherMoves) {
  World w;
  ASSERT_NO_FATAL_FAILURE(trip(w, 3, kFlagOverCurrent));
  std::array<double, kModules> before{};
  for (std::size_t i = 0; i < kModules; ++i) before[i] = w.modules[i].position_deg;
  double furthest_deg = 0;
  w.send(lss::CommandKind::solve);
  w.step();
  while (w.state() == State::solve_errors) {
    w.step();
    furthest_deg = std::max(furthest_deg,
                            std::abs(std::remainder(w.modules[3].position_deg - before[3], 360)));
    for (std::size_t i = 0; i < kModules; ++i) {
      if (i == 3) continue;
      ASSERT_EQ(w.modules[i].position_deg, before[i]);
      ASSERT_FALSE(w.modules[i].flags & kFlagMotionControl);
    }
  }
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_TRUE(tried(w, StrategyKind::move_free));
  EXPECT_FALSE(tried(w, StrategyKind::cool_down));
  EXPECT_NEAR(furthest_deg, 20, 0.5);
  EXPECT_NEAR(std::remainder(w.modules[3].position_deg - before[3], 360), 0, 0.1);
  EXPECT_FALSE(w.modules[3].flags & kFlagMotionControl);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
}

TEST(Solver, ALegThatDoesNotComeFreeIsIsolated) {
  World w;
  ASSERT_NO_FATAL_FAILURE(trip(w, 3, kFlagOverCurrent));
  w.modules[3].stuck = true;
  ASSERT_TRUE(w.solve(60));
  EXPECT_TRUE(tried(w, StrategyKind::cool_down));
  EXPECT_EQ(isolated(w), 1u << 3) << "its flags are well without power, but it does not move";
}

TEST(Solver, ADriverThatFailsUnderPowerOnlyIsIsolated) {
  World w;
  ASSERT_NO_FATAL_FAILURE(trip(w, 1, kFlagDriverFault));
  solve_with(w, [&] {
    if (!(w.modules[1].flags & kFlagMotionControl)) return;
    w.modules[1].flags |= kFlagDriverFault;
    w.modules[1].stuck = true;
  });
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_TRUE(tried(w, StrategyKind::reset_module));
  EXPECT_EQ(isolated(w), 1u << 1);
  EXPECT_TRUE(w.stand());
}

TEST(Solver, ALegThatIsDeadAtBootIsIsolatedAfterAnEmergencyStop) {
  World w;
  w.modules[5].alive = false;
  w.run(1);
  w.send(lss::CommandKind::emergency_stop);
  w.step();
  ASSERT_TRUE(w.solve(60));
  EXPECT_EQ(isolated(w), 1u << 5);
  EXPECT_TRUE(w.stand());
}

TEST(Solver, TwoLegsWithDifferentFaultsAreBothLookedAt) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].alive = false;
  w.modules[3].current_mA = 1500;
  w.run(1);
  ASSERT_EQ(w.state(), State::fatal_error);
  w.modules[3].current_mA = 100;
  ASSERT_TRUE(w.solve(120));
  EXPECT_EQ(isolated(w), 1u << 2);
  EXPECT_TRUE(tried(w, StrategyKind::move_free)) << "for the one that drew too much";
}

TEST(Solver, ARestoredLegThatIsStillStoppedIsNoticed) {
  World w;
  ASSERT_NO_FATAL_FAILURE(trip(w, 1, kFlagDriverFault));
  solve_with(w, [&] { w.modules[1].flags |= kFlagDriverFault; });
  ASSERT_EQ(w.state(), State::idle);
  ASSERT_EQ(isolated(w), 1u << 1);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u) << "what it has is nobody's concern";
  w.send(lss::CommandKind::restore);
  w.run(0.1);
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.has(faults::module_driver_fault, 2));
}

TEST(Solver, AMotorThatCannotBeSwitchedOffIsNotIsolated) {
  Parameters p;
  p.solver.order[static_cast<std::size_t>(FaultClass::obedience)] = {StrategyKind::isolate};
  World w(p);
  ASSERT_TRUE(w.stand());
  w.in_.bus.counters.module[1].disobeys = true;
  w.run(0.1);
  ASSERT_EQ(w.state(), State::fatal_error);
  w.modules[1].flags |= kFlagMotionControl;
  w.send(lss::CommandKind::solve);
  w.step();
  while (w.state() == State::solve_errors) {
    w.modules[1].flags |= kFlagMotionControl;
    w.step();
  }
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_EQ(isolated(w), 0);
}

TEST(Solver, AHotLegIsLeftToCoolDown) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[3].temperature_cdegC = 9000;
  w.run(1);
  w.modules[3].flags |= kFlagOverCurrent;
  w.modules[3].stuck = true;
  w.run(0.2);
  ASSERT_EQ(w.state(), State::fatal_error);
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return tried(w, StrategyKind::cool_down); }, 30));
  w.run(20);
  EXPECT_EQ(w.state(), State::solve_errors) << "it waits";
  w.modules[3].temperature_cdegC = 4000;
  EXPECT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 5));
}

TEST(Solver, TooMuchCurrentEndsMovingFree) {
  World w;
  ASSERT_NO_FATAL_FAILURE(trip(w, 3, kFlagOverCurrent));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return (w.modules[3].flags & kFlagMoving) != 0; }, 5));
  w.modules[3].current_mA = 1500;
  ASSERT_TRUE(w.run_until([&] { return (w.modules[3].flags & kFlagMotionControl) == 0; }, 0.2));
  EXPECT_EQ(w.state(), State::solve_errors);
}

TEST(Solver, AnEmergencyStopEndsItAtOnce) {
  World w;
  ASSERT_NO_FATAL_FAILURE(trip(w, 3, kFlagOverCurrent));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return (w.modules[3].flags & kFlagMoving) != 0; }, 5));
  w.send(lss::CommandKind::emergency_stop);
  w.step();
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.all_stopped());
}

TEST(Solver, AModuleWithADriverFaultIsResetAndTheOthersAreNot) {
  World w;
  ASSERT_NO_FATAL_FAILURE(trip(w, 1, kFlagDriverFault));
  std::array<bool, kModules> was_reset{};
  solve_with(w, [&] {
    for (std::size_t i = 0; i < kModules; ++i)
      was_reset[i] |= w.out_.command.module[i].kind == ModuleOrder::Kind::reset;
  });
  EXPECT_EQ(w.state(), State::idle);
  for (std::size_t i = 0; i < kModules; ++i) EXPECT_EQ(was_reset[i], i == 1) << kModuleNames[i];
}

// [Conf-3]
TEST(Solver, TheConfigurationSaysWhatIsTriedInWhichOrder) {
  Parameters p;
  p.solver.order[static_cast<std::size_t>(FaultClass::current)] = {StrategyKind::reset_module};
  World w(p);
  ASSERT_NO_FATAL_FAILURE(trip(w, 3, kFlagOverCurrent));
  ASSERT_TRUE(w.solve(15));
  EXPECT_TRUE(tried(w, StrategyKind::reset_module));
  EXPECT_FALSE(tried(w, StrategyKind::move_free));
}

TEST(Solver, EachStrategyHasItsBudget) {
  Parameters p;
  p.solver.budget_ns = 3 * kSecond;
  p.solver.order[static_cast<std::size_t>(FaultClass::contact)] = {StrategyKind::reconnect,
                                                                   StrategyKind::reset_module};
  World w(p);
  ASSERT_TRUE(w.stand());
  w.modules[2].alive = false;
  w.run(1);
  const TimeNs begin = w.time_ns_;
  EXPECT_FALSE(w.solve(60));
  EXPECT_NEAR(static_cast<double>(w.time_ns_ - begin) * 1e-9, 6, 0.2);
}

}  // namespace
}  // namespace lss::zebro
