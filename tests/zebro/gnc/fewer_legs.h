#pragma once

// Sets of legs out of service, for tests.

#include <bit>
#include <string>
#include <vector>

#include "gnc/zebro/fewer_legs.h"
#include "tests/zebro/gnc/generators.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {

inline constexpr const char* kLegNames[] = {"LF", "RF", "LM", "RM", "LH", "RH"};
inline constexpr const char* kSpeedNames[] = {"zero", "low", "medium", "high"};

// All sets of one and of two legs.
inline std::vector<LegSet> some_isolated() {
  std::vector<LegSet> sets;
  for (int legs = 1; legs < 1 << kLegs; ++legs) {
    if (std::popcount(static_cast<LegSet>(legs)) <= 2) sets.push_back(static_cast<LegSet>(legs));
  }
  return sets;
}

inline std::vector<LegSet> creeping() {
  std::vector<LegSet> sets;
  for (const LegSet legs : some_isolated()) {
    if (creeps_without(legs, {})) sets.push_back(legs);
  }
  return sets;
}

inline std::vector<LegSet> rowing() {
  std::vector<LegSet> sets;
  for (const LegSet legs : some_isolated()) {
    if (can_walk_without(legs) && !creeps_without(legs, {})) sets.push_back(legs);
  }
  return sets;
}

inline std::string legs_text(LegSet legs) {
  std::string text;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(legs, i)) text += (text.empty() ? "" : " ") + std::string(kLegNames[i]);
  }
  return text;
}

}  // namespace lss::gnc::zebro::test
