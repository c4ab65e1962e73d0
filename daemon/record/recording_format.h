#pragma once

// The bytes of a recording's chunks (docs/recording.md). Only for recording.cpp and
// recording_reader.cpp.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "daemon/record/recording.h"

namespace lss::record::format {

static_assert(std::endian::native == std::endian::little, "numbers in files are little-endian");

inline constexpr auto& kMagic = kRecordingMagic;
inline constexpr std::size_t kPrologue = 16;  // magic, format, crc
inline constexpr std::array<std::uint8_t, 4> kChunkMagic{'L', 'S', 'S', 'c'};
inline constexpr std::array<std::uint8_t, 4> kTrailMagic{'c', 'S', 'S', 'L'};
inline constexpr std::size_t kHead = 20;     // magic, kind, three zeros, index, size, crc
inline constexpr std::size_t kTrail = 8;     // crc of head and payload, magic
inline constexpr std::size_t kItemHead = 8;  // kind, three zeros, size
inline constexpr std::size_t kEndPayload = 32;

enum ChunkKind : std::uint8_t { kBegin = 1, kItems = 2, kEnd = 3 };

template <class T>
void append(std::vector<std::uint8_t>& to, const T& x) {
  const std::size_t at = to.size();
  to.resize(at + sizeof x);
  std::memcpy(&to[at], &x, sizeof x);
}

template <class T>
T load(std::span<const std::uint8_t> from, std::size_t at) {
  T x;
  std::memcpy(&x, &from[at], sizeof x);
  return x;
}

inline bool starts_with(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

struct Head {
  std::uint8_t kind = 0;
  std::uint32_t index = 0, size = 0;
};

// False: there is no valid head.
inline bool read_head(std::span<const std::uint8_t> bytes, Head& head) {
  if (bytes.size() < kHead || !starts_with(bytes, kChunkMagic)) return false;
  head = {.kind = bytes[4],
          .index = load<std::uint32_t>(bytes, 8),
          .size = load<std::uint32_t>(bytes, 12)};
  return load<std::uint32_t>(bytes, 16) == crc32c(bytes.first(16));
}

// Of a chunk that begins here and fits.
struct Body {
  bool crc = false, trail = false;
};
inline Body check_body(std::span<const std::uint8_t> bytes, const Head& head) {
  const std::size_t end = kHead + head.size;
  return {.crc = load<std::uint32_t>(bytes, end) == crc32c(bytes.first(end)),
          .trail = starts_with(bytes.subspan(end + 4), kTrailMagic)};
}

inline std::string_view text(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace lss::record::format
