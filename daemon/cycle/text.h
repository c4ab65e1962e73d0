#pragma once

// Events as sentences, for the log and for DDS. Ordinary threads.

#include <span>
#include <string>

#include "daemon/cycle/messages.h"
#include "daemon/cycle/tunables.h"

namespace lss {

// A vehicle's names for its modes, modules (wheels, nodes; subject n is modules[n - 1]), strategies
// of error solving, parameters, commands, and, when it flies, phases and programs of a flight and
// findings of a calibration.
struct Vocabulary {
  std::span<const char*const> modes, modules, strategies, phases = {}, programs = {}, findings = {};
  std::span<const CommandInfo> commands = {};  // its own
  std::span<const TunableInfo> tunables = {};
  const CommandInfo* (*command)(std::uint16_t kind) = nullptr;
};

// "limits.current_A", and the unit with a leading blank; for numbers from 1 on.
std::string tunable_name(std::span<const TunableInfo> tunables, std::size_t number);
std::string tunable_unit(std::span<const TunableInfo> tunables, std::size_t number);

// "module 3 (LM): leg passed its calibration sensor"
std::string event_text(const EventRecord& event, const Vocabulary& vocabulary);

}  // namespace lss
