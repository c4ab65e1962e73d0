// The verbs of the command tables, and the verbs about commands: heartbeat, command, version.

#include <fmt/format.h>

#include <algorithm>
#include <exception>

#include "tools/lss-cli/session/motion.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

// The arguments after a verb of the command table.
struct Typed {
  std::vector<std::string> words;
  std::map<std::string, std::string> named;
  std::shared_ptr<std::optional<double>> for_s;
  bool stay = false, hold = false;
};

// Commands that are part of verbs which do more.
constexpr std::string_view kOwnVerbs[] = {"data", "estop", "reset-timing", "set-parameter",
                                          "save-parameters"};

using Vehicles = std::vector<const Vehicle*>;

// Of the first of the vehicles that has any.
std::string examples_of(std::span<const Vehicle* const> vehicles, const CommandInfo& command) {
  for (const Vehicle* vehicle : vehicles) {
    const auto own = vehicle->examples.find(command.kind);
    if (own != vehicle->examples.end()) return own->second;
  }
  return command.parameters.empty() ? fmt::format("  lss-cli {}\n", command.name) : "";
}

Motion motion_of(const Vehicle& vehicle, const std::string& verb, const Typed& typed) {
  Motion motion{
      .command = read_invocation(find_command(vehicle, verb), vehicle, typed.words, typed.named),
      .for_s = typed.for_s ? *typed.for_s : std::nullopt,
      .stay = typed.stay,
      .hold = typed.hold};
  if (motion.for_s && !is_endless(vehicle, motion.command)) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} ends by itself: --for says nothing", describe(motion.command)));
  }
  return motion;
}

// The vehicles that have a command of this name.
Vehicles owners_of(std::span<const Vehicle* const> vehicles, const std::string& command) {
  Vehicles owners;
  for (const Vehicle* vehicle : vehicles) {
    const std::vector<std::string> names = command_names(*vehicle);
    if (std::ranges::find(names, command) != names.end()) owners.push_back(vehicle);
  }
  return owners;
}

// Before any contact: the vehicle is not known yet, but at least one vehicle must understand these
// words.
void check_words(const Vehicles& vehicles, const std::string& verb, const Typed& typed) {
  std::exception_ptr first;
  for (const Vehicle* vehicle : owners_of(vehicles, verb)) {
    try {
      motion_of(*vehicle, verb, typed);
      return;
    } catch (const Failure&) {
      if (!first) first = std::current_exception();
    }
  }
  if (first) std::rethrow_exception(first);
}

ExitCode run_command(Context& context, const std::string& verb, const Typed& typed) {
  Session& session = context.session();
  return run_motion(context, motion_of(session.vehicle(), verb, typed));
}

void add_parameters(Grammar& grammar, CLI::App& sub, const CommandInfo& info,
                    const Vehicle& vehicle, Typed& typed) {
  for (const ParameterInfo& p : info.parameters) {
    const std::string option = fmt::format("--{}", p.name);
    if (sub.get_option_no_throw(option) == nullptr) {  // another vehicle may have it too
      sub.add_option_function<std::string>(
          option, [&typed, name = p.name](const std::string& value) { typed.named[name] = value; },
          p.help);
    }
    const std::vector<std::string> names = value_names(p, vehicle);
    grammar.values(sub, option, names);
    if (p.choices != kNoYes && p.choices != kOffOn) grammar.values(sub, "", names);
  }
  if (info.endless && sub.get_option_no_throw("--for") == nullptr) {
    typed.for_s =
        add_duration(sub, "--for", "how long; then it stops and lies down (default: until Ctrl-C)");
  }
  const bool rests = vehicle.rest != static_cast<std::uint16_t>(CommandKind::stop);
  if (info.endless && rests && sub.get_option_no_throw("--stay") == nullptr)
    sub.add_flag("--stay", typed.stay, "after --for it stands, motors on");
  if (info.leased && sub.get_option_no_throw("--hold") == nullptr) {
    sub.add_flag("--hold", typed.hold, "then stay attached until Ctrl-C");
  }
}

