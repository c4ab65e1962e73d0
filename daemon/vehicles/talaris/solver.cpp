#include "daemon/vehicles/talaris/solver.h"

#include "daemon/cycle/plan.h"

namespace lss::talaris {

FaultClass class_of(FaultId fault) noexcept {
  switch (fault) {
    case FaultId::module_silent:
    case FaultId::module_reset:
    case FaultId::node_refuses:
    case FaultId::port_lost:
    case FaultId::bus_off:
      return FaultClass::contact;
    case FaultId::navigation_lost:
    case FaultId::attitude_lost:
      return FaultClass::navigation;
    default:
      return FaultClass::system;
  }
}

void Solver::begin(std::span<const FaultClass> wrong) noexcept {
  std::array<bool, kFaultClasses> present{};
  for (const FaultClass c : wrong) present[static_cast<std::size_t>(c)] = true;
  // The cause may be gone by now.
  strategies_.begin(plan(parameters_.order, present, StrategyKind::reconnect));
}

Solver::Report Solver::step(SolveTarget& target, bool healthy) noexcept {
  return strategies_.step(
      target.now(), healthy, [&] { return parameters_.budget_ns; },
      [&] {
        if (kind() == StrategyKind::reset_node) target.reset_modules(target.faulty_modules());
        if (kind() == StrategyKind::realign) target.realign();
        return Treatment::done;
      });
}

}  // namespace lss::talaris
