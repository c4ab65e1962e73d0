#pragma once

// Events as sentences, for the log and for DDS. Ordinary threads.

#include <string>

#include "daemon/core/messages.h"

namespace lss {

// How a vehicle names its modes and its modules (wheels, nodes); subject n is modules[n - 1].
struct Vocabulary {
  const char* const* modes;
  std::size_t mode_count;
  const char* const* modules;
  std::size_t module_count;
};

// "module 3 (LM): leg passed its calibration sensor"
std::string event_text(const EventRecord& event, const Vocabulary& vocabulary);

}  // namespace lss
