// lss-sim: simulated vehicles, as hardware. See docs/simulator.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/lss-sim/frame/control.h"
#include "tools/lss-sim/frame/runner.h"

namespace {

enum ExitCode { kOk = 0, kFailed = 1, kUsage = 2, kNobody = 3 };

constexpr const char* kExamples =
    "Examples:\n"
    "  lss-sim zebro --dir /run/lss --pace\n"
    "  lss-sim zebro --dir /tmp/z --pace --seed 7 --truth truth.jsonl --fault 5s:module-dead:3\n"
    "  lss-sim fault --dir /tmp/z leg-stuck:2\n"
    "  lss-sim fault --dir /tmp/z clear\n"
    "  lss-sim faults zebro\n"
    "  lss-sim ardito --dir /tmp/a --pace --fault 10s:E-TM:2\n";

struct Arguments {
  lss::sim::RunOptions run;
  std::string truth, speed = "1", client_speed;
  std::vector<std::string> faults;
  std::string fault_folder, fault_text, faults_vehicle;
};

int complain(const std::string& sentence, ExitCode code) {
  fmt::print(stderr, "lss-sim: {}\n", sentence);
  return code;
}

void add_line_options(CLI::App& command, Arguments& arguments) {
  command.add_flag("--pace", arguments.run.pace, "characters take the time they take on a wire");
  command.add_option("--baud", arguments.run.baud, "rate of the serial lines, when paced")
      ->check(CLI::Range(1'200, 4'000'000))
      ->capture_default_str();
}

void add_can_options(CLI::App& command, Arguments& arguments, const std::string& address) {
  command.add_flag("--pace", arguments.run.pace,
                   "characters and frames take the time they take on their wires");
  command
      .add_option("--can", arguments.run.can,
                  "the bus: udp://127.0.0.1:PORT (cannelloni; port 0: any), or an interface, vcan0")
      ->default_str(address);
}

void add_run_options(CLI::App& command, Arguments& arguments, const std::string& can_address) {
  command
      .add_option("--dir", arguments.run.folder, "folder of the links to the ports, and of faults")
      ->required();
  can_address.empty() ? add_line_options(command, arguments)
                      : add_can_options(command, arguments, can_address);
  command.add_option("--seed", arguments.run.seed, "of everything random")->capture_default_str();
  command
      .add_option("--speed", arguments.speed,
                  "of the physics against the clock; max with --lockstep: all that the machine has")
      ->check(CLI::Range(0.01, 100.0) | CLI::IsMember({"max"}))
      ->capture_default_str();
  command.add_flag("--lockstep", arguments.run.lockstep,
                   "simulated time, which lssd --lockstep follows: independent of the machine");
  command
      .add_option("--client-speed", arguments.client_speed,
                  "with --lockstep: --speed while lss-cli run --lockstep takes part; it can wait "
                  "--at-speed meanwhile")
      ->check(CLI::Range(0.01, 100.0) | CLI::IsMember({"max"}))
      ->needs("--lockstep");
  command
      .add_option("--client-at", arguments.run.client_at_s,
                  "with --lockstep: time stands still at this second until lss-cli run --lockstep "
                  "takes part")
      ->check(CLI::Range(0.1, 1e6))
      ->needs("--lockstep");
  command
      .add_option("--for", arguments.run.for_s,
                  "with --lockstep: ends after so many simulated seconds, time stands still then")
      ->check(CLI::Range(0.1, 1e7))
      ->needs("--lockstep");
  command.add_option("--truth", arguments.truth, "write the true state there, JSON lines at 10 Hz");
  command.add_option("--fault", arguments.faults,
                     "TIME:KIND[:ARG...], for example 5s:bus-cut; repeatable");
  command.footer(kExamples);
}

int run_vehicle(const lss::sim::VehicleKind& kind, Arguments& arguments) {
  const auto kinds = lss::sim::fault_kinds_of(kind);
  for (const std::string& text : arguments.faults) {
    const auto fault = lss::sim::parse_timed_fault(text, kinds);
    if (!fault) return complain(fault.error(), kUsage);
    arguments.run.faults.push_back(*fault);
  }
  const bool any_speed = arguments.speed == "max";
  if (any_speed && !arguments.run.lockstep)
    return complain("--speed max needs --lockstep: in real time the speed is a number", kUsage);
  arguments.run.speed = any_speed ? 0 : std::stod(arguments.speed);
  if (const std::string& text = arguments.client_speed; !text.empty())
    arguments.run.client_speed = text == "max" ? 0 : std::stod(text);
  if (!arguments.truth.empty()) arguments.run.truth = arguments.truth;
  if (arguments.run.can.empty()) arguments.run.can = kind.can_address();
  try {
    const auto ran = lss::sim::run(kind, arguments.run);
    return ran ? kOk : complain(ran.error(), kFailed);
  } catch (const std::invalid_argument& error) {  // options that do not go together
    return complain(error.what(), kUsage);
  }
}

int inject(const Arguments& arguments) {
  std::string message;
  switch (lss::sim::send_to_simulator(arguments.fault_folder, arguments.fault_text, message)) {
    case lss::sim::Answer::ok: return kOk;
    case lss::sim::Answer::refused: return complain(message, kUsage);
    case lss::sim::Answer::nobody: break;
  }
  return complain(message, kNobody);
}

// "did you mean" for a first word that is no subcommand; empty when there is nothing to suggest.
std::string suggestion(int argc, char** argv, const std::vector<std::string>& names) {
  if (argc < 2 || argv[1][0] == '-') return {};
  const std::string nearest = lss::sim::nearest_name(argv[1], names);
  if (nearest.empty() || nearest == argv[1]) return {};
  return fmt::format("lss-sim: '{}' is not known, did you mean '{}'?\n", argv[1], nearest);
}

}  // namespace

int main(int argc, char** argv) {
  const auto vehicles = lss::sim::all_vehicles();
  std::vector<std::string> names;
  for (const auto& vehicle : vehicles) names.push_back(vehicle->name());

  Arguments arguments;
  CLI::App app("Simulated vehicles: real bytes on lines and buses, rigid-body physics behind them.",
               "lss-sim");
  app.set_version_flag("--version",
                       fmt::format("lss-sim {} ({})", LSS_VERSION, fmt::join(names, ", ")));
  app.footer(kExamples);
  app.require_subcommand(1);
  for (const auto& vehicle : vehicles) {
    CLI::App* command = app.add_subcommand(vehicle->name(), vehicle->summary());
    add_run_options(*command, arguments, vehicle->can_address());
    vehicle->add_options(*command);
  }
  CLI::App* fault = app.add_subcommand("fault", "set or clear a fault while a simulator runs");
  fault->add_option("--dir", arguments.fault_folder, "folder of the running simulator")->required();
  fault->add_option("fault", arguments.fault_text, "KIND[:ARG...], clear, or clear:KIND")
      ->required();
  fault->footer(kExamples);
  CLI::App* faults = app.add_subcommand("faults", "list what can be broken");
  faults->add_option("vehicle", arguments.faults_vehicle)->required()->check(CLI::IsMember(names));

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    names.insert(names.end(), {"fault", "faults"});
    fmt::print(stderr, "{}", suggestion(argc, argv, names));
    app.exit(error);
    return kUsage;
  }
  if (fault->parsed()) return inject(arguments);
  for (const auto& vehicle : vehicles) {
    if (faults->parsed() && arguments.faults_vehicle == vehicle->name()) {
      fmt::print("{}", lss::sim::describe(lss::sim::fault_kinds_of(*vehicle)));
    } else if (app.got_subcommand(vehicle->name())) {
      return run_vehicle(*vehicle, arguments);
    }
  }
  return kOk;
}
