#include "daemon/vehicles/ardito/solver.h"

#include <bit>

#include "daemon/cycle/plan.h"

namespace lss::ardito {

FaultClass class_of(FaultId fault) noexcept {
  switch (fault) {
    case FaultId::module_silent:
    case FaultId::module_reset:
    case FaultId::stale_input:
    case FaultId::node_refuses:
      return FaultClass::contact;
    case FaultId::drive_fault:
    case FaultId::module_disobeys:
    case FaultId::power_lost:
    case FaultId::emergency_button:
      return FaultClass::drive;
    case FaultId::mobility_error:
    case FaultId::steering_critical:
    case FaultId::wheel_critical:
      return FaultClass::mobility;
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
  treating_ = true;
  healthy_since_ns_ = 0;
  left_ = kind() == StrategyKind::retest ? target.diagnosed() : std::uint16_t{0};
  next_ns_ = target.now();
  until_ns_ = target.now() + parameters_.budget_ns + std::popcount(left_) * parameters_.close_ns;
}

Solver::Treatment Solver::treat(SolveTarget& target) noexcept {
  switch (kind()) {
    case StrategyKind::reset_fault:
      target.reset_faults();
      return Treatment::done;
    case StrategyKind::reset_node:
      target.reset_nodes(target.faulty_modules());
      return Treatment::done;
    case StrategyKind::retest:
      // One at a time: two clutches that close at once draw twice the current.
      if (target.now() < next_ns_) return Treatment::running;
      if (left_ == 0) return Treatment::done;
      target.forget(static_cast<std::uint16_t>(left_ & -left_));
      left_ = static_cast<std::uint16_t>(left_ & (left_ - 1));
      next_ns_ = target.now() + parameters_.close_ns;
      return Treatment::running;
    case StrategyKind::isolate: {
      const auto nodes = static_cast<std::uint16_t>(target.faulty_modules() | target.diagnosed());
      return nodes == 0 || target.isolate(nodes) ? Treatment::done : Treatment::failed;
    }
    case StrategyKind::none:
    case StrategyKind::reconnect:
      break;
  }
  return Treatment::done;
}

Solver::Report Solver::give_up() noexcept {
  if (at_ + 1 == plan_.size() || plan_[at_ + 1] == StrategyKind::none) return Report::unsolved;
  ++at_;
  begun_ = false;
  return Report::next;
}

Solver::Report Solver::step(SolveTarget& target, bool healthy) noexcept {
  if (!begun_) begin_strategy(target);
  if (target.now() > until_ns_) return give_up();
  if (treating_) {
    const Treatment treatment = treat(target);
    if (treatment == Treatment::failed) return give_up();
    treating_ = treatment == Treatment::running;
    return Report::running;  // its effect shows in the next frames
  }
  if (!healthy) {
    healthy_since_ns_ = 0;
  } else if (healthy_since_ns_ == 0) {
    healthy_since_ns_ = target.now();
  } else if (target.now() - healthy_since_ns_ >= kProof) {
    return Report::solved;
  }
  return Report::running;
}

}  // namespace lss::ardito
