#pragma once

// The faults of `lss-sim faults zebro` on a walking Lunar Zebro, alone and two at a time: what must
// happen and by when (docs/icd-zebro.md, config/zebro.toml), and what did. The vehicle walks on
// kinematics, in virtual time.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/cycle/messages.h"

namespace lss::zebro {

enum class Reaction : std::uint8_t {
  walks_on,
  warns,  // walks on, and a fault that is a warning says so
  stops,  // emergency stop to all, FatalError
};

// Faults hidden while it lasts.
enum class Hides : std::uint8_t { nothing, module, line };

// Result of `solve` while the fault lasts.
enum class Lasting : std::uint8_t { not_stopped, idle, isolated, remains };

struct FaultCase {
  const char* fault;  // as for lss-sim, # for the module
  Reaction reaction;
  FaultId id;                     // the evidence
  double within_s;                // from the fault to FatalError, or to the warning
  const char* because;            // where that time comes from
  std::array<FaultId, 3> also{};  // may be said besides, or instead
  Hides hides = Hides::nothing;
  double delays_s = 0;  // other faults are seen so much later
  Lasting lasting = Lasting::not_stopped;
  bool until_restored = false;  // `solve` isolates the leg also when the fault has gone

  bool of_module() const;
  // "module-dead:3"
  std::string text(unsigned module) const;
};

std::span<const FaultCase> fault_cases();
// Those that are looked at two at a time: the first ones. What a sensor or gear does to another
// fault of its leg depends on where the leg is.
std::span<const FaultCase> paired_cases();

struct Injection {
  const FaultCase* fault = nullptr;
  unsigned module = 1;
  double at_s = 0;  // after the first
};

struct Observed {
  std::optional<double> stopped_s;  // from the first fault to FatalError
  std::optional<double> warned_s;   // to the first warning
  std::vector<std::string> wrong;   // violations, for a person
};

// Stands up, walks for a while that `seed` gives, breaks; if it stopped, all faults are cleared and
// solved and it stands again, else it comes to a safe stop.
Observed break_walk(unsigned seed, std::span<const Injection> injections);

// Walks, breaks, and solves while the fault lasts.
Lasting solve_while_it_lasts(unsigned seed, const Injection& injection);

}  // namespace lss::zebro
