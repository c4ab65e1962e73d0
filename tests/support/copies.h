#pragma once

// The copies of a value in the memory of an object, and how radiation damages them.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lss::testing_support {

// Where the value is in memory, in order. Other threads may change the rest of the memory
// meanwhile.
template <class T>
__attribute__((no_sanitize("thread"))) std::vector<std::uint8_t*> copies_of(
    const T& value, std::span<std::uint8_t> memory) {
  std::vector<std::uint8_t*> copies;
  const auto* const wanted = reinterpret_cast<const std::uint8_t*>(&value);
  for (std::size_t at = 0; at + sizeof value <= memory.size(); at += sizeof value) {
    std::size_t same = 0;
    while (same < sizeof value && memory.data()[at + same] == wanted[same]) ++same;
    if (same == sizeof value) copies.push_back(&memory[at]);
  }
  return copies;
}

// `which`: of two; 2: both, so that neither can be corrected by the other.
inline void damage(const std::vector<std::uint8_t*>& copies, std::size_t which) {
  if (which != 1) *copies[0] ^= 1;
  if (which != 0) *copies[1] ^= 2;
}

}  // namespace lss::testing_support
