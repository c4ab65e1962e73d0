// Conditions in every situation of the locomotion controller: in every state, and in every mode of
// Operational.

#include <gtest/gtest.h>

#include <cmath>

#include "world.h"

namespace lss::zebro {
namespace {

struct Place {
  const char* name;
  State state;
  Mode mode;
  void (*go)(World& w);
};

void stand_and_send(World& w, CommandKind kind) {
  ASSERT_TRUE(w.stand());
  w.send(kind);
}

void lose_module(World& w) {
  ASSERT_TRUE(w.stand());
  w.modules[1].alive = false;
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 2));
}

constexpr Place kPlaces[] = {
    {"Idle", State::idle, Mode::none, [](World&) {}},
    {"Holding", State::operational, Mode::holding,
     [](World& w) { w.send(lss::CommandKind::start, {0}); }},
    {"StandingUp", State::operational, Mode::standing_up,
     [](World& w) { w.send(lss::CommandKind::start, {1}); }},
    {"Standing", State::operational, Mode::standing, [](World& w) { w.stand(); }},
    {"Walking", State::operational, Mode::walking,
     [](World& w) {
       w.send(lss::CommandKind::start, {2, 1, 0, 3});
     }},
    {"FinishingStep", State::operational, Mode::finishing_step,
     [](World& w) {
       ASSERT_TRUE(w.stand());
       w.send(CommandKind::walk, {1, 0, 3});
       w.run(8);
       w.send(CommandKind::stand);
     }},
    {"LyingDown", State::operational, Mode::lying_down,
     [](World& w) { stand_and_send(w, CommandKind::lay_down); }},
    {"Lying", State::operational, Mode::lying,
     [](World& w) { stand_and_send(w, CommandKind::lay_down); }},
    {"Stowing", State::operational, Mode::stowing,
     [](World& w) { stand_and_send(w, CommandKind::stow); }},
    {"Stowed", State::operational, Mode::stowed,
     [](World& w) { stand_and_send(w, CommandKind::stow); }},
    {"Bridge", State::operational, Mode::bridge,
     [](World& w) {
       ASSERT_TRUE(w.stand());
       w.send(CommandKind::leg, {4, 0.5, 4, 1});
     }},
    {"FatalError", State::fatal_error, Mode::none, lose_module},
    {"SolveErrors", State::solve_errors, Mode::none,
     [](World& w) {
       lose_module(w);
       w.send(lss::CommandKind::solve);
     }},
};

class Everywhere : public testing::TestWithParam<Place> {
 protected:
  void go(World& w) const {
    w.run(0.2);
    ASSERT_NO_FATAL_FAILURE(GetParam().go(w));
    ASSERT_TRUE(w.run_until([&] { return there(w); }, 40));
  }
  bool there(const World& w) const {
    return w.state() == GetParam().state && w.mode() == GetParam().mode;
  }
  bool operational() const { return GetParam().state == State::operational; }
};

INSTANTIATE_TEST_SUITE_P(Zebro, Everywhere, testing::ValuesIn(kPlaces),
                         [](const auto& place) { return std::string(place.param.name); });

bool motors_off(const World& w) {
  for (const IdealModule& m : w.modules) {
    if (m.alive && (m.flags & kFlagMotionControl)) return false;
  }
  return true;
}

void expect_safe(World& w) {
  EXPECT_TRUE(w.state() == State::idle || w.state() == State::fatal_error);
  w.run(0.1);
  EXPECT_TRUE(motors_off(w));
}

// From any standstill: errors solved, and it stands.
void expect_usable(World& w) {
  w.run(0.5);
  if (w.state() == State::fatal_error) w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 15));
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
  EXPECT_TRUE(w.stand());
}

void reset_by_itself(IdealModule& m) {
  m.flags = kFlagReset;
  m.position_deg = m.rate_deg_s = 0;
}

const Ack* answer(const World& w, lss::CommandKind kind) {
  for (const Ack& ack : w.acks) {
    if (ack.kind == static_cast<std::uint16_t>(kind)) return &ack;
  }
  return nullptr;
}

// [Oper-1]
TEST_P(Everywhere, EveryCommandIsAnsweredAndNoneEndsTheListening) {
  const auto try_each = [&](std::span<const CommandInfo> commands) {
    for (const CommandInfo& command : commands) {
      World w;
      ASSERT_NO_FATAL_FAILURE(go(w));
      std::array<double, kMaxParameters> p{};
      for (std::size_t i = 0; i < command.parameters.size(); ++i) {
        const ParameterInfo& parameter = command.parameters[i];
        p[i] = std::isnan(parameter.fallback) ? parameter.max : parameter.fallback;
      }
      const auto answered = w.acks.size();
      w.send(command.kind, {p[0], p[1], p[2], p[3]});
      w.step();
      ASSERT_GT(w.acks.size(), answered) << command.name;
      EXPECT_EQ(w.acks[answered].kind, command.kind) << command.name;
      w.run(20);
      w.send(lss::CommandKind::request_data, {}, "anyone");
      w.step();
      EXPECT_EQ(w.last(Phase::completed)->source, source("anyone")) << "after " << command.name;
    }
  };
  try_each(kCommands);
  try_each(kCommonCommands);
}

