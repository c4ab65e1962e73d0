// lss-campaign: fault campaigns of all vehicles, a scenario for each number.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "tests/campaign/report.h"
#include "tests/support/stamp.h"

namespace {

using namespace lss::campaign;

constexpr const char* kExamples =
    "Examples:\n"
    "  lss-campaign --runs 200\n"
    "  lss-campaign zebro --first 17 --runs 1 --verbose    report of scenario 17\n"
    "  lss-campaign zebro --first 17 --runs 1 --record DIR    ... frame by frame, for lss-cli log\n"
    "  lss-campaign --runs 300 --markdown docs/campaign.md\n"
    "  lss-campaign talaris --flips 10000 --seed 3    single bits of memory, docs/flips.md\n"
    "Exit code 0: all conditions satisfied.";

void tell(const Subject& subject, const Run& run, bool all) {
  if (run.broken.empty() && !all) return;
  fmt::print("{} {}\n", subject.vehicle, run.number);
  for (const std::string& line : run.story) fmt::print("  {}\n", line);
  for (const std::string& line : run.broken) fmt::print("  BROKEN {}\n", line);
  std::fflush(stdout);
}

// Unsafe: 1.
int flip_bits(const FlipPlan& plan, const std::vector<std::string>& wanted) {
  bool unsafe = false;
  for (const Subject& subject : subjects()) {
    if (!wanted.empty() && std::ranges::count(wanted, subject.vehicle) == 0) continue;
    const FlipCounts counts = subject.flip(plan);
    fmt::print("{}\n", flip_table(subject.vehicle, counts));
    std::fflush(stdout);
    unsafe = unsafe || counts.state.back() + counts.program.back() != 0;
  }
  return unsafe ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  unsigned runs = 100, first = 1;
  bool verbose = false;
  std::vector<std::string> wanted;
  std::string markdown;
  std::filesystem::path folder;
  FlipPlan flips;
  bool unprotected = false;
  CLI::App cli("Scenarios of random faults and commands on the whole chain, in virtual time.",
               "lss-campaign");
  std::vector<std::string> names;
  for (const Subject& subject : subjects()) names.emplace_back(subject.vehicle);
  cli.add_option("vehicle", wanted, "vehicle; none: all")->check(CLI::IsMember(names));
  cli.add_option("--runs", runs, "scenarios of each vehicle")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  cli.add_option("--first", first, "number of the first scenario")->capture_default_str();
  cli.add_flag("--verbose", verbose, "report every scenario, not only violations");
  cli.add_option("--record", folder, "keep a flight recording of each scenario in this folder")
      ->check(CLI::ExistingDirectory);
  cli.add_option("--flips", flips.flips,
                 "instead: flip as many single bits of the daemon's memory");
  cli.add_option("--part", flips.part, "flips: this part of the state only, as the table names it");
  cli.add_option("--seed", flips.seed, "seed of the flips")->capture_default_str();
  cli.add_flag("--unprotected", unprotected, "flips: without the daemon's protection against them");
  cli.add_option("--markdown", markdown, "write the document there");
  cli.footer(kExamples);
  CLI11_PARSE(cli, argc, argv);

  if (flips.flips != 0) {
    flips.protect = !unprotected;
    return flip_bits(flips, wanted);
  }
  std::vector<Summary> summaries;
  bool held = true;
  for (const Subject& subject : subjects()) {
    if (!wanted.empty() && std::ranges::count(wanted, subject.vehicle) == 0) continue;
    Summary& summary = summaries.emplace_back(subject);
    const std::clock_t begin = std::clock();
    for (unsigned i = 0; i < runs; ++i) {
      const Run run = folder.empty() ? subject.play(first + i) : subject.record(first + i, folder);
      tell(subject, run, verbose);
      summary.add(run);
    }
    summary.cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    fmt::print("{}\n", summary.line());
    std::fflush(stdout);
    held = held && summary.broken == 0;
  }
  if (!markdown.empty()) {
    std::ofstream file(markdown, std::ios::trunc);
    file << document(summaries,
                     fmt::format("lss-campaign --first {} --runs {} --markdown "
                                 "docs/campaign.md",
                                 first, runs),
                     lss::testing_support::stamp(markdown));
    if (!file.flush()) {
      fmt::print(stderr, "{} cannot be written\n", markdown);
      return 1;
    }
  }
  return held ? 0 : 1;
}
