#include "daemon/runtime/command_port.h"

#include <algorithm>

namespace lss {
namespace {

bool stopped_by_command(const SupervisorState& state) noexcept {
  return state.controller.state == State::fatal_error &&
         std::ranges::any_of(state.faults, [](const FaultRecord& fault) {
           return fault.id == FaultId::emergency_stop;
         });
}

}  // namespace

void CommandPort::receive(Request request, std::uint64_t writer, const Answer& answer) {
  const auto say = [&](Phase phase, const Verdict& verdict = {}) {
    answer({.source = request.source,
            .sequence = request.sequence,
            .kind = request.kind,
            .phase = phase,
            .verdict = verdict,
            .time_ns = request.arrival_ns});
  };
  const auto refuse = [&](const Verdict& verdict) {
    if (request.kind == 0) return;  // heartbeats are not answered
    // A dry run is answered, not counted.
    if ((request.flags & kFlagDryRun) == 0) refused_.fetch_add(1, std::memory_order_relaxed);
    say(Phase::rejected, verdict);
  };

  if (is_emergency_stop(request)) return emergency_stop(request, answer);
  state_.update();
  if (const Verdict v = armour_.check(request, writer, state_.value().authority);
      v.reason != Reason::none)
    return refuse(v);
  if (request.kind == 0) return heartbeat(request);
  // While other commands wait for their frame, and for commands that the vehicle itself considers,
  // the frame judges. Else the newest state is the present one, and the answer needs no frame.
  if (is_newest()) {
    if (const Verdict v = Supervisor::evaluate(logic_, state_.value(), request);
        v.reason != Reason::none)
      return refuse(v);
    const bool considered =
        request.kind == static_cast<std::uint16_t>(CommandKind::set_parameter) ||
        (logic_.considered != nullptr && logic_.considered(request.kind));
    if (!considered) {
      say(Phase::accepted);
      if (request.flags & kFlagDryRun) return;
      request.acknowledged = true;
    }
  }
  if (put(request)) {
    ++commands_;
  } else if (!request.acknowledged) {
    refuse({.reason = Reason::busy});
  } else {
    refused_.fetch_add(1, std::memory_order_relaxed);
    say(Phase::failed, {.reason = Reason::busy});
  }
}

// Authority, form and number are not checked.
void CommandPort::emergency_stop(Request request, const Answer& answer) {
  const auto say = [&](Phase phase) {
    answer({.source = request.source,
            .sequence = request.sequence,
            .kind = request.kind,
            .phase = phase,
            .time_ns = request.arrival_ns});
  };
  if ((request.flags & kFlagDryRun) != 0) return say(Phase::accepted);
  if (stop_now_) stop_now_();
  say(Phase::accepted);
  request.acknowledged = true;
  // A repeated stop of a stopped vehicle is answered at once.
  if (stopped_by_command(state_.get())) {
    say(Phase::completed);
    request.answered = true;
  }
  const std::uint64_t replaced = newest_stop_.replaced();
  newest_stop_.put(request);
  stop_ns_ = request.arrival_ns;
  const Request before = std::exchange(last_stop_, request);
  // The frame has not read the one before: it ends behind the newest, or here, among so many.
  if (newest_stop_.replaced() != replaced && !before.answered && !stops_.push(before)) {
    answer({.source = before.source,
            .sequence = before.sequence,
            .kind = before.kind,
            .phase = Phase::superseded,
            .verdict = {.reason = Reason::superseded},
            .time_ns = request.arrival_ns});
  }
}

void CommandPort::heartbeat(const Request& request) noexcept {
  const auto note = [&](Beat& beat) {
    beat = {.source = request.source, .arrival_ns = request.arrival_ns, .count = beat.count + 1};
  };
  if ((request.flags & kFlagAnotherDaemon) != 0) {
    note(beats_.another_daemon);
  } else {
    const bool holder = request.source == state_.value().authority;
    note(holder ? beats_.holder : beats_.anyone);
  }
  newest_beats_.put(beats_);
}

bool CommandPort::put(const Request& request) noexcept {
  const bool holder = request.source == state_.value().authority;
  const auto into = [&](auto& queue, std::size_t holders_only) {
    return (holder || queue.room() > holders_only) && queue.push(request);
  };
  const CommandInfo* info = logic_.command(request.kind);
  return info != nullptr && info->ends_motion ? into(ending_, kEnding / 2)
                                              : into(queue_, kQueue / 4);
}

bool CommandPort::is_newest() const noexcept {
  const SupervisorState& state = state_.value();
  return state.commands_taken == commands_ && state.ended_ns >= stop_ns_;
}

std::uint32_t CommandPort::take(std::span<Request> out) noexcept {
  std::uint32_t count = 0;
  // Counted before the stops are read: no command is given before a stop that was received first.
  const std::size_t ending = ending_.waiting(), queued = queue_.waiting();
  const auto pop = [&](auto& queue, std::size_t most) {
    for (; most > 0 && count < out.size() && queue.pop(out[count]); --most) ++count;
  };
  if (newest_stop_.update()) out[count++] = newest_stop_.value();
  if (newest_beats_.update()) {
    const Beats& now = newest_beats_.value();
    const auto add = [&](const Beat& beat, std::uint64_t& taken, std::uint16_t flags) {
      if (beat.count == std::exchange(taken, beat.count)) return;
      out[count++] = {.source = beat.source, .flags = flags, .arrival_ns = beat.arrival_ns};
    };
    add(now.anyone, beats_taken_[0], 0);
    add(now.holder, beats_taken_[1], 0);
    add(now.another_daemon, beats_taken_[2], kFlagAnotherDaemon);
  }
  pop(stops_, kStops);
  pop(ending_, ending);
  pop(queue_, queued);
  return count;
}

}  // namespace lss
