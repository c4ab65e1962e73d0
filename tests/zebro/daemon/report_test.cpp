// The armour for what modules report, through the cycle. [Env-2]

#include <gtest/gtest.h>

#include "idl/zebro/codes.h"
#include "world.h"

namespace lss::zebro {
namespace {

constexpr std::uint16_t kLM = 3;

// Of every status of module LM, before the cycle.
void alter_status(World& w, std::function<void(ModuleReply&)> change) {
  w.alter = [change](World& world) {
    for (std::uint32_t i = 0; i < world.in_.sample_count; ++i) {
      ModuleReply& reply = world.in_.samples[i];
      if (reply.module + 1 == kLM && reply.code == static_cast<std::uint8_t>(Code::status))
        change(reply);
    }
  };
}

void put(ModuleReply& reply, std::size_t at, std::uint16_t value) {
  reply.data[at] = static_cast<std::uint8_t>(value >> 8);
  reply.data[at + 1] = static_cast<std::uint8_t>(value & 0xFF);
}

bool walks(World& w) {
  if (!w.stand()) return false;
  w.send(CommandKind::walk, {1, 0, 3});
  if (!w.run_until(Mode::walking, 5)) return false;
  w.run(5);
  return w.mode() == Mode::walking;
}

TEST(Reports, ThatCannotBeStopEverythingAndNameTheModule_Env_2) {
  struct Case {
    std::size_t at;
    std::uint16_t value;
  };
  for (const Case c : {Case{2, 0xFFFF}, Case{2, 36'000}, Case{0, 0x8003}, Case{0, 0x0203},
                       Case{4, 0x7FFF}, Case{6, 0xFFFF}}) {
    World w;
    ASSERT_TRUE(walks(w));
    alter_status(w, [&](ModuleReply& r) { put(r, c.at, c.value); });
    ASSERT_TRUE(w.run_until(State::fatal_error, 0.1)) << c.at << " " << c.value;
    EXPECT_TRUE(w.has(faults::report_impossible, kLM));
    EXPECT_TRUE(w.all_stopped());
    EXPECT_LT(w.out_.telemetry.modules[kLM - 1].position_rad, 6.2832);
  }
}

TEST(Reports, ThatCannotBeAreNoContactInIdle_Env_2) {
  World w;
  alter_status(w, [](ModuleReply& r) { put(r, 2, 0xFFFF); });
  w.run(0.3);
  EXPECT_TRUE(w.has(faults::report_impossible, kLM));
  EXPECT_NE(w.why(lss::CommandKind::start, {0, 1, 0, 0}), Reason::none);
}

TEST(Reports, OfHealthWithoutSupplyAreRefused_Env_2) {
  World w;
  ASSERT_TRUE(walks(w));
  w.modules[kLM - 1].supply_mV = 0;
  ASSERT_TRUE(w.run_until(State::fatal_error, 0.1));
  EXPECT_TRUE(w.has(faults::report_impossible, kLM));
}

TEST(Reports, OfRandomAnglesAreNamedWithinFiveFrames_Env_2) {
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    World w;
    ASSERT_TRUE(walks(w));
    std::uint32_t x = seed;
    alter_status(w, [&x](ModuleReply& r) {
      x = x * 1664525u + 1013904223u;
      put(r, 2, static_cast<std::uint16_t>((x >> 8) % 36'000));
    });
    ASSERT_TRUE(w.run_until(State::fatal_error, 0.2)) << seed;
    EXPECT_TRUE(w.has(faults::position_jumps, kLM) || w.has(faults::gear_slips, kLM)) << seed;
  }
}

TEST(Reports, OneThatIsWrongAloneIsNotBelievedAndNothingStops_Env_2) {
  World w;
  ASSERT_TRUE(walks(w));
  const double before_rad = w.out_.telemetry.modules[kLM - 1].position_rad;
  alter_status(w, [](ModuleReply& r) {
    put(r, 2, static_cast<std::uint16_t>(((r.data[2] << 8 | r.data[3]) + 9'000) % 36'000));
  });
  w.step();
  EXPECT_NEAR(w.out_.telemetry.modules[kLM - 1].position_rad, before_rad, 0.2);
  w.alter = {};
  w.run(10);
  EXPECT_EQ(w.mode(), Mode::walking);
}

TEST(Reports, OfASensorThatStandsStillNameTheLeg_Env_2) {
  for (const double after_s : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
    World w;
    ASSERT_TRUE(walks(w));
    w.run(after_s);
    std::uint16_t frozen = 0;
    bool seen = false;
    alter_status(w, [&](ModuleReply& r) {
      if (!seen) frozen = static_cast<std::uint16_t>(r.data[2] << 8 | r.data[3]);
      seen = true;
      put(r, 2, frozen);
      put(r, 0, static_cast<std::uint16_t>((r.data[0] << 8 | r.data[1]) & ~kFlagHallSensor));
    });
    ASSERT_TRUE(w.run_until(State::fatal_error, 5)) << after_s;
    EXPECT_TRUE(w.has(faults::leg_still, kLM)) << after_s;
    EXPECT_EQ(w.supervisor_.state().fault_count, 1u) << after_s;
  }
}

// A motor without strength: its leg stays where it is and is named, the others are not.
TEST(Reports, AMotionThatDoesNotEndNamesItsLateLegs_Conf_3) {
  World w;
  w.run(0.2);
  w.modules[kLM - 1].stuck = true;
  w.send(lss::CommandKind::start, {1});
  ASSERT_TRUE(w.run_until(State::fatal_error, 40));
  EXPECT_TRUE(w.has(faults::leg_still, kLM) || w.has(faults::motion_timeout, kLM));
  EXPECT_FALSE(w.has(faults::motion_timeout, 0));
}

TEST(Reports, OfALegThatPassesItsSensorElsewhereThanItCountsAreASlippedGear_Env_2) {
  World w;
  ASSERT_TRUE(walks(w));
  IdealModule& leg = w.modules[kLM - 1];
  leg.sensor_deg = 140;  // where it passes the sensor now, as it counts
  ASSERT_TRUE(w.run_until(State::fatal_error, 10));
  EXPECT_TRUE(w.has(faults::gear_slips, kLM));
}

TEST(Reports, AHotModuleSaysSoItself_Prod_5) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[kLM - 1].flags |= kFlagHot;
  w.run(0.1);
  EXPECT_TRUE(w.has(FaultId::temperature_warning, kLM));
  EXPECT_EQ(w.state(), State::operational);
  w.modules[kLM - 1].flags = static_cast<std::uint16_t>(w.modules[kLM - 1].flags & ~kFlagHot);
  w.run(0.1);
  EXPECT_FALSE(w.has(FaultId::temperature_warning, kLM));
}

TEST(Reports, AllMotorsTogetherHaveALimit_P_Int_1) {
  World w;
  ASSERT_TRUE(walks(w));
  for (std::size_t i = 0; i < kLegs; ++i) w.modules[i].current_mA = 980;  // 5.9 A with the panel's
  w.run(1);
  EXPECT_EQ(w.mode(), Mode::walking);
  for (std::size_t i = 0; i < kLegs; ++i) w.modules[i].current_mA = 1000;
  ASSERT_TRUE(w.run_until(State::fatal_error, 0.2));
  EXPECT_TRUE(w.has(faults::current_sum));
}

TEST(Reports, ResentCommandsDoNotFillTheEvents) {
  World w;
  ASSERT_TRUE(walks(w));
  w.events.clear();
  for (int i = 0; i < 2000; ++i) {
    ++w.in_.bus.counters.module[1].resends;
    w.step();
  }
  EXPECT_LE(w.events.size(), 12u) << "1, 2, 4, ... 1024";
  ASSERT_NE(w.heard(events::module_resent), nullptr);
  EXPECT_GE(w.heard(events::module_resent)->argument[0], 1024);
}

}  // namespace
}  // namespace lss::zebro
