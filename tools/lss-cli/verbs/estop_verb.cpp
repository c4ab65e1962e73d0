// estop: the emergency stop of every vehicle on the domain, or of one.

#include <fmt/format.h>

#include <algorithm>

#include "tools/lss-cli/session/ack.h"
#include "tools/lss-cli/session/emergency.h"
#include "tools/lss-cli/session/motion.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

std::string name_of(const Stopped& stopped, const std::vector<Stopped>& all) {
  if (stopped.vehicle_id.empty()) return "a daemon without a name";
  const bool one = std::ranges::count(all, stopped.vehicle_id,
                                      [](const Stopped& s) { return s.vehicle_id; }) == 1;
  return one ? stopped.vehicle_id
             : fmt::format("{} ({})", stopped.vehicle_id, instance_text(stopped.instance));
}

std::string line(const Stopped& stopped, const std::string& name, const Style& style) {
  if (stopped.completed()) {
    return fmt::format("{:<15} {} in {:.0f} ms{}\n", name, style.good("stopped"),
                       stopped.after_s * 1e3, stopped.fell ? "; it was in the air: it fell" : "");
  }
  const std::string last =
      stopped.answered ? fmt::format("; its last answer: {}", phase_name(stopped.ack.phase)) : "";
  const bool says_why = stopped.answered && stopped.ack.reason != 0;
  return fmt::format("{:<15} {}{}{}\n", name, style.bad("not confirmed"), last,
                     says_why ? ", " + reason_text(stopped.ack) : "");
}

// Shows all answers; a daemon that did not confirm is a Failure.
void tell(Context& context, const std::vector<Stopped>& all) {
  std::string missing;
  std::size_t count = 0;
  for (const Stopped& stopped : all) {
    const std::string name = name_of(stopped, all);
    context.output.print(line(stopped, name, context.output.style()));
    context.report(to_json(stopped, context.link().source()));
    if (stopped.completed()) continue;
    ++count;
    missing += (missing.empty() ? "" : ", ") + name;
  }
  if (count > 0) {
    throw Failure(
        ExitCode::timed_out,
        fmt::format("{} of {} did not confirm the emergency stop: {}", count, all.size(), missing),
        "send it again, or cut the power of the motors; see: lss-cli status");
  }
  context.output.note("see: lss-cli status; leave FatalError with: lss-cli solve");
}

// For one vehicle when it is named with the verb or with the program's --vehicle. LSS_VEHICLE does
// not count: a user may have forgotten it, and a stop must never reach fewer vehicles than the user
// expects.
std::string meant(const Context& context, const std::string& name) {
  const Options& options = context.options;
  const bool other = !name.empty() && options.vehicle_typed && name != options.vehicle_id;
  if (other && !context.in_sequence) {
    throw Failure(ExitCode::usage,
                  fmt::format("estop {} with --vehicle {}: which?", name, options.vehicle_id),
                  "lss-cli estop stops them all");
  }
  if (!name.empty()) return name;
  return options.vehicle_typed ? options.vehicle_id : std::string(dds::kEveryVehicle);
}

ExitCode dry_run(Context& context, const std::string& name) {
  if (!name.empty()) {
    throw Failure(ExitCode::usage, "estop NAME has no --dry-run",
                  "lss-cli --dry-run --vehicle NAME estop");
  }
  return run_motion(context, {.command = {.info = &common_command(CommandKind::emergency_stop)},
                              .for_s = std::nullopt});
}

ExitCode run_estop(Context& context, const std::string& name) {
  const std::string vehicle_id = meant(context, name);
  if (context.options.dry_run) return dry_run(context, name);
  Link& link = context.link();
  link.open_emergency(context.options.source);
  EmergencyStop stop(link, vehicle_id);
  EmergencyStop::Hooks hooks;
  if (context.connected()) {  // this session may have another vehicle
    hooks.turn = [&] { context.session().beat_when_due(); };
    hooks.answer = [&](const lss_CommandAck& ack) { context.session().heard(ack); };
  }
  stop.run(context.options.find_timeout_s(), hooks);
  const std::vector<Stopped> all = stop.results();
  if (all.empty()) {
    throw link.unreachable(vehicle_id == dds::kEveryVehicle ? "" : vehicle_id);
  }
  tell(context, all);
  return ExitCode::completed;
}

}  // namespace

void add_estop_verb(Grammar& grammar) {
  const CommandInfo& info = common_command(CommandKind::emergency_stop);
  CLI::App& sub = grammar.verb(
      info.name, "emergency stop of every vehicle on the domain, at once, from anyone", R"(
  lss-cli estop                    all of them; LSS_VEHICLE is not looked at
  lss-cli estop zebro-1            this one only; so does: lss-cli --vehicle zebro-1 estop
It is sent again until each vehicle has confirmed it, for --timeout at most (default 3s).
What is in the air falls: lss-cli land brings it down in good order. Afterwards: lss-cli solve.
Exit code 0: each vehicle found has stopped; 3: none was reached; 7: some did not confirm it.
)");
  auto name = std::make_shared<std::string>();
  sub.add_option("name", *name, "vehicle_id; without it every vehicle on the domain");
  grammar.on(sub, [name](Context& context) { return run_estop(context, *name); });
}

}  // namespace lss::cli
