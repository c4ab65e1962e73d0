#include "daemon/runtime/command_port.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "tests/core/set_parameter.h"

namespace lss {
namespace {

constexpr CommandInfo kPortCommands[] = {{4, "solve", Access::holder, false, "", {}},
                                         {3, "estop", Access::anyone, false, "", {}, true},
                                         {2, "stop", Access::holder, false, "", {}, true}};
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
    .commands = kPortCommands,
    .sense = [](const SupervisorState&, const Request&) { return Verdict{}; }};

class CommandPortTest : public testing::Test {
 protected:
  void receive(std::uint16_t kind, std::uint64_t sequence, std::uint16_t flags = 0) {
    receive({.sequence = sequence, .kind = kind, .flags = flags}, "test");
  }
  void receive(Request r, const std::string& source) {
    source.copy(r.source.data(), 31);
    r.arrival_ns = ++now_ns_;
    port_.receive(r, 1, [&](const Ack& ack) { acks_.push_back(ack); });
  }
  // The next request for the frame thread; false: none.
  bool pop(Request& r) { return port_.take({&r, 1}) == 1; }
  std::vector<Request> take(std::size_t most = 32) {
    std::vector<Request> requests(most);
    requests.resize(port_.take(requests));
    return requests;
  }
  // The frame thread has run: state, and how many commands it took.
  void show(State state, std::uint64_t taken, const std::string& holder = "") {
    SupervisorState s;
    s.controller.state = state;
    s.commands_taken = taken;
    s.ended_ns = now_ns_;
    holder.copy(s.authority.data(), 31);
    port_.show(s);
  }
  unsigned count(Phase phase, Reason reason = Reason::none) const {
    unsigned n = 0;
    for (const Ack& ack : acks_) n += ack.phase == phase && ack.verdict.reason == reason;
    return n;
  }
  TimeNs now_ns_ = 0;
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
  ASSERT_TRUE(pop(r));
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
  EXPECT_FALSE(pop(r));
}

TEST_F(CommandPortTest, LeavesTheVerdictToTheFrameWhileAnotherCommandIsOnItsWay) {
  show(State::fatal_error, 0);
  receive(3, 1);
  receive(4, 2);
  EXPECT_EQ(acks_.size(), 1u) << "what the first will have changed is not known yet";
  Request r;
  ASSERT_TRUE(pop(r) && pop(r));
  EXPECT_FALSE(r.acknowledged);
  show(State::fatal_error, 1);
  receive(4, 3);
  EXPECT_EQ(acks_.size(), 2u);
}

TEST_F(CommandPortTest, ADryRunIsAnsweredAndGoesNoFurther) {
  show(State::fatal_error, 0);
  receive(4, 1, kFlagDryRun);
  ASSERT_EQ(acks_.size(), 1u);
  EXPECT_EQ(acks_[0].phase, Phase::accepted);
  Request r;
  EXPECT_FALSE(pop(r));
}

TEST_F(CommandPortTest, ADryRunThatIsRefusedIsAnsweredAndNotCounted) {
  show(State::idle, 0);
  receive(4, 1, kFlagDryRun);
  ASSERT_EQ(acks_.size(), 1u);
  EXPECT_EQ(acks_[0].phase, Phase::rejected);
  EXPECT_EQ(port_.refused(), 0u);
}

TEST_F(CommandPortTest, AParameterOutOfRangeIsRefusedAtOnceAndWhetherItGoesWithOthersIsTheFrames) {
  static constexpr CommandInfo kSet = set_parameter_command(Access::holder);
  static constexpr TunableInfo kInfos[] = {
      {"a.speed_m_s", "m/s", 0, 2, Change::always, false, "how fast"},
      {"a.gain", "", 0, 2, Change::at_rest, false, "how hard"}};
  Logic logic = kLogic;
  logic.commands = {&kSet, 1};
  logic.tunables = kInfos;
  CommandPort port(logic, 100, 1000);
  SupervisorState walking;
  walking.controller.state = State::operational;
  port.show(walking);
  std::uint64_t sequence = 0;
  const auto answer = [&](std::string_view name, double value) {
    Request r{.sequence = ++sequence, .kind = 9, .parameter = {value}};
    std::string("test").copy(r.source.data(), 31);
    name.copy(r.name.data(), r.name.size());
    acks_.clear();
    port.receive(r, 1, [&](const Ack& ack) { acks_.push_back(ack); });
    return acks_.empty() ? Reason::none : acks_[0].verdict.reason;
  };
  EXPECT_EQ(answer("a.speed_m_s", 3), Reason::parameter_range);
  EXPECT_EQ(answer("a.gains", 1), Reason::no_such_parameter) << "by the armour";
  EXPECT_EQ(answer("a.gain", 1), Reason::not_in_state);
  Request r;
  EXPECT_EQ(port.take({&r, 1}), 0u);
  EXPECT_EQ(answer("a.speed_m_s", 1), Reason::none);
  EXPECT_TRUE(acks_.empty()) << "the frame says whether it is accepted";
  ASSERT_EQ(port.take({&r, 1}), 1u);
  EXPECT_FALSE(r.acknowledged);
}

TEST_F(CommandPortTest, AnEmergencyStopStopsAtOnceIsAnsweredAndGoesToTheFrame) {
  show(State::operational, 0);
  receive(4, 1);
  EXPECT_EQ(stops_, 0) << "no other command does";
  receive(3, 2);
  EXPECT_EQ(stops_, 1);
  EXPECT_EQ(acks_.back().phase, Phase::accepted);
  Request r;
  ASSERT_TRUE(pop(r));
  EXPECT_EQ(r.kind, 3) << "ahead of what came before";
  EXPECT_TRUE(r.acknowledged);
  EXPECT_FALSE(r.answered);
  receive(3, 3, kFlagDryRun);
  EXPECT_EQ(stops_, 1) << "a dry run stops nothing";
  EXPECT_EQ(acks_.back().phase, Phase::accepted);
}

TEST_F(CommandPortTest, AnEmergencyStopIsObeyedHoweverBadlyItIsPut) {
  show(State::operational, 0);
  Request unnamed{.sequence = 1, .kind = 4};
  port_.receive(unnamed, 1, [](const Ack&) {});
  EXPECT_EQ(stops_, 0) << "refused by the armour, and another command";
  unnamed.kind = 3;
  unnamed.source.fill('x');
  unnamed.parameter.fill(std::numeric_limits<double>::quiet_NaN());
  port_.receive(unnamed, 1, [](const Ack&) {});
  port_.receive(unnamed, 1, [](const Ack&) {});
  EXPECT_EQ(stops_, 2) << "nor is a number used up";
}

TEST_F(CommandPortTest, AFloodOfCommandsDelaysNoEmergencyStop) {
  show(State::operational, 0, "pilot");
  for (std::uint64_t i = 1; i <= 1000; ++i) receive({.sequence = i, .kind = 4}, "pilot");
  ASSERT_GT(count(Phase::rejected, Reason::not_in_state) + count(Phase::rejected, Reason::busy),
            0u);
  acks_.clear();
  receive(3, 1);
  EXPECT_EQ(stops_, 1);
  ASSERT_EQ(acks_.size(), 1u);
  EXPECT_EQ(acks_[0].phase, Phase::accepted);
  EXPECT_EQ(take().front().kind, 3);
}

// Two people press the button in one frame: both are answered to the end.
TEST_F(CommandPortTest, EmergencyStopsOfOneFrameGoToItTheNewestFirst) {
  show(State::operational, 0);
  for (std::uint64_t i = 1; i <= 3; ++i) receive(3, i);
  const std::vector<Request> requests = take();
  ASSERT_EQ(requests.size(), 3u);
  EXPECT_EQ(requests[0].sequence, 3u);
  EXPECT_EQ(requests[1].sequence, 1u);
  EXPECT_EQ(requests[2].sequence, 2u);
  EXPECT_TRUE(take().empty());
  EXPECT_EQ(count(Phase::superseded, Reason::superseded), 0u);
}

TEST_F(CommandPortTest, OfAFloodOfEmergencyStopsEachIsEndedOnce) {
  show(State::operational, 0);
  for (std::uint64_t i = 1; i <= 1000; ++i) receive(3, i);
  EXPECT_EQ(stops_, 1000);
  EXPECT_EQ(count(Phase::accepted), 1000u);
  const std::vector<Request> requests = take();
  EXPECT_EQ(requests.at(0).sequence, 1000u);
  EXPECT_EQ(requests.size(), 1 + CommandPort::kStops);
  EXPECT_EQ(count(Phase::superseded, Reason::superseded), 999 - CommandPort::kStops);
  receive(3, 1001);
  EXPECT_EQ(take().size(), 1u) << "what the frame has read is not given to it again";
}

TEST_F(CommandPortTest, AnEmergencyStopOfAStoppedVehicleIsAnsweredWithoutAFrame) {
  SupervisorState stopped;
  stopped.controller.state = State::fatal_error;
  stopped.faults[0].id = FaultId::emergency_stop;
  port_.show(stopped);
  receive(3, 1);
  EXPECT_EQ(count(Phase::completed), 1u);
  const std::vector<Request> requests = take();
  ASSERT_EQ(requests.size(), 1u) << "a solve may be on its way";
  EXPECT_TRUE(requests[0].answered);
  receive(3, 11);
  receive(3, 12);
  EXPECT_EQ(take().size(), 1u) << "both are answered";
  acks_.clear();
  receive(3, 13);
  take();
  stopped.faults[0].id = FaultId::module_silent;
  port_.show(stopped);
  receive(3, 2);
  EXPECT_EQ(count(Phase::completed), 1u) << "stopped for another reason: the frame confirms";
}

TEST_F(CommandPortTest, AFloodOfCommandsDelaysNoStop) {
  show(State::fatal_error, 0, "pilot");
  for (std::uint64_t i = 1; i <= 1000; ++i) receive({.sequence = i, .kind = 4}, "pilot");
  receive({.sequence = 2000, .kind = 2}, "pilot");
  EXPECT_EQ(take().front().kind, 2) << "ahead of the others";
}

TEST_F(CommandPortTest, OthersLeaveRoomInTheQueueForTheHolder) {
  show(State::operational, 0, "pilot");
  receive({.sequence = 1, .kind = 3}, "x");  // from now on the frame judges
  for (std::uint64_t i = 1; i <= 1000; ++i) receive({.sequence = i, .kind = 4}, "stranger");
  EXPECT_EQ(count(Phase::rejected, Reason::busy), 1000 - 48u);
  acks_.clear();
  receive({.sequence = 1001, .kind = 4}, "pilot");
  EXPECT_EQ(count(Phase::rejected, Reason::busy), 0u);
}

TEST_F(CommandPortTest, OthersLeaveRoomForTheHoldersStop) {
  show(State::operational, 0, "pilot");
  receive({.sequence = 1, .kind = 3}, "x");  // from now on the frame judges
  for (std::uint64_t i = 1; i <= 1000; ++i) receive({.sequence = i, .kind = 2}, "stranger");
  acks_.clear();
  receive({.sequence = 1001, .kind = 2}, "pilot");
  EXPECT_EQ(count(Phase::rejected, Reason::busy), 0u);
}

TEST_F(CommandPortTest, HeartbeatsAreStateTheNewestOfAnyoneAndOfTheHolder) {
  show(State::operational, 0, "pilot");
  receive({.kind = 0}, "pilot");
  for (int i = 0; i < 100'000; ++i) receive({.kind = 0}, "source " + std::to_string(i));
  const std::vector<Request> requests = take();
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_STREQ(requests[0].source.data(), "source 99999");
  EXPECT_STREQ(requests[1].source.data(), "pilot");
  EXPECT_TRUE(take().empty()) << "an old one is not news";
  receive({.kind = 0}, "source");
  EXPECT_EQ(take().size(), 1u) << "and the holder's old one is not";
}

TEST_F(CommandPortTest, AFloodOfHeartbeatsDelaysNoCommand) {
  show(State::fatal_error, 0, "pilot");
  for (int i = 0; i < 1000; ++i) receive({.kind = 0}, "pilot");
  receive({.sequence = 1, .kind = 4}, "pilot");
  EXPECT_EQ(count(Phase::accepted), 1u);
}

TEST_F(CommandPortTest, AFullQueueIsAnsweredAndNothingIsLostSilently) {
  show(State::fatal_error, 0);
  for (std::uint64_t i = 1; i <= 100; ++i) receive(4, i);
  unsigned taken = 0;
  for (Request r; pop(r);) ++taken;
  EXPECT_GT(count(Phase::rejected, Reason::busy) + count(Phase::failed, Reason::busy), 0u);
  EXPECT_EQ(count(Phase::rejected, Reason::busy) + count(Phase::failed, Reason::busy) + taken,
            100u);
}

}  // namespace
}  // namespace lss
