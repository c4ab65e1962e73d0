#include "daemon/core/command_port.h"

namespace lss {

void CommandPort::receive(Request request, const Answer& answer) {
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
    // Who only asks is answered, not counted.
    if ((request.flags & kFlagDryRun) == 0) refused_.fetch_add(1, std::memory_order_relaxed);
    say(Phase::rejected, verdict);
  };

  if (const Verdict v = armour_.check(request); v.reason != Reason::none) return refuse(v);
  if (stop_now_ && (request.flags & kFlagDryRun) == 0 &&
      request.kind == static_cast<std::uint16_t>(CommandKind::emergency_stop))
    stop_now_();
  // A heartbeat, a command while others wait for their frame, and one that the vehicle itself has
  // to look at is for the frame to judge. Else the newest state is the present one, and the answer
  // needs no frame.
  if (request.kind != 0 && state_.get().commands_taken == pushed_) {
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
  if (!queue_.push(request)) {
    if (request.kind == 0) return;
    if (!request.acknowledged) return refuse({.reason = Reason::busy});
    refused_.fetch_add(1, std::memory_order_relaxed);
    return say(Phase::failed, {.reason = Reason::busy});
  }
  if (request.kind != 0) ++pushed_;
}

}  // namespace lss
