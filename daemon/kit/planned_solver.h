#pragma once

// Error solving by strategies whose order the configuration gives for each class of faults: the
// part that does not depend on the vehicle, which passes its treatment to step(). Parameters:
// order, a list of strategies for each class. Frame thread; time is data; no allocation.

#include <array>
#include <cstddef>
#include <span>
#include <tuple>

#include "daemon/cycle/plan.h"
#include "daemon/cycle/strategies.h"

namespace lss::kit {

template <class Kind, class FaultClass, class Parameters>
class PlannedSolver {
 public:
  using Report = typename Strategies<Kind>::Report;

  explicit PlannedSolver(const Parameters& parameters) noexcept : parameters_(parameters) {}

  // Plans the strategies from the present faults. The first one begins with the next step.
  void begin(std::span<const FaultClass> wrong) noexcept {
    std::array<bool, std::tuple_size_v<decltype(Parameters::order)>> present{};
    for (const FaultClass c : wrong) present[static_cast<std::size_t>(c)] = true;
    // The cause may be gone by now.
    strategies_.begin(plan(parameters_.order, present, Kind::reconnect));
  }
  void end() noexcept { strategies_.end(); }
  // Applies to the running strategy, too.
  void configure(const Parameters& parameters) noexcept { parameters_ = parameters; }
  bool running() const noexcept { return strategies_.running(); }
  Kind kind() const noexcept { return strategies_.kind(); }
  // See Strategies.
  template <class BeginOne, class Treat>
  Report step(TimeNs now, bool healthy, BeginOne&& begin_one, Treat&& treat) noexcept {
    return strategies_.step(now, healthy, begin_one, treat);
  }

 protected:
  Parameters parameters_;

 private:
  Strategies<Kind> strategies_;
};

}  // namespace lss::kit
