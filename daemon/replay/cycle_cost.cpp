#include "daemon/replay/cycle_cost.h"

#include <fmt/format.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include "daemon/runtime/clock.h"

namespace lss::record {
namespace {

constexpr int kWarmPasses = 3, kColdPasses = 5;
constexpr std::uint64_t kMostInstructions = 20'000'000;  // of a frame
constexpr double kNever = std::numeric_limits<double>::infinity();

// The frames of a recording in their order, some of them chosen.
class Chosen : public Probe {
 public:
  explicit Chosen(const std::vector<bool>& chosen) : chosen_(chosen) {}

 protected:
  bool is_chosen() const { return at_ < chosen_.size() && chosen_[at_]; }
  std::size_t at() const { return at_; }
  void next() { ++at_; }

 private:
  const std::vector<bool>& chosen_;
  std::size_t at_ = 0;
};

// All frames.
struct Executed {
  std::vector<std::uint64_t> number{};
  std::vector<double> least_ns{};
};

class Clock final : public Probe {
 public:
  explicit Clock(Executed& frames) : frames_(frames) {}
  void begin() noexcept override { begin_ns_ = machine_ns(); }
  void end(std::uint64_t frame) noexcept override {
    const auto took_ns = static_cast<double>(machine_ns() - begin_ns_);
    if (at_ == frames_.number.size()) {
      frames_.number.push_back(frame);
      frames_.least_ns.push_back(took_ns);
    }
    frames_.least_ns[at_] = std::min(frames_.least_ns[at_], took_ns);
    ++at_;
  }

 private:
  Executed& frames_;
  TimeNs begin_ns_ = 0;
  std::size_t at_ = 0;
};

// The times of the chosen frames, with no line of theirs in the caches of data.
class ColdClock final : public Chosen {
 public:
  ColdClock(const std::vector<bool>& chosen, std::vector<double>& least_ns)
      : Chosen(chosen), least_ns_(least_ns), other_(size()) {}
  void begin() noexcept override {
    if (!is_chosen()) return;
    constexpr std::size_t kLine = 64;
    volatile char* const other = other_.data();
    for (std::size_t i = 0; i < other_.size(); i += kLine) other[i] = static_cast<char>(i);
    begin_ns_ = machine_ns();
  }
  void end(std::uint64_t) noexcept override {
    if (is_chosen()) {
      const auto took_ns = static_cast<double>(machine_ns() - begin_ns_);
      least_ns_[at()] = std::min(least_ns_[at()], took_ns);
    }
    next();
  }

 private:
  // Twice the last cache; one that many processors share has more than its part for us.
  static std::size_t size() {
    constexpr long kLeast = 4 << 20, kMost = 64 << 20;
    const long last = std::max(::sysconf(_SC_LEVEL3_CACHE_SIZE), ::sysconf(_SC_LEVEL2_CACHE_SIZE));
    return static_cast<std::size_t>(std::clamp(2 * last, kLeast, kMost));
  }

  std::vector<double>& least_ns_;
  std::vector<char> other_;
  TimeNs begin_ns_ = 0;
};

// In the counted process: a signal at both ends of a chosen frame, which the counter receives.
class Marks final : public Chosen {
 public:
  using Chosen::Chosen;
  void begin() noexcept override {
    if (is_chosen()) ::raise(SIGUSR1);
  }
  void end(std::uint64_t) noexcept override {
    if (is_chosen()) ::raise(SIGUSR1);
    next();
  }
};

tl::expected<void, std::string> replayed(const std::filesystem::path& path, Probe& probe) {
  std::string said;
  const Replayed result = replay_file(
      path, [&](const std::string& line) { said += line; }, &probe);
  if (result == Replayed::equal || result == Replayed::incomplete) return {};
  return tl::unexpected(said);
}

class Tracer {
 public:
  explicit Tracer(pid_t child) : child_(child) {}
  ~Tracer() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  // The signal that it stopped for; 0: it ended.
  int resume(bool one_instruction) {
    if (::ptrace(one_instruction ? PTRACE_SINGLESTEP : PTRACE_CONT, child_, nullptr, nullptr) != 0)
      return 0;
    return wait();
  }
  int wait() {
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0) {
      if (errno != EINTR) return 0;
    }
    if (WIFSTOPPED(status)) return WSTOPSIG(status);
    child_ = 0;
    return 0;
  }

