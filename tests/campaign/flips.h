#pragma once

// Flipped bits: radiation changes single bits in the memory of a commercial computer. At a drawn
// moment of a run one drawn bit is flipped in what the daemon keeps in memory, in its code and
// constants, or in registers and stack of a thread (traps.h); the run goes on in a copy of the
// process (fork), and what reached the bus is compared bit by bit with the same run without a flip.
// Not flipped: the libraries (DDS, C).

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/campaign/traps.h"

namespace lss::campaign {

enum class FlipOutcome : std::uint8_t {
  none,       // the same on the bus, nothing was reported
  corrected,  // the same on the bus, and reported
  safe,       // other orders, with a report of it within a second
  restarted,  // the process ended, or hung: the watchdog's restart
  silent,     // other orders, without a report
  unsafe,     // a rule of rules.h is broken
};
inline constexpr std::size_t kFlipOutcomes = 6;
inline constexpr const char* kFlipOutcomeNames[] = {"no effect", "corrected",    "detected, safe",
                                                    "restarted", "silent wrong", "unsafe"};
using FlipTally = std::array<std::uint64_t, kFlipOutcomes>;

struct FlipPlan {
  unsigned seed = 1;
  unsigned flips = 0;
  bool to_the_end = false;  // also runs in which nothing of the flip is left
  bool protect = true;      // with the daemon's own protection
  // Only this one; "state": all of it; empty: the program too. "registers", a register's name,
  // "stack", "heap" and what else a chain has are flipped only when they are named here.
  // Of several things with one name one can be named, too: "bus: grid".
  std::string part{};
  std::optional<std::uint64_t> bit{};  // always this one of the part
};

// Bytes of the daemon. Program: its code, constants and static data. Of a thread: registers, or the
// stack, without bytes.
struct FlipPart {
  enum Kind : std::uint8_t { state, program, more, of_thread };

  std::string name;
  std::span<std::uint8_t> bytes;
  Kind kind = state;
  DaemonThread thread = DaemonThread::frame;
};

struct FlipCounts {
  std::map<std::string, std::uint64_t> bytes;  // of each part
  std::map<std::string, FlipTally> parts;
  FlipTally state{}, program{};               // sums of parts of these kinds
  Instructions instructions{};                // among which flips of registers and stack are drawn
  std::map<std::string, FlipTally> places;    // where they were other than without effect
  std::map<std::string, std::uint64_t> hung;  // of the restarts of each part
  unsigned scenarios = 0;
  double simulated_s = 0, slowest_detection_s = 0;
};

// Functions and constants of the daemon in this program, by its table of symbols (nm of binutils).
// Throws std::runtime_error where that cannot be read.
const std::vector<FlipPart>& program_parts();
// The function of this program, also of the test, or "a library".
std::string function_at(std::uintptr_t instruction);
// The bit of this part, also where it is write-protected.
void flip(std::span<std::uint8_t> bytes, std::uint64_t bit);

// Runs `run` in a copy of this process. restarted: it ended, threw, or took more than `cpu_s` or
// ten times as long by the clock.
struct FlipResult {
  FlipOutcome outcome = FlipOutcome::restarted;
  double detected_s = 0;  // safe: after the first other order
  bool hung = false;      // restarted: it took too long
  bool waits = false;     // none, so far
};
FlipResult in_a_copy(const std::function<FlipResult()>& run, unsigned cpu_s);
// The bytes that `run` returns, from a copy of this process. Throws std::runtime_error.
std::vector<std::uint64_t> told_by_a_copy(const std::function<std::vector<std::uint64_t>()>& run);

std::uint64_t digest(std::uint64_t before, std::span<const std::uint8_t> bytes);

// Of everything that a master put on its bus, with its times.
struct Sent {
  std::uint64_t digest = 0;
  template <class... T>
  void add(const T&... values) {
    const auto one = [this](const auto& value) {
      digest =
          campaign::digest(digest, {reinterpret_cast<const std::uint8_t*>(&value), sizeof value});
    };
    (one(values), ...);
  }
};

// The 95 % interval of a share (Wilson 1927).
struct Interval {
  double low, high;
};
Interval wilson(std::uint64_t hits, std::uint64_t of);

// Of one vehicle, in Markdown. `command`: what repeats it.
std::string flip_table(std::string_view vehicle, const FlipCounts& counts);

}  // namespace lss::campaign
