// zebro-mission: missions of Lunar Zebro in simulation, one seed after the other.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <vector>

#include "tests/support/stamp.h"
#include "tests/zebro/mission/report.h"

int main(int argc, char** argv) {
  using namespace lss::zebro::mission;
  Options options;
  int seeds = 1, first = 1;
  std::string markdown;
  CLI::App cli("Missions of Lunar Zebro on the kinematic plant, faster than real time.",
               "zebro-mission");
  cli.add_option("--seeds", seeds, "how many missions")->check(CLI::PositiveNumber);
  cli.add_option("--first", first, "seed of the first")->capture_default_str();
  cli.add_option("--metres", options.autopilot.course_m, "length of the course")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  cli.add_option("--fault-hours", options.fault_mean_h, "of operation between two faults")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  std::string speed = "low";
  cli.add_option("--speed", speed, "of walking")
      ->check(CLI::IsMember({"low", "medium", "high"}))
      ->capture_default_str();
  cli.add_option("--flight", options.flight_s, "of a leg, seconds")
      ->check(CLI::Range(2.0, 20.0))
      ->capture_default_str();
  bool verbose = false;
  cli.add_flag("--verbose", verbose, "say what happens");
  cli.add_option("--markdown", markdown, "write the document there");
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }

  if (verbose) options.tell = [](const std::string& what) { fmt::print("  {}\n", what); };
  using lss::gnc::zebro::Speed;
  options.autopilot.speed = speed == "low"      ? Speed::low
                            : speed == "medium" ? Speed::medium
                                                : Speed::high;

  std::vector<Result> results;
  bool held = true;
  for (int i = 0; i < seeds; ++i) {
    options.seed = static_cast<unsigned>(first + i);
    results.push_back(run(options));
    fmt::print("{}\n", line(results.back()));
    for (const std::string& violation : results.back().violations) fmt::print("  {}\n", violation);
    std::fflush(stdout);
    held = held && results.back().violations.empty();
    if (markdown.empty()) continue;
    // After each, so that an interrupted run has a document of its results.
    const std::string command = fmt::format(
        "zebro-mission --seeds {} --first {} --metres {} --fault-hours {} --speed {} --flight {} "
        "--markdown docs/mission-zebro.md",
        i + 1, first, options.autopilot.course_m, options.fault_mean_h, speed, options.flight_s);
    std::ofstream file(markdown, std::ios::trunc);
    file << document(results, options, command, lss::testing_support::stamp(markdown));
    if (!file.flush()) {
      fmt::print(stderr, "cannot write {}: choose another file for --markdown\n", markdown);
      return 1;
    }
  }
  return held ? 0 : 1;
}
