#pragma once

// A vehicle whose locomotion controller is verified. It brings NAME/*.cpp here, which define
// NAME_verified(); properties of every vehicle are in common.h.

#include <span>
#include <string>

#include "tools/lss-lc/explorer.h"

namespace lss::lc {

struct Verified {
  const char* name;   // of the roster
  const char* title;  // for people
  const Table* table;
  // Of this table, or of another that is checked against the same properties.
  Model (*model)(const Table& table, std::uint16_t modules);
  std::uint16_t modules;                    // all, bit i: module i+1
  std::uint16_t few;                        // enough for mutations of the table, and fast
  std::span<const char* const> mode_names;  // from none on
  std::uint8_t goals;                       // how many, with none
  std::string (*text)(const ControllerState& state);
  std::span<const char* const> module_names;
};

// The vehicles of this build, in the order of the roster; nullptr: there is none of this name.
std::span<const Verified* const> verified_vehicles();
const Verified* verified_vehicle(const std::string& name);

// "module heard LM"
std::string text(const Verified& vehicle, Happening happening);
// The part common to every vehicle: ", port closed, held, LM silent".
std::string text_of_links(const ControllerState& state, std::span<const char* const> module_names);

}  // namespace lss::lc
