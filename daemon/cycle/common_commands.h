#pragma once

// The commands of every vehicle, as far as they mean the same for all: a vehicle's event_of() and
// reached() (Logic in daemon/cycle/supervisor.h) call these first or last. Pure functions; any
// thread.

#include <cstdint>
#include <span>

#include "daemon/cycle/controller.h"
#include "daemon/cycle/messages.h"

namespace lss {

// Event::none for `start` and `stop`, which belong to the vehicle, and for commands not in common.
lc::Event common_event(const Request& request) noexcept;

// The event of the table's own list that names the command, else the common one.
lc::Event event_of(const lc::Table& table, const Request& request) noexcept;

// Common commands that are complete when accepted. The others are judged by the vehicle.
bool done_at_once(std::uint16_t kind) noexcept;

// Needs authority when a source has it, but supersedes no command. A reset of modules among them is
// completed when they are back (Supervisor::set_resetting).
bool is_beside(std::uint16_t kind) noexcept;

// Changes no state of the locomotion controller: no row of its table takes it.
bool is_of_parameters(std::uint16_t kind) noexcept;

// In the vehicle's table or in the common one; nullptr when there is none.
const CommandInfo* find_command(std::span<const CommandInfo> own, std::uint16_t kind) noexcept;

}  // namespace lss
