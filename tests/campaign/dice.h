#pragma once

// Random choices of a scenario, the same for the same number everywhere.

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "idl/commands.h"
#include "tools/lss-sim/frame/faults.h"

namespace lss::campaign {

class Dice {
 public:
  explicit Dice(unsigned number) : random_(number * 2'654'435'761u + 97u) {}

  double between(double from, double to) { return from + (to - from) * share(); }
  int whole(int from, int to) {
    return from + static_cast<int>(share() * (static_cast<double>(to) - from + 1));
  }
  bool chance(double p) { return share() < p; }
  template <class Range>
  const auto& one_of(const Range& range) {
    return range[static_cast<std::size_t>(whole(0, static_cast<int>(std::size(range)) - 1))];
  }

 private:
  // Not by the library's distributions: they differ between libraries.
  double share() { return static_cast<double>(random_()) / 4294967296.0; }

  std::mt19937 random_;
};

// As lss-sim reads it: any type, any arguments in their ranges.
std::string draw_fault(Dice& dice, std::span<const sim::FaultKind> kinds);

// Any values in their ranges, sometimes slightly outside.
std::vector<double> draw_parameters(Dice& dice, const CommandInfo& command);

}  // namespace lss::campaign
