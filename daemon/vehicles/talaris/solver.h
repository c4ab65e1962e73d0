#pragma once

// Error solving of TALARIS: strategies, tried one after the other until everything that is needed
// answers and nothing else is wrong, for a while. The configuration names the strategies of each
// class of faults and their order. Frame thread; time is data.

#include <array>
#include <cstdint>

#include "daemon/kit/planned_solver.h"
#include "idl/talaris/commands.h"

namespace lss::talaris {

enum class FaultClass : std::uint8_t {
  contact,     // a node of the actuators or a port is not there
  navigation,  // the data of navigation are not reliable
  system,      // frames, gas, emergency stops by command
};
inline constexpr std::size_t kFaultClasses = 3;
inline constexpr const char* kFaultClassNames[kFaultClasses] = {"contact", "navigation", "system"};
FaultClass class_of(FaultId fault) noexcept;

using StrategyList = Strategies<StrategyKind>::List;

struct SolverParameters {
  std::array<StrategyList, kFaultClasses> order{{
      {StrategyKind::reconnect, StrategyKind::reset_node},
      {StrategyKind::realign, StrategyKind::reconnect},
      {StrategyKind::reconnect},
  }};
  TimeNs budget_ns = 10 * kSecond;  // for one strategy
};

using Solver = kit::PlannedSolver<StrategyKind, FaultClass, SolverParameters>;

}  // namespace lss::talaris
