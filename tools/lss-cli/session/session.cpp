#include "tools/lss-cli/session/session.h"

#include <fmt/format.h>

#include "idl/codes.h"
#include "tools/lss-cli/session/ack.h"
#include "tools/lss-cli/session/answer.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli {
namespace {

constexpr double kBeat_s = 0.2;
constexpr double kProgress_s = 0.1;
constexpr double kLook_s = 0.1;  // for an answer that is late
constexpr double kTelemetryComes_s = 0.5, kTelemetryAsked_s = 3;
constexpr std::size_t kAtOnce = 8;  // half of the topic's history

// Motion detached from one lss-cli belongs to every lss-cli.
std::string source_name(const Options& options, const Link& link, const lss_Status& status) {
  if (!options.source.empty()) return options.source;
  if (options.detach || text(status.authority) == link.own_name()) return link.own_name();
  return link.own_source();
}

std::string end_by_lease(const Options& options) {
  return fmt::format("without a heartbeat the daemon stops the vehicle in {}",
                     format_duration(options.lease_ms / 1000.0));
}

// The command that ends another source's motion. In the air an emergency stop lets the vehicle
// fall.
std::string ending_by_anyone(const lss_Status& status) {
  const std::string stop = fmt::format("lss-cli estop {}", text(status.vehicle_id));
  if (!status.airborne) return stop;
  return status.stop_in_flight == lss_STOP_LANDS
             ? fmt::format("lss-cli land ({} lets it fall)", stop)
             : stop + " (it falls)";
}

bool is_accepted(const Sent& sent) { return sent.answered && sent.ack.phase != lss_PHASE_REJECTED; }
bool is_begun(const Sent& sent) { return sent.executing || sent.ack.phase == lss_PHASE_COMPLETED; }
bool is_completed(const Sent& sent) { return sent.ack.phase == lss_PHASE_COMPLETED; }

}  // namespace

Session::Session(Link& link, Output& output, const Options& options)
    : link_(link), output_(output), options_(options) {}

void Session::take_part(const std::string& folder) {
  if (options_.source.empty()) options_.source = link_.own_name();
  open();
  link_.take_part(folder);
}

void Session::beat() {
  if (options_.source.empty()) options_.source = link_.own_name();
  beating_ = true;
}

void Session::open() { link_.open_commands(source_name(options_, link_, link_.status())); }

Sent& Session::submit(const Invocation& command, std::uint16_t flags, bool quiet) {
  open();
  // A stop also needs the lease until it is completed.
  const bool acts = (flags & kFlagDryRun) == 0 && command.info->access == Access::holder;
  if (acts) check_name(command);
  beating_ = beating_ || acts;
  attached_ = attached_ || (acts && command.info->leased);
  Sent& sent = (quiet ? quiet_ : sent_).emplace_back();
  sent.command = command;
  sent.sent = Clock::now();
  sent.sent_ns = link_.status().time_ns;
  sent.seq = link_.send(command, flags);
  return sent;
}

// Before any motion: checks that this is the intended vehicle, and the only one of its name.
void Session::check_name(const Invocation& command) {
  if (!beating_) link_.check_meant();
  const std::optional<Problem> conflict = name_conflict(link_.status(), link_.instances());
  if (!conflict) return;
  if (command.info->leased) throw Failure(ExitCode::rejected, conflict->text, conflict->advice);
  if (!warned_) output_.note("warning: " + conflict->text);
  warned_ = true;
}

void Session::await(Sent& sent, const char* phase, bool (*done)(const Sent&), double takes_s) {
  const double longest_s = options_.finish_timeout_s(takes_s);
  const Clock::time_point finish = sent.sent + seconds(longest_s);
  while (!done(sent)) {
    if (sent.over()) fail(sent);
    const Clock::time_point now = Clock::now();
    if (!sent.answered && could_answer(now - sent.sent, sent.sent_ns, link_.status())) {
      throw Failure(
          ExitCode::timed_out,
          fmt::format("{} was not acknowledged: outcome unknown", sent.command.info->name),
          "see: lss-cli status");
    }
    if (now >= finish) {
      throw Failure(ExitCode::timed_out,
                    fmt::format("{} is not {} after {}: outcome unknown", sent.command.info->name,
                                phase, format_duration(longest_s)),
                    "see: lss-cli status; wait longer with --timeout");
    }
    pump(sent.answered ? finish : std::max(sent.sent + kAnswer, now + seconds(kLook_s)));
  }
}

const Sent& Session::accept(const Invocation& command) {
  Sent& sent = submit(command, 0);
  await(sent, "accepted", is_accepted);
  show(sent);
  return sent;
}

