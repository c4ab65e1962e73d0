#include "tools/lss-cli/session/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli {
namespace {

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

Invocation stop_of(const Session& session) {
  return with_defaults(
      find_command(session.vehicle(), static_cast<std::uint16_t>(CommandKind::stop)));
}

// The line of progress of `what` from now on.
void show_progress(Session& session, const std::string& what) {
  session.open_telemetry();
  session.set_progress([&session, what, begin = Clock::now()] {
    const std::string state =
        status_line(session.vehicle(), session.link().status(), session.link().telemetry());
    return fmt::format("{} {}: {}", what, format_duration(seconds_since(begin)), state);
  });
}

void preview(Context& context, const std::vector<Invocation>& plan) {
  Session& session = context.session();
  session.dry_run(plan.front());
  context.output.print(fmt::format("{} would be accepted\n", describe(plan.front())));
  std::string rest;
  for (std::size_t i = 1; i < plan.size(); ++i)
    rest += (rest.empty() ? "" : ", ") + describe(plan[i]);
  if (!rest.empty()) context.output.print(fmt::format("then would follow: {}\n", rest));
}

// Keeps up the heartbeat until Ctrl-C (Interrupted) or until the vehicle stops by itself (Failure).
void hold(Session& session) {
  show_progress(session, "holding, Ctrl-C to stop");
  while (true) {
    session.pump(Clock::now() + seconds(1));
    session.check_operational();
  }
}

// The odometry, once received; nothing when telemetry is on_request.
std::optional<double> odometer_m(Session& session) {
  const void* sample = session.link().telemetry();
  return sample == nullptr ? std::nullopt : session.vehicle().distance_m(sample);
}

// The progress of an endless command.
class Way {
 public:
  explicit Way(Session& session) : session_(session) {}

  // The first telemetry sample is the start.
  void notice() {
    if (!begin_m_) begin_m_ = odometer_m(session_);
  }

  // Empty until telemetry comes.
  std::optional<double> distance_m() {
    notice();
    const std::optional<double> now_m = odometer_m(session_);
    return now_m ? std::optional(*now_m - *begin_m_) : std::nullopt;
  }
  double duration_s() const { return seconds_since(begin_); }

  std::string text() {
    const std::optional<double> way_m = distance_m();
    const std::string time = format_duration(duration_s());
    return way_m ? fmt::format("{:.3f} m in {}", *way_m, time) : time;
  }

  nlohmann::json json() {
    const std::optional<double> way_m = distance_m();
    return {{"distance_m", way_m ? nlohmann::json(*way_m) : nlohmann::json()},
            {"duration_s", duration_s()}};
  }

