// Scripts (TALARIS thesis 4.5.1, A.3.2): rejections, and the actions of accepted ones.

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

Request step_of(double id, double index, double at, StepKind kind, double which, double value) {
  Request r;
  r.parameter = {id, index, at, double(kind), which, value, 0, 0};
  return r;
}
Request begin_of(double id, double steps) {
  Request r;
  r.parameter = {id, steps, 0, 0, 0, 0, 0, 0};
  return r;
}

class TalarisScript : public testing::Test {
 protected:
  void begin(int steps) { script_.begin(begin_of(7, steps)); }
  Verdict add(double at, StepKind kind, double which, double value) {
    const Request r = step_of(7, script_.loaded(), at, kind, which, value);
    const Verdict v = script_.consider_step(r);
    if (v.reason == Reason::none) script_.add(r);
    return v;
  }
  Script script_;
};

TEST_F(TalarisScript, OverlappingPulsesOfOneValveAreRefusedWithTheStep) {
  begin(3);
  ASSERT_EQ(add(0, StepKind::pulse, 0b11, 0.5).reason, Reason::none);
  ASSERT_EQ(add(0.2, StepKind::pulse, 0b100, 0.5).reason, Reason::none) << "another valve";
  const Verdict v = add(0.4, StepKind::pulse, 0b10, 0.1);
  EXPECT_EQ(v.reason, Reason::script_overlap);
  EXPECT_EQ(v.subject, 3);
  EXPECT_DOUBLE_EQ(v.measured, 0.4);
  EXPECT_DOUBLE_EQ(v.limit, 0.6) << "the first release after 0.5 s";
  EXPECT_EQ(add(0.6, StepKind::pulse, 0b10, 0.1).reason, Reason::none);
}

TEST_F(TalarisScript, StepsMustNotGoBackwards) {
  begin(2);
  ASSERT_EQ(add(2, StepKind::pulse, 1, 0.1).reason, Reason::none);
  const Verdict v = add(1.9, StepKind::pulse, 2, 0.1);
  EXPECT_EQ(v.reason, Reason::script_backwards);
  EXPECT_EQ(v.subject, 2);
  EXPECT_DOUBLE_EQ(v.limit, 2);
}

TEST_F(TalarisScript, ValuesHaveTheirRanges) {
  begin(1);
  EXPECT_EQ(add(0, StepKind::pulse, 1, 0.039).reason, Reason::script_value);
  EXPECT_EQ(add(0, StepKind::pulse, 1, 30.1).reason, Reason::script_value);
  EXPECT_EQ(add(0, StepKind::throttle, 1, 1.01).reason, Reason::script_value);
  EXPECT_EQ(add(0, StepKind::rpm, 1, 40001).reason, Reason::script_value);
  EXPECT_EQ(add(0, StepKind::rpm, 16, 1000).reason, Reason::script_actuator);
  EXPECT_EQ(add(599.9, StepKind::pulse, 1, 0.2).reason, Reason::script_too_long);
  EXPECT_EQ(add(599.8, StepKind::pulse, 1, 0.2).reason, Reason::none);
}

TEST_F(TalarisScript, StepsComeInTheirOrderAndOfOneScript) {
  begin(2);
  EXPECT_EQ(script_.consider_step(step_of(7, 1, 0, StepKind::pulse, 1, 0.1)).reason,
            Reason::script_order);
  EXPECT_EQ(script_.consider_step(step_of(8, 0, 0, StepKind::pulse, 1, 0.1)).reason,
            Reason::script_other);
  ASSERT_EQ(add(0, StepKind::pulse, 1, 0.1).reason, Reason::none);
  const Verdict v = script_.consider_run(7);
  EXPECT_EQ(v.reason, reasons::script_incomplete);
  EXPECT_EQ(v.measured, 1);
  EXPECT_EQ(v.limit, 2);
  EXPECT_EQ(script_.consider_run(9).reason, Reason::script_other);
  ASSERT_EQ(add(1, StepKind::pulse, 1, 0.1).reason, Reason::none);
  EXPECT_EQ(add(2, StepKind::pulse, 1, 0.1).reason, Reason::script_order) << "one too many";
  EXPECT_EQ(script_.consider_run(7).reason, Reason::none);
}

