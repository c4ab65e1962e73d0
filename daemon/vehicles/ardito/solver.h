#pragma once

// Error solving of D.I.A.N.A. Ardito: strategies, tried one after the other until every node in
// service runs, no drive is in fault and nothing else is wrong, for a while. The configuration
// names the strategies of each class of faults and their order. Frame thread; time is data.

#include <array>
#include <cstdint>

#include "daemon/kit/planned_solver.h"
#include "idl/ardito/commands.h"

namespace lss::ardito {

enum class FaultClass : std::uint8_t {
  contact,   // a node is not there, or not as it should be
  drive,     // a drive is in fault, or does not follow its orders
  mobility,  // the failure detection found too much
  system,    // links, frames, emergency stops by command or button
};
inline constexpr std::size_t kFaultClasses = 4;
inline constexpr const char* kFaultClassNames[kFaultClasses] = {"contact", "drive", "mobility",
                                                                "system"};
FaultClass class_of(FaultId fault) noexcept;

using StrategyList = Strategies<StrategyKind>::List;

struct SolverParameters {
  std::array<StrategyList, kFaultClasses> order{{
      {StrategyKind::reconnect, StrategyKind::reset_node, StrategyKind::isolate},
      {StrategyKind::reset_fault, StrategyKind::reset_node, StrategyKind::isolate},
      {StrategyKind::retest, StrategyKind::isolate},
      {StrategyKind::reconnect, StrategyKind::reset_fault},
  }};
  TimeNs budget_ns = 10 * kSecond;  // for one strategy
  TimeNs close_ns = kSecond;        // between closing two clutches
};

class Vehicle;

class Solver final : public kit::PlannedSolver<StrategyKind, FaultClass, SolverParameters> {
 public:
  using PlannedSolver::PlannedSolver;

  // Once per frame while running. `healthy`: no fault at all in this frame. next: the strategy did
  // not help; call again when the locomotion controller agreed to the next one.
  Report step(Vehicle& vehicle, bool healthy) noexcept;

 private:
  TimeNs begin_strategy(Vehicle& vehicle) noexcept;
  Treatment treat(Vehicle& vehicle) noexcept;

  std::uint16_t left_ = 0;  // nodes to diagnose again
  TimeNs next_ns_ = 0;      // the next of them
};

}  // namespace lss::ardito
