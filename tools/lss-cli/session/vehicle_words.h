#pragma once

// What the vehicles' parts of the command line share: words for numbers. Pure functions.

#include <cstddef>
#include <cstdint>
#include <string>

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

}  // namespace lss::cli
