#include "daemon/cycle/supervisor.h"

#include <algorithm>
#include <utility>

#include "daemon/cycle/common_commands.h"
#include "daemon/cycle/subjects.h"

namespace lss {
namespace {

// An unknown fault is fatal.
template <class Id>
Severity severity_of(Id id, const OwnCodes& own) noexcept {
  const CodeInfo* code = info(id, own);
  return code != nullptr ? static_cast<Severity>(code->severity) : Severity::fatal;
}

bool held_by_another(const SupervisorState& s, const Name& source) noexcept {
  return s.authority.front() != '\0' && s.authority != source;
}

int tunable_of(const Logic& logic, const Request& request) noexcept {
  return find_tunable(logic.tunables, {request.name.data(), request.name.size()});
}

// All checks except against the values of other parameters, which the vehicle does.
Verdict check_parameter(const Logic& logic, const SupervisorState& s, const Request& r) noexcept {
  if (r.kind != kind_of(CommandKind::set_parameter)) return {};
  const int index = tunable_of(logic, r);
  if (index < 0) return {.reason = Reason::no_such_parameter};
  const TunableInfo& t = logic.tunables[static_cast<std::size_t>(index)];
  const auto subject = static_cast<std::uint16_t>(index + 1);
  const double value = arguments<SetParameter>(r).value;
  if (!(value >= t.min && value <= t.max)) {
    return {.reason = Reason::parameter_range,
            .measured = value,
            .limit = value < t.min ? t.min : t.max,
            .subject = subject};
  }
  if (!in_range(t, value))
    return {.reason = Reason::parameter_whole, .measured = value, .subject = subject};
  const bool rests = s.controller.state == State::idle || s.controller.state == State::fatal_error;
  if (t.change == Change::at_rest && !rests)
    return {.reason = Reason::not_in_state, .measured = static_cast<double>(s.controller.state)};
  return {};
}

}  // namespace

const CommandInfo* Logic::command(std::uint16_t kind) const noexcept {
  return find_command(commands, kind);
}

Verdict Supervisor::evaluate(const Logic& logic, const SupervisorState& state,
                             const Request& request) noexcept {
  const CommandInfo* info = logic.command(request.kind);
  if (info == nullptr)
    return {.reason = Reason::unknown_command, .measured = static_cast<double>(request.kind)};
  if (info->access == Access::holder && held_by_another(state, request.source)) {
    return {.reason = Reason::not_authorised};
  }
  // It was received before a stop that was obeyed already.
  if (request.arrival_ns < state.ended_ns && info->access == Access::holder && !info->ends_motion &&
      !is_beside(request.kind))
    return {.reason = Reason::superseded};
  if (request.kind == kind_of(CommandKind::start) && state.another_daemon_ns != 0) {
    return {
        .reason = Reason::name_conflict,
        .measured = static_cast<double>((state.time_ns - state.another_daemon_ns) / kMillisecond),
        .limit = static_cast<double>(kGoneAfter / kMillisecond)};
  }
  if (is_of_parameters(request.kind)) return check_parameter(logic, state, request);
  lc::ControllerState controller = state.controller;
  controller.links = static_cast<std::uint8_t>(controller.links & ~lc::kObcSilent);  // present
  // Modules in reset do not answer.
  controller.silent = static_cast<std::uint16_t>(
      controller.silent | (state.resetting & ~static_cast<unsigned>(controller.isolated)));
  Verdict verdict =
      lc::step(*logic.table, controller, logic.event_of(request), logic.subject_of(request))
          .verdict;
  if (verdict.subject != 0 && verdict.reason == Reason::module_silent) {
    verdict.measured = static_cast<double>(state.age_ms[verdict.subject - 1u]);
    verdict.limit = static_cast<double>(state.silent_limit_ms);
  }
  if (verdict.reason == Reason::never_heard &&
      (static_cast<unsigned>(state.unfit) >> (verdict.subject - 1u) & 1u) != 0)
    verdict.reason = Reason::not_configured;
  return verdict.reason == Reason::none ? logic.sense(state, request) : verdict;
}

void Supervisor::begin(TimeNs now, Actor& actor) noexcept {
  state_.time_ns = now;
  actor_ = &actor;
  outbox_.ack_count = outbox_.event_count = outbox_.dropped = 0;
  outbox_.holder = state_.active.kind != 0 ? state_.active.source : state_.authority;
  save_ = {};
  fell_ = false;
  series_.report_due(now, [this](const EventRecord& event) { put(event); });
}

void Supervisor::request(const Request& request) noexcept {
  if ((request.flags & kFlagAnotherDaemon) != 0) return another_daemon();
  if (request.kind == 0) return heartbeat(request);
  const bool stop = is_emergency_stop(request);
  if (!stop && (request.flags & kFlagSaved) == 0) ++state_.commands_taken;
  command(request);
}

void Supervisor::heartbeat(const Request& request) noexcept {
  state_.contact_ns = state_.time_ns;
  if (state_.controller.links & lc::kObcSilent) happen(lc::Event::obc_heard);
  if (request.source == state_.authority) state_.heartbeat_ns = state_.time_ns;
}

// Both daemons obey commands for either, and each renews the other's lease: this one stops as
// without a lease, and does not start while the other is there.
void Supervisor::another_daemon() noexcept {
  const bool known = std::exchange(state_.another_daemon_ns, state_.time_ns) != 0;
  if (known) return;
  latch(FaultId::name_conflict);
  if (state_.controller.state == State::operational) stop_safely(Reason::name_conflict);
}

// As without a lease. A command that already leads to a stop goes on to its end.
void Supervisor::stop_safely(Reason reason) noexcept {
  const CommandInfo* active = logic_.command(state_.active.kind);  // none: 0, or damaged memory
  if (active != nullptr && active->leased) finish(Phase::failed, reason);
  happen(lc::Event::lease_expired);
}

void Supervisor::check_name() noexcept {
  if (state_.another_daemon_ns == 0 || state_.time_ns - state_.another_daemon_ns <= kGoneAfter)
    return;
  state_.another_daemon_ns = 0;
  clear(FaultId::name_conflict);
}

// Guards on the state, then those of the vehicle.
Verdict Supervisor::judge(const Request& request) noexcept {
  if (const Verdict v = evaluate(logic_, state_, request); v.reason != Reason::none) return v;
  if (request.kind == kind_of(CommandKind::set_parameter)) return adjust(request, false).verdict;
  if (request.kind == kind_of(CommandKind::save_parameters))
    return save_.kind == 0 ? Verdict{} : Verdict{.reason = Reason::busy};
  return actor_->consider(request);
}

// Of a request that evaluate() let pass.
Adjusted Supervisor::adjust(const Request& request, bool really) noexcept {
  return actor_->adjust(static_cast<std::size_t>(tunable_of(logic_, request)),
                        arguments<SetParameter>(request).value, really);
}

// A change is in force in this frame; a save is answered when it is on the disk.
bool Supervisor::handle_parameters(const Request& request, const Active& command) noexcept {
  if (!is_of_parameters(request.kind)) return false;
  if (request.kind == kind_of(CommandKind::save_parameters)) {
    save_ = command;
    return true;
  }
  const Adjusted adjusted = adjust(request, true);
  note(EventId::parameter_changed, 0, tunable_of(logic_, request) + 1, adjusted.before,
       arguments<SetParameter>(request).value);
  acknowledge(command, Phase::completed);
  return true;
}

void Supervisor::command(const Request& request) noexcept {
  const Active command{
      .source = request.source, .sequence = request.sequence, .kind = request.kind};
  const Verdict verdict = judge(request);
  if (verdict.reason != Reason::none) {
    if ((request.flags & kFlagDryRun) == 0) {
      ++state_.commands_refused;
      // The subject of an event is a module; the answer names an argument, a parameter or a step.
      const bool module = subject_is(verdict.reason) == SubjectIs::module;
      const std::uint16_t subject =
          module && !is_of_parameters(request.kind) ? verdict.subject : std::uint16_t{0};
      note(EventId::command_rejected, subject, request.kind, static_cast<double>(verdict.reason));
    }
    acknowledge(command, request.acknowledged ? Phase::failed : Phase::rejected, verdict);
    return;
  }
  if ((request.flags & kFlagSaved) == 0) heartbeat(request);
  if (!request.acknowledged) acknowledge(command, Phase::accepted);
  if (request.flags & kFlagDryRun) return;

  const CommandInfo& info = *logic_.command(request.kind);
  const bool replaces =
      !is_beside(request.kind) && (info.access == Access::holder || !done_at_once(request.kind));
  if (info.ends_motion) state_.ended_ns = std::max(state_.ended_ns, request.arrival_ns);
  if (replaces && state_.active.kind != 0) finish(Phase::superseded, Reason::superseded);
  if (info.leased) take_authority(request);
  if (replaces) state_.active = command;
  if (!request.answered) acknowledge(command, Phase::executing);
  if (handle_parameters(request, command)) return;
  const bool emergency_stop = is_emergency_stop(request);
  fell_ = fell_ || (emergency_stop && airborne());  // by one of the stops of this frame
  if (emergency_stop) raise(FaultId::emergency_stop);
  if (request.kind == kind_of(CommandKind::reset_timing)) note(EventId::timing_reset);
  const lc::Event event = logic_.event_of(request);
  const bool waits = event == lc::Event::reset_module;
  if (waits) begin_reset(request, command);
  apply(event, &request, logic_.subject_of(request));
  if (!replaces && !waits && !request.answered)
    acknowledge(command, Phase::completed,
                {.reason = emergency_stop && fell_ ? Reason::fell : Reason::none});
}

// Completed when its modules are back. Only one at a time; modules of an earlier one are still
// expected to be silent.
void Supervisor::begin_reset(const Request& request, const Active& command) noexcept {
  end_reset(Phase::superseded, {.reason = Reason::superseded});
  const int module = arguments<Reset>(request).module;
  reset_ = command;
  reset_modules_ = static_cast<std::uint16_t>(module == 0 ? 0xFFFFu : 1u << (module - 1));
  state_.resetting = static_cast<std::uint16_t>(state_.resetting | reset_modules_);
}

void Supervisor::end_reset(Phase phase, const Verdict& verdict) noexcept {
  if (reset_.kind != 0) acknowledge(reset_, phase, verdict);
  reset_ = {};
}

void Supervisor::reset_failed(Reason reason, std::uint16_t module) noexcept {
  if ((static_cast<unsigned>(reset_modules_) >> (module - 1u) & 1u) == 0) return;
  Verdict verdict{.reason = reason, .subject = module};
  if (reason == Reason::module_silent) {
    verdict.measured = static_cast<double>(state_.age_ms[module - 1u]);
    verdict.limit = static_cast<double>(state_.silent_limit_ms);
  }
  end_reset(Phase::failed, verdict);
}

Verdict Supervisor::happen(lc::Event event, unsigned subject) noexcept {
  return apply(event, nullptr, subject);
}

Verdict Supervisor::apply(lc::Event event, const Request* request, unsigned subject) noexcept {
  const lc::ControllerState before = state_.controller;
  const lc::Result result = lc::step(*logic_.table, before, event, subject);
  if (result.row < 0) return result.verdict;
  state_.controller = result.next;
  if (result.actions & lc::kClearFaults) {
    // Warnings clear by themselves when their cause is gone.
    for (const FaultRecord& fault : std::array(state_.faults)) {
      if (fault.id != FaultId::none && fatal(fault.id)) clear(fault.id, fault.subject);
    }
  }
  const unsigned changed = before.isolated ^ result.next.isolated;
  for (std::uint16_t i = 0; changed >> i != 0; ++i) {
    const bool gone = (result.next.isolated >> i & 1u) != 0;
    if ((changed >> i & 1u) != 0)
      note(gone ? EventId::module_isolated : EventId::modules_restored,
           static_cast<std::uint16_t>(i + 1));
  }
  if (result.actions & lc::kIsolate) {
    for (const FaultRecord& fault : std::array(state_.faults)) {
      if (fault.id != FaultId::none && fault.subject == subject) clear(fault.id, fault.subject);
    }
  }
  if (result.actions != 0) actor_->act(result.actions, request);
  // A command that a reset of the controller ends in Idle would look completed.
  if (event == lc::Event::reset_controller && before.state == State::idle &&
      state_.active.kind != 0 && state_.active.kind != kind_of(CommandKind::stop))
    finish(Phase::superseded, Reason::superseded);
  follow(before);
  return result.verdict;
}

// Consequences of a change of state for the events and for the command being executed.
void Supervisor::follow(const lc::ControllerState& before) noexcept {
  const lc::ControllerState& now = state_.controller;
  if (now.state != before.state) {
    note(EventId::state_changed, 0, static_cast<double>(before.state),
         static_cast<double>(now.state));
  }
  if (now.mode != before.mode) note(EventId::mode_changed, 0, before.mode, now.mode);
  if (!(now.links & lc::kHeld) && state_.authority.front() != '\0') {
    note(EventId::authority_released);
    state_.authority = {};
  }
  if (state_.active.kind == 0) return;
  const bool stop = state_.active.kind == kind_of(CommandKind::stop);
  const bool unsolved = now.state == State::fatal_error && before.state == State::solve_errors;
  // A stop that breaks error solving off has stopped everything.
  if (logic_.reached(state_.active.kind, state_) || (unsolved && stop)) {
    finish(Phase::completed);
  } else if (unsolved) {
    finish(Phase::failed, Reason::not_solved);
  } else if (now.state == State::fatal_error) {
    finish(Phase::failed, Reason::emergency);
  } else if (now.state == State::idle && before.state == State::operational && !stop) {
    finish(Phase::superseded, Reason::superseded);
  }
}

bool Supervisor::fatal(FaultId id) const noexcept {
  return severity_of(id, logic_.codes) == Severity::fatal;
}

void Supervisor::raise(FaultId id, std::uint16_t subject, double measured, double limit) noexcept {
  latch(id, subject, measured, limit);
  if (fatal(id) && !airborne()) happen(lc::Event::emergency);
}

// Faults raised in the air. Otherwise no fatal fault is latched in these states.
void Supervisor::stop_after_landing() noexcept {
  const State state = state_.controller.state;
  if (logic_.airborne == nullptr || airborne()) return;
  if (state != State::idle && state != State::operational) return;
  for (const FaultRecord& fault : state_.faults) {
    if (fault.id != FaultId::none && fatal(fault.id)) return void(happen(lc::Event::emergency));
  }
}

void Supervisor::latch(FaultId id, std::uint16_t subject, double measured, double limit) noexcept {
  FaultRecord* fault = find(id, subject);
  if (fault == nullptr) {
    report(fatal(id) ? Severity::fatal : Severity::warning,
           static_cast<std::uint16_t>(static_cast<std::uint16_t>(id) + kFaultEventBase), subject,
           {measured, limit});
    if (state_.fault_count <= kMaxFaults) ++state_.fault_count;
    fault = place_of(id);
    if (fault == nullptr) return;
    *fault = {.id = id, .subject = subject, .count = 0, .since_ns = state_.time_ns};
  }
  ++fault->count;
}

// Where a new fault is kept: a fatal one that does not fit replaces one that is not. nullptr:
// nowhere.
FaultRecord* Supervisor::place_of(FaultId id) noexcept {
  FaultRecord* const empty = find(FaultId::none, 0);
  if (empty != nullptr || !fatal(id)) return empty;
  const auto lesser =
      std::ranges::find_if(state_.faults, [&](const FaultRecord& f) { return !fatal(f.id); });
  return lesser != state_.faults.end() ? &*lesser : nullptr;
}

// Those that do not fit are forgotten with the first that is cleared.
void Supervisor::clear(FaultId id, std::uint16_t subject) noexcept {
  FaultRecord* fault = find(id, subject);
  if (fault == nullptr) return;
  *fault = {};
  state_.fault_count = std::min<std::uint32_t>(state_.fault_count, kMaxFaults) - 1;
  note(EventId::fault_cleared, subject, static_cast<double>(id));
}

FaultRecord* Supervisor::find(FaultId id, std::uint16_t subject) noexcept {
  for (FaultRecord& fault : state_.faults) {
    if (fault.id == id && fault.subject == subject) return &fault;
  }
  return nullptr;
}

void Supervisor::check_links() noexcept {
  // A report of the vehicle may complete the running command.
  if (state_.active.kind != 0 && logic_.reached(state_.active.kind, state_))
    finish(Phase::completed);
  if ((state_.resetting & reset_modules_) == 0) end_reset(Phase::completed);
  const std::uint8_t links = state_.controller.links;
  if ((links & lc::kHeld) && state_.time_ns - state_.heartbeat_ns > state_.lease_ns) {
    note(EventId::lease_expired, 0,
         static_cast<double>(state_.time_ns - state_.heartbeat_ns) * 1e-6);
    stop_safely(Reason::lease_expired);
  }
  check_obc();
  check_name();
  stop_after_landing();
}

void Supervisor::shut_down() noexcept {
  series_.report_all([this](const EventRecord& event) { put(event); });
  // In the air the safe command would make it fall.
  happen(airborne() ? lc::Event::lease_expired : lc::Event::reset_controller);
}

void Supervisor::check_obc() noexcept {
  if ((state_.controller.links & lc::kObcSilent) ||
      state_.time_ns - state_.contact_ns <= parameters_.obc_timeout_ns)
    return;
  if (airborne()) {  // the same as without a lease: it lands
    happen(lc::Event::lease_expired);
    return;
  }
  const bool operational = state_.controller.state == State::operational;
  happen(lc::Event::obc_silent);
  if (operational) raise(FaultId::obc_silent);
}

void Supervisor::abandon(Reason reason) noexcept {
  if (state_.active.kind != 0) finish(Phase::failed, reason);
}

void Supervisor::count_late(std::uint64_t late) noexcept {
  if (std::exchange(state_.late_commands, late) == late) return;
  note(EventId::frame_late, 0, static_cast<double>(late));
}

void Supervisor::check_memory(MemoryCheck memory) noexcept {
  if (memory == MemoryCheck::corrected) note(EventId::memory_corrected);
  if (memory != MemoryCheck::lost) return;
  raise(FaultId::memory_lost);
  if (airborne()) stop_safely(Reason::emergency);  // it lands
}

void Supervisor::check_stop(bool pending) noexcept {
  constexpr int kFramesToFollow = 2;
  const bool followed = state_.controller.state == State::fatal_error;
  unfollowed_frames_ = pending && !followed ? unfollowed_frames_ + 1 : 0;
  if (unfollowed_frames_ <= kFramesToFollow) return;
  latch(FaultId::stop_not_followed);
  happen(lc::Event::emergency);  // also in the air: no command passes any more
}

void Supervisor::gate_closed(double check) noexcept {
  ++state_.safe_commands;
  note(EventId::gate_closed, 0, check);
  raise(FaultId::gate_closed);
}

void Supervisor::set_ages(const std::array<std::int64_t, kMaxModules>& age_ms,
                          std::int64_t limit_ms) noexcept {
  state_.age_ms = age_ms;
  state_.silent_limit_ms = limit_ms;
}

void Supervisor::take_authority(const Request& request) noexcept {
  if (state_.authority.front() == '\0') note(EventId::authority_taken);
  state_.authority = request.source;
  state_.lease_ns = static_cast<TimeNs>(request.lease_ms) * kMillisecond;
  state_.heartbeat_ns = state_.time_ns;
}

void Supervisor::finish(Phase phase, Reason reason) noexcept {
  const Active command = state_.active;
  state_.active = {};
  acknowledge(command, phase, {.reason = reason});
}

void Supervisor::acknowledge(const Active& command, Phase phase, const Verdict& verdict) noexcept {
  if (outbox_.ack_count == kMaxAcks) {
    ++outbox_.dropped;
    return;
  }
  outbox_.acks[outbox_.ack_count++] = {.source = command.source,
                                       .sequence = command.sequence,
                                       .kind = command.kind,
                                       .phase = phase,
                                       .verdict = verdict,
                                       .time_ns = state_.time_ns};
}

void Supervisor::note(EventId id, std::uint16_t subject, double a, double b, double c,
                      double d) noexcept {
  report(severity_of(id, logic_.codes), static_cast<std::uint16_t>(id), subject, {a, b, c, d});
}

void Supervisor::report(Severity severity, std::uint16_t id, std::uint16_t subject,
                        const std::array<double, 4>& argument) noexcept {
  series_.add({.time_ns = state_.time_ns,
               .severity = severity,
               .id = id,
               .subject = subject,
               .argument = argument},
              [this](const EventRecord& event) { put(event); });
}

void Supervisor::put(const EventRecord& event) noexcept {
  if (outbox_.event_count == kMaxEvents) {
    ++outbox_.dropped;
    return;
  }
  outbox_.events[outbox_.event_count++] = event;
}

}  // namespace lss
