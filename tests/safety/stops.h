#pragma once

// Safety suite: authority, lease, and everything by which a vehicle is stopped. See safety_suite.h.

#include "scene.h"

namespace lss::safety {

template <class T>
class SafetyStops : public testing::Test {};
TYPED_TEST_SUITE_P(SafetyStops);

TYPED_TEST_P(SafetyStops, BootsSafeAndStaysSoUntilItIsStarted) {
  using T = TypeParam;
  const auto w = fresh<T>();
  w->step();
  EXPECT_TRUE(safe<T>(*w)) << "in its first frame";
  for (const CommandInfo& info : commands<T>()) {
    SCOPED_TRACE(info.name);
    const auto kind = static_cast<CommandKind>(info.kind);
    if (kind == CommandKind::start || kind == CommandKind::emergency_stop) continue;
    const Ack ack = answer_to<T>(*w, request_of(info));
    if (info.leased) {
      EXPECT_EQ(ack.phase, Phase::rejected) << "it moves something";
    }
    EXPECT_TRUE(stays_sound<T>(*w, 1));
    EXPECT_EQ(w->state(), State::idle);
  }
  EXPECT_EQ(w->supervisor_.state().authority, Name{});
}

TYPED_TEST_P(SafetyStops, ASecondSourceIsRefusedWhileTheFirstHasAuthority) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  for (const CommandInfo& info : commands<T>()) {
    if (info.access != Access::holder) continue;
    SCOPED_TRACE(info.name);
    const Ack ack = answer_to<T>(*w, request_of(info, "intruder"));
    EXPECT_EQ(ack.phase, Phase::rejected);
    EXPECT_EQ(ack.verdict.reason, Reason::not_authorised);
    EXPECT_EQ(w->state(), State::operational);
    EXPECT_EQ(w->supervisor_.state().authority, source("test"));
  }
  EXPECT_TRUE(T::moves(*w)) << "the first one's command goes on";
}

// Also without the armour in front of the cycle, and in the frame of the first one's start.
TYPED_TEST_P(SafetyStops, TheCycleItselfRefusesASecondSource) {
  using T = TypeParam;
  const auto w = std::make_unique<WorldOf<T>>(T::parameters());
  ASSERT_TRUE(comes_to_motion<T>(*w));
  for (const CommandInfo& info : commands<T>()) {
    if (info.access != Access::holder) continue;
    const Ack ack = answer_to<T>(*w, request_of(info, "intruder"));
    EXPECT_EQ(ack.verdict.reason, Reason::not_authorised) << info.name;
  }
  EXPECT_TRUE(T::moves(*w));
}

TYPED_TEST_P(SafetyStops, AuthorityIsFreeAfterAStop) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  w->send(CommandKind::stop);
  ASSERT_TRUE(w->run_until(State::idle, T::kRest_s)) << "at rest";
  EXPECT_EQ(w->supervisor_.state().authority, Name{});
  w->run(1);
  EXPECT_EQ(answer_to<T>(*w, request_of(*T::logic().command(1), "another")).phase, Phase::accepted);
  EXPECT_EQ(w->supervisor_.state().authority, source("another"));
}

// [Oper-7]
TYPED_TEST_P(SafetyStops, AStopEndsIdleAndSafeEverywhere) {
  using T = TypeParam;
  Request stop = request_of(*T::logic().command(2));
  const bool choice = !T::logic().command(2)->parameters.empty();  // how to stop
  for (const auto& place : places<T>()) {
    for (const bool other : {false, true}) {
      SCOPED_TRACE(place.name + (other ? ", the other way" : ""));
      const auto w = at<T>(place);
      ASSERT_NE(w, nullptr);
      if (choice) stop.parameter[0] = other ? 0 : 1;
      const std::uint64_t sequence = w->put(stop);
      w->step();
      if (place.state == State::fatal_error) {
        EXPECT_NE(w->answer(CommandKind::stop, Phase::rejected), nullptr) << "it is stopped";
        EXPECT_TRUE(safe<T>(*w));
        continue;
      }
      const auto completed = [&] { return w->answer(CommandKind::stop, Phase::completed); };
      if (place.state == State::solve_errors) {
        EXPECT_EQ(w->state(), State::fatal_error);
        EXPECT_TRUE(stopped<T>(*w)) << "in the frame that got it";
        EXPECT_NE(w->answer(CommandKind::solve, Phase::superseded), nullptr);
        EXPECT_NE(completed(), nullptr);
        EXPECT_NE(w->supervisor_.state().fault_count, 0u) << "they are not solved";
        EXPECT_TRUE(stays_stopped<T>(*w, 1));
        continue;
      }
      ASSERT_TRUE(w->run_until([&] { return w->state() == State::idle && completed() != nullptr; },
                               T::kRest_s))
          << where<T>(*w);
      EXPECT_EQ(completed()->sequence, sequence);
      EXPECT_TRUE(stays_sound<T>(*w, 1));
      EXPECT_EQ(w->state(), State::idle);
      EXPECT_EQ(w->supervisor_.state().fault_count, 0u);
    }
  }
}

