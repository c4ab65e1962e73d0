#pragma once

// Counts the rounds of error solving for the same class of faults of one module, without a stretch
// of healthy operation in between: a limit for a leg that jams at every step, or for isolating one
// leg after another. Frame thread; nothing allocates.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "daemon/vehicles/zebro/solver.h"

namespace lss::zebro {

class Rounds {
 public:
  struct Most {
    unsigned rounds = 0;
    std::uint16_t module = 0;  // from 1 on; 0: none
  };

  // Error solving begins with these. Duplicates count once.
  void begun(std::span<const Symptom> symptoms) noexcept {
    std::array<bool, kKinds> counted{};
    for (const Symptom& symptom : symptoms) {
      const std::size_t kind = kind_of(symptom);
      if (!symptom.counts || std::exchange(counted[kind], true)) continue;
      rounds_[kind] = std::min(rounds_[kind] + 1, kMost);
    }
  }

  // The one of these with the most rounds.
  Most most(std::span<const Symptom> symptoms) const noexcept {
    Most most;
    for (const Symptom& symptom : symptoms) {
      const unsigned rounds = rounds_[kind_of(symptom)];
      if (symptom.counts && rounds > most.rounds)
        most = {.rounds = rounds, .module = symptom.module};
    }
    return most;
  }

  // Without a stretch of healthy operation in between; 0: never.
  unsigned of(const Symptom& symptom) const noexcept { return rounds_[kind_of(symptom)]; }

  void forget() noexcept { rounds_ = {}; }

 private:
  static constexpr std::size_t kKinds = kFaultClasses * (kModules + 1);
  static constexpr unsigned kMost = 1'000'000;

  static std::size_t kind_of(const Symptom& symptom) noexcept {
    return static_cast<std::size_t>(symptom.fault_class) * (kModules + 1) +
           std::min<std::size_t>(symptom.module, kModules);
  }

  std::array<unsigned, kKinds> rounds_{};
};

}  // namespace lss::zebro
