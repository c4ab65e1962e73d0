#pragma once

// One safety suite for every vehicle: authority, lease, stops, losses, gate, bad inputs, resets,
// records and parameters. A vehicle passes it with one file, tests/NAME/daemon/safety_test.cpp, or,
// out of this tree, with a file like it:
//
//   struct Traits { ... };
//   LSS_SAFETY_SUITE(Name, Traits);
//   LSS_SAFETY_LIMITS(Name, Traits);  // says its limits
//   LSS_SAFETY_RESETS(Name, Traits);  // has modules that a command resets
//
// Everything is tested on the vehicle that ships, in its own cycle and behind the daemon's entry of
// commands; time is data. Include the vehicle's record.h before the macros.
//
// Traits:
//   World                        of the vehicle's tests, a CycleWorld (cycle_world.h); its
//                                constructor takes (parameters, Supervisor::Parameters)
//   parameters()                 of the configuration that ships, logic(), tuning(),
//   allocations()                of this program so far: those of Shipped, below
//   bool ready(World&)           from Idle to where kMotion is accepted
//   Motion kMotion               the command that makes it move
//   bool moves(const World&)     the command in out_ moves it
//   bool safe(const World&)      the command in out_ can move nothing
//   double kRest_s               within which a stop or a lost lease ends in Idle
//   faults()                     losses and failures (scene.h), one for each module that must
//                                answer, the port, stale data. The loss of a module is one
//                                `everywhere`; error solving takes a while for the first one
//   bad_commands()               functions that each make a good command in motion one that the
//                                gate must replace
//   bool& stop_pending(BusReport&)  the report of an all-stop that the cycle has to confirm
// Optional:
//   bool stopped(const World&)   the command in out_ is the emergency stop, too; else: safe
//   bool in_range(const World&)  what the gate guarantees besides finite numbers
//   places()                     modes of Operational and how to come there; else: in motion
//   limits(), no_limits()        each limit of its supervision, and names of the parameters that
//   are
//                                none or whose limit another test has (limits.h)
//   kResettable, take_away(World&, module), bring_back(World&, module)  numbers of modules that a
//                                command resets and whose absence is an emergency; parameters()
//                                has reset_ns. kAlsoReset: others that a reset of all reaches.
//                                kVital: one of them that error solving cannot do without;
//                                else: the first one

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

// The traits that are functions of the vehicle; LSS_CONFIG is its file, NAME.toml.
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
