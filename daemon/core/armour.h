#pragma once

// The armour around the cycle (Zebro thesis 7.2.1): whatever comes in over DDS passes here before
// anything else sees it. Known command, finite numbers, ranges and choices of the command table, a
// source with a name, a sequence number not used before, a lease within bounds. Called by the DDS
// listener, one call at a time; bounded work, no allocation.

#include <array>
#include <cstdint>

#include "daemon/core/messages.h"

namespace lss {

class Armour {
 public:
  using Lookup = const CommandInfo* (*)(std::uint16_t kind);

  Armour(Lookup lookup, std::uint32_t lease_min_ms, std::uint32_t lease_max_ms) noexcept
      : lookup_(lookup), lease_min_ms_(lease_min_ms), lease_max_ms_(lease_max_ms) {}

  // reason none: the request may go on. A refused command does not use up its sequence number.
  Verdict check(const Request& request) noexcept;

 private:
  static constexpr std::size_t kMaxSources = 32;
  struct Source {
    Name name{};
    std::uint64_t sequence = 0;
    TimeNs seen_ns = 0;
  };

  Verdict check_parameters(const CommandInfo& info, const Request& request) const noexcept;
  Verdict check_sequence(const Request& request) noexcept;

  Lookup lookup_;
  std::uint32_t lease_min_ms_, lease_max_ms_;
  std::array<Source, kMaxSources> sources_{};
};

}  // namespace lss
