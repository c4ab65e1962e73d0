#include "tools/lss-cli/talaris/verbs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <random>

#include "tools/lss-cli/session/motion.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/talaris/script.h"
#include "tools/lss-cli/talaris/vehicle.h"
#include "tools/lss-cli/verbs/steps.h"

namespace lss::cli::talaris {
namespace {

using lss::talaris::CommandKind;

const CommandInfo& command(CommandKind kind) {
  return find_command(vehicle(), static_cast<std::uint16_t>(kind));
}

ExitCode run(Context& context, const Invocation& invocation) {
  Motion motion;
  motion.command = invocation;
  return run_motion(context, motion);
}

void only_talaris(Context& context, const char* verb) {
  const std::string_view name = context.session().vehicle().name;
  if (name != talaris::vehicle().name)
    throw Failure(ExitCode::unknown_name, fmt::format("{} has no '{}'", name, verb));
}

// hop

struct Hop {
  std::string program = "hop";
  std::map<std::string, std::string> named;
  bool arm = false;
};

// The commands that a person would type one after the other.
std::vector<std::string> sequence_of(const Hop& hop) {
  std::string plan = "plan " + hop.program;
  for (const auto& [name, value] : hop.named) plan += fmt::format(" --{} '{}'", name, value);
  std::vector<std::string> lines = {"gnc standby", "gnc calibrate", plan, "gnc execute"};
  if (hop.arm) lines.insert(lines.begin(), "edf arm");
  return lines;
}

// The first step only: the others are allowed when it is completed.
ExitCode preview_hop(Context& context, const std::vector<std::string>& lines,
                     const std::vector<Step>& steps) {
  run_step(context, steps.front());
  context.output.print(
      fmt::format("then would follow: {}\n", fmt::join(std::span(lines).subspan(1), "; ")));
  return ExitCode::completed;
}

void check(const Hop& hop) {
  const std::string words[] = {hop.program};
  read_invocation(command(CommandKind::plan), vehicle(), words, hop.named);
}

ExitCode run_hop(Context& context, const Hop& hop) {
  only_talaris(context, "hop");
  const std::vector<std::string> lines = sequence_of(hop);
  const std::vector<Step> steps =
      parse_steps(context, fmt::format("{}", fmt::join(lines, "; ")), "");
  if (context.options.dry_run) return preview_hop(context, lines, steps);
  if (context.in_sequence) {
    for (const Step& step : steps) run_step(context, step);
    return ExitCode::completed;
  }
  return run_steps(context, steps, false);
}

void add_hop(Grammar& grammar) {
  CLI::App& sub = grammar.verb(
      "hop", "calibrate, plan and fly, from where it is; then everything shut and off", R"(
  lss-cli hop --arm --height 2 --distance 30      the fans' controllers just got power
  lss-cli hop --height 1 --distance 5
  lss-cli hop --program fan-altitude --height 0.3
)");
  auto hop = std::make_shared<Hop>();
  sub.add_option("--program", hop->program, "what is flown");
  grammar.values(sub, "--program",
                 value_names(command(CommandKind::plan).parameters[0], vehicle()));
  for (const ParameterInfo& p : command(CommandKind::plan).parameters.subspan(1)) {
    sub.add_option_function<std::string>(
        fmt::format("--{}", p.name),
        [hop, name = p.name](const std::string& value) { hop->named[name] = value; }, p.help);
  }
  sub.add_flag("--arm", hop->arm,
               "start the fans' speed controllers up first; only when they just got power");
  grammar.on(
      sub, [hop](Context& context) { return run_hop(context, *hop); }, [hop] { check(*hop); });
}

// edf

struct Edf {
  std::vector<std::string> words;
  std::map<std::string, std::string> named;
  bool hold = false;
};

constexpr const char* kEdf[] = {"arm", "throttle", "rpm"};

Invocation invocation_of(const Edf& edf) {
  const std::vector<std::string> known(std::begin(kEdf), std::end(kEdf));
  const std::string what = edf.words.empty() ? "" : edf.words.front();
  if (std::ranges::find(known, what) == known.end()) {
    throw no_form("edf " + what, "edf arm, edf throttle SHARE, or edf rpm SPEED");
  }
  return read_invocation(find_command(vehicle(), "edf-" + what), vehicle(),
                         std::span(edf.words).subspan(1), edf.named);
}

void add_edf(Grammar& grammar) {
  CLI::App& sub =
      grammar.verb("edf", "the fans: start-up of their controllers, throttle, or speed", R"(
  lss-cli edf arm                  only when their controllers just got power
  lss-cli edf arm done             they beeped already: nothing is sent
  lss-cli edf throttle 0.2 --fans 1,3 --hold
  lss-cli edf rpm 12000 --hold     all four, closed loop, until Ctrl-C
)");
  auto edf = std::make_shared<Edf>();
  sub.add_option("words", edf->words, "arm, throttle SHARE, or rpm SPEED")->required();
  grammar.values(sub, "", {std::begin(kEdf), std::end(kEdf)});
  for (const CommandKind kind :
       {CommandKind::edf_arm, CommandKind::edf_throttle, CommandKind::edf_rpm}) {
    for (const ParameterInfo& p : command(kind).parameters) {
      const std::string option = fmt::format("--{}", p.name);
      if (sub.get_option_no_throw(option) != nullptr) continue;
      sub.add_option_function<std::string>(
          option, [edf, name = p.name](const std::string& value) { edf->named[name] = value; },
          p.help);
      grammar.values(sub, option, value_names(p, vehicle()));
    }
  }
  sub.add_flag("--hold", edf->hold, "then stay attached until Ctrl-C");
  grammar.on(
      sub,
      [edf](Context& context) {
        only_talaris(context, "edf");
        Motion motion;
        motion.command = invocation_of(*edf);
        motion.hold = edf->hold;
        return run_motion(context, motion);
      },
      [edf] { invocation_of(*edf); });
}

// script

// Separates the steps of one sender from those of another.
double new_id() {
  std::random_device device;
  return 1 + device() % 4'000'000'000u;
}

// The commands that send the script under an id: its announcement, then a step for each line.
std::vector<Invocation> upload_of(double id, const std::vector<ScriptStep>& script) {
  std::vector<Invocation> all = {
      {&command(CommandKind::script_begin), {id, static_cast<double>(script.size())}}};
  for (std::size_t i = 0; i < script.size(); ++i) {
    const ScriptStep& s = script[i];
    all.push_back(
        {&command(CommandKind::script_step),
         {id, static_cast<double>(i), s.at_s, static_cast<double>(s.kind), s.which, s.value}});
  }
  return all;
}

// Sends it to the daemon, which reports impossible steps with their line.
double upload(Context& context, const std::string& name, const std::vector<ScriptStep>& script) {
  const double id = new_id();
  Session& session = context.session();
  const std::vector<Invocation> all = upload_of(id, script);
  session.complete_all({all.front()}, [&](std::size_t) { return name + ": "; });
  session.complete_all({all.begin() + 1, all.end()},
                       [&](std::size_t i) { return fmt::format("{}:{}: ", name, script[i].line); });
  return id;
}

std::string summary(const std::vector<ScriptStep>& script) {
  return fmt::format("{} steps, {}", script.size(), format_duration(duration_s(script)));
}

ExitCode check_script(Context& context, const std::string& name) {
  const std::vector<ScriptStep> script = parse_script(read_input(name), name);
  only_talaris(context, "script");
  upload(context, name, script);
  context.output.print(fmt::format("{} can be run: {}\n", name, summary(script)));
  context.output.document({{"script", name}, {"steps", script.size()}});
  return ExitCode::completed;
}

ExitCode run_script(Context& context, const std::string& name) {
  const std::vector<ScriptStep> script = parse_script(read_input(name), name);
  only_talaris(context, "script");
  const double id = upload(context, name, script);
  context.output.print(fmt::format("{}: {}\n", name, summary(script)));
  Motion motion;
  motion.command = {&command(CommandKind::script_run), {id}};
  motion.takes_s = duration_s(script);
  motion.ending = Invocation{&command(CommandKind::script_abort), {}};
  const ExitCode code = run_motion(context, motion);
  if (!context.in_sequence) stop_attached(context, "the script is done");
  return code;
}

ExitCode do_script(Context& context, const std::string& what, const std::string& name) {
  if (what == "check" && !name.empty()) return check_script(context, name);
  if (what == "run" && !name.empty()) return run_script(context, name);
  if (what == "abort" && name.empty())
    return run(context, {&command(CommandKind::script_abort), {}});
  throw no_form(fmt::format("script {} {}", what, name),
                "script run FILE, script check FILE, or script abort");
}

void add_script(Grammar& grammar) {
  CLI::App& sub = grammar.verb("script", "timed actuations from a file: run, check, abort", R"(
  lss-cli script check pulses.script       reads it, and asks the daemon
  lss-cli script run pulses.script         5 s later the first actuation; Ctrl-C: all-stop
  lss-cli script abort                     all-stop, from anyone
A line of the file:
  500ms  valves 1,3  for 100ms
  2s     fans all    throttle 0.3
  6s     fans 1,2    rpm 12000
)");
  auto what = std::make_shared<std::string>();
  auto name = std::make_shared<std::string>();
  sub.add_option("what", *what, "run, check or abort")->required();
  sub.add_option("file", *name, "- for stdin");
  grammar.values(sub, "", {"run", "check", "abort"});
  grammar.on(sub, [what, name](Context& context) { return do_script(context, *what, *name); });
}

}  // namespace

std::vector<Invocation> script_commands(std::string_view text) {
  const double id = new_id();
  std::vector<Invocation> all = upload_of(id, parse_script(text, "line"));
  all.push_back({&command(CommandKind::script_run), {id}});
  return all;
}

void add_verbs(Grammar& grammar) {
  add_hop(grammar);
  add_edf(grammar);
  add_script(grammar);
}

}  // namespace lss::cli::talaris
