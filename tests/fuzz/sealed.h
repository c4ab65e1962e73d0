#pragma once

// Checksums that are right, so that what they protect is read: of flight recordings and of saved
// parameters. A fuzzer cannot guess them.

#include <vector>

#include "daemon/record/recording_format.h"
#include "tests/fuzz/fuzz.h"

namespace lss::fuzz {

inline void put_crc(std::vector<std::uint8_t>& bytes, std::size_t from, std::size_t at) {
  const std::uint32_t crc = record::crc32c(Bytes(bytes).subspan(from, at - from));
  std::memcpy(&bytes[at], &crc, sizeof crc);
}

// Of the first bytes and of each chunk, as far as they follow each other.
inline std::vector<std::uint8_t> sealed_recording(Bytes input) {
  namespace format = record::format;
  std::vector<std::uint8_t> bytes(input.begin(), input.end());
  if (bytes.size() < format::kPrologue) return bytes;
  put_crc(bytes, 0, format::kPrologue - 4);
  std::size_t at = format::kPrologue;
  for (std::uint32_t index = 0; at + format::kHead + format::kTrail <= bytes.size(); ++index) {
    std::ranges::copy(format::kChunkMagic, bytes.begin() + static_cast<std::ptrdiff_t>(at));
    std::memcpy(&bytes[at + 8], &index, sizeof index);
    std::uint32_t size = 0;
    std::memcpy(&size, &bytes[at + 12], sizeof size);
    size = static_cast<std::uint32_t>(
        std::min<std::size_t>(size, bytes.size() - at - format::kHead - format::kTrail));
    std::memcpy(&bytes[at + 12], &size, sizeof size);
    put_crc(bytes, at, at + 16);
    const std::size_t end = at + format::kHead + size;
    put_crc(bytes, at, end);
    std::ranges::copy(format::kTrailMagic, bytes.begin() + static_cast<std::ptrdiff_t>(end + 4));
    at = end + format::kTrail;
  }
  return bytes;
}

}  // namespace lss::fuzz
