// Stops in the supervisor: order of arrival decides, and another daemon of the same name is no
// partner. And its faults, when there are more than fit.

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "daemon/cycle/common_commands.h"
#include "daemon/cycle/supervisor.h"

namespace lss {
namespace {

constexpr std::uint16_t kStart = 1, kStop = 2, kEstop = 3, kSolve = 4, kData = 6, kLand = 50;
constexpr CommandInfo kCommands[] = {
    {kStart, "start", Access::holder, true, "", {}},
    {kStop, "stop", Access::holder, false, "", {}, true},
    {kLand, "land", Access::anyone, false, "", {}, true},
};

constexpr auto kStartEvent = static_cast<lc::Event>(lc::kVehicleEvents);
constexpr auto kStopEvent = static_cast<lc::Event>(lc::kVehicleEvents + 1);
constexpr lc::Row row(lc::Event event, State from, State to, std::uint8_t mode,
                      lc::ActionSet actions) {
  return {event, lc::in(from), lc::kAnyMode, 0, lc::kKeep, to, mode, 0, actions};
}
constexpr std::array kRows = {
    row(kStartEvent, State::idle, State::operational, 1, lc::kTakeAuthority),
    row(kStopEvent, State::operational, State::idle, 0, lc::kMotorsOff),
    row(kStopEvent, State::idle, State::idle, 0, 0),
    row(lc::Event::lease_expired, State::operational, State::idle, 0, lc::kMotorsOff),
};
constexpr lc::Rows kIndexed(kRows);
const lc::Table kTable{&kIndexed,
                       {},
                       0,
                       {},
                       [](unsigned, const lc::ControllerState&, unsigned) { return Verdict{}; },
                       [](lc::ActionSet, lc::ControllerState&) {},
                       &lc::kCommonRows};
const Logic kLogic{.table = &kTable,
                   .event_of =
                       [](const Request& r) {
                         if (r.kind == kStart) return kStartEvent;
                         return r.kind == kStop || r.kind == kLand ? kStopEvent : common_event(r);
                       },
                   .subject_of = [](const Request&) { return 0U; },
                   .reached =
                       [](std::uint16_t kind, const SupervisorState& s) {
                         if (kind == kStart) return false;  // goes on
                         if (kind == kSolve) return s.controller.state == State::idle;
                         return true;
                       },
                   .commands = kCommands,
                   .sense = [](const SupervisorState&, const Request&) { return Verdict{}; }};

class SupervisorStopsTest : public testing::Test, public Actor {
 protected:
  SupervisorStopsTest() { frame({}); }

  static Request request(std::uint16_t kind, TimeNs arrival_ns, const char* source = "pilot") {
    Request r{.sequence = static_cast<std::uint64_t>(arrival_ns),
              .kind = kind,
              .lease_ms = 1000,
              .arrival_ns = arrival_ns};
    std::strcpy(r.source.data(), source);
    return r;
  }
  static Request another_daemon() {
    Request r = request(0, 0, "lssd");
    r.flags = kFlagAnotherDaemon;
    return r;
  }
  void frame(const std::vector<Request>& requests, TimeNs later_ns = 100 * kMillisecond) {
    now_ns_ += later_ns;
    supervisor_.begin(now_ns_, *this);
    for (const Request& r : requests) supervisor_.request(r);
    supervisor_.check_links();
    const Supervisor::Outbox& box = supervisor_.outbox();
    acks_.insert(acks_.end(), box.acks.begin(), box.acks.begin() + box.ack_count);
  }
  // How the command that arrived then ended.
  Ack end_of(TimeNs arrival_ns) const {
    Ack last;
    for (const Ack& ack : acks_) {
      if (ack.sequence == static_cast<std::uint64_t>(arrival_ns)) last = ack;
    }
    return last;
  }
  State state() const { return supervisor_.state().controller.state; }
  bool has(FaultId id) const {
    return std::ranges::any_of(supervisor_.state().faults,
                               [&](const FaultRecord& fault) { return fault.id == id; });
  }
  bool conflict() const { return has(FaultId::name_conflict); }
  void act(lc::ActionSet, const Request*) noexcept override {}

