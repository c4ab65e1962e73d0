#include "tests/campaign/flips.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numeric>
#include <stdexcept>

extern "C" const char __executable_start;

namespace lss::campaign {
namespace {

constexpr double kZ95 = 1.959964;
constexpr unsigned kWall = 10;  // seconds for each second of CPU, beside other programs

bool of_the_daemon(std::string_view name) {
  for (const std::string_view what : {"vtable for ", "guard variable for ", "typeinfo for "})
    if (name.starts_with(what)) name.remove_prefix(what.size());
  if (name.starts_with("non-virtual thunk to ")) name.remove_prefix(21);
  // Of the test alone; a template of the daemon may still name it in its arguments.
  const std::string_view own = name.substr(0, name.find('('));
  for (const std::string_view test : {"sim::", "campaign::", "testing_support::", "::Chain",
                                      "::FrameBus", "::BusLine", "::Line::", "typeinfo name"})
    if (own.find(test) != own.npos) return false;
  return own.find("lss::") != own.npos && !own.starts_with("std::") && !own.starts_with("fmt::") &&
         own.find("CLI::") == own.npos;
}

// All of this program.
std::vector<FlipPart> read_symbols() {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(
      popen("nm -SC --defined-only /proc/$PPID/exe", "r"), pclose);
  std::vector<FlipPart> all;
  std::array<char, 8192> line;
  while (pipe && std::fgets(line.data(), line.size(), pipe.get()) != nullptr) {
    unsigned long address = 0, size = 0;
    char type = 0;
    int name_at = 0;
    if (std::sscanf(line.data(), "%lx %lx %c %n", &address, &size, &type, &name_at) != 3) continue;
    std::string name(&line[static_cast<std::size_t>(name_at)]);
    while (!name.empty() && name.back() == '\n') name.pop_back();
    if (std::strchr("tTwWvVrRdDbBu", type) == nullptr) continue;
    auto* at = reinterpret_cast<std::uint8_t*>(const_cast<char*>(&__executable_start) +
                                               address);  // linked at 0
    all.push_back({name, {at, size}, FlipPart::program});
  }
  if (all.empty())
    throw std::runtime_error(
        "nm does not list this program's symbols: install binutils, do not strip it");
  return all;
}

const std::vector<FlipPart>& symbols() {
  static const std::vector<FlipPart> all = read_symbols();
  return all;
}

// What a copy of this process writes into its pipe; empty when it fails.
struct Copied {
  std::vector<std::uint8_t> bytes;
  bool hung = false;
};
Copied copy(const std::function<std::vector<std::uint8_t>()>& run, unsigned cpu_s) {
  int ends[2];
  std::fflush(nullptr);
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("this process cannot be copied: out of memory?");
  if (child == 0) {
    close(ends[0]);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDERR_FILENO);
    dup2(nowhere, STDOUT_FILENO);
    const rlimit no_core{0, 0}, cpu{cpu_s, cpu_s}, memory{4ul << 30, 4ul << 30};
    setrlimit(RLIMIT_CORE, &no_core);
    setrlimit(RLIMIT_CPU, &cpu);
    setrlimit(RLIMIT_AS, &memory);
    alarm(kWall * cpu_s);  // it may also wait for something that never comes
    try {
      const std::vector<std::uint8_t> result = run();
      for (std::size_t at = 0; at < result.size();) {
        const ssize_t put = write(ends[1], &result[at], result.size() - at);
        if (put <= 0) break;
        at += static_cast<std::size_t>(put);
      }
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  close(ends[1]);
  Copied result;
  std::array<std::uint8_t, 4096> some;
  for (ssize_t got; (got = read(ends[0], some.data(), some.size())) > 0;)
    result.bytes.insert(result.bytes.end(), some.begin(), some.begin() + got);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) result.bytes.clear();
  for (const int limit : {SIGPROF, SIGXCPU, SIGKILL, SIGALRM})
    result.hung |= WIFSIGNALED(status) && WTERMSIG(status) == limit;
  return result;
}

template <class T>
std::vector<std::uint8_t> as_bytes(const T* values, std::size_t count) {
  std::vector<std::uint8_t> bytes(count * sizeof(T));
  std::memcpy(bytes.data(), values, bytes.size());
  return bytes;
}

std::uint64_t total(const FlipTally& tally) {
  return std::accumulate(tally.begin(), tally.end(), std::uint64_t{0});
}

std::string share(std::uint64_t hits, std::uint64_t of) {
  if (of == 0) return "-";
  const Interval i = wilson(hits, of);
  return fmt::format("{} ({:.3f} %, {:.3f} to {:.3f})", hits,
                     100.0 * static_cast<double>(hits) / static_cast<double>(of), 100 * i.low,
                     100 * i.high);
}

std::string row(const std::string& name, const std::string& bytes, const FlipTally& tally) {
  std::string text = fmt::format("| {} | {} | {} |", name, bytes, total(tally));
  for (const std::uint64_t n : tally) text += fmt::format(" {} |", share(n, total(tally)));
  return text + "\n";
}

}  // namespace

const std::vector<FlipPart>& program_parts() {
  static const std::vector<FlipPart> parts = [] {
    std::vector<FlipPart> all = symbols();
    std::erase_if(all, [](const FlipPart& part) { return !of_the_daemon(part.name); });
    return all;
  }();
  return parts;
}

std::string function_at(std::uintptr_t instruction) {
  for (const FlipPart& part : symbols()) {
    const auto begin = reinterpret_cast<std::uintptr_t>(part.bytes.data());
    if (instruction >= begin && instruction < begin + part.bytes.size()) return part.name;
  }
  return "a library";
}

void flip(std::span<std::uint8_t> bytes, std::uint64_t bit) {
  std::uint8_t* at = &bytes[bit / 8];
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  void* begin = reinterpret_cast<void*>(reinterpret_cast<std::uintptr_t>(at) / page * page);
  // Code stays writable in this copy: a page may have both.
  if (mprotect(begin, page, PROT_READ | PROT_WRITE | PROT_EXEC) != 0)
    throw std::runtime_error("a page cannot be made writable");
  *at = static_cast<std::uint8_t>(*at ^ 1u << bit % 8);
  __builtin___clear_cache(reinterpret_cast<char*>(at), reinterpret_cast<char*>(at) + 1);
}

FlipResult in_a_copy(const std::function<FlipResult()>& run, unsigned cpu_s) {
  const auto [bytes, hung] = copy(
      [&] {
        const FlipResult result = run();
        return as_bytes(&result, 1);
      },
      cpu_s);
  FlipResult result{.hung = hung};
  if (bytes.size() == sizeof result) std::memcpy(&result, bytes.data(), sizeof result);
  return result;
}

std::vector<std::uint64_t> told_by_a_copy(const std::function<std::vector<std::uint64_t>()>& run) {
  constexpr unsigned kCpu_s = 600;
  const Copied copied = copy(
      [&] {
        const std::vector<std::uint64_t> all = run();
        return as_bytes(all.data(), all.size());
      },
      kCpu_s);
  if (copied.bytes.empty()) throw std::runtime_error("the run without a flip fails");
  std::vector<std::uint64_t> all(copied.bytes.size() / sizeof(std::uint64_t));
  std::memcpy(all.data(), copied.bytes.data(), all.size() * sizeof(std::uint64_t));
  return all;
}

std::uint64_t digest(std::uint64_t before, std::span<const std::uint8_t> bytes) {
  constexpr std::uint64_t kPrime = 0x9E37'79B9'7F4A'7C15;
  std::uint64_t d = before + bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, &bytes[at], std::min<std::size_t>(8, bytes.size() - at));
    d = (d ^ word) * kPrime;
    d ^= d >> 29;
  }
  return d;
}