// One verb for all vehicles that have a command of this name.
void add_table_verbs(Grammar& grammar) {
  std::map<std::string, std::pair<CLI::App*, std::shared_ptr<Typed>>> known;
  const Vehicles vehicles(grammar.vehicles().begin(), grammar.vehicles().end());
  // A vehicle that is not on the roster may name a command as a verb that does something else.
  std::optional<Grammar> fixed;
  if (!vehicles.empty() && find_vehicle(vehicles.front()->name) == nullptr)
    fixed.emplace(grammar.scope(), std::span<const Vehicle* const>());
  for (const Vehicle* vehicle : vehicles) {
    for (const CommandInfo* info : commands_of(*vehicle)) {
      const std::string name = info->name;
      if (std::ranges::find(kOwnVerbs, name) != std::end(kOwnVerbs)) continue;
      if (fixed && fixed->has(name)) continue;
      if (is_composed(*vehicle, name)) continue;
      auto& [sub, typed] = known[name];
      if (sub == nullptr) {
        sub = &grammar.verb(name, info->summary, examples_of(vehicles, *info));
        typed = std::make_shared<Typed>();
        if (!info->parameters.empty())
          sub->add_option("words", typed->words, "parameters, also without their names");
        grammar.on(
            *sub,
            [name, typed = typed](Context& context) { return run_command(context, name, *typed); },
            [name, vehicles, typed = typed] { check_words(vehicles, name, *typed); });
      }
      add_parameters(grammar, *sub, *info, *vehicle, *typed);
    }
  }
}

ExitCode run_heartbeat(Context& context, std::optional<double> for_s) {
  Session& session = context.session();
  session.beat();
  session.set_progress([&session] {
    return "heartbeat of " + session.link().source() + ": " +
           status_line(session.vehicle(), session.link().status(), session.link().telemetry());
  });
  const Clock::time_point end = for_s ? Clock::now() + seconds(*for_s) : Clock::time_point::max();
  try {
    while (Clock::now() < end) session.pump(std::min(end, Clock::now() + seconds(1)));
  } catch (const Interrupted&) {
  }
  session.set_progress(nullptr);
  return ExitCode::completed;
}

ExitCode list_commands(Context& context) {
  const Vehicle& vehicle = context.session().vehicle();
  nlohmann::json list = nlohmann::json::array();
  for (const CommandInfo* info : commands_of(vehicle)) {
    list.push_back(to_json(*info, vehicle));
    context.output.print(fmt::format("{:>4}  {:<10} {}\n", info->kind, info->name, info->summary));
  }
  context.output.document({{"vehicle", vehicle.name}, {"commands", std::move(list)}});
  return ExitCode::completed;
}

ExitCode describe_command(Context& context, const std::string& name) {
  context.described();
  const Vehicles known = vehicles_of(context);
  const Vehicles owners = owners_of(known, name);
  if (owners.empty() && !known.empty()) find_command(*known.front(), name);  // suggests names
  const Vehicle& vehicle = owners.size() == 1 ? *owners.front() : context.session().vehicle();
  const CommandInfo& info = find_command(vehicle, name);
  context.output.document(to_json(info, vehicle));
  context.output.print(describe(info, vehicle));
  return ExitCode::completed;
}

void add_heartbeat(Grammar& grammar) {
  CLI::App& sub = grammar.verb("heartbeat", "keep up the lease of what was commanded with --detach",
                               "  lss-cli --detach walk forward & lss-cli heartbeat --for 1min\n");
  const auto for_s = add_duration(sub, "--for", "how long (default: until Ctrl-C)");
  grammar.on(sub, [for_s](Context& context) { return run_heartbeat(context, *for_s); });
}

void add_command(Grammar& grammar) {
  CLI::App& sub = grammar.verb("command", "the command table: list, describe NAME",
                               "  lss-cli command list\n  lss-cli command describe walk\n");
  auto what = std::make_shared<std::string>();
  auto name = std::make_shared<std::string>();
  sub.add_option("what", *what, "list or describe")->required();
  sub.add_option("name", *name, "of a command");
  grammar.values(sub, "", {"list", "describe"});
  for (const Vehicle* vehicle : grammar.vehicles())
    grammar.values(sub, "describe", command_names(*vehicle));
  grammar.on(sub, [what, name](Context& context) {
    if (*what == "list" && name->empty()) return list_commands(context);
    if (*what == "describe" && !name->empty()) return describe_command(context, *name);
    throw no_form(fmt::format("command {} {}", *what, *name),
                  "command list, or command describe NAME");
  });
}

}  // namespace

void add_command_verbs(Grammar& grammar) {
  add_estop_verb(grammar);
  add_table_verbs(grammar);
  for (const Vehicle* vehicle : grammar.vehicles()) {
    if (vehicle->overlay != nullptr && vehicle->overlay->add_verbs != nullptr)
      vehicle->overlay->add_verbs(grammar);
  }
  add_heartbeat(grammar);
  add_command(grammar);
}

}  // namespace lss::cli