// [Oper-2]
TEST_P(Everywhere, AResetOfTheControllerIsTakenAndEndsSafe) {
  World w;
  ASSERT_NO_FATAL_FAILURE(go(w));
  w.send(lss::CommandKind::reset, {-1});
  w.step();
  EXPECT_EQ(answer(w, lss::CommandKind::reset)->phase, Phase::accepted);
  EXPECT_EQ(w.state(),
            GetParam().state == State::idle || operational() ? State::idle : State::fatal_error);
  expect_safe(w);
  w.modules[1].alive = true;
  expect_usable(w);
}

// [Oper-3] [P-Int-2]
TEST_P(Everywhere, ARestartedDaemonSwitchesAllMotorsOffAndCanGoOn) {
  World before;
  ASSERT_NO_FATAL_FAILURE(go(before));
  World w;
  w.modules = before.modules;
  w.time_ns_ = before.time_ns_;
  for (IdealModule& m : w.modules) m.serial = ~0u;  // numbers of orders begin again
  w.step();
  EXPECT_EQ(w.state(), State::idle);
  w.run(0.1);
  EXPECT_TRUE(motors_off(w));
  w.modules[1].alive = true;
  expect_usable(w);
}

// [P-Int-2]
TEST_P(Everywhere, AModuleThatWasResetIsMadeSafeAndCanGoOn) {
  for (const std::size_t module : {0u, 3u, 6u}) {
    SCOPED_TRACE(kModuleNames[module]);
    World w;
    ASSERT_NO_FATAL_FAILURE(go(w));
    reset_by_itself(w.modules[module]);
    w.step();
    if (operational()) {
      EXPECT_EQ(w.state(), State::fatal_error);
      EXPECT_TRUE(w.all_stopped()) << "in the frame that saw it";
      EXPECT_TRUE(w.has(FaultId::module_reset, static_cast<std::uint16_t>(module + 1)));
    }
    w.modules[1].alive = true;
    ASSERT_TRUE(w.run_until([&] { return w.state() != State::solve_errors; }, 60));
    expect_safe(w);
    expect_usable(w);
  }
}

// [Env-3] [Oper-4]
TEST_P(Everywhere, AResetReachesOneModuleOrAllAndNoOther) {
  for (int wanted = 0; wanted <= kModules; ++wanted) {
    SCOPED_TRACE(wanted);
    World w;
    ASSERT_NO_FATAL_FAILURE(go(w));
    w.send(lss::CommandKind::reset, {static_cast<double>(wanted)});
    w.step();
    if (GetParam().state != State::idle && GetParam().state != State::fatal_error) {
      EXPECT_EQ(answer(w, lss::CommandKind::reset)->verdict.reason, Reason::not_in_state)
          << "it would pull a leg away: stop first";
      continue;
    }
    for (int i = 1; i <= kModules; ++i) {
      const bool reset =
          w.out_.command.module[static_cast<std::size_t>(i - 1)].kind == ModuleOrder::Kind::reset;
      EXPECT_EQ(reset, wanted == 0 || wanted == i) << "module " << i << ", wanted " << wanted;
    }
    w.modules[1].alive = true;
    w.run(0.5);
    expect_usable(w);
  }
}

// [Oper-5]
TEST_P(Everywhere, AnEmergencyStopEndsWhereErrorsAreSolved) {
  World w;
  ASSERT_NO_FATAL_FAILURE(go(w));
  w.send(lss::CommandKind::emergency_stop, {}, "anyone");
  w.step();
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.all_stopped()) << "in the frame that got it";
  w.send(lss::CommandKind::solve);
  w.step();
  EXPECT_EQ(w.state(), State::solve_errors);
}

// [Func-2] [Oper-7]
TEST_P(Everywhere, AStopEndsIdleWithMotorsOffLyingWhenAskedFor) {
  for (const double lay_down : {0.0, 1.0}) {
    World w;
    ASSERT_NO_FATAL_FAILURE(go(w));
    w.send(lss::CommandKind::stop, {lay_down});
    w.step();
    if (GetParam().state == State::fatal_error || GetParam().state == State::solve_errors) {
      EXPECT_EQ(answer(w, lss::CommandKind::stop)->phase, Phase::rejected) << "it is stopped";
      EXPECT_TRUE(motors_off(w));
      continue;
    }
    ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 60));
    w.run(0.1);
    EXPECT_TRUE(motors_off(w));
    EXPECT_EQ(w.last(Phase::completed)->kind, static_cast<std::uint16_t>(lss::CommandKind::stop));
    EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
    if (lay_down == 0 || GetParam().mode != Mode::walking) continue;
    for (std::size_t i = 0; i < kLegs; ++i) EXPECT_NEAR(w.modules[i].position_deg, 254.3, 3);
  }
}

}  // namespace
}  // namespace lss::zebro
