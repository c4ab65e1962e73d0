#pragma once

// Events as sentences, for the log and for DDS. Ordinary threads.

#include <span>
#include <string>

#include "daemon/core/messages.h"

namespace lss {

// How a vehicle names its modes, its modules (wheels, nodes; subject n is modules[n - 1]), its
// strategies of error solving, and, when it flies, phases and programs of a flight and what a
// calibration may find.
struct Vocabulary {
  std::span<const char*const> modes, modules, strategies, phases = {}, programs = {}, findings = {};
};

// "module 3 (LM): leg passed its calibration sensor"
std::string event_text(const EventRecord& event, const Vocabulary& vocabulary);

}  // namespace lss