// [O-Int-2]
TYPED_TEST_P(SafetyStops, WithoutTheHeartbeatOfItsLeaseItComesToRestEverywhere) {
  using T = TypeParam;
  for (const auto& place : places<T>()) {
    if (place.state != State::operational) continue;
    SCOPED_TRACE(place.name);
    const auto w = at<T>(place);
    ASSERT_NE(w, nullptr);
    w->step();
    w->heartbeat_ = false;
    const TimeNs last_ns = w->supervisor_.state().heartbeat_ns;
    w->events.clear();
    const auto released = [&] { return w->supervisor_.state().authority == Name{}; };
    ASSERT_TRUE(w->run_until(released, 3)) << "authority is not released";
    const TimeNs after_ns = w->time_ns_ - last_ns;
    EXPECT_GT(after_ns, kSecond) << "the lease is a second";
    EXPECT_LE(after_ns, kSecond + w->period_ns_);
    EXPECT_NE(w->heard(EventId::lease_expired), nullptr);
    ASSERT_TRUE(w->state() == State::idle || w->run_until(State::idle, T::kRest_s)) << where<T>(*w);
    EXPECT_TRUE(stays_sound<T>(*w, 2));
    EXPECT_EQ(w->supervisor_.state().fault_count, 0u) << "a safe stop is no fault";
  }
}

TYPED_TEST_P(SafetyStops, ACommandWhoseLeaseExpiresHasFailed) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  w->heartbeat_ = false;
  w->run(1.3);
  const Ack* failed = w->answer(static_cast<CommandKind>(T::kMotion.kind), Phase::failed);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->verdict.reason, Reason::lease_expired);
}

TYPED_TEST_P(SafetyStops, OnlyTheHoldersHeartbeatRenewsALease) {
  using T = TypeParam;
  for (const std::uint16_t flags : {std::uint16_t{0}, std::uint16_t{2}}) {  // 2: was "detached"
    const auto w = fresh<T>();
    w->run(1);  // with heartbeats of "test"
    Request start = request_of(*T::logic().command(1), "elsewhere");
    start.flags = flags;
    ASSERT_EQ(answer_to<T>(*w, start).phase, Phase::accepted);
    w->run(0.9);
    EXPECT_EQ(w->supervisor_.state().authority, source("elsewhere"));
    w->run(1);
    EXPECT_EQ(w->supervisor_.state().authority, Name{});
  }
}

// [O-Int-2]
TYPED_TEST_P(SafetyStops, WithoutAnyContactWithTheOBCItIsAnEmergency) {
  using T = TypeParam;
  const auto w = moving<T>({.obc_timeout_ns = 500 * kMillisecond});
  ASSERT_NE(w, nullptr);
  w->heartbeat_ = false;
  const TimeNs last_ns = w->supervisor_.state().contact_ns;
  ASSERT_TRUE(w->run_until(State::fatal_error, 2)) << "nobody is there";
  EXPECT_GT(w->time_ns_ - last_ns, 500 * kMillisecond);
  EXPECT_LE(w->time_ns_ - last_ns, 500 * kMillisecond + w->period_ns_);
  EXPECT_TRUE(stopped<T>(*w));
  EXPECT_TRUE(w->has(FaultId::obc_silent));
  w->heartbeat_ = true;
  EXPECT_TRUE(stays_stopped<T>(*w, 2)) << "also when it is back";
}

