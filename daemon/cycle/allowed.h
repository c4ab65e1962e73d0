#pragma once

// When a command is allowed, read from the rows of the locomotion controller that ships. Pure.

#include <span>
#include <string>
#include <vector>

#include "daemon/cycle/controller.h"

namespace lss::lc {

struct Allowed {
  std::string where;              // "Idle", or "Operational Standing, Walking"
  std::vector<std::string> when;  // all must be true: "the panel is in"
};

// For the events that the command can cause, in the order of the table.
std::vector<Allowed> allowed(const Table& table, std::span<const char* const> modes,
                             std::span<const Event> events);

// The events that this command can cause, depending on its choices.
std::vector<Event> events_of(const CommandInfo& info, Event (*event_of)(const Request& request));

// From the rows of its events. Commands for parameters are in no row: they have their own table.
std::vector<Allowed> allowed(const CommandInfo& info, const Table& table,
                             std::span<const char* const> modes,
                             Event (*event_of)(const Request& request));

}  // namespace lss::lc