const Sent& Session::begin(const Invocation& command) {
  Sent& sent = submit(command, 0);
  await(sent, "executing", is_begun);
  show(sent);
  return sent;
}

const Sent& Session::complete(const Invocation& command, double takes_s) {
  Sent& sent = submit(command, 0);
  await(sent, "completed", is_completed, takes_s);
  show(sent);
  return sent;
}

void Session::complete_all(const std::vector<Invocation>& commands,
                           const std::function<std::string(std::size_t)>& where) {
  for (std::size_t first = 0; first < commands.size(); first += kAtOnce) {
    const std::size_t end = std::min(commands.size(), first + kAtOnce);
    const std::size_t before = quiet_.size();
    for (std::size_t i = first; i < end; ++i) submit(commands[i], 0, true);
    for (std::size_t i = first; i < end; ++i) {
      try {
        await(quiet_[before + i - first], "completed", is_completed);
      } catch (const Failure& e) {
        throw Failure(e.code(), where(i) + e.what(), e.advice());
      }
    }
  }
}

void Session::dry_run(const Invocation& command) {
  await(submit(command, kFlagDryRun), "accepted", is_accepted);
}

void Session::safe_stop(const std::string& why) {
  if (!attached_) return;
  try {
    if (status().state == lss_STATE_OPERATIONAL) {
      output_.note(fmt::format("{}: {} (Ctrl-C leaves at once)", why,
                               link_.status().airborne ? "landing" : "stopping safely"));
      complete(
          with_defaults(find_command(vehicle(), static_cast<std::uint16_t>(CommandKind::stop))));
    }
    attached_ = false;
  } catch (const Interrupted&) {
    left_at_once();
  } catch (const Failure& e) {
    progress_ = nullptr;
    attached_ = e.code() == ExitCode::timed_out;
    if (!attached_) throw;
    beating_ = false;
    throw Failure(e.code(), e.what(), fmt::format("{}; {}", end_by_lease(options_), e.advice()));
  }
}

const lss_Status& Session::status() {
  const Clock::time_point until = Clock::now() + kStatusFollows;
  while (link_.status().time_ns < last_ack_ns_ && Clock::now() < until) pump(until);
  return link_.status();
}

void Session::end_by(const Invocation& command, const std::string& why) {
  if (!attached_) return;
  try {
    output_.note(fmt::format("{}: {} (Ctrl-C leaves at once)", why, command.info->name));
    complete(command);
    attached_ = false;
  } catch (const Failure&) {  // it is not the motion to end
    safe_stop(why);
  } catch (const Interrupted&) {
    left_at_once();
  }
}

void Session::left_at_once() {
  attached_ = beating_ = false;
  has_left_ = true;
  throw Failure(ExitCode::timed_out, "left at once", end_by_lease(options_));
}

const void* Session::telemetry() {
  link_.open_telemetry();
  const auto wait_for_one = [&](double longest_s) {
    const Clock::time_point until = Clock::now() + seconds(longest_s);
    while (link_.telemetry() == nullptr && Clock::now() < until) pump(until);
    return link_.telemetry();
  };
  if (const void* sample = wait_for_one(kTelemetryComes_s)) return sample;
  try {
    submit({&common_command(CommandKind::request_data), {}}, 0, true);
  } catch (const Failure& failure) {
    if (failure.code() != ExitCode::not_authorised) throw;  // who may only look waits
  }
  return wait_for_one(kTelemetryAsked_s);
}

bool Session::pump_input(Clock::time_point until, int input_fd) {
  if (beating_) until = std::min(until, next_beat_);
  if (progress_) until = std::min(until, next_progress_);
  until = std::min(until, Clock::now() + kDaemonLost);
  const Waker::Result woken = link_.wait(until, input_fd);
  if (woken.interrupted) throw Interrupted();
  beat_when_due();
  const Clock::time_point now = Clock::now();
  take_acks();
  link_.status();
  check_daemon();
  if (progress_ && now >= next_progress_) {
    output_.progress(progress_());
    next_progress_ = now + seconds(kProgress_s);
  }
  return woken.input;
}

void Session::beat_when_due() {
  const Clock::time_point now = Clock::now();
  if (!beating_ || now < next_beat_) return;
  open();
  link_.heartbeat();
  next_beat_ = now + seconds(kBeat_s);
}

void Session::take_acks() {
  while (const std::optional<lss_CommandAck> ack = link_.next_ack()) heard(*ack);
}

