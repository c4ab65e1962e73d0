// lss-search: looks for scripts of scenarios that break a condition, with libFuzzer's engine. Its
// feedback is the vehicle's behaviour: which situation of the supervisor followed which (state,
// mode, faults, modules out of service). lss-campaign search starts it; the programs are those of
// the release, in full speed. docs/fuzzing.md.

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <optional>

#include "tests/campaign/results.h"
#include "tests/campaign/script.h"
#include "tests/support/stamp.h"

// Of compiler-rt.
extern "C" int LLVMFuzzerRunDriver(int* argc, char*** argv,
                                   int (*play)(const std::uint8_t* script, std::size_t size));

namespace {

using namespace lss::campaign;

// The engine keeps a script that reaches a new one, and clears them before each.
[[gnu::section("__libfuzzer_extra_counters")]] std::array<std::uint8_t, 1u << 16> seen;

class Search {
 public:
  Search(const Subject& subject, Shard shard, const char* out)
      : subject_(subject), shard_(shard), out_(out), summary_(subject) {}

  void play(const Script& script) {
    const std::clock_t begin = std::clock();
    const Run run = play_seen(script);
    summary_.add(run);
    summary_.cpu_s += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (!run.broken.empty()) found(script, run);
  }

  void write_results() const {
    if (out_ == nullptr) return;
    write({.commit =
               lss::testing_support::commit_around(std::filesystem::read_symlink("/proc/self/exe")),
           .first = 1,
           .runs = 0,
           .shard = shard_,
           .summaries = {summary_}},
          out_);
  }

 private:
  static constexpr unsigned kPlays = 400;  // of a shrink

  Run play_seen(const Script& script) const {
    std::uint64_t last = 0;
    return subject_.play_script(script, [&last](std::uint64_t situation) {
      if (situation == last) return;
      std::uint8_t& counter = seen[(last * 31 + situation) >> 48];
      if (counter < 255) ++counter;
      last = situation;
    });
  }

  // A sentence without its time and its numbers: shrinking must not go on to another violation.
  static std::string kind(const Run& run) {
    std::string text = run.broken.front();
    std::erase_if(text, [](char c) {
      return std::string_view("0123456789.-").find(c) != std::string_view::npos;
    });
    return text;
  }

  [[noreturn]] void found(const Script& script, const Run& run) {
    fmt::print("broken: {}\nshrinks {} bytes\n", run.broken.front(), script.size());
    const auto fails = [&](const Script& shorter) {
      const Run again = play_seen(shorter);
      return !again.broken.empty() && kind(again) == kind(run);
    };
    const std::string shortest = to_hex(shrink(script, fails, kPlays));
    const Run last = play_seen(*from_hex(shortest));
    for (const std::string& line : last.story) fmt::print("  {}\n", line);
    summary_.complaints.clear();
    for (const std::string& line : last.broken) {
      fmt::print("  BROKEN {}\n", line);
      summary_.complaints.push_back(fmt::format("--script {}: {}", shortest, line));
    }
    fmt::print("repeat: lss-campaign {} --script {}\n", subject_.vehicle,
               shortest.empty() ? "''" : shortest);
    std::fflush(stdout);
    write_results();
    std::_Exit(1);
  }

  const Subject& subject_;
  Shard shard_;
  const char* out_;
  Summary summary_;
};

// For the test of the search: breaks when five bytes are right, each of which is a
// situation of its own. Without feedback that takes forever.
Subject planted() {
  Subject subject{};
  subject.vehicle = "planted";
  subject.play_script = [](std::span<const std::uint8_t> script,
                           const std::function<void(std::uint64_t)>& tell) {
    Run run;
    std::uint64_t right = 0;
    if (tell) tell(1);
    for (; right < 5 && right < script.size() && script[right] == 3 * right + 100; ++right)
      if (tell) tell((right + 1) * 0x9E37'79B9'7F4A'7C15u);
    if (right == 5) run.broken.emplace_back("0.000 s: planted");
    run.simulated_s = 1;
    return run;
  };
  return subject;
}

std::optional<Search> search;

int play(const std::uint8_t* script, std::size_t size) {
  search->play({script, script + size});
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  static const Subject fake = planted();
  const Subject* subject = nullptr;
  const std::string vehicle = argc > 1 ? argv[1] : "";
  for (const Subject& one : subjects())
    if (one.vehicle == vehicle) subject = &one;
  if (vehicle == fake.vehicle) subject = &fake;
  if (subject == nullptr) {
    fmt::print(stderr,
               "Usage: lss-search VEHICLE [OPTION of libFuzzer...], by lss-campaign search\n");
    return 2;
  }
  argv[1] = argv[0];
  --argc, ++argv;
  const char* const shard = std::getenv("LSS_SEARCH_SHARD");
  search.emplace(*subject, shard != nullptr ? parse_shard(shard) : Shard{},
                 std::getenv("LSS_SEARCH_OUT"));
  std::atexit([] { search->write_results(); });
  return LLVMFuzzerRunDriver(&argc, &argv, play);
}