  TimeNs now_ns_ = kSecond;
  Supervisor supervisor_{kLogic, {}};
  std::vector<Ack> acks_;
};

TEST_F(SupervisorStopsTest, WhatCameBeforeAnEmergencyStopIsNotObeyedAfterIt) {
  frame({request(kEstop, 1)});
  ASSERT_EQ(state(), State::fatal_error);
  frame({request(kEstop, 12), request(kSolve, 11)});
  EXPECT_EQ(state(), State::fatal_error) << "the stop came after the solve, and goes first";
  EXPECT_EQ(end_of(11).verdict.reason, Reason::superseded);
  frame({request(kSolve, 10)});
  EXPECT_EQ(state(), State::fatal_error) << "also when it waited for a frame";
  frame({request(kSolve, 13)});
  EXPECT_EQ(state(), State::solve_errors);
}

TEST_F(SupervisorStopsTest, WhatCameBeforeAStopIsNotObeyedAfterIt) {
  frame({request(kStop, 12), request(kStart, 11)});
  EXPECT_EQ(state(), State::idle);
  EXPECT_EQ(end_of(11).verdict.reason, Reason::superseded);
  frame({request(kStart, 13)});
  EXPECT_EQ(state(), State::operational);
}

TEST_F(SupervisorStopsTest, WhoeverAsksHoweverMuchEveryAnswerToTheHolderIsGiven) {
  frame({request(kStart, 10)});
  acks_.clear();
  std::vector<Request> asked(kMaxRequests - 1, request(kData, 11, "stranger"));
  asked.push_back(request(kStop, 12));
  frame(asked);
  EXPECT_EQ(supervisor_.outbox().dropped, 0u);
  EXPECT_EQ(end_of(10).phase, Phase::superseded);
  EXPECT_EQ(end_of(12).phase, Phase::completed);
  EXPECT_EQ(acks_.size(), 3 * kMaxRequests + 1);
  EXPECT_EQ(supervisor_.outbox().holder, request(kStop, 12).source);
}

TEST_F(SupervisorStopsTest, AStopThatIsRefusedEndsNothing) {
  frame({request(kStart, 10)});
  frame({request(kStop, 12, "stranger")});
  EXPECT_EQ(end_of(12).verdict.reason, Reason::not_authorised);
  EXPECT_EQ(state(), State::operational);
  EXPECT_LT(supervisor_.state().ended_ns, 12);
}

TEST_F(SupervisorStopsTest, AskingForDataIsNotEndedByAStop) {
  frame({request(kEstop, 12), request(kData, 11)});
  EXPECT_EQ(end_of(11).phase, Phase::completed);
}

TEST_F(SupervisorStopsTest, ALandingOrderedByAStrangerTakesThePlaceOfWhatRuns) {
  frame({request(kStart, 10)});
  frame({request(kLand, 11, "stranger")});
  EXPECT_EQ(state(), State::idle);
  EXPECT_EQ(end_of(10).phase, Phase::superseded);
  EXPECT_EQ(end_of(11).phase, Phase::completed);
}

TEST_F(SupervisorStopsTest, AnAnsweredEmergencyStopIsNotAnsweredAgain) {
  Request stop = request(kEstop, 5);
  stop.acknowledged = stop.answered = true;
  frame({stop});
  EXPECT_EQ(state(), State::fatal_error);
  EXPECT_TRUE(acks_.empty());
}

TEST_F(SupervisorStopsTest, EveryEmergencyStopOfTheFrameInWhichItFellSaysSo) {
  Logic flies = kLogic;
  flies.airborne = [](const lc::ControllerState& s) { return s.state == State::operational; };
  supervisor_ = Supervisor(flies, {});
  frame({});
  frame({request(kStart, 10)});
  frame({request(kEstop, 12, "another"), request(kEstop, 11)});
  EXPECT_EQ(end_of(12).verdict.reason, Reason::fell);
  EXPECT_EQ(end_of(11).verdict.reason, Reason::fell);
  frame({request(kEstop, 13)});
  EXPECT_EQ(end_of(13).verdict.reason, Reason::none) << "it fell once";
}

TEST_F(SupervisorStopsTest, AnotherDaemonOfTheNameKeepsItInIdle) {
  frame({another_daemon()});
  EXPECT_TRUE(conflict());
  EXPECT_EQ(state(), State::idle);
  frame({request(kStart, 10)});
  EXPECT_EQ(state(), State::idle);
  EXPECT_EQ(end_of(10).verdict.reason, Reason::name_conflict);
  EXPECT_EQ(end_of(10).verdict.measured, 100) << "ms since it was heard";
  frame({}, Supervisor::kGoneAfter - 100 * kMillisecond);
  EXPECT_TRUE(conflict());
  frame({request(kStart, 11)}, kMillisecond);
  EXPECT_EQ(end_of(11).verdict.reason, Reason::name_conflict);
  EXPECT_FALSE(conflict()) << "gone";
  frame({request(kStart, 12)});
  EXPECT_EQ(state(), State::operational);
}

TEST_F(SupervisorStopsTest, AnotherDaemonOfTheNameStopsItSafely) {
  frame({request(kStart, 10)});
  ASSERT_EQ(state(), State::operational);
  frame({another_daemon()});
  EXPECT_EQ(state(), State::idle);
  EXPECT_TRUE(conflict());
  EXPECT_EQ(end_of(10).phase, Phase::failed);
  EXPECT_EQ(end_of(10).verdict.reason, Reason::name_conflict);
}

TEST_F(SupervisorStopsTest, TheHeartbeatOfAnotherDaemonIsNoSignOfLife) {
  frame({request(kStart, 10)});
  const TimeNs before = supervisor_.state().contact_ns;
  frame({another_daemon()});
  EXPECT_EQ(supervisor_.state().contact_ns, before);
}

TEST_F(SupervisorStopsTest, TheCycleHasToFollowAStopThatTheBusObeyed) {
  frame({request(kStart, 10)});
  const auto pending_frame = [&] {
    now_ns_ += 100 * kMillisecond;
    supervisor_.begin(now_ns_, *this);
    supervisor_.check_stop(true);
  };
  pending_frame();
  pending_frame();
  EXPECT_EQ(state(), State::operational) << "it may be on its way";
  pending_frame();
  EXPECT_EQ(state(), State::fatal_error);
}

TEST_F(SupervisorStopsTest, OfMoreFaultsThanFitNoneIsLeftWhenAllAreSolved) {
  const auto count = [&] { return supervisor_.state().fault_count; };
  for (std::uint16_t module = 1; module < kMaxFaults; ++module)
    supervisor_.raise(FaultId::module_silent, module);
  supervisor_.latch(FaultId::temperature_warning, 1);
  EXPECT_EQ(count(), kMaxFaults);
  supervisor_.raise(FaultId::memory_lost);
  EXPECT_TRUE(has(FaultId::memory_lost)) << "in the place of the warning";
  EXPECT_EQ(count(), kMaxFaults + 1) << "more than fit";
  const auto events = supervisor_.outbox().event_count;
  for (int frame = 0; frame < 3; ++frame) {
    supervisor_.raise(FaultId::memory_lost);
    supervisor_.latch(FaultId::temperature_warning, 1);
  }
  EXPECT_EQ(count(), kMaxFaults + 1) << "the same ones again";
  EXPECT_EQ(supervisor_.outbox().event_count, events);
  supervisor_.happen(lc::Event::port_opened);
  supervisor_.happen(lc::Event::solve);
  ASSERT_EQ(supervisor_.happen(lc::Event::solved).reason, Reason::none);
  EXPECT_EQ(state(), State::idle);
  EXPECT_EQ(count(), 0u);
}

}  // namespace
}  // namespace lss
