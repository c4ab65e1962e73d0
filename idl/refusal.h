#pragma once

// Why a program cannot start, and whether another start helps. Pure data.

#include <cstdint>
#include <string>

namespace lss {

enum class Cure : std::uint8_t {
  unknown,
  time,    // the clock is set, or a network interface comes up
  change,  // of the configuration, options or files: another start does not help
};

struct Refusal {
  std::string text;  // a sentence that says what to do
  Cure cure = Cure::unknown;
};

}  // namespace lss
