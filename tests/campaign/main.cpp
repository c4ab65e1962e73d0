// lss-campaign: fault campaigns of all vehicles, a scenario for each number, or for each script
// that a search found.

#include <fmt/format.h>
#include <sys/personality.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/campaign/flip_results.h"
#include "tests/campaign/results.h"
#include "tests/campaign/script.h"
#include "tests/support/stamp.h"

namespace {

using namespace lss::campaign;
namespace fs = std::filesystem;

constexpr const char* kExamples =
    "Examples:\n"
    "  lss-campaign --runs 200\n"
    "  lss-campaign zebro --first 17 --runs 1 --verbose    report of scenario 17\n"
    "  lss-campaign zebro --first 17 --runs 1 --record DIR    ... frame by frame, for lss-cli log\n"
    "  lss-campaign --runs 300 --markdown docs/campaign.md\n"
    "  lss-campaign --runs 9000 --shard 2/8 --out 2.json    an eighth of it, on one of eight "
    "computers\n"
    "  lss-campaign merge *.json    the sum of all eighths\n"
    "  lss-campaign search zebro --for 600    scripts that break a condition\n"
    "  lss-campaign zebro --script HEX    report of a script that a search printed\n"
    "  lss-campaign talaris --flips 10000 --seed 3    single bits of memory, docs/flips.md\n"
    "  lss-campaign zebro --flips 1000 --part registers    ... of registers\n"
    "  lss-campaign merge seed-*.json    the sum of several seeds, each with --out\n"
    "Exit code 0: all conditions satisfied.";

struct Options {
  unsigned runs = 100, first = 1;
  bool verbose = false;
  std::vector<std::string> wanted;
  std::string markdown, shard = "1/1", out, script;
  fs::path folder;
  // merge
  std::vector<std::string> files;
  // search
  std::string searched;
  fs::path corpus;
  unsigned seconds = 600;
  FlipPlan flips;
  bool unprotected = false;
};

void tell(const Subject& subject, const Run& run, bool all) {
  if (run.broken.empty() && !all) return;
  fmt::print("{} {}\n", subject.vehicle, run.number);
  for (const std::string& line : run.story) fmt::print("  {}\n", line);
  for (const std::string& line : run.broken) fmt::print("  BROKEN {}\n", line);
  std::fflush(stdout);
}

// Where a pointer with a flipped bit leads depends on where the program and its stack are: from now
// on always at the same addresses. Begins the program again, without an environment.
void fix_addresses(char** arguments) {
  constexpr unsigned long kAsk = 0xffffffff;
  const int answer = ::personality(kAsk);
  const auto now = static_cast<unsigned long>(answer);
  if (answer != -1 && (now & ADDR_NO_RANDOMIZE) != 0) return;
  if (answer != -1 && ::personality(now | ADDR_NO_RANDOMIZE) != -1) {
    char* const no_environment[] = {nullptr};
    ::execve("/proc/self/exe", arguments, no_environment);
  }
  fmt::print(stderr, "addresses are random here: the same seed can have other outcomes\n");
}

FlipResults flip_bits(const FlipPlan& plan, const std::vector<std::string>& wanted) {
  FlipResults results{
      .commit = lss::testing_support::commit_around(fs::read_symlink("/proc/self/exe")),
      .part = plan.part,
      .protect = plan.protect,
      .seeds = {plan.seed},
      .vehicles = {}};
  for (const Subject& subject : subjects()) {
    if (!wanted.empty() && std::ranges::count(wanted, subject.vehicle) == 0) continue;
    results.vehicles[subject.vehicle] = subject.flip(plan);
  }
  return results;
}

// Unsafe: 1.
int tell_flips(const FlipResults& results, const std::string& out) {
  fmt::print("{}", document(results));
  std::fflush(stdout);
  if (!out.empty()) write(results, out);
  bool unsafe = false;
  for (const auto& [vehicle, counts] : results.vehicles) {
    for (const auto& [part, tally] : counts.parts) unsafe = unsafe || tally.back() != 0;
  }
  return unsafe ? 1 : 0;
}

FlipResults merge_flips(const std::vector<std::string>& files) {
  std::vector<FlipResults> all;
  for (const std::string& file : files) all.push_back(read_flips(file));
  return merge(all);
}

Results play(const Options& o) {
  Results results{.commit = lss::testing_support::commit_around(fs::read_symlink("/proc/self/exe")),
                  .first = o.first,
                  .runs = o.runs,
                  .shard = parse_shard(o.shard),
                  .summaries = {}};
  for (const Subject& subject : subjects()) {
    if (!o.wanted.empty() && std::ranges::count(o.wanted, subject.vehicle) == 0) continue;
    Summary& summary = results.summaries.emplace_back(subject);
    const std::clock_t begin = std::clock();
    for (unsigned i = results.shard.number - 1; i < o.runs; i += results.shard.of) {
      const Run run =
          o.folder.empty() ? subject.play(o.first + i) : subject.record(o.first + i, o.folder);
      tell(subject, run, o.verbose);
      summary.add(run);
    }
    summary.cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    fmt::print("{}\n", summary.line());
    std::fflush(stdout);
  }
  return results;
}

Results merge_files(const Options& o) {
  std::vector<Results> shards;
  for (const std::string& file : o.files) shards.push_back(read(file));
  Results all = merge(shards);
  for (const Summary& summary : all.summaries) {
    for (const std::string& what : summary.complaints)
      fmt::print("{} {}\n", summary.subject.vehicle, what);
    fmt::print("{}\n", summary.line());
  }
  return all;
}

// Looked at before hours of work, not after them.
void expect_writable(const fs::path& file) {
  if (file.empty()) return;
  const fs::path place = fs::exists(file) ? file : fs::absolute(file).parent_path();
  if (fs::is_directory(file) || ::access(place.c_str(), W_OK) != 0)
    throw std::runtime_error(file.string() +
                             " cannot be written: name a file in a folder that you may write to");
}

void write_document(const Results& results, const std::string& markdown) {
  std::ofstream file(markdown, std::ios::trunc);
  file << document(results.summaries,
                   fmt::format("lss-campaign --first {} --runs {} --markdown docs/campaign.md",
                               results.first, results.runs),
                   lss::testing_support::stamp(markdown));
  if (!file.flush()) throw std::runtime_error(markdown + " cannot be written");
}

int play_script(const Options& o) {
  const auto script = from_hex(o.script);
  if (!script) throw std::runtime_error("--script: not an even number of hexadecimal digits");
  if (o.wanted.size() != 1) throw std::runtime_error("--script: name one vehicle");
  const auto all = subjects();
  const Subject& subject = *std::ranges::find(all, o.wanted.front(), &Subject::vehicle);
  const Run run = subject.play_script(*script, nullptr);
  tell(subject, run, true);
  return run.broken.empty() ? 0 : 1;
}

// libFuzzer's engine takes over this process.
int search(const Options& o) {
  constexpr int kLongest = 400;  // bytes of a script
  const std::string program = fs::read_symlink("/proc/self/exe").parent_path() / "lss-search";
  if (!fs::exists(program))
    throw std::runtime_error(
        fmt::format("there is no {}: install libclang-rt-14-dev, then ninja lss-search", program));
  const Shard shard = parse_shard(o.shard);
  const fs::path found = o.corpus.empty() ? fs::path("lss-search-" + o.searched) : o.corpus;
  fs::create_directories(found);
  if (fs::is_empty(found)) {  // scripts of any choices
    std::mt19937 random(shard.number);
    for (int i = 0; i < 32; ++i) {
      Script script(kLongest);
      for (std::uint8_t& byte : script) byte = static_cast<std::uint8_t>(random());
      std::ofstream(found / fmt::format("{}", i), std::ios::binary)
          .write(reinterpret_cast<const char*>(script.data()), kLongest);
    }
  }
  std::vector<std::string> words = {program,
                                    o.searched,
                                    fmt::format("-seed={}", shard.number),
                                    fmt::format("-max_total_time={}", o.seconds),
                                    fmt::format("-max_len={}", kLongest),
                                    "-len_control=0",
                                    "-timeout=120",
                                    "-rss_limit_mb=2048",
                                    "-print_final_stats=1",
                                    "-artifact_prefix=" + (found / "broken-").string(),
                                    found.string()};
  ::setenv("LSS_SEARCH_SHARD", o.shard.c_str(), 1);
  if (!o.out.empty()) ::setenv("LSS_SEARCH_OUT", fs::absolute(o.out).c_str(), 1);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(stdout);
  ::execv(program.c_str(), arguments.data());
  throw std::runtime_error(fmt::format("{} cannot be started: {}", program, std::strerror(errno)));
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App cli("Scenarios of random faults and commands on the whole chain, in virtual time.",
               "lss-campaign");
  std::vector<std::string> names;
  for (const Subject& subject : subjects()) names.emplace_back(subject.vehicle);
  cli.add_option("vehicle", o.wanted, "vehicle; none: all")->check(CLI::IsMember(names));
  cli.add_option("--runs", o.runs, "scenarios of each vehicle")
      ->check(CLI::Range(1U, 1'000'000'000U))
      ->capture_default_str();
  cli.add_option("--first", o.first, "number of the first scenario")->capture_default_str();
  cli.add_option("--shard", o.shard, "I/N: only each Nth of them, beginning with the Ith")
      ->capture_default_str();
  cli.add_option("--out", o.out, "write the results there, for merge");
  const CLI::Option* const script = cli.add_option(
      "--script", o.script, "one scenario, with its choices as hexadecimal bytes; \"\": all are 0");
  cli.add_option("--flips", o.flips.flips,
                 "instead: flip as many single bits of the daemon's memory, or of --part");
  cli.add_option("--part", o.flips.part,
                 "flips: this part only, as the table names it; \"state\": all but the program; "
                 "\"registers\" or one of them (\"rip\"), \"stack\": of the threads, on amd64; "
                 "\"heap\", \"sensor lines\": of talaris; one of several: \"bus: grid\"");
  cli.add_option("--seed", o.flips.seed, "seed of the flips")->capture_default_str();
  cli.add_flag("--unprotected", o.unprotected,
               "flips: without the daemon's protection against them");
  cli.add_flag("--verbose", o.verbose, "report every scenario, not only violations");
  cli.add_option("--record", o.folder, "keep a flight recording of each scenario in this folder")
      ->check(CLI::ExistingDirectory);
  cli.add_option("--markdown", o.markdown, "write the document there");
  cli.footer(kExamples);
  CLI::App* merges = cli.add_subcommand(
      "merge", "Adds up the results of all shards of a campaign, or of flips of several seeds.");
  merges->add_option("file", o.files, "results (--out) of each shard or seed")->required();
  merges->add_option("--out", o.out, "write the sum there");
  merges->add_option("--markdown", o.markdown, "write the document there");
  CLI::App* searches = cli.add_subcommand(
      "search", "Looks for scenarios that break a condition, by the code that they reach.");
  searches->add_option("vehicle", o.searched)->required()->check(CLI::IsMember(names));
  searches->add_option("--for", o.seconds, "seconds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  searches->add_option("--corpus", o.corpus, "folder of scripts to begin with, to which it adds");
  searches->add_option("--out", o.out, "write there what was played");
  searches->add_option("--shard", o.shard, "I/N: other scripts in each of N searches");
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }

  try {
    for (const std::string& file : {o.out, o.markdown}) expect_writable(file);
    if (searches->parsed()) return search(o);
    if (o.flips.flips != 0) {
      fix_addresses(argv);
      o.flips.protect = !o.unprotected;
      return tell_flips(flip_bits(o.flips, o.wanted), o.out);
    }
    if (merges->parsed() && is_flips(o.files.front())) {
      if (!o.markdown.empty())
        throw std::runtime_error("--markdown is not for flips: the table is printed");
      return tell_flips(merge_flips(o.files), o.out);
    }
    if (script->count() != 0) return play_script(o);
    const Results results = merges->parsed() ? merge_files(o) : play(o);
    if (!o.out.empty()) write(results, o.out);
    if (!o.markdown.empty()) write_document(results, o.markdown);
    const bool held = std::ranges::all_of(
        results.summaries, [](const Summary& summary) { return summary.broken == 0; });
    return held ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "lss-campaign: {}\n", error.what());
    return 2;
  }
}
