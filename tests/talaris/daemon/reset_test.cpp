// A commanded reset: nodes are away for a while, which is expected, and come back or do not. What
// a reset ends: values of a node whose sensors do not answer.

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

constexpr std::uint16_t kReset = static_cast<std::uint16_t>(lss::CommandKind::reset);

bool answered(const World& w, lss::Phase phase) {
  return std::ranges::any_of(
      w.acks, [&](const Ack& ack) { return ack.kind == kReset && ack.phase == phase; });
}

// With the load cell of the test stand.
Parameters on_the_stand() {
  Parameters p = quick();
  p.buses.can.load_cell = true;
  return p;
}

std::uint16_t module_of(std::size_t node) {
  return static_cast<std::uint16_t>(kValveModule + node);
}

void leave(World& w, std::size_t node) { w.node(node).state = canopen::NodeState::booting; }

void come_back(World& w, std::size_t node) {
  w.node(node).state = canopen::NodeState::operational;
  ++w.node(node).boots;
}

void expect_well(const World& w) {
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
}

TEST(TalarisReset, OfTheLoadCellIsNoEmergencyAndEndsWhenItIsBack) {
  const std::size_t node = kLoadCellNode;
  World w(on_the_stand());
  w.run(6);
  ASSERT_EQ(w.why(lss::CommandKind::reset, {double(module_of(node))}), Reason::none);
  EXPECT_TRUE(answered(w, lss::Phase::executing));
  EXPECT_NE(w.heard(EventId::reset_begun), nullptr);
  leave(w, node);
  w.run(6);
  ++w.node(node).emcys;
  w.run(1);
  expect_well(w);
  EXPECT_FALSE(answered(w, lss::Phase::completed));
  const Verdict refused = w.ask(lss::CommandKind::start);
  EXPECT_EQ(refused.reason, Reason::module_silent);
  EXPECT_EQ(refused.subject, module_of(node));
  come_back(w, node);
  w.step();
  EXPECT_TRUE(answered(w, lss::Phase::completed));
  EXPECT_NE(w.heard(EventId::reset_ended), nullptr);
  w.run(6);
  expect_well(w);
  EXPECT_EQ(w.why(lss::CommandKind::start), Reason::none);
}

// It is needed on the test stand only.
TEST(TalarisReset, ALoadCellThatStaysAwayIsAWarningAtItsDeadline) {
  World w(on_the_stand());
  w.run(6);
  ASSERT_EQ(w.why(lss::CommandKind::reset, {kLoadCellModule}), Reason::none);
  leave(w, kLoadCellNode);
  w.run(9.5);
  expect_well(w);
  w.run(1);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_TRUE(w.has(faults::load_cell_lost, kLoadCellModule));
  EXPECT_TRUE(answered(w, lss::Phase::failed));
}

// Only its known data is discarded.
TEST(TalarisReset, OfTheImuIsOverAtOnce) {
  World w;
  w.run(1);
  ASSERT_EQ(w.why(lss::CommandKind::reset, {kImuModule}), Reason::none);
  EXPECT_TRUE(answered(w, lss::Phase::completed));
}

TEST(TalarisReset, OfALoadCellThatIsNotThereIsOverAtOnce) {
  World w;
  w.run(1);
  ASSERT_EQ(w.why(lss::CommandKind::reset, {kLoadCellModule}), Reason::none);
  EXPECT_TRUE(answered(w, lss::Phase::completed));
}

// EMCY 0x5000: a sensor of the node does not answer.
TEST(TalarisReset, EndsThatTheValuesOfANodeAreNotUsed) {
  for (const std::size_t node : {kValveNode, kFanNode}) {
    World w;
    ASSERT_TRUE(w.start() && w.arm() && w.calibrate());
    ASSERT_EQ(w.why(Kind::plan, {double(Program::hop), 2, 5, 0, 0}), Reason::none);
    w.node(node).emcy_register = 0x81;
    w.step();
    EXPECT_TRUE(w.has(faults::values_stuck, module_of(node)));
    EXPECT_EQ(w.state(), State::operational) << "a warning on the ground";
    const Verdict v = w.ask(Kind::gnc, {2});
    EXPECT_EQ(v.reason, reasons::values_stuck);
    EXPECT_EQ(v.subject, module_of(node));
    w.node(node).emcy_register = 0;  // by its boot-up
    w.run(1);
    EXPECT_FALSE(w.has(faults::values_stuck, module_of(node)));
    EXPECT_EQ(w.why(Kind::gnc, {2}), Reason::none);
  }
}

TEST(TalarisReset, FanSpeedsThatDoNotChangeEndAFlight) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 20));
  ASSERT_TRUE(w.run_until(Phase::traverse, 10));
  w.node(kFanNode).emcy_register = 0x81;
  ASSERT_TRUE(w.run_until(Phase::escape, 1));
  w.step();
  EXPECT_TRUE(w.airborne());
  EXPECT_TRUE(w.has(faults::values_stuck, kFanModule));
  EXPECT_TRUE(w.has(FaultId::module_silent, kFanModule));
}

TEST(TalarisReset, TwoInOneFrameReachBothNodes) {
  World w;
  w.run(1);
  w.send(lss::CommandKind::reset, {kValveModule});
  w.send(lss::CommandKind::reset, {kFanModule});
  w.step();
  EXPECT_EQ(w.orders().reset_nodes, 1u << kValveNode | 1u << kFanNode);
  EXPECT_TRUE(answered(w, lss::Phase::superseded));
}

}  // namespace
}  // namespace lss::talaris
