// A commanded reset: nodes are away for a while, which is expected, and come back or do not.

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
