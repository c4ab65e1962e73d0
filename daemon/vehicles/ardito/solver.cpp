#include "daemon/vehicles/ardito/solver.h"

#include <bit>
#include <utility>

#include "daemon/vehicles/ardito/vehicle.h"
#include "idl/ardito/codes.h"

namespace lss::ardito {

FaultClass class_of(FaultId fault) noexcept {
  constexpr std::pair<FaultId, FaultClass> kClasses[] = {
      {FaultId::module_silent, FaultClass::contact},
      {FaultId::module_reset, FaultClass::contact},
      {FaultId::stale_input, FaultClass::contact},
      {FaultId::node_refuses, FaultClass::contact},
      {FaultId::drive_fault, FaultClass::drive},
      {FaultId::module_disobeys, FaultClass::drive},
      {faults::power_lost, FaultClass::drive},
      {faults::emergency_button, FaultClass::drive},
      {faults::mobility_error, FaultClass::mobility},
      {faults::steering_critical, FaultClass::mobility},
      {faults::wheel_critical, FaultClass::mobility},
  };
  return class_in(kClasses, fault, FaultClass::system);
}

// Returns the time that the strategy may take.
TimeNs Solver::begin_strategy(Vehicle& vehicle) noexcept {
  left_ = kind() == StrategyKind::retest ? vehicle.diagnosed() : std::uint16_t{0};
  next_ns_ = vehicle.now();
  return parameters_.budget_ns + std::popcount(left_) * parameters_.close_ns;
}

Treatment Solver::treat(Vehicle& vehicle) noexcept {
  switch (kind()) {
    case StrategyKind::reset_fault: vehicle.reset_faults(); return Treatment::done;
    case StrategyKind::reset_node:
      vehicle.reset_nodes(vehicle.faulty_modules());
      return Treatment::done;
    case StrategyKind::retest:
      // Clutches close one at a time: two at once would draw twice the current.
      if (vehicle.now() < next_ns_) return Treatment::running;
      if (left_ == 0) return Treatment::done;
      vehicle.forget(static_cast<std::uint16_t>(left_ & -left_));
      left_ = static_cast<std::uint16_t>(left_ & (left_ - 1));
      next_ns_ = vehicle.now() + parameters_.close_ns;
      return Treatment::running;
    case StrategyKind::isolate: {
      const auto nodes = static_cast<std::uint16_t>(vehicle.faulty_modules() | vehicle.diagnosed());
      return nodes == 0 || vehicle.isolate(nodes) ? Treatment::done : Treatment::failed;
    }
    case StrategyKind::none:
    case StrategyKind::reconnect: break;
  }
  return Treatment::done;
}

Solver::Report Solver::step(Vehicle& vehicle, bool healthy) noexcept {
  return PlannedSolver::step(
      vehicle.now(), healthy, [&] { return begin_strategy(vehicle); },
      [&] { return treat(vehicle); });
}

}  // namespace lss::ardito
