#pragma once

// What the vehicles' parts of the command line share: words for numbers, and problems that the
// telemetry shows. Pure functions.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/cycle/supervisor.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {

template <std::size_t N>
const char* name_of(const char* const (&names)[N], std::size_t index) {
  return index < N ? names[index] : "?";
}

// "-" for what is no number.
std::string fixed(double value, int digits);

// Of a part with the age of its last message.
template <class Part>
bool never_heard(const Part& part) {
  return part.age_ms == kNeverHeard_ms;
}

// A fault of this subject; 0: of any.
bool latched(const lss_Status& status, FaultId id, std::uint16_t subject = 0);

// `what` is not open. Nothing when a fault of that port says so.
std::vector<Problem> closed_port(const lss_Status& status, const char* what,
                                 std::uint16_t subject = 0);

// "RM does not answer, last reply 3 s ago" with `how` before the time, or "RM has never answered".
std::string unheard(const Vehicle& vehicle, std::uint16_t subject, std::uint64_t age_ms,
                    const std::string& how);

// When a command is allowed, by the controller itself.
inline auto allowed_by(const Logic& (*logic)() noexcept, std::span<const char* const> modes) {
  return [logic, modes](const CommandInfo& info) {
    return lc::allowed(info, *logic().table, modes, logic().event_of);
  };
}

// Adds the command with its default arguments.
template <class Kind>
void add_step(std::vector<Invocation>& steps, const Vehicle& vehicle, Kind kind) {
  steps.push_back(with_defaults(find_command(vehicle, static_cast<std::uint16_t>(kind))));
}

}  // namespace lss::cli
