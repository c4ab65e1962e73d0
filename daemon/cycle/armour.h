#pragma once

// The armour around the cycle (Zebro thesis 7.2.1): checks everything received over DDS before
// anything else uses it. Known command, finite numbers, ranges and choices of the command table,
// the name of a parameter that there is, a source with a name, a lease within bounds, and for
// commands of restricted access a sequence number that its DDS writer has not used before.
// Emergency stops bypass it (CommandPort). Called by the DDS listener, one call at a time; bounded
// work, no allocation.

#include <array>
#include <cstdint>

#include "daemon/cycle/messages.h"

namespace lss {

class Armour {
 public:
  // `commands`: the vehicle's own.
  Armour(std::span<const CommandInfo> commands, std::span<const TunableInfo> tunables,
         std::uint32_t lease_min_ms, std::uint32_t lease_max_ms) noexcept
      : commands_(commands),
        tunables_(tunables),
        lease_min_ms_(lease_min_ms),
        lease_max_ms_(lease_max_ms) {}

  // reason none: the request passes. A refused command does not use up its sequence number.
  // `holder`: the source with authority; empty: nobody.
  Verdict check(const Request& request, std::uint64_t writer, const Name& holder) noexcept;

 private:
  // Remembers the numbers of so many writers. A new one replaces the one silent for longest, but
  // not the holder's while there are others: so no client can lock out another.
  static constexpr std::size_t kMaxWriters = 32;
  struct Writer {
    std::uint64_t id = 0;  // 0: free
    Name source{};
    std::uint64_t sequence = 0;
    TimeNs seen_ns = 0;
  };

  Verdict check_parameters(const CommandInfo& info, const Request& request) const noexcept;
  Verdict check_name(const CommandInfo& info, const Request& request) const noexcept;
  Verdict check_sequence(const Request& request, std::uint64_t writer, const Name& holder) noexcept;

  std::span<const CommandInfo> commands_;
  std::span<const TunableInfo> tunables_;
  std::uint32_t lease_min_ms_, lease_max_ms_;
  std::array<Writer, kMaxWriters> writers_{};
};

}  // namespace lss