// [Oper-5] [P-Int-2]
TYPED_TEST_P(SafetyStops, AnEmergencyStopOfAnyoneIsObeyedInItsFrameEverywhere) {
  using T = TypeParam;
  const auto anyones = [](WorldOf<T>& w) { w.send(CommandKind::emergency_stop, {}, "anyone"); };
  // Behind as many other requests as the queues take, of a stranger and of the holder.
  const auto crowded = [](WorldOf<T>& w) {
    for (std::size_t i = 0; i < 3 * kMaxRequests; ++i) {
      w.send(CommandKind::request_data, {}, "stranger");
      demand_motion<T>(w);
      w.send(CommandKind::stop, {}, "stranger", kFlagDryRun);
    }
    w.send(CommandKind::emergency_stop, {}, "anyone");
    for (std::size_t i = 0; i < kMaxRequests; ++i) demand_motion<T>(w);
  };
  // Nothing in it is looked at but its kind.
  const auto malformed = [](WorldOf<T>& w) {
    Request r{.kind = static_cast<std::uint16_t>(CommandKind::emergency_stop)};
    r.source.fill('\xff');
    r.parameter.fill(kRequired);
    w.put(r);
  };
  const auto together = [](WorldOf<T>& w) {
    w.put(request_of(*T::logic().command(1)));
    w.send(CommandKind::emergency_stop, {}, "anyone");
    w.send(CommandKind::emergency_stop, {}, "another");
    w.put(request_of(*T::logic().command(1)));
  };
  const std::vector<std::function<void(WorldOf<T>&)>> ways = {anyones, crowded, malformed,
                                                              together};
  for (const auto& place : places<T>()) {
    for (std::size_t way = 0; way < ways.size(); ++way) {
      SCOPED_TRACE(place.name + ", way " + std::to_string(way));
      const auto w = at<T>(place);
      ASSERT_NE(w, nullptr);
      ways[way](*w);
      w->step();
      EXPECT_EQ(w->state(), State::fatal_error);
      EXPECT_TRUE(stopped<T>(*w)) << "in the frame that got it";
      EXPECT_TRUE(w->has(FaultId::emergency_stop));
      EXPECT_TRUE(stays_stopped<T>(*w, 1));
    }
  }
}

// [Oper-5]
TYPED_TEST_P(SafetyStops, AfterAnEmergencyStopNothingMovesUntilItIsSolvedAndStarted) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  w->send(CommandKind::emergency_stop);
  w->step();
  for (const CommandInfo& info : commands<T>()) {
    if (!info.leased && info.kind < 100) continue;  // the vehicle's own, and start
    const Request request = request_of(info);
    const auto event = static_cast<std::size_t>(T::logic().event_of(request));
    const Ack ack = answer_to<T>(*w, request);
    EXPECT_TRUE(stopped<T>(*w)) << info.name;
    if (!info.leased && (T::logic().table->rows->from[event] & lc::in(State::fatal_error)) != 0)
      continue;  // it changes what is in service
    EXPECT_EQ(ack.verdict.reason, Reason::not_in_state) << info.name;
  }
  EXPECT_TRUE(stays_stopped<T>(*w, 5));
  ASSERT_TRUE(is_solved<T>(*w));
  EXPECT_TRUE(stays_sound<T>(*w, 2)) << "solved, but not started";
  EXPECT_EQ(answer_to<T>(*w, request_of(*T::logic().command(1))).phase, Phase::accepted);
  w->run(0.5);
  EXPECT_FALSE(T::moves(*w)) << "what moved before does not move again";
  w->send(CommandKind::stop);
  ASSERT_TRUE(w->run_until(State::idle, T::kRest_s));
  EXPECT_TRUE(comes_to_motion<T>(*w));
}

// The command that was being executed ends with the stop.
TYPED_TEST_P(SafetyStops, AnEmergencyStopFailsTheCommandThatRuns) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  w->send(CommandKind::emergency_stop, {}, "anyone");
  w->step();
  const Ack* failed = w->answer(static_cast<CommandKind>(T::kMotion.kind), Phase::failed);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->verdict.reason, Reason::emergency);
  EXPECT_NE(w->answer(CommandKind::emergency_stop, Phase::completed), nullptr);
}

TYPED_TEST_P(SafetyStops, ADryRunSaysWhatWouldHappenAndDoesNothing) {
  using T = TypeParam;
  for (const auto& place : places<T>()) {
    SCOPED_TRACE(place.name);
    const auto twin = at<T>(place), w = at<T>(place);
    ASSERT_TRUE(w != nullptr && twin != nullptr);
    for (const CommandInfo& info : commands<T>()) {
      SCOPED_TRACE(info.name);
      Request r = request_of(info);
      r.flags = kFlagDryRun;
      const Ack ack = answer_to<T>(*w, r);
      twin->step();
      EXPECT_TRUE(ack.phase == Phase::accepted || ack.phase == Phase::rejected);
      EXPECT_EQ(w->supervisor_.controller(), twin->supervisor_.controller());
      EXPECT_EQ(w->out_.command, twin->out_.command);
      EXPECT_EQ(w->supervisor_.state().commands_refused,
                twin->supervisor_.state().commands_refused);
    }
  }
}

