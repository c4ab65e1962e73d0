// A commanded reset: modules are away for a while, which is expected, and come back or do not.

#include <gtest/gtest.h>

#include "world.h"

namespace lss::zebro {
namespace {

constexpr std::uint16_t kReset = static_cast<std::uint16_t>(lss::CommandKind::reset);

// The answer to the last reset in this phase; nullptr: there is none.
const Ack* answer(const World& w, Phase phase) {
  for (auto ack = w.acks.rbegin(); ack != w.acks.rend(); ++ack) {
    if (ack->kind == kReset && ack->phase == phase) return &*ack;
  }
  return nullptr;
}

// In Idle, all modules have answered; a reset module is away for this time.
void idle(World& w, double boot_s) {
  for (IdealModule& module : w.modules) module.boot_ns = static_cast<TimeNs>(boot_s * 1e9);
  w.run(0.2);
}

Verdict start(World& w) {
  w.acks.clear();
  w.send(lss::CommandKind::start, {0});
  w.step();
  const Ack* rejected = w.last(Phase::rejected);
  return rejected != nullptr ? rejected->verdict : Verdict{};
}

void expect_well(const World& w) {
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
}

bool heard(const World& w, EventId id, std::uint16_t subject) {
  return std::ranges::any_of(w.events, [&](const EventRecord& e) {
    return e.id == static_cast<std::uint16_t>(id) && e.subject == subject;
  });
}

// [Oper-4]
TEST(ZebroReset, OfAModuleIsNoEmergencyAndEndsWhenItIsBack) {
  for (std::uint16_t number = 1; number <= kModules; ++number) {
    SCOPED_TRACE(number);
    World w;
    idle(w, 2);
    w.send(lss::CommandKind::reset, {double(number)});
    w.run(1.5);
    expect_well(w);
    EXPECT_NE(answer(w, Phase::executing), nullptr);
    EXPECT_EQ(answer(w, Phase::completed), nullptr);
    EXPECT_TRUE(heard(w, EventId::reset_begun, number));
    const Verdict refused = start(w);
    EXPECT_EQ(refused.reason, Reason::module_silent);
    EXPECT_EQ(refused.subject, number);
    ASSERT_TRUE(w.run_until([&] { return answer(w, Phase::completed) != nullptr; }, 2));
    EXPECT_TRUE(heard(w, EventId::reset_ended, number));
    expect_well(w);
    EXPECT_EQ(start(w).reason, Reason::none);
  }
}

TEST(ZebroReset, OfAllModulesIsNoEmergencyAndItStandsUpAfterIt) {
  World w;
  idle(w, 2);
  w.send(lss::CommandKind::reset, {0});
  ASSERT_TRUE(w.run_until([&] { return answer(w, Phase::completed) != nullptr; }, 4));
  expect_well(w);
  EXPECT_TRUE(w.stand());
}

// [Oper-4]
TEST(ZebroReset, AModuleThatStaysAwayIsAFaultAtItsDeadline) {
  World w;
  idle(w, 1000);
  w.send(lss::CommandKind::reset, {3});
  w.run(4.9);
  expect_well(w);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 0.2));
  EXPECT_TRUE(w.has(FaultId::module_silent, 3));
  EXPECT_TRUE(w.all_stopped());
  ASSERT_NE(answer(w, Phase::failed), nullptr);
  EXPECT_EQ(answer(w, Phase::failed)->verdict.reason, Reason::module_silent);
  EXPECT_EQ(answer(w, Phase::failed)->verdict.subject, 3);
}

TEST(ZebroReset, AModuleThatWasNotCommandedIsAFaultAsEver) {
  World w;
  idle(w, 2);
  w.send(lss::CommandKind::reset, {3});
  w.run(0.5);
  w.modules[4].alive = false;
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 1));
  EXPECT_TRUE(w.has(FaultId::module_silent, 5));
  EXPECT_FALSE(w.has(FaultId::module_silent, 3));
}

TEST(ZebroReset, OfAModuleThatIsAwayBringsItBackAndSolveGoesOn) {
  World w;
  idle(w, 0);
  w.modules[1].alive = false;
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 1));
  w.send(lss::CommandKind::reset, {2});
  w.run(1);
  w.modules[1].alive = true;  // receives it when it has power again
  w.modules[1].serial = 0;
  ASSERT_TRUE(w.run_until([&] { return answer(w, Phase::completed) != nullptr; }, 3));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 15));
  expect_well(w);
}

// The order did not reach it, or another took its place.
TEST(ZebroReset, ThatWasNotSeenFailsAndTheModuleIsNoFault) {
  World w;
  idle(w, 0);
  w.modules[2].serial = w.out_.command.module[2].serial + 1;  // it takes no notice of the next one
  w.send(lss::CommandKind::reset, {3});
  w.run(5.2);
  ASSERT_NE(answer(w, Phase::failed), nullptr);
  EXPECT_EQ(answer(w, Phase::failed)->verdict.reason, Reason::not_reset);
  EXPECT_EQ(answer(w, Phase::failed)->verdict.subject, 3);
  expect_well(w);
}

}  // namespace
}  // namespace lss::zebro