void Session::heard(const lss_CommandAck& ack) {
  if (text(ack.vehicle_id) != text(link_.status().vehicle_id)) return;
  last_ack_ns_ = std::max<std::int64_t>(last_ack_ns_, ack.time_ns);
  for (std::deque<Sent>* list : {&sent_, &quiet_}) {
    for (Sent& sent : *list) {
      if (sent.seq != ack.seq || sent.over()) continue;
      sent.ack = ack;
      sent.answered = true;
      sent.executing = sent.executing || ack.phase == lss_PHASE_EXECUTING;
      sent.heard = Clock::now();
      if (list == &sent_) output_.record(to_json(sent));
    }
  }
}

void Session::check_daemon() {
  if (!link_.daemon_lost()) return;
  const bool waiting = !sent_.empty() && !sent_.back().over();
  throw Failure(
      waiting ? ExitCode::timed_out : ExitCode::unreachable,
      waiting ? fmt::format("the daemon went away: the outcome of {} is unknown",
                            sent_.back().command.info->name)
              : "the daemon went away",
      "check that lssd runs (systemctl status lssd@NAME); motors stop by themselves without it");
}

void Session::check(const Sent& command) {
  if (command.over() && !is_completed(command)) fail(command);
  check_operational();
}

void Session::check_operational() {
  const lss_Status& now = link_.status();
  if (now.time_ns < last_ack_ns_ || now.state == lss_STATE_OPERATIONAL) return;
  throw Failure(
      ExitCode::failed, fmt::format("the vehicle went to {}{}", state_name(now.state), faults()),
      now.state == lss_STATE_FATAL_ERROR ? "see: lss-cli status, then: lss-cli solve" : "");
}

void Session::check_in_force() {
  if (!sent_.empty() && sent_.back().over() && !is_completed(sent_.back())) fail(sent_.back());
  if (link_.status().state == lss_STATE_FATAL_ERROR) check_operational();
}

std::string Session::faults() {
  std::string list;
  for (const lss_Fault& fault : status().faults) {
    if (fault.id != 0) list += (list.empty() ? ": " : ", ") + fault_text(vehicle(), fault);
  }
  return list;
}

void Session::fail(const Sent& sent) {
  const lss_CommandAck& ack = sent.ack;
  const CodeInfo* reason = info(static_cast<Reason>(ack.reason), vehicle().codes);
  const bool rejected = ack.phase == lss_PHASE_REJECTED;
  std::string why = reason_text(ack, vehicle().codes);
  std::string advice = reason != nullptr ? reason->advice : "";
  ExitCode code = rejected ? ExitCode::rejected : ExitCode::failed;
  if (ack.reason == static_cast<std::uint16_t>(Reason::not_authorised)) {
    code = ExitCode::not_authorised;
    const std::string_view holder = text(link_.status().authority);
    if (!holder.empty()) {
      advice = fmt::format("{0} has it: stop it there, act in its name with --source {0}, or: {1}",
                           holder, ending_by_anyone(link_.status()));
    }
  } else if (ack.reason == static_cast<std::uint16_t>(Reason::emergency)) {
    why += faults();
  } else if (ack.reason == static_cast<std::uint16_t>(Reason::not_in_state) && reason != nullptr) {
    why = fmt::format("{} ({})", reason->text, state_name(link_.status().state));
    if (link_.status().state == lss_STATE_FATAL_ERROR)
      advice = "see why with: lss-cli status, then: lss-cli solve";
  }
  const char* what = rejected                            ? "rejected"
                     : ack.phase == lss_PHASE_SUPERSEDED ? "superseded"
                                                         : "failed";
  throw Failure(code, fmt::format("{} {}: {}", sent.command.info->name, what, why), advice);
}

void Session::show(const Sent& sent) {
  const double taken_s = std::chrono::duration<double>(sent.heard - sent.sent).count();
  const std::string phase = phase_name(sent.ack.phase);
  output_.print(
      fmt::format("{:<10} {}{}\n", sent.command.info->name, output_.style().good(phase),
                  is_completed(sent) ? fmt::format("  {}", format_duration(taken_s)) : ""));
}

nlohmann::json Session::to_json(const Sent& sent) const {
  nlohmann::json result = ack_json(sent.ack, vehicle().codes);
  if (!sent.answered) result["phase"] = "unanswered";
  result["command"] = sent.command.info->name;
  result["kind"] = sent.command.info->kind;
  result["source"] = link_.source();
  result["seq"] = sent.seq;
  result["duration_s"] = nullptr;
  if (sent.answered)
    result["duration_s"] = std::chrono::duration<double>(sent.heard - sent.sent).count();
  return result;
}

nlohmann::json Session::report() const {
  nlohmann::json list = nlohmann::json::array();
  for (const Sent& sent : sent_) list.push_back(to_json(sent));
  return list;
}

}  // namespace lss::cli
