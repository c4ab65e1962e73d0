#pragma once

// A vehicle whose locomotion controller is verified. Its files NAME/*.cpp in this folder define
// NAME_verified() with LSS_VERIFIED. Properties that all vehicles must have are in common.h.

#include <span>
#include <string>

#include "tools/lss-lc/composition.h"
#include "tools/lss-lc/explorer.h"

namespace lss::lc {

struct FlagName {
  std::uint8_t flag;
  const char* text;         // shown when `flag` is set
  std::uint8_t unless = 0;  // and `unless` is not set
};

struct Verified {
  const char* name;  // of the roster
  const Table* table;
  // Makes the model of this table, or of another table that must have the same properties.
  Model (*model)(const Table& table, std::uint16_t modules);
  std::span<const char* const> mode_names;  // the first one is none
  std::span<const char* const> goal_names;  // the first one is none
  const char* title;                        // for messages
  std::uint16_t modules;                    // all modules, bit i: module i+1
  std::uint16_t few;  // the modules with which mutations of the table are explored quickly
  std::span<const FlagName> flag_names;
  std::span<const char* const> module_names;
  // Explores supervisor, watch and solver together (composition.h); nullptr: not explored.
  Composition (*composition)(const Depth& depth) = nullptr;
};

// The vehicles of this build, in the order of the roster. nullptr: none has this name.
std::span<const Verified* const> verified_vehicles();
const Verified* verified_vehicle(const std::string& name);

// "module heard LM"
std::string text(const Verified& vehicle, Happening happening);
// "Operational Walking, goal idle, held, LM silent"
std::string text(const Verified& vehicle, const ControllerState& state);

}  // namespace lss::lc

// Defines NAME_verified() with kTable, model_of(), kModeNames and kGoals of the vehicle's
// namespace. The arguments after the name are the other members, from .title on. Use it outside of
// any namespace.
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
