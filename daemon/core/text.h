#pragma once

// Events as sentences, for the log and for DDS. Ordinary threads.

#include <span>
#include <string>

#include "daemon/core/messages.h"
#include "daemon/core/tunables.h"

namespace lss {

// How a vehicle names its modes, its modules (wheels, nodes; subject n is modules[n - 1]), its
// strategies of error solving, its parameters, and, when it flies, phases and programs of a flight
// and what a calibration may find.
struct Vocabulary {
  std::span<const char*const> modes, modules, strategies, phases = {}, programs = {}, findings = {};
  std::span<const TunableInfo> tunables = {};
};

// "limits.current_A", and the unit with a blank before it; for a number from 1 on.
std::string tunable_name(std::span<const TunableInfo> tunables, std::size_t number);
std::string tunable_unit(std::span<const TunableInfo> tunables, std::size_t number);

// "module 3 (LM): leg passed its calibration sensor"
std::string event_text(const EventRecord& event, const Vocabulary& vocabulary);

}  // namespace lss
