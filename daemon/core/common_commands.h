#pragma once

// The commands that every vehicle has, where they mean the same for all of them: a vehicle's
// event_of(), reached() and command() (Logic in daemon/core/supervisor.h) ask here first or last.
// Pure functions; any thread.

#include <cstdint>
#include <span>

#include "daemon/core/messages.h"
#include "daemon/lc/controller.h"

namespace lss {

// Event::none for `start` and `stop`, which are the vehicle's own, and for all that are not common.
lc::Event common_event(const Request& request) noexcept;

// Common commands that are over as soon as they are accepted. The others a vehicle has to judge.
bool done_at_once(std::uint16_t kind) noexcept;

// Needs authority where somebody holds it, but takes no command's place: what runs goes on.
bool is_beside(std::uint16_t kind) noexcept;

// Changes nothing that the locomotion controller knows: no row of its table takes it.
bool is_of_parameters(std::uint16_t kind) noexcept;

// In the vehicle's table or in the common one; nullptr when there is none.
const CommandInfo* find_command(std::span<const CommandInfo> own, std::uint16_t kind) noexcept;

}  // namespace lss
