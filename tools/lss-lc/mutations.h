#pragma once

// Measures how well the properties cover the table: every row is changed in turn, and the
// exploration must detect each change. With all properties, and with the requirements alone:
// without the contracts, which say of each event exactly when it is accepted.

#include <array>
#include <string>
#include <vector>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

enum class Change : std::uint8_t {
  dropped,     // not from one of its states or modes
  redirected,  // to another state, mode or goal
  loosened,    // without a guard
  idle,        // without an action
  widened,     // from another state or mode, too
  busy,        // with another action
};
inline constexpr std::size_t kChanges = 6;
inline constexpr const char* kChangeNames[kChanges] = {"dropped transition", "redirected",
                                                       "missing guard",      "missing action",
                                                       "widened row",        "added action"};

struct Mutations {
  struct Count {
    std::size_t all = 0;
    std::size_t caught = 0;      // by the properties
    std::size_t equivalent = 0;  // no reachable state behaves differently: nothing to detect
    std::size_t demanded = 0;    // of those caught: by the requirements alone
  };
  std::array<Count, kChanges> of{};     // by Change
  std::vector<std::string> survivors;   // undetected by all properties
  std::vector<std::string> undemanded;  // detected by contracts only
  double seconds = 0;

  Count sum() const;
};

// With few modules, for speed.
Mutations mutate(const Verified& vehicle);

}  // namespace lss::lc
