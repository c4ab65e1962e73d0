#include "daemon/core/command_port.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace lss {
namespace {

constexpr CommandInfo kSolve{4, "solve", Access::holder, false, "", {}};
constexpr CommandInfo kStop{3, "estop", Access::anyone, false, "", {}};
const lc::Rows kNoRows({});
const lc::Table kTable{&kNoRows,
                       {},
                       0,
                       {},
                       [](unsigned, const lc::ControllerState&, unsigned) { return Verdict{}; },
                       [](lc::ActionSet, lc::ControllerState&) {},
                       &lc::kCommonRows};
const Logic kLogic{
    .table = &kTable,
    .event_of =
        [](const Request& r) { return r.kind == 4 ? lc::Event::solve : lc::Event::emergency_stop; },
    .subject_of = [](const Request&) { return 0U; },
    .reached = [](std::uint16_t, const SupervisorState&) { return true; },
    .command = [](std::uint16_t kind) -> const CommandInfo* {
      if (kind == 4) return &kSolve;
      return kind == 3 ? &kStop : nullptr;
    },
    .sense = [](const SupervisorState&, const Request&) { return Verdict{}; }};

class CommandPortTest : public testing::Test {
 protected:
  void receive(std::uint16_t kind, std::uint64_t sequence, std::uint16_t flags = 0) {
    Request r{.sequence = sequence, .kind = kind, .flags = flags};
    std::string("test").copy(r.source.data(), 31);
    port_.receive(r, [&](const Ack& ack) { acks_.push_back(ack); });
  }
  // The frame thread has run: state, and how many commands it took.
  void show(State state, std::uint64_t taken) {
    SupervisorState s;
    s.controller.state = state;
    s.commands_taken = taken;
    port_.show(s);
  }
  int stops_ = 0;
  CommandPort port_{kLogic, 100, 1000, [this] { ++stops_; }};
  std::vector<Ack> acks_;
};

TEST_F(CommandPortTest, AcceptsAtOnceWhatTheNewestStateAllows) {
  show(State::fatal_error, 0);
  receive(4, 1);
  ASSERT_EQ(acks_.size(), 1u);
  EXPECT_EQ(acks_[0].phase, Phase::accepted);
  Request r;
  ASSERT_TRUE(port_.pop(r));
  EXPECT_TRUE(r.acknowledged);
}

TEST_F(CommandPortTest, RejectsAtOnceWhatTheNewestStateForbids) {
  show(State::idle, 0);
  receive(4, 1);
  ASSERT_EQ(acks_.size(), 1u);
  EXPECT_EQ(acks_[0].phase, Phase::rejected);
  EXPECT_EQ(acks_[0].verdict.reason, Reason::not_in_state);
  EXPECT_EQ(port_.refused(), 1u);
  Request r;
  EXPECT_FALSE(port_.pop(r));
}

TEST_F(CommandPortTest, LeavesTheVerdictToTheFrameWhileAnotherCommandIsOnItsWay) {
  show(State::fatal_error, 0);
  receive(3, 1);
  receive(4, 2);
  EXPECT_EQ(acks_.size(), 1u) << "what the first will have changed is not known yet";
  Request r;
  ASSERT_TRUE(port_.pop(r) && port_.pop(r));
  EXPECT_FALSE(r.acknowledged);
  show(State::fatal_error, 2);
  receive(4, 3);
  EXPECT_EQ(acks_.size(), 2u);
}

TEST_F(CommandPortTest, ADryRunIsAnsweredAndGoesNoFurther) {
  show(State::fatal_error, 0);
  receive(4, 1, kFlagDryRun);
  ASSERT_EQ(acks_.size(), 1u);
  EXPECT_EQ(acks_[0].phase, Phase::accepted);
  Request r;
  EXPECT_FALSE(port_.pop(r));
}

TEST_F(CommandPortTest, ADryRunThatIsRefusedIsAnsweredAndNotCounted) {
  show(State::idle, 0);
  receive(4, 1, kFlagDryRun);
  ASSERT_EQ(acks_.size(), 1u);
  EXPECT_EQ(acks_[0].phase, Phase::rejected);
  EXPECT_EQ(port_.refused(), 0u);
}

TEST_F(CommandPortTest, AParameterOutOfRangeIsRefusedAtOnceAndWhetherItGoesWithOthersIsTheFrames) {
  static constexpr CommandInfo kSet{9, "set-parameter", Access::holder, false, "", kSetParameters};
  static constexpr TunableInfo kInfos[] = {
      {"a.speed_m_s", "m/s", 0, 2, Change::always, false, "how fast"},
      {"a.gain", "", 0, 2, Change::at_rest, false, "how hard"}};
  Logic logic = kLogic;
  logic.command = [](std::uint16_t) { return &kSet; };
  logic.tunables = kInfos;
  CommandPort port(logic, 100, 1000);
  SupervisorState walking;
  walking.controller.state = State::operational;
  port.show(walking);
  std::uint64_t sequence = 0;
  const auto answer = [&](double number, double value) {
    Request r{.sequence = ++sequence, .kind = 9, .parameter = {number, value}};
    std::string("test").copy(r.source.data(), 31);
    acks_.clear();
    port.receive(r, [&](const Ack& ack) { acks_.push_back(ack); });
    return acks_.empty() ? Reason::none : acks_[0].verdict.reason;
  };
  EXPECT_EQ(answer(1, 3), Reason::parameter_range);
  EXPECT_EQ(answer(3, 1), Reason::no_such_parameter);
  EXPECT_EQ(answer(41, 1), Reason::out_of_range) << "by the armour";
  EXPECT_EQ(answer(1.5, 1), Reason::not_a_choice);
  EXPECT_EQ(answer(2, 1), Reason::not_in_state);
  Request r;
  EXPECT_FALSE(port.pop(r));
  EXPECT_EQ(answer(1, 1), Reason::none);
  EXPECT_TRUE(acks_.empty()) << "the frame says whether it is accepted";
  ASSERT_TRUE(port.pop(r));
  EXPECT_FALSE(r.acknowledged);
}

TEST_F(CommandPortTest, AnEmergencyStopIsToldAtOnceAndStillGoesToTheFrame) {
  show(State::operational, 0);
  receive(4, 1);
  EXPECT_EQ(stops_, 0) << "no other command is";
  receive(3, 2);
  EXPECT_EQ(stops_, 1);
  Request r;
  ASSERT_TRUE(port_.pop(r));
  EXPECT_EQ(r.kind, 3);
  receive(3, 3, kFlagDryRun);
  EXPECT_EQ(stops_, 1) << "a dry run stops nothing";
}

TEST_F(CommandPortTest, AnEmergencyStopIsToldHoweverBadlyItIsPut) {
  show(State::operational, 0);
  Request unnamed{.sequence = 1, .kind = 4};
  port_.receive(unnamed, [](const Ack&) {});
  EXPECT_EQ(stops_, 0) << "refused by the armour, and another command";
  unnamed.kind = 3;
  port_.receive(unnamed, [](const Ack&) {});
  EXPECT_EQ(stops_, 1);
}

TEST_F(CommandPortTest, AnEmergencyStopIsToldAtOnceAlsoWhenTheQueueIsFull) {
  show(State::fatal_error, 0);
  for (std::uint64_t i = 1; i <= 100; ++i) receive(4, i);
  receive(3, 101);
  EXPECT_EQ(stops_, 1);
  EXPECT_EQ(acks_.back().verdict.reason, Reason::busy);
}

TEST_F(CommandPortTest, AFullQueueIsAnsweredAndNothingIsLostSilently) {
  show(State::fatal_error, 0);
  for (std::uint64_t i = 1; i <= 100; ++i) receive(4, i);
  unsigned busy = 0, taken = 0;
  for (const Ack& ack : acks_) busy += ack.verdict.reason == Reason::busy;
  for (Request r; port_.pop(r);) ++taken;
  EXPECT_GT(busy, 0u);
  EXPECT_EQ(busy + taken, 100u);
}

}  // namespace
}  // namespace lss
