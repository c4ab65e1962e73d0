#pragma once

// A ControllerState packed into 8 bytes, 16 modules at most.

#include <cstdint>

#include "daemon/cycle/controller.h"

namespace lss::lc {

using Key = std::uint64_t;

// Bits of each part, from the lowest on. Modules come last: answering, unheard, silent or isolated
// take two bits each.
struct KeyBits {
  static constexpr unsigned kState = 2, kMode = 5, kGoal = 4, kStrategy = 3, kFlags = 8, kLinks = 3;
  static constexpr unsigned kFirst = kState + kMode + kGoal + kStrategy;
  static constexpr unsigned kModule = (64 - kFirst - kFlags - kLinks) / 2;
};

inline Key pack(const ControllerState& s) noexcept {
  Key key = 0;
  unsigned at = 0;
  const auto put = [&](std::uint64_t value, unsigned bits) {
    key |= value << at;
    at += bits;
  };
  put(static_cast<std::uint64_t>(s.state), KeyBits::kState);
  put(s.mode, KeyBits::kMode);
  put(s.goal, KeyBits::kGoal);
  put(s.strategy, KeyBits::kStrategy);
  put(s.flags, KeyBits::kFlags);
  put(s.links, KeyBits::kLinks);
  put(std::uint64_t{s.silent} | s.isolated, KeyBits::kModule);
  put(std::uint64_t{s.unheard} | s.isolated, KeyBits::kModule);
  return key;
}

inline ControllerState unpack(Key key) noexcept {
  ControllerState s;
  const auto take = [&](unsigned bits) {
    const std::uint64_t value = key & ((std::uint64_t{1} << bits) - 1);
    key >>= bits;
    return value;
  };
  s.state = static_cast<State>(take(KeyBits::kState));
  s.mode = static_cast<std::uint8_t>(take(KeyBits::kMode));
  s.goal = static_cast<std::uint8_t>(take(KeyBits::kGoal));
  s.strategy = static_cast<std::uint8_t>(take(KeyBits::kStrategy));
  s.flags = static_cast<std::uint8_t>(take(KeyBits::kFlags));
  s.links = static_cast<std::uint8_t>(take(KeyBits::kLinks));
  const std::uint64_t low = take(KeyBits::kModule), high = take(KeyBits::kModule);
  s.isolated = static_cast<std::uint16_t>(low & high);
  s.silent = static_cast<std::uint16_t>(low & ~high);
  s.unheard = static_cast<std::uint16_t>(high & ~low);
  return s;
}

// Whether unpack(pack(s)) == s: every part fits, and no module has two states at once.
inline bool packs(const ControllerState& s) noexcept {
  const auto over = [](unsigned value, unsigned bits) { return value >> bits; };
  const unsigned twice =
      (s.silent & s.unheard) | (s.silent & s.isolated) | (s.unheard & s.isolated);
  static_assert(KeyBits::kFlags >= 8 && KeyBits::kModule >= 16, "these have room for all");
  return (twice | over(static_cast<unsigned>(s.state), KeyBits::kState) |
          over(s.mode, KeyBits::kMode) | over(s.goal, KeyBits::kGoal) |
          over(s.links, KeyBits::kLinks) | over(s.strategy, KeyBits::kStrategy)) == 0;
}

}  // namespace lss::lc
