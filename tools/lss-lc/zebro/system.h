#pragma once

// Requirements on Lunar Zebro's locomotion controller, as properties of its states and steps,
// written from the requirements and not from the table: tools/lss-lc/explorer.h visits all states
// and checks the table against them.

#include "tools/lss-lc/explorer.h"

namespace lss::zebro {

inline constexpr std::uint16_t kAllModules = 0x7F;

// The table that ships, or another to be checked against the same properties.
lc::Model model_of(const lc::Table& table, std::uint16_t modules = kAllModules);

std::span<const lc::Contract> contracts();

// "Operational Walking, goal idle, panel in, held, module 3 (LM) silent"
std::string text(const lc::ControllerState& state);

}  // namespace lss::zebro
