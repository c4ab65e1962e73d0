#pragma once

// Numbers in frames and objects of a simulated CANopen node: little-endian, saturated; and the
// fields of a PDO's identifier and mapping (CiA 301). Pure.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace lss::sim::nodes {

// Of a COB-ID.
inline constexpr std::uint32_t kInvalid = 0x8000'0000, kNoRemote = 0x4000'0000;
inline constexpr std::uint32_t kExtended = 0x2000'0000, kIdBits = 0x7FF;
inline constexpr std::uint8_t kMostMapped = 8;

inline std::uint32_t little_endian(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

inline void to_little_endian(std::uint32_t value, std::span<std::uint8_t> bytes) {
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(value);
    value >>= 8;
  }
}

// An entry of a mapping: index, sub-index, bits.
struct Mapped {
  std::uint16_t index;
  std::uint8_t sub, bits;
};
inline Mapped unpack(std::uint32_t entry) {
  return {static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8),
          static_cast<std::uint8_t>(entry)};
}

// Values saturate and do not wrap.
inline std::int64_t saturate(double value, std::int64_t low, std::int64_t high) {
  return std::clamp<std::int64_t>(std::llround(std::clamp(value, -3e9, 3e9)), low, high);
}
inline std::int64_t to_i16(double value) { return saturate(value, INT16_MIN, INT16_MAX); }
inline std::int64_t to_u16(double value) { return saturate(value, 0, UINT16_MAX); }
inline std::int64_t to_i32(double value) { return saturate(value, INT32_MIN, INT32_MAX); }

}  // namespace lss::sim::nodes
