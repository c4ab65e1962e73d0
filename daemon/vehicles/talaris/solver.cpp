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
  plan_ = plan(parameters_.order, present, StrategyKind::reconnect);
  at_ = 0;
  running_ = true;
  begun_ = false;
}

void Solver::begin_strategy(SolveTarget& target) noexcept {
  begun_ = true;
  healthy_since_ns_ = 0;
  until_ns_ = target.now() + parameters_.budget_ns;
  if (kind() == StrategyKind::reset_node) target.reset_modules(target.faulty_modules());
  if (kind() == StrategyKind::realign) target.realign();
}

Solver::Report Solver::give_up() noexcept {
  if (at_ + 1 == plan_.size() || plan_[at_ + 1] == StrategyKind::none) return Report::unsolved;
  ++at_;
  begun_ = false;
  return Report::next;
}

Solver::Report Solver::step(SolveTarget& target, bool healthy) noexcept {
  if (!begun_) {
    begin_strategy(target);
    return Report::running;  // its effect shows in the next frames
  }
  if (target.now() > until_ns_) return give_up();
  if (!healthy) {
    healthy_since_ns_ = 0;
  } else if (healthy_since_ns_ == 0) {
    healthy_since_ns_ = target.now();
  } else if (target.now() - healthy_since_ns_ >= kProof) {
    return Report::solved;
  }
  return Report::running;
}

}  // namespace lss::talaris