 private:
  pid_t child_;
};

// Instructions between the next two marks; 0: there are none any more.
std::uint64_t between_marks(Tracer& tracer) {
  for (int signal = tracer.resume(false); signal != SIGUSR1; signal = tracer.resume(false)) {
    if (signal == 0) return 0;
  }
  for (std::uint64_t steps = 1; steps < kMostInstructions; ++steps) {
    const int signal = tracer.resume(true);
    if (signal == SIGUSR1) return steps;
    if (signal == 0) return 0;
  }
  return 0;
}

// In the order of the chosen frames.
tl::expected<std::vector<std::uint64_t>, std::string> count(const std::filesystem::path& path,
                                                            const std::vector<bool>& chosen) {
  const pid_t child = ::fork();
  if (child < 0) return tl::unexpected(fmt::format("fork: {}", std::strerror(errno)));
  if (child == 0) {
    if (::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) ::_exit(1);
    ::raise(SIGSTOP);
    ::raise(SIGUSR1);  // nothing between two marks: what they cost by themselves
    ::raise(SIGUSR1);
    Marks marks(chosen);
    ::_exit(replayed(path, marks) ? 0 : 1);
  }
  Tracer tracer(child);
  if (tracer.wait() != SIGSTOP)
    return tl::unexpected(std::string(
        "a process may not trace its own child here (ptrace): allow it in the sandbox, or run "
        "it outside"));
  const std::uint64_t nothing = between_marks(tracer);
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(std::ranges::count(chosen, true)));
  for (std::uint64_t& instructions : counts) {
    instructions = between_marks(tracer);
    if (nothing == 0 || instructions <= nothing)
      return tl::unexpected(
          std::string("instructions cannot be counted here: no processor that steps one by one"));
    instructions -= nothing;
  }
  return counts;
}

}  // namespace

tl::expected<CycleCost, std::string> cycle_cost(const std::filesystem::path& path,
                                                std::size_t most) {
  Executed frames;
  for (int pass = 0; pass < kWarmPasses; ++pass) {
    Clock clock(frames);
    if (auto ok = replayed(path, clock); !ok) return tl::unexpected(ok.error());
  }
  const std::size_t all = frames.number.size();
  if (all == 0) return tl::unexpected(path.string() + ": no frame of it can be executed");
  std::vector<std::size_t> order(all);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order,
                           [&](auto a, auto b) { return frames.least_ns[a] > frames.least_ns[b]; });
  order.resize(std::min(all, most));
  std::ranges::sort(order);
  std::vector<bool> chosen(all);
  for (const std::size_t i : order) chosen[i] = true;

  const auto counts = count(path, chosen);
  if (!counts) return tl::unexpected(counts.error());
  std::vector<double> cold_ns(all, kNever);
  for (int pass = 0; pass < kColdPasses; ++pass) {
    ColdClock clock(chosen, cold_ns);
    if (auto ok = replayed(path, clock); !ok) return tl::unexpected(ok.error());
  }

  CycleCost cost{.frames = all, .counted = order.size()};
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint64_t instructions = (*counts)[i];
    const double ns = cold_ns[order[i]];
    cost.ns_per_instruction =
        std::max(cost.ns_per_instruction, ns / static_cast<double>(instructions));
    cost.longest_ns = std::max(cost.longest_ns, ns);
    if (instructions > cost.instructions) {
      cost.instructions = instructions;
      cost.frame = frames.number[order[i]];
    }
  }
  return cost;
}

}  // namespace lss::record
