#include "tests/campaign/dice.h"

#include <cmath>

namespace lss::campaign {
namespace {

constexpr double kWide = 100;  // wider ranges are drawn by their logarithm: small ones matter too

double draw(Dice& dice, const sim::FaultArgument& a) {
  if (!a.choices.empty()) return dice.one_of(a.choices);
  if (a.optional && dice.chance(0.5)) return a.fallback;
  double value = dice.between(a.min, a.max);
  if (a.max > kWide && a.min >= 0) {
    const double least = std::max(a.min, 1e-2);
    value = least * std::pow(a.max / least, dice.between(0, 1));
  }
  return a.whole ? std::round(value) : value;
}

}  // namespace

std::string draw_fault(Dice& dice, std::span<const sim::FaultKind> kinds) {
  const sim::FaultKind& kind = dice.one_of(kinds);
  sim::Fault fault{.kind = &kind, .values = {}};
  for (const sim::FaultArgument& argument : kind.arguments)
    fault.values.push_back(draw(dice, argument));
  return sim::to_text(fault);
}

std::vector<double> draw_parameters(Dice& dice, const CommandInfo& command) {
  std::vector<double> values;
  for (const ParameterInfo& p : command.parameters) {
    if (std::isfinite(p.fallback) && dice.chance(0.3)) {
      values.push_back(p.fallback);
      continue;
    }
    const double beyond = dice.chance(0.05) ? 1.1 : 1;
    const double value = dice.between(p.min, p.max) * beyond;
    values.push_back(p.is_whole() ? std::round(value) : value);
  }
  return values;
}

}  // namespace lss::campaign