 private:
  Session& session_;
  std::optional<double> begin_m_;
  Clock::time_point begin_ = Clock::now();
};

void show_way(Session& session, const std::string& what, const std::shared_ptr<Way>& way,
              Clock::time_point end) {
  session.set_progress([&session, what, way, end] {
    const double left_s = std::chrono::duration<double>(end - Clock::now()).count();
    const std::string left = end == Clock::time_point::max()
                                 ? ""
                                 : fmt::format(", {} left", format_duration(std::max(0.0, left_s)));
    const std::string state =
        status_line(session.vehicle(), session.link().status(), session.link().telemetry());
    return fmt::format("{} {}{}: {}", what, way->text(), left, state);
  });
}

// An endless command for its time, then to standstill.
void run_endless(Context& context, const Motion& motion) {
  Session& session = context.session();
  const Sent& sent = session.begin(motion.command);
  if (context.in_sequence && !motion.for_s) return;
  const Clock::time_point end =
      motion.for_s ? Clock::now() + seconds(*motion.for_s) : Clock::time_point::max();
  const auto way = std::make_shared<Way>(session);
  show_way(session, motion.command.info->name, way, end);
  while (Clock::now() < end) {
    session.pump(std::min(end, Clock::now() + seconds(1)));
    session.check(sent);
    way->notice();
  }
  const bool stays = motion.stay || context.in_sequence;
  const Invocation ending =
      stays ? with_defaults(find_command(session.vehicle(), session.vehicle().rest))
            : stop_of(session);
  show_progress(session, ending.info->name);
  const std::string result = way->text();
  nlohmann::json document = way->json();
  session.complete(ending);
  document["command"] = motion.command.info->name;
  context.output.document(std::move(document));
  context.output.print(fmt::format("{} {}\n", describe(motion.command), result));
}

double takes_s(const Session& session, const Motion& motion) {
  return std::max(motion.takes_s, session.vehicle().takes_s(motion.command));
}

void run_attached(Context& context, const Motion& motion) {
  Session& session = context.session();
  if (is_endless(session.vehicle(), motion.command)) {
    run_endless(context, motion);
  } else {
    session.complete(motion.command, takes_s(session, motion));
  }
  if (motion.hold) hold(session);
}

void run_detached(Context& context, const Motion& motion) {
  Session& session = context.session();
  const bool wait = context.options.wait && !is_endless(session.vehicle(), motion.command);
  wait ? session.complete(motion.command, takes_s(session, motion))
       : session.accept(motion.command);
  if (motion.command.info->leased) {
    context.output.note(
        fmt::format("detached: without a heartbeat of {0} for {1} it stops (lss-cli --source {0} "
                    "heartbeat)",
                    session.link().source(), format_duration(context.options.lease_ms / 1000.0)));
  }
}

// Ctrl-C: the vehicle stops safely. This is the regular end of an endless command.
ExitCode interrupted(Context& context, const Motion& motion, Clock::time_point begin) {
  Session& session = context.session();
  session.set_progress(nullptr);
  if (!session.attached()) {
    throw Failure(ExitCode::timed_out, fmt::format("interrupted: the outcome of {} is unknown",
                                                   motion.command.info->name));
  }
  const double after_s = seconds_since(begin);
  show_progress(session, "stop");
  motion.ending ? session.end_by(*motion.ending, "interrupted") : session.safe_stop("interrupted");
  session.set_progress(nullptr);
  const bool stopped_all = session.status().state == lss_STATE_FATAL_ERROR;
  const bool open_end =
      motion.hold || (is_endless(session.vehicle(), motion.command) && !motion.for_s);
  if (open_end && !context.in_sequence) return ExitCode::completed;
  throw Failure(ExitCode::failed,
                fmt::format("{} was interrupted after {}; {}", motion.command.info->name,
                            format_duration(after_s),
                            stopped_all ? "all-stop: lss-cli solve makes it ready again"
                                        : "the vehicle stopped safely"));
}

bool ends_unattended(const Context& context, const Motion& motion) {
  return motion.command.info->leased && !context.in_sequence && !motion.hold &&
         !context.options.detach;
}

}  // namespace

ExitCode run_motion(Context& context, const Motion& motion) {
  Session& session = context.session();
  std::vector<Invocation> plan = session.vehicle().prepare(session.status(), motion.command);
  if (context.options.dry_run) {
    plan.push_back(motion.command);
    preview(context, plan);
    return ExitCode::completed;
  }
  const Clock::time_point begin = Clock::now();
  try {
    for (const Invocation& step : plan) {
      show_progress(session, step.info->name);
      session.complete(step);
    }
    show_progress(session, motion.command.info->name);
    context.options.detach ? run_detached(context, motion) : run_attached(context, motion);
    session.set_progress(nullptr);
  } catch (const Interrupted&) {
    return interrupted(context, motion, begin);
  } catch (...) {
    session.set_progress(nullptr);
    throw;
  }
  if (ends_unattended(context, motion) && session.status().state == lss_STATE_OPERATIONAL) {
    context.output.note(
        fmt::format("note: no heartbeat goes on from here: the vehicle comes to a safe stop in {}. "
                    "Stay attached with "
                    "--hold, or --detach and lss-cli heartbeat",
                    format_duration(context.options.lease_ms / 1000.0)));
  }
  return ExitCode::completed;
}

}  // namespace lss::cli
