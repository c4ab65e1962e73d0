#pragma once

// Records of the MCAP format, version 0 (mcap.dev/spec), as far as we write or read them. Pure
// data.

#include <cstdint>
#include <string>
#include <string_view>

#include "tools/lss-cli/recording/octets.h"

namespace lss::cli::recording {

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::string_view kLibrary = "lss-cli";      // begins our library field
inline constexpr std::string_view kMetadata = "lss";         // what was recorded
inline constexpr std::string_view kEndMetadata = "lss.end";  // how it ended, once for each run

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kMetadataRecord = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};
inline constexpr std::size_t kRecordHead = 9;  // opcode and length
inline constexpr std::size_t kFooterSize = kRecordHead + 8 + 8 + 4;

struct Schema {
  std::string name;      // lss::Status
  std::string encoding;  // omgidl
  std::string text;
};

struct Channel {
  std::uint16_t schema = 0;
  std::string topic;
  std::string encoding;  // cdr
  Texts metadata;
};

// When and how often.
struct Span {
  std::uint64_t messages = 0;
  std::int64_t first_ns = 0, last_ns = 0;  // log time, UTC; both 0 without messages

  void add(std::int64_t ns) {
    first_ns = messages == 0 || ns < first_ns ? ns : first_ns;
    last_ns = messages == 0 || ns > last_ns ? ns : last_ns;
    ++messages;
  }
};

}  // namespace lss::cli::recording
