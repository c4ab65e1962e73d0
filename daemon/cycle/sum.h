#pragma once

// A checksum for memory: notices each difference that is within one word of 8 bytes, others with a
// probability of 1 - 2^-64. Four independent products at a time.

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

namespace lss {

// A difference in a single word always changes it: the factor is odd, and what is added to a
// product is the same.
inline std::uint64_t sum(std::span<const std::uint8_t> bytes) noexcept {
  constexpr std::uint64_t kFactor = 0x9E37'79B9'7F4A'7C15;
  constexpr std::size_t kLanes = 4, kStep = kLanes * sizeof(std::uint64_t);
  std::array<std::uint64_t, kLanes> lane{1, 2, 3, 4}, words;
  std::size_t at = 0;
  const auto add = [&] {
    for (std::size_t i = 0; i < kLanes; ++i) lane[i] = (lane[i] ^ words[i]) * kFactor;
  };
  for (; at + kStep <= bytes.size(); at += kStep) {
    std::memcpy(words.data(), &bytes[at], kStep);
    add();
  }
  if (at < bytes.size()) {
    words = {};
    std::memcpy(words.data(), &bytes[at], bytes.size() - at);
    add();
  }
  std::uint64_t all = 0;
  for (const std::uint64_t one : lane) all = (all ^ one) * kFactor;
  return all;
}

}  // namespace lss
