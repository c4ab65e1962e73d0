#include "tools/lss-cli/certify/scheduling.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <sstream>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli::certify {
namespace {

constexpr int kNoProgram = 127;

std::string list_of(const std::vector<int>& cpus) {
  return fmt::format("{}", fmt::join(cpus, ","));
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

Ran run_program(const std::vector<std::string>& words) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return {kNoProgram, "no pipe"};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  for (const int end : ends) ::posix_spawn_file_actions_addclose(&actions, end);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  Ran ran{.code = kNoProgram};
  if (error == 0) {
    std::array<char, 4096> part{};
    for (ssize_t n = 0; (n = ::read(ends[0], part.data(), part.size())) != 0;) {
      if (n < 0 && errno != EINTR) break;
      if (n > 0) ran.output.append(part.data(), static_cast<std::size_t>(n));
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  ::close(ends[0]);
  return ran;
}

std::optional<Timerlat> parse_timerlat(std::string_view output) {
  std::istringstream lines{std::string(output)};
  std::vector<bool> of_thread;  // the columns
  std::optional<Timerlat> found;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "Index") {
      of_thread.clear();
      while (words >> word) of_thread.push_back(word.starts_with("Thr"));
    } else if (word == "max:") {
      for (std::size_t i = 0; i < of_thread.size() && words >> word; ++i) {
        double ns = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), ns);
        if (error != std::errc{} || end != word.data() + word.size()) continue;  // "-": no sample
        if (!found) found.emplace();
        double& most_us = of_thread[i] ? found->thread_us : found->irq_us;
        most_us = std::max(most_us, ns / 1000);
      }
    }
  }
  if (found && found->thread_us <= 0) found.reset();
  return found;
}

std::optional<double> parse_cyclictest(std::string_view output) {
  std::optional<double> most_us;
  constexpr std::string_view kMax = "Max:";
  for (std::size_t at = 0; (at = output.find(kMax, at)) != std::string_view::npos;) {
    at = output.find_first_not_of(' ', at + kMax.size());
    if (at == std::string_view::npos) break;
    double ns = 0;
    const char* const end = output.data() + output.size();
    if (std::from_chars(output.data() + at, end, ns).ec == std::errc{})
      most_us = std::max(most_us.value_or(0), ns / 1000);
  }
  return most_us;
}

Scheduling measure_scheduling(const Place& place, int seconds) {
  const std::string cpus = list_of(place.cpus);
  // Its histogram is not used, only its maxima.
  std::vector<std::string> words = {"rtla", "timerlat",
                                    "hist", "--nano",
                                    "-b",   "1000",
                                    "-d",   fmt::format("{}s", seconds),
                                    "-P",   fmt::format("f:{}", place.priority)};
  if (!cpus.empty()) words.insert(words.end(), {"-c", cpus});
  const Ran rtla = run_program(words);
  if (rtla.code == 0) {
    if (const auto t = parse_timerlat(rtla.output)) {
      return {.us = t->irq_us + t->thread_us,
              .tool = fmt::format("{}", fmt::join(words, " ")),
              .note = fmt::format("the largest latency of the interrupt, {:.1f} us, and of the "
                                  "thread, {:.1f} us, added",
                                  t->irq_us, t->thread_us)};
    }
  }
  const std::string no_rtla =
      rtla.code == kNoProgram ? "rtla is not installed (apt-get install rtla)"
                              : fmt::format(
                                    "rtla timerlat failed: \"{}\" (it needs root and a kernel with "
                                    "CONFIG_TIMERLAT_TRACER, as Debian's has)",
                                    first_line(rtla.output));
  words = {"cyclictest",
           "--quiet",
           "--nsecs",
           "--mlockall",
           "--policy=fifo",
           "--interval=1000",
           fmt::format("--priority={}", place.priority),
           fmt::format("--duration={}", seconds)};
  if (cpus.empty()) {
    words.emplace_back("--smp");
  } else {
    words.insert(words.end(),
                 {"--affinity=" + cpus, fmt::format("--threads={}", place.cpus.size())});
  }
  const Ran cyclictest = run_program(words);
  if (const auto us = parse_cyclictest(cyclictest.output); cyclictest.code == 0 && us) {
    return {.us = *us,
            .tool = fmt::format("{}", fmt::join(words, " ")),
            .note = "a sample, not a bound: " + no_rtla};
  }
  throw Failure(
      ExitCode::failed, "the kernel's scheduling latency cannot be measured: " + no_rtla,
      cyclictest.code == kNoProgram
          ? "cyclictest is not installed either (apt-get install rt-tests); or give a known "
            "number: --latency-us N"
          : fmt::format("cyclictest failed, too: \"{}\"; run it as root, or give a known number: "
                        "--latency-us N",
                        first_line(cyclictest.output)));
}

}  // namespace lss::cli::certify
