#pragma once

// Random choices of a scenario, the same for the same number everywhere; or those of a script,
// which has them as bytes.

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
  // Two bytes for each choice; zeros follow them.
  explicit Dice(std::span<const std::uint8_t> script)
      : script_(script.begin(), script.end()), scripted_(true) {}

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
  double share() {
    if (!scripted_) return static_cast<double>(random_()) / 4294967296.0;
    const unsigned high = next(), low = next();
    return (high * 256 + low) / 65536.0;
  }
  unsigned next() { return at_ < script_.size() ? script_[at_++] : 0u; }

  std::mt19937 random_;
  std::vector<std::uint8_t> script_;
  std::size_t at_ = 0;
  bool scripted_ = false;
};

// In nine runs of ten it begins to move, and goes on for `most_s` at most. false: it cannot begin.
template <class Chain, class Move>
bool sets_out(Dice& dice, Chain& chain, double most_s, Move&& move) {
  if (dice.chance(0.1)) return true;
  if (!move(dice)) return false;
  chain.run(dice.between(0, most_s));
  return true;
}

// As lss-sim reads it: any type, any arguments in their ranges.
std::string draw_fault(Dice& dice, std::span<const sim::FaultKind> kinds);

// Any values in their ranges, sometimes slightly outside.
std::vector<double> draw_parameters(Dice& dice, const CommandInfo& command);

}  // namespace lss::campaign