// Windows in which a valve is open, from the orders of all frames; ns after the first release.
struct Window {
  TimeNs from_ns, to_ns;
};
std::array<std::vector<Window>, kHopperValves> played(Script& script) {
  std::array<std::vector<Window>, kHopperValves> windows;
  script.run();
  TimeNs release_ns = -5 * kSecond;
  while (!script.over()) {
    TalarisOrders o;
    o.release_ns = release_ns;
    script.advance(o, [](const FanChange&) {});
    for (std::size_t i = 0; i < kHopperValves; ++i) {
      const bool both = o.hold[i].open && o.pulse[i].on_ns != 0;
      RC_ASSERT(!both);
      TimeNs from_ns = release_ns, to_ns = release_ns;
      if (o.hold[i].open) {
        RC_ASSERT(o.hold[i].until_ns > release_ns);
        to_ns = std::min(o.hold[i].until_ns, release_ns + kFrame);
      }
      if (o.pulse[i].on_ns != 0) {
        const ValvePulse& p = o.pulse[i];
        const TimeNs end_ns = p.delay_ns + p.on_ns;
        RC_ASSERT(p.delay_ns >= 0 && end_ns <= kFrame);
        RC_ASSERT(p.on_ns >= 40 * kMillisecond || end_ns == kFrame);
        from_ns = release_ns + p.delay_ns;
        to_ns = release_ns + end_ns;
      }
      if (from_ns == to_ns) continue;
      if (!windows[i].empty() && windows[i].back().to_ns == from_ns && from_ns == release_ns &&
          o.hold[i].open) {
        windows[i].back().to_ns = to_ns;
      } else {
        windows[i].push_back({from_ns, to_ns});
      }
    }
    release_ns += kFrame;
  }
  return windows;
}

// For any input: an accepted script is played exactly, within all limits, one pulse after another.
TEST(TalarisScriptProperty, WhatIsTakenIsPlayedExactly) {
  EXPECT_TRUE(rc::check([] {
    Script script;
    const int count = *rc::gen::inRange(1, 40);
    script.begin(begin_of(3, count));
    std::array<std::vector<Window>, kHopperValves> wanted;
    double at_s = 0;
    for (int tries = 0; script.loaded() < count; ++tries) {
      if (tries > 10 * count) RC_DISCARD("too many refused");
      const double next_s = at_s + *rc::gen::inRange(-100, 900) * 1e-3;
      const double which = *rc::gen::inRange(1, 256);
      const double on_s = *rc::gen::inRange(20, 900) * 1e-3;
      if (next_s < 0) continue;
      const Request r = step_of(3, script.loaded(), next_s, StepKind::pulse, which, on_s);
      if (script.consider_step(r).reason != Reason::none) continue;
      script.add(r);
      at_s = next_s;
      const TimeNs from_ns = std::llround(next_s * 1e3) * kMillisecond;
      for (std::size_t i = 0; i < kHopperValves; ++i) {
        if (static_cast<unsigned>(which) >> i & 1u)
          wanted[i].push_back({from_ns, from_ns + std::llround(on_s * 1e3) * kMillisecond});
      }
    }
    RC_ASSERT(script.consider_run(3).reason == Reason::none);
    const auto got = played(script);
    for (std::size_t i = 0; i < kHopperValves; ++i) {
      RC_ASSERT(got[i].size() == wanted[i].size());
      for (std::size_t k = 0; k < got[i].size(); ++k) {
        RC_ASSERT(got[i][k].from_ns == wanted[i][k].from_ns);
        RC_ASSERT(got[i][k].to_ns == wanted[i][k].to_ns);
        if (k > 0) RC_ASSERT(got[i][k].from_ns >= got[i][k - 1].to_ns);
      }
    }
  }));
}

// ---- in the cycle

void upload(World& w) {
  w.send(Kind::script_begin, {5, 3});
  w.send(Kind::script_step, {5, 0, 0, 0, 0b1, 0.5});
  w.send(Kind::script_step, {5, 1, 0.29, 0, 0b10, 0.1});
  w.send(Kind::script_step, {5, 2, 1, 0, 0b1, 0.04});
  w.step();
}

// Started, with the script uploaded.
struct WithScript : World {
  WithScript() {
    EXPECT_TRUE(start());
    upload(*this);
  }
};

TEST(TalarisScripts, TheFirstActuationIsFiveSecondsAfterRun) {
  WithScript w;
  ASSERT_EQ(w.why(Kind::script_run, {5}), Reason::none);
  EXPECT_EQ(w.mode(), Mode::script);
  const TimeNs run_ns = w.orders().release_ns;
  ASSERT_TRUE(w.run_until([&] { return !w.shut(); }, 6));
  EXPECT_EQ(w.orders().release_ns - run_ns, 5 * kSecond);
  EXPECT_EQ(w.orders().pulse[0].on_ns, 200 * kMillisecond);
  w.step();
  EXPECT_EQ(w.orders().hold[0].until_ns - run_ns, 5500 * kMillisecond);
  EXPECT_EQ(w.orders().pulse[1].delay_ns, 90 * kMillisecond);
  EXPECT_EQ(w.orders().pulse[1].on_ns, 100 * kMillisecond);
  EXPECT_EQ(w.out_.telemetry.script_done, 2);
  EXPECT_NEAR(w.out_.telemetry.script_s, 5.4, 1e-9);
  ASSERT_TRUE(w.run_until(Mode::manual, 2));
  EXPECT_TRUE(w.shut());
  EXPECT_NE(w.heard(events::script_begun), nullptr);
  EXPECT_NE(w.heard(events::script_ended), nullptr);
  EXPECT_EQ(w.heard(events::script_step_done)->argument[1], 3);
  EXPECT_EQ(w.last(lss::Phase::completed)->kind, 322);
  EXPECT_NEAR(w.gas_s, 0.64, 0.011);
  EXPECT_EQ(w.supervisor_.state().safe_commands, 0u);
}

