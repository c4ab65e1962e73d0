#pragma once

// Faults that can be injected while a simulator runs: the types of a vehicle, their arguments,
// their syntax ("5s:module-dead:3", "clear:noise"), and the active ones. Parsing is for start-up
// and for the control thread; FaultBoard may be called from any thread: one lock, short lists.

#include <functional>
#include <mutex>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/time.h"

namespace lss::sim {

struct FaultArgument {
  const char* name;  // "N", "P", "SECONDS"
  const char* meaning;
  double min, max;
  bool whole = false;
  bool optional = false;
  double fallback = 0;
  bool hexadecimal = false;                 // output format; both are accepted
  std::span<const double> choices = {};     // only these, when there are any
  std::span<const char* const> words = {};  // instead of numbers: of min, min + 1, ... max
};

struct FaultKind {
  const char* name;
  std::span<const FaultArgument> arguments;
  const char* meaning;
  bool momentary = false;  // happens once; cannot be cleared
  std::size_t per_unit =
      0;  // number of first arguments that select the unit; each unit has its own fault
};

struct Fault {
  const FaultKind* kind = nullptr;  // nullptr: all, only when clearing
  std::vector<double> values;  // one for each argument; when clearing, none or those of the unit
  bool clear = false;
};

struct TimedFault {
  double at_s = 0;
  Fault fault;
};

// "KIND[:ARG...]", "clear", "clear:KIND" or "clear:KIND:UNIT". The error is a sentence for a
// person.
tl::expected<Fault, std::string> parse_fault(std::string_view text,
                                             std::span<const FaultKind> kinds);

// "TIME:" before it; TIME is 5s, 0.5s, 500ms or 2min after the start.
tl::expected<TimedFault, std::string> parse_timed_fault(std::string_view text,
                                                        std::span<const FaultKind> kinds);

// As parse_fault reads it.
std::string to_text(const Fault& fault);

// One line for each type, with arguments and their ranges.
std::string describe(std::span<const FaultKind> kinds);

// The nearest of `names` in spelling, empty when none is near.
std::string nearest_name(std::string_view wrong, std::span<const std::string> names);

// Whether a fault of this probability strikes now.
inline bool strikes(double probability, std::mt19937& random) {
  return probability > 0 && std::bernoulli_distribution(probability)(random);
}

// The faults of a serial line or a CAN bus.
struct WireFaults {
  double noise = 0;      // probability that a character or a frame is changed
  double drop = 0;       // ... that a frame is lost whole, either direction
  double duplicate = 0;  // ... that a frame comes twice
  TimeNs late_ns = 0;    // delay of what the devices say
  bool cut = false;      // nothing passes, either direction

  // For noise, drop, duplicate, late and bus-cut; of a numbered line, line-noise and so on. False
  // when the fault is none of these.
  bool set(const Fault& fault, bool attach);
};

// The active faults. `act` carries out attaching and clearing; it is called without the lock.
class FaultBoard {
 public:
  using Act = std::function<void(const Fault&, bool attach)>;
  using InForce = std::function<bool(const Fault&)>;

  FaultBoard(Act act, InForce in_force) : act_(std::move(act)), in_force_(std::move(in_force)) {}

  void inject(const Fault& fault);
  // Canonical texts; those that ended by themselves are dropped.
  std::vector<std::string> attached();

 private:
  std::vector<Fault> take_matching(const Fault& fault);

  Act act_;
  InForce in_force_;
  std::mutex mutex_;
  std::vector<Fault> attached_;
};

}  // namespace lss::sim
