// lss-bench: how fast the parts of the daemon are, each against a reference in the same run.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/bench/growth.h"
#include "tests/bench/programs.h"
#include "tests/bench/report.h"

namespace {

using namespace lss::bench;

constexpr double kBusy = 0.1;  // of all CPUs, for others: too much for figures

constexpr const char* kExamples =
    "Examples:\n"
    "  lss-bench                         all rows, half an hour\n"
    "  lss-bench --quick                 all rows for seconds: does it run, not how fast\n"
    "  lss-bench --row ii,v --json       two rows, for a program\n"
    "  lss-bench --row ii --campaign load   3034 frames of 200 ms, eleven minutes, all CPUs busy\n"
    "  lss-bench --markdown docs/performance.md\n"
    "  lss-bench --growth --markdown docs/growth.md   how cost grows, with pictures beside it in "
    "images/; ten minutes\n"
    "  lss-bench --machine --markdown docs/machine-timing.md   rows i, ii, vi, xi in a machine "
    "whose\n"
    "                                    time is counted in instructions: maxima and what was "
    "missed\n"
    "  lss-bench --machine --box amd64,trixie,arm64   the same in three machines, side by side\n"
    "Run it with nothing else on the machine, and with the permission for SCHED_FIFO.";

struct Row {
  const char* name;
  const char* what;
  Figures (*measure)(const Options&);  // nullptr: not by this program, `what` says why
};
constexpr Row kRows[] = {
    {"i", "wake-up of the frame thread", wake_up},
    {"ii", "last sensor byte in to actuator byte out", byte_to_byte},
    {"iii", "command to acknowledgement", command_to_ack},
    {"iv", "telemetry", telemetry_cost},
    {"v", "cycle of seven modules on RS-485", leg_bus_cycle},
#ifdef LSS_BENCH_ARDITO
    {"vi", "cycle of Ardito on CAN", can_cycle},
#else
    {"vi", "cycle on CAN: Ardito is not built", nullptr},
#endif
    {"vii", "mathematics of a frame", frame_mathematics},
    {"viii", "state space of the locomotion controller", state_space},
    {"ix", "memory and steadiness", memory},
    {"x", "death of the daemon, and exec to READY", time_to_ready},
    {"xi", "edge at an absolute time", edge_error},
    {"xii", "simulation against the wall-clock", simulation_speed},
    {"xiii", "emergency stop to the bus, also under a flood", emergency_stop},
    {"xiv", "simulated time in lockstep", lockstep_speed},
    {"xv", "DDS Security", security},
    {"xvi", "many vehicles on one domain", fleet},
};

std::string row_list() {
  std::string text = "Rows:\n";
  for (const Row& row : kRows)
    text += fmt::format("  {:<5} {}{}\n", row.name, row.what, row.measure ? "" : " (not measured)");
  return text;
}

// A row that failed is no reason to lose the others; `failed` says so at the end.
Figures measure(const Row& row, const Options& options, bool& failed) {
  if (row.measure == nullptr) return {not_measured(row.name, "", row.what)};
  try {
    Figures figures = row.measure(options);
    failed |= std::ranges::any_of(figures, &Figure::failed);
    return figures;
  } catch (const NotHere& why) {
    return {not_measured(row.name, row.what, why.what())};
  } catch (const std::exception& error) {
    failed = true;
    fmt::print(stderr, "row {} failed: {}\n", row.name, error.what());
    Figure broken = not_measured(row.name, row.what, error.what());
    broken.failed = true;
    return {broken};
  }
}

// The same program in the deterministic machine, twice: tests/bench/machine.py.
int in_machine(const Options& options, const std::vector<std::string>& names,
               const std::vector<std::string>& boxes, bool as_json, const std::string& document) {
  std::vector<std::string> words{"python3", LSS_BENCH_SOURCE "/tests/bench/machine.py",
                                 program("lss-bench")};
  if (options.quick) words.emplace_back("--quick");
  if (as_json) words.emplace_back("--json");
  if (!names.empty())
    words.insert(words.end(), {"--row", fmt::format("{}", fmt::join(names, ","))});
  if (!boxes.empty())
    words.insert(words.end(), {"--box", fmt::format("{}", fmt::join(boxes, ","))});
  if (!document.empty()) words.insert(words.end(), {"--markdown", document});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execvp(argv[0], argv.data());
  fmt::print(stderr, "python3 is not installed\n");
  return 1;
}

bool write(const std::filesystem::path& path, const std::string& text) {
  if (std::ofstream(path) << text << std::flush) return true;
  fmt::print(stderr, "cannot write {}\n", path.string());
  return false;
}

// Pictures are beside the document, in images/.
int grow(const Options& options, const std::string& document) {
  const Machine machine = this_machine();
  const Others others;
  bool failed = false;
  const std::vector<Growth> all = growth(options, failed);
  if (others.share() > kBusy)
    fmt::print(stderr, "not to be quoted: others took {:.0f} % of the CPUs\n",
               others.share() * 100);
  fmt::print("{}", table(all));
  if (document.empty()) return failed ? 1 : 0;
  const std::filesystem::path images = std::filesystem::path(document).parent_path() / "images";
  std::error_code exists;
  std::filesystem::create_directories(images, exists);
  for (const Growth& one : all) {
    if (!one.points.empty() && !write(images / ("growth-" + one.name + ".svg"), picture(one)))
      return 1;
  }
  const std::string command =
      fmt::format("lss-bench --growth{} --markdown {}", options.quick ? " --quick" : "", document);
  return write(document, markdown(all, machine, command, "images")) && !failed ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::vector<std::string> names, boxes;
  std::string campaign, document;
  bool as_json = false, machine_wanted = false, growth_wanted = false;
  CLI::App cli("Performance figures, each a ratio against a reference of the same run.",
               "lss-bench");
  cli.add_option("--row", names, "rows to measure, e.g. ii,v; without it all")->delimiter(',');
  cli.add_flag("--quick", options.quick, "for seconds; the figures mean little");
  cli.add_option("--campaign", campaign, "row ii in full length: idle, or load (all CPUs at work)")
      ->check(CLI::IsMember({"idle", "load"}));
  cli.add_flag(
      "--maxima", options.maxima,
      "also maxima and how often something was missed: in a machine that counts instructions");
  cli.add_flag("--machine", machine_wanted,
               "in a virtual machine that counts instructions; rows i,ii,vi,xi");
  cli.add_option(
         "--box", boxes,
         "with --machine: amd64 (Debian as here), trixie (Debian 13), arm64; several give a "
         "table with a column for each; without it amd64")
      ->delimiter(',')
      ->check(CLI::IsMember({"amd64", "trixie", "arm64"}))
      ->needs("--machine");
  cli.add_flag("--json", as_json, "a list instead of a table");
  cli.add_option("--markdown", document, "also write the document with machine and table there");
  cli.add_flag("--growth", growth_wanted,
               "how cost grows with samples, modules, subscribers, vehicles, minutes of recording")
      ->excludes("--row", "--campaign", "--maxima", "--machine", "--json");
  cli.footer(row_list() + "\n" + kExamples);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }

