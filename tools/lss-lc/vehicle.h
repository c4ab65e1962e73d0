#pragma once

// A vehicle whose locomotion controller is verified. It brings NAME/*.cpp here, which define
// NAME_verified() with LSS_VERIFIED; properties of every vehicle are in common.h.

#include <span>
#include <string>

#include "tools/lss-lc/composition.h"
#include "tools/lss-lc/explorer.h"

namespace lss::lc {

struct FlagName {
  std::uint8_t flag;
  const char* text;         // when it is set
  std::uint8_t unless = 0;  // and this one is not
};

struct Verified {
  const char* name;  // of the roster
  const Table* table;
  // Of this table, or of another that is checked against the same properties.
  Model (*model)(const Table& table, std::uint16_t modules);
  std::span<const char* const> mode_names;  // from none on
  std::span<const char* const> goal_names;  // from none on
  const char* title;                        // for people
  std::uint16_t modules;                    // all, bit i: module i+1
  std::uint16_t few;                        // enough for mutations of the table, and fast
  std::span<const FlagName> flag_names;
  std::span<const char* const> module_names;
  // Supervisor, watch and solver together (composition.h); nullptr: not explored.
  Composition (*composition)(const Depth& depth) = nullptr;
};

// The vehicles of this build, in the order of the roster; nullptr: there is none of this name.
std::span<const Verified* const> verified_vehicles();
const Verified* verified_vehicle(const std::string& name);

// "module heard LM"
std::string text(const Verified& vehicle, Happening happening);
// "Operational Walking, goal idle, held, LM silent"
std::string text(const Verified& vehicle, const ControllerState& state);

}  // namespace lss::lc

// NAME_verified(), with kTable, model_of(), kModeNames and kGoals of the vehicle's namespace; then
// the other members, from .title on. Outside of any namespace.
#define LSS_VERIFIED(vehicle, ...)                                     \
  namespace lss::lc {                                                  \
  const Verified& vehicle##_verified() {                               \
    static const Verified kVerified{.name = #vehicle,                  \
                                    .table = &vehicle::kTable,         \
                                    .model = vehicle::model_of,        \
                                    .mode_names = vehicle::kModeNames, \
                                    .goal_names = vehicle::kGoals,     \
                                    __VA_ARGS__};                      \
    return kVerified;                                                  \
  }                                                                    \
  }  // namespace lss::lc