TEST(TalarisScripts, AreUploadedInIdleAndRunInOperationalOnly) {
  World w;
  w.run(1);
  upload(w);
  EXPECT_EQ(w.out_.telemetry.script_steps, 3);
  EXPECT_EQ(w.last(lss::Phase::rejected), nullptr);
  EXPECT_EQ(w.why(Kind::script_run, {5}), Reason::not_in_state);
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.why(Kind::script_run, {5}), Reason::none);
}

TEST(TalarisScripts, ABadStepIsRefusedByTheDaemonWithItsNumber) {
  World w;
  w.run(1);
  upload(w);
  w.send(Kind::script_begin, {6, 2});
  w.send(Kind::script_step, {6, 0, 0, 0, 1, 0.5});
  w.step();
  const Verdict v = w.ask(Kind::script_step, {6, 1, 0.3, 0, 1, 0.1});
  EXPECT_EQ(v.reason, Reason::script_overlap);
  EXPECT_EQ(v.subject, 2);
  w.send(Kind::script_step, {6, 1, 0.3, 0, 1, 0.1});
  w.step();
  const EventRecord* rejected = w.heard(EventId::command_rejected);
  ASSERT_NE(rejected, nullptr);
  EXPECT_EQ(rejected->subject, 0) << "a step is no module";
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.why(Kind::script_run, {6}), reasons::script_incomplete);
  EXPECT_EQ(w.why(Kind::script_run, {5}), Reason::script_other);
  EXPECT_EQ(w.mode(), Mode::manual);
}

TEST(TalarisScripts, NothingIsTakenWhileOneRuns) {
  WithScript w;
  ASSERT_EQ(w.why(Kind::script_run, {5}), Reason::none);
  for (const auto kind :
       {Kind::manual, Kind::duty_cycle, Kind::valve, Kind::pulse, Kind::gnc, Kind::plan,
        Kind::enable, Kind::script_begin, Kind::script_step, Kind::script_run})
    EXPECT_EQ(w.why(kind, {1, 1, 1}), Reason::not_in_mode) << static_cast<int>(kind);
  EXPECT_EQ(w.mode(), Mode::script);
}

TEST(TalarisScripts, DisabledValvesAndFansNotStartedAreFoundBeforeItRuns) {
  WithScript w;
  ASSERT_EQ(w.why(Kind::enable, {0b1}), Reason::none);
  EXPECT_EQ(w.why(Kind::script_run, {5}), reasons::valve_disabled);
  w.send(Kind::script_begin, {8, 1});
  w.send(Kind::script_step, {8, 0, 0, 1, 15, 0.2});
  w.step();
  EXPECT_EQ(w.why(Kind::script_run, {8}), reasons::fans_not_armed);
  ASSERT_TRUE(w.arm());
  ASSERT_EQ(w.why(Kind::script_run, {8}), Reason::none);
  ASSERT_TRUE(w.run_until([&] { return w.orders().fan_us[0] == 1200; }, 6));
  ASSERT_TRUE(w.run_until(Mode::manual, 1));
  EXPECT_TRUE(w.shut()) << "also the fans";
}

class ScriptStops : public testing::TestWithParam<bool> {};

// In the lead and with valves open, by abort and by emergency stop.
TEST_P(ScriptStops, ShutEverythingAtOnceUntilSolve) {
  for (const double into_s : {1.0, 5.2}) {
    WithScript w;
    ASSERT_EQ(w.why(Kind::script_run, {5}), Reason::none);
    w.run(into_s);
    if (GetParam()) {
      w.send(Kind::script_abort);
    } else {
      w.send(lss::CommandKind::emergency_stop, {}, "anyone");
    }
    w.step();
    EXPECT_EQ(w.state(), State::fatal_error);
    EXPECT_TRUE(w.shut());
    EXPECT_TRUE(w.orders().all_stop);
    EXPECT_NE(w.heard(events::script_aborted), nullptr);
    for (int i = 0; i < 50; ++i) {
      w.step();
      ASSERT_TRUE(w.shut());
    }
    EXPECT_EQ(w.why(lss::CommandKind::start), Reason::not_in_state);
    w.send(lss::CommandKind::solve);
    ASSERT_TRUE(w.run_until(State::idle, 20));
    w.acks.clear();
    ASSERT_TRUE(w.start());
    w.run(8);
    EXPECT_TRUE(w.shut()) << "it does not go on";
  }
}
INSTANTIATE_TEST_SUITE_P(Talaris, ScriptStops, testing::Bool(), [](const auto& test) {
  return test.param ? std::string("abort") : std::string("estop");
});

}  // namespace
}  // namespace lss::talaris
