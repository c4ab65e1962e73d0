#pragma once

// One safety suite for every vehicle: authority, lease, stops, losses, gate, bad inputs, resets,
// records and parameters. A vehicle passes it with one file, tests/NAME/daemon/safety_test.cpp, or,
// out of this tree, with a file like it:
//
//   struct Traits { ... };
//   LSS_SAFETY_SUITE(Name, Traits);
//   LSS_SAFETY_LIMITS(Name, Traits);  // if Traits has limits()
//   LSS_SAFETY_RESETS(Name, Traits);  // if a command resets modules of the vehicle
//
// The suite tests the code of the vehicle that ships, in its own cycle and behind the daemon's
// entry of commands; time is data. Include the vehicle's record.h before the macros.
//
// Traits:
//   World                        a CycleWorld (cycle_world.h) of the vehicle; its constructor takes
//                                (parameters, Supervisor::Parameters)
//   parameters()                 of the configuration that ships; logic(), tuning();
//   allocations()                number of allocations so far; Shipped, below, has all four
//   bool ready(World&)           brings the vehicle from Idle to where kMotion is accepted
//   Motion kMotion               the command that makes the vehicle move
//   bool moves(const World&)     whether the command in out_ moves the vehicle
//   bool safe(const World&)      whether the command in out_ cannot move the vehicle
//   double kRest_s               time within which a stop or an expired lease ends in Idle
//   faults()                     losses and failures (scene.h): of each module that must answer, of
//                                the port, stale data. The loss of a module sets `everywhere`.
//                                Solving the first fault must take more than one frame
//   bad_commands()               functions that change a good command in motion into one that the
//                                gate must replace
//   bool& stop_pending(BusReport&)  the report of an all-stop that the cycle has to confirm
// Optional:
//   bool stopped(const World&)   whether the command in out_ is the emergency stop; default: safe
//   bool in_range(const World&)  what the gate guarantees in addition to finite numbers
//   places()                     modes of Operational, with how to enter them; default: in motion
//   limits(), no_limits()        the limits of the vehicle's supervision; names of parameters that
//                                are no limits or whose limit another test covers (limits.h)
//   kResettable, take_away(World&, module), bring_back(World&, module)  numbers of modules that a
//                                command resets and whose absence is an emergency; parameters()
//                                has reset_ns. kAlsoReset: other modules that a reset of all
//                                reaches. kVital: a resettable module that error solving needs;
//                                default: the first one

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "daemon/config/config.h"
#include "faults.h"
#include "inputs.h"
#include "limits.h"
#include "parameters.h"
#include "records.h"
#include "resets.h"
#include "stops.h"
#include "tests/support/allocations.h"

namespace lss::safety {

// Traits that call the vehicle's functions; LSS_CONFIG is the path of its NAME.toml.
template <auto kRead, auto kLogic, auto kTuning>
struct Shipped {
  static const auto& parameters() {
    static const auto kParameters = [] {
      const std::filesystem::path file = LSS_CONFIG;
      std::decay_t<decltype(kRead(std::declval<config::Section&>()))> parameters;
      const auto config =
          config::load(file, {file.stem().string()},
                       [&](const auto&, config::Section& section) { parameters = kRead(section); });
      if (!config) throw std::runtime_error(config.error());
      return parameters;
    }();
    return kParameters;
  }
  static const auto& logic() { return kLogic(); }
  static const auto& tuning() { return kTuning(); }
  static std::uint64_t allocations() { return testing_support::allocations(); }
};

}  // namespace lss::safety

#define LSS_SAFETY_SUITE(Name, Traits)                                            \
  namespace lss::safety {                                                         \
  INSTANTIATE_TYPED_TEST_SUITE_P(Name, SafetyStops, testing::Types<Traits>);      \
  INSTANTIATE_TYPED_TEST_SUITE_P(Name, SafetyFaults, testing::Types<Traits>);     \
  INSTANTIATE_TYPED_TEST_SUITE_P(Name, SafetyInputs, testing::Types<Traits>);     \
  INSTANTIATE_TYPED_TEST_SUITE_P(Name, SafetyRecords, testing::Types<Traits>);    \
  INSTANTIATE_TYPED_TEST_SUITE_P(Name, SafetyParameters, testing::Types<Traits>); \
  }                                                                               \
  static_assert(true)

#define LSS_SAFETY_LIMITS(Name, Traits)                                       \
  namespace lss::safety {                                                     \
  INSTANTIATE_TYPED_TEST_SUITE_P(Name, SafetyLimits, testing::Types<Traits>); \
  }                                                                           \
  static_assert(true)

#define LSS_SAFETY_RESETS(Name, Traits)                                       \
  namespace lss::safety {                                                     \
  INSTANTIATE_TYPED_TEST_SUITE_P(Name, SafetyResets, testing::Types<Traits>); \
  }                                                                           \
  static_assert(true)