TYPED_TEST_P(SafetyStops, ShutDownIsSafeAtOnceEverywhere) {
  using T = TypeParam;
  in_each_place<T>([](WorldOf<T>& w, const auto& place) {
    if (airborne<T>(w)) return;  // it lands first
    w.in_.shut_down = true;
    w.step();
    EXPECT_TRUE(safe<T>(w));
    EXPECT_NE(w.state(), State::operational);
    if (place.state == State::operational) {
      EXPECT_TRUE(stopped<T>(w)) << "of all at once";
    }
  });
}

// [Oper-2]
TYPED_TEST_P(SafetyStops, AResetOfTheControllerEndsSafeEverywhereAndItCanGoOn) {
  using T = TypeParam;
  in_each_place<T>([](WorldOf<T>& w, const auto& place) {
    if (airborne<T>(w)) return;  // it would fall
    w.acks.clear();
    w.send(CommandKind::reset, {-1});
    w.step();
    EXPECT_NE(w.answer(CommandKind::reset, Phase::accepted), nullptr);
    EXPECT_NE(w.answer(CommandKind::reset, Phase::completed), nullptr);
    const bool rests = place.state == State::idle || place.state == State::operational;
    EXPECT_EQ(w.state(), rests ? State::idle : State::fatal_error);
    EXPECT_TRUE(rests ? safe<T>(w) : stopped<T>(w));
    if (place.state == State::solve_errors && faults<T>().front().heal) faults<T>().front().heal(w);
    w.run(2);
    EXPECT_TRUE(recovers<T>(w));
  });
}

// The daemon is started again; the hardware is as it was.
// [Oper-3] [P-Int-2]
TYPED_TEST_P(SafetyStops, ARestartedDaemonBeginsSafeEverywhereAndItCanGoOn) {
  using T = TypeParam;
  in_each_place<T>([](WorldOf<T>& w, const auto&) {
    w.restart(T::parameters());
    w.step();
    EXPECT_EQ(w.state(), State::idle);
    EXPECT_TRUE(safe<T>(w)) << "in its first frame";
    EXPECT_TRUE(stays_sound<T>(w, 2));
    EXPECT_EQ(w.supervisor_.state().authority, Name{});
    if (faults<T>().front().heal) faults<T>().front().heal(w);
    w.run(5);
    EXPECT_TRUE(comes_to_motion<T>(w));
  });
}

// [Oper-1]
TYPED_TEST_P(SafetyStops, EveryCommandIsAnsweredEverywhereAndNoneEndsTheListening) {
  using T = TypeParam;
  for (const auto& place : places<T>()) {
    for (const CommandInfo& info : commands<T>()) {
      SCOPED_TRACE(place.name + ", " + info.name);
      const auto w = at<T>(place);
      ASSERT_NE(w, nullptr);
      const Ack ack = answer_to<T>(*w, request_of(info));
      EXPECT_TRUE(ack.phase == Phase::accepted || ack.phase == Phase::rejected);
      if (ack.phase == Phase::rejected) {
        EXPECT_NE(ack.verdict.reason, Reason::none);
      }
      EXPECT_TRUE(stays_sound<T>(*w, 5));
      w->acks.clear();
      w->send(CommandKind::request_data, {}, "anyone");
      w->step();
      EXPECT_TRUE(w->out_.data_requested);
      EXPECT_NE(w->answer(CommandKind::request_data, Phase::completed), nullptr);
    }
  }
}

TYPED_TEST_P(SafetyStops, AStartIsAnsweredAcceptedExecutingAndCompleted) {
  using T = TypeParam;
  const auto w = rested<T>();
  w->put(request_of(*T::logic().command(1)));
  ASSERT_TRUE(
      w->run_until([&] { return w->answer(CommandKind::start, Phase::completed) != nullptr; }, 30));
  std::vector<Phase> phases;
  for (const Ack& ack : w->acks) {
    if (ack.kind == 1) phases.push_back(ack.phase);
  }
  EXPECT_EQ(phases, (std::vector{Phase::accepted, Phase::executing, Phase::completed}));
}

TYPED_TEST_P(SafetyStops, ANewCommandSupersedesTheRunningOne) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  w->acks.clear();
  w->send(CommandKind::stop);
  w->step();
  const Ack* superseded = w->last(Phase::superseded);
  ASSERT_NE(superseded, nullptr);
  EXPECT_EQ(superseded->kind, T::kMotion.kind);
}

