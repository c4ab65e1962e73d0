#pragma once

// Error solving by strategies whose order the configuration gives for each class of faults: the
// part that does not depend on the vehicle. A vehicle derives from it and treats. Parameters:
// order, a list of strategies for each class. Frame thread; time is data; no allocation.

#include <array>
#include <cstddef>
#include <span>
#include <tuple>

#include "daemon/cycle/plan.h"
#include "daemon/cycle/strategies.h"

namespace lss::kit {

template <class Kind, class FaultClass, class Parameters>
class PlannedSolver : public Strategies<Kind> {
 public:
  explicit PlannedSolver(const Parameters& parameters) noexcept : parameters_(parameters) {}

  // Plans the strategies from the present faults. The first one begins with the next step.
  void begin(std::span<const FaultClass> wrong) noexcept {
    std::array<bool, std::tuple_size_v<decltype(Parameters::order)>> present{};
    for (const FaultClass c : wrong) present[static_cast<std::size_t>(c)] = true;
    // The cause may be gone by now.
    Strategies<Kind>::begin(plan(parameters_.order, present, Kind::reconnect));
  }
  // Applies to the running strategy, too.
  void configure(const Parameters& parameters) noexcept { parameters_ = parameters; }

 protected:
  Parameters parameters_;
};

}  // namespace lss::kit