Interval wilson(std::uint64_t hits, std::uint64_t of) {
  if (of == 0) return {0, 1};
  const auto n = static_cast<double>(of);
  const double p = static_cast<double>(hits) / n, z2 = kZ95 * kZ95;
  const double middle = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ95 / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return {std::max(middle - half, 0.0), std::min(middle + half, 1.0)};
}

std::string flip_table(std::string_view vehicle, const FlipCounts& counts) {
  std::string text = fmt::format(
      "### {}\n\n{} scenarios, {:.1f} h simulated after flips; slowest detection {:.2f} s.\n\n| "
      "what was hit | bytes | flips |",
      vehicle, counts.scenarios, counts.simulated_s / 3600, counts.slowest_detection_s);
  for (const char* name : kFlipOutcomeNames) text += fmt::format(" {} |", name);
  text += "\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  std::uint64_t program_bytes = 0, state_bytes = 0;
  for (const FlipPart& part : program_parts()) program_bytes += part.bytes.size();
  for (const auto& [name, bytes] : counts.bytes) state_bytes += bytes;
  if (total(counts.state) != 0) text += row("**state**", std::to_string(state_bytes), counts.state);
  for (const auto& [name, tally] : counts.parts) {
    const auto bytes = counts.bytes.find(name);
    const bool known = bytes != counts.bytes.end();
    if (name != "program") text += row(name, known ? std::to_string(bytes->second) : "-", tally);
  }
  if (total(counts.program) != 0)
    text += row("**code, constants**", std::to_string(program_bytes), counts.program);
  if (counts.instructions != Instructions{})
    text += fmt::format("\nDrawn among {} instructions of the thread frame, {} of bus.\n",
                        counts.instructions[0], counts.instructions[1]);

  for (const auto& [name, hung] : counts.hung)
    text += fmt::format("\nOf the restarts of {}, {} hung.\n", name, hung);

  std::vector<std::pair<std::string, FlipTally>> worst(counts.places.begin(), counts.places.end());
  const auto harm = [](const FlipTally& t) {
    return 10 * t[static_cast<std::size_t>(FlipOutcome::silent)] +
           1000 * t[static_cast<std::size_t>(FlipOutcome::unsafe)] +
           t[static_cast<std::size_t>(FlipOutcome::restarted)];
  };
  std::ranges::stable_sort(worst, std::ranges::greater{},
                           [&](const auto& place) { return harm(place.second); });
  constexpr std::size_t kWorst = 12;
  if (worst.size() > kWorst) worst.resize(kWorst);
  text += "\n| worst places | restarted | silent | unsafe |\n|---|---:|---:|---:|\n";
  for (const auto& [name, tally] : worst) {
    if (harm(tally) != 0)
      text += fmt::format("| `{}` | {} | {} | {} |\n", name, tally[3], tally[4], tally[5]);
  }
  return text;
}

}  // namespace lss::campaign