// Reports about a slow machine must not slow it down further.
TYPED_TEST_P(SafetyStops, LateCommandsAreReportedNowAndThenAndNoneIsForgotten) {
  using T = TypeParam;
  const auto w = rested<T>();
  const auto told = [&] {
    std::vector<double> counts;
    for (const EventRecord& event : w->events) {
      if (event.id == static_cast<std::uint16_t>(EventId::frame_late))
        counts.push_back(event.argument[0]);
    }
    return counts;
  };
  w->in_.late_commands = 1;
  w->step();
  EXPECT_EQ(told(), std::vector<double>{1});
  for (const TimeNs end = w->time_ns_ + 2 * kSecond; w->time_ns_ < end; w->step())
    ++w->in_.late_commands;
  const auto late = static_cast<double>(w->in_.late_commands);
  EXPECT_EQ(told().size(), 2u) << "again after a second";
  EXPECT_EQ(w->supervisor_.state().late_commands, w->in_.late_commands);
  w->run(10);
  ASSERT_EQ(told().size(), 3u) << "and two seconds later";
  EXPECT_EQ(told().back(), late) << "the rest, once, when it is time";
}

// A late client gets the last events of each kind and module: what repeats replaces only itself,
// and a live one sees few of it.
TYPED_TEST_P(SafetyStops, AFloodOfConsequencesDoesNotHideItsCause) {
  using T = TypeParam;
  const auto flooded = [] {
    auto w = fresh<T>();
    w->run(1);
    w->events.clear();
    w->send(CommandKind::emergency_stop);
    w->step();
    EXPECT_EQ(w->state(), State::fatal_error);
    w->executed = [&] {
      for (std::uint16_t i = 0; i < 3; ++i) w->supervisor_.note(EventId::module_was_reset, 1);
    };
    for (const TimeNs end = w->time_ns_ + 120 * kSecond; w->time_ns_ < end; w->step())
      ++w->in_.late_commands;
    w->executed = {};
    return w;
  };
  const auto w = flooded();
  const auto late = static_cast<std::uint32_t>(w->in_.late_commands);
  w->run(61);
  const auto last = [&](EventId id) { return w->heard(id); };
  ASSERT_NE(last(EventId::frame_late), nullptr);
  EXPECT_EQ(last(EventId::frame_late)->count, late);
  ASSERT_NE(last(EventId::module_was_reset), nullptr);
  EXPECT_EQ(last(EventId::module_was_reset)->count, 3 * late);
  EXPECT_LT(w->events.size(), 40u);
  const auto of = [&](std::uint16_t id) {
    return std::ranges::count_if(w->events, [&](const EventRecord& e) { return e.id == id; });
  };
  EXPECT_EQ(of(kFaultEventBase + static_cast<std::uint16_t>(FaultId::emergency_stop)), 1);
  EXPECT_EQ(of(static_cast<std::uint16_t>(EventId::state_changed)), 1);

  const auto again = flooded();
  again->run(61);
  ASSERT_EQ(again->events.size(), w->events.size());
  for (std::size_t i = 0; i < w->events.size(); ++i) {
    EXPECT_EQ(again->events[i].time_ns, w->events[i].time_ns);
    EXPECT_EQ(again->events[i].id, w->events[i].id);
    EXPECT_EQ(again->events[i].count, w->events[i].count);
  }
}

REGISTER_TYPED_TEST_SUITE_P(
    SafetyStops, BootsSafeAndStaysSoUntilItIsStarted,
    ASecondSourceIsRefusedWhileTheFirstHasAuthority, TheCycleItselfRefusesASecondSource,
    AuthorityIsFreeAfterAStop, AStopEndsIdleAndSafeEverywhere,
    WithoutTheHeartbeatOfItsLeaseItComesToRestEverywhere, ACommandWhoseLeaseExpiresHasFailed,
    OnlyTheHoldersHeartbeatRenewsALease, WithoutAnyContactWithTheOBCItIsAnEmergency,
    AnEmergencyStopOfAnyoneIsObeyedInItsFrameEverywhere,
    AfterAnEmergencyStopNothingMovesUntilItIsSolvedAndStarted,
    AnEmergencyStopFailsTheCommandThatRuns, ADryRunSaysWhatWouldHappenAndDoesNothing,
    ShutDownIsSafeAtOnceEverywhere, AResetOfTheControllerEndsSafeEverywhereAndItCanGoOn,
    ARestartedDaemonBeginsSafeEverywhereAndItCanGoOn,
    EveryCommandIsAnsweredEverywhereAndNoneEndsTheListening,
    AStartIsAnsweredAcceptedExecutingAndCompleted, ANewCommandSupersedesTheRunningOne,
    LateCommandsAreReportedNowAndThenAndNoneIsForgotten, AFloodOfConsequencesDoesNotHideItsCause);

}  // namespace lss::safety
