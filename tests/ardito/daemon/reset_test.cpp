// A commanded reset: nodes are away for a while, which is expected, and come back or do not.

#include <gtest/gtest.h>

#include "idl/ardito/codes.h"
#include "world.h"

namespace lss::ardito {
namespace {

constexpr std::uint16_t kReset = static_cast<std::uint16_t>(lss::CommandKind::reset);

// The answer to the last reset in this phase; nullptr: there is none.
const Ack* answer(const World& w, Phase phase) {
  for (auto ack = w.acks.rbegin(); ack != w.acks.rend(); ++ack) {
    if (ack->kind == kReset && ack->phase == phase) return &*ack;
  }
  return nullptr;
}

// In Idle, all nodes running; those that are reset boot for so long.
void idle(World& w, double boot_s) {
  w.boot_ns.fill(static_cast<TimeNs>(boot_s * 1e9));
  // Values come a little after the node.
  w.distort = [&w](std::vector<Reading>& readings) {
    const auto silent = [&](std::size_t node) {
      return w.node(node).state != canopen::NodeState::operational ||
             w.node(node).since_ns > w.time_ns_ - 300 * kMillisecond;
    };
    std::erase_if(readings, [&](const Reading& r) {
      return (std::holds_alternative<Imu>(r) && silent(kImu)) ||
             (std::holds_alternative<Rocker>(r) && silent(kIo));
    });
  };
  w.run(1);
  w.events.clear();
}

Verdict start(World& w) {
  w.acks.clear();
  w.send(lss::CommandKind::start, {0});
  w.step();
  const Ack* rejected = w.last(Phase::rejected);
  return rejected != nullptr ? rejected->verdict : Verdict{};
}

bool any_fault(const World& w) { return w.supervisor_.state().fault_count != 0; }

TEST(ArditoReset, WhatTheNodeSaysMeanwhileIsNoFault) {
  World w;
  idle(w, 3);
  w.send(lss::CommandKind::reset, {2});
  w.run(1);
  ++w.node(1).reboots;
  ++w.node(1).emcys;
  w.node(1).emcy_code = 0x8130;
  w.run(1);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_FALSE(any_fault(w));
}

TEST(ArditoReset, TheDeadlineIsAParameter) {
  Parameters p;
  p.reset_ns = 2 * kSecond;
  World w(p);
  w.boot_ns.fill(3 * kSecond);
  w.run(1);
  w.send(lss::CommandKind::reset, {7});
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 2.3));
  EXPECT_TRUE(w.has(FaultId::module_silent, 7));
}

// Driving by hand does not need it.
TEST(ArditoReset, AnImuThatStaysAwayIsAWarningAtItsDeadline) {
  World w;
  idle(w, 1000);
  w.send(lss::CommandKind::reset, {kImuNode});
  w.run(9.5);
  EXPECT_FALSE(any_fault(w));
  w.run(1);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_TRUE(w.has(faults::imu_lost, kImuNode));
  ASSERT_NE(answer(w, Phase::failed), nullptr);
  EXPECT_EQ(answer(w, Phase::failed)->verdict.reason, Reason::module_silent);
}

TEST(ArditoReset, TwoInOneFrameReachBothNodes) {
  World w;
  idle(w, 3);
  w.send(lss::CommandKind::reset, {2});
  w.send(lss::CommandKind::reset, {3});
  w.run(1);
  EXPECT_EQ(w.node(1).state, canopen::NodeState::booting);
  EXPECT_EQ(w.node(2).state, canopen::NodeState::booting);
  w.run(3);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_EQ(start(w).reason, Reason::none);
}

TEST(ArditoReset, WithoutAPortFailsForThat) {
  World w;
  idle(w, 0);
  w.in_.bus.open = false;
  w.step();
  ASSERT_EQ(w.state(), State::fatal_error);
  w.send(lss::CommandKind::reset, {0});
  w.run(11);
  ASSERT_NE(answer(w, Phase::failed), nullptr);
  EXPECT_EQ(answer(w, Phase::failed)->verdict.reason, Reason::port_closed);
  EXPECT_FALSE(w.has(FaultId::module_silent, 1));
}

}  // namespace
}  // namespace lss::ardito