  if (!campaign.empty()) {
    options.campaign = campaign == "load" ? Campaign::load : Campaign::idle;
    if (names != std::vector<std::string>{"ii"}) {
      fmt::print(stderr, "--campaign is of row ii: add --row ii\n");
      return 2;
    }
  }
  for (const std::string& name : names) {
    if (std::ranges::none_of(kRows, [&](const Row& row) { return row.name == name; })) {
      fmt::print(stderr, "there is no row '{}'. {}", name, row_list());
      return 2;
    }
  }

  if (growth_wanted) return grow(options, document);
  Cyclictest::counts_instructions = options.maxima;
  if (machine_wanted) return in_machine(options, names, boxes, as_json, document);

  std::string command = "lss-bench --markdown";
  if (options.quick) command += " --quick";
  if (!names.empty()) command += fmt::format(" --row {}", fmt::join(names, ","));
  if (!campaign.empty()) command += " --campaign " + campaign;

  const Machine machine = this_machine();
  Figures figures;
  bool failed = false;
  for (const Row& row : kRows) {
    const bool wanted =
        names.empty() ? row.measure != nullptr : std::ranges::count(names, row.name) > 0;
    if (!wanted) continue;
    fmt::print(stderr, "row {}: {}\n", row.name, row.what);
    const Others others;
    Figures measured = measure(row, options, failed);
    const double share = others.share();
    for (Figure& f : measured) {
      if (share > kBusy && std::isfinite(f.value))
        f.note += fmt::format("{}not to be quoted: others took {:.0f} % of the CPUs",
                              f.note.empty() ? "" : "; ", share * 100);
      figures.push_back(std::move(f));
    }
    // After each row, so that a run that is interrupted keeps what it has measured, beside the
    // document of before.
    if (document.empty()) continue;
    const std::string so_far = document + ".new";
    if (!(std::ofstream(so_far) << markdown(figures, machine, command) << std::flush)) {
      fmt::print(stderr, "cannot write {}\n", so_far);
      return 1;
    }
  }
  fmt::print("{}", as_json ? json(figures) : table(figures));
  if (!document.empty() && std::rename((document + ".new").c_str(), document.c_str()) != 0) {
    fmt::print(stderr, "cannot write {}; the document is in {}.new\n", document, document);
    return 1;
  }
  return failed ? 1 : 0;
}
