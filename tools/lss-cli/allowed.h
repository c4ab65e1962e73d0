#pragma once

// When a command may be given, read from the rows of the locomotion controller that ships. Pure.

#include <span>
#include <string>
#include <vector>

#include "daemon/lc/controller.h"

namespace lss::cli {

struct Allowed {
  std::string where;              // "Idle", or "Operational Standing, Walking"
  std::vector<std::string> when;  // all must hold: "the panel is in"
};

// Of the events that the command may be, in the order of the table.
std::vector<Allowed> allowed(const lc::Table& table, std::span<const char* const> modes,
                             std::span<const lc::Event> events);

// The events that a command of that kind may be, by its choices.
std::vector<lc::Event> events_of(const CommandInfo& info,
                                 lc::Event (*event_of)(const Request& request));

// By the rows of its events. No row takes those of parameters, which have a table of their own.
std::vector<Allowed> allowed(const CommandInfo& info, const lc::Table& table,
                             std::span<const char* const> modes,
                             lc::Event (*event_of)(const Request& request));

}  // namespace lss::cli
