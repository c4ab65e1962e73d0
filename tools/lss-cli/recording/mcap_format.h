#pragma once

// Records of the MCAP format, version 0 (mcap.dev/spec), as far as lss-cli writes or reads them.
// Pure data.

#include <cstdint>
#include <string>
#include <string_view>

#include "tools/lss-cli/recording/bytes.h"

namespace lss::cli::recording {

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::string_view kLibrary = "lss-cli";      // the start of our library field
inline constexpr std::string_view kMetadata = "lss";         // what was recorded
inline constexpr std::string_view kEndMetadata = "lss.end";  // the end of a run, once for each run

// Types of records.
inline constexpr std::uint8_t kHeader = 0x01, kFooter = 0x02, kSchema = 0x03, kChannel = 0x04,
                              kMessage = 0x05, kChunk = 0x06, kMessageIndex = 0x07,
                              kChunkIndex = 0x08, kStatistics = 0x0B, kMetadataRecord = 0x0C,
                              kMetadataIndex = 0x0D, kSummaryOffset = 0x0E, kDataEnd = 0x0F;
inline constexpr std::size_t kRecordHead = 9;  // opcode and length
inline constexpr std::size_t kFooterSize = kRecordHead + 8 + 8 + 4;

// Limits of a file, so that no file exhausts its reader; our own files are far below. A file above
// them is rejected.
namespace most {
inline constexpr std::size_t kDescriptions = 4'000'000;  // bytes of all but chunks and indexes
inline constexpr std::size_t kIdl = 256'000;             // bytes of the IDL of a schema
inline constexpr std::size_t kChannels = 1000;
inline constexpr std::size_t kChunks = 1'000'000;
inline constexpr std::size_t kName = 256;          // characters of a topic, or of a column
inline constexpr std::size_t kModuleDepth = 16;    // modules in modules
inline constexpr std::size_t kStructDepth = 16;    // structs in structs
inline constexpr std::size_t kMembers = 256;       // of a struct, or names of an enum
inline constexpr std::size_t kElements = 100'000;  // of an array
inline constexpr std::size_t kColumns = 100'000;   // of all types of a schema, of all topics
}  // namespace most

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

// From one time to another in ns: a file may contain any times, and their difference may overflow.
inline double ns_between(std::int64_t from_ns, std::int64_t to_ns) {
  std::int64_t ns = 0;
  if (!__builtin_sub_overflow(to_ns, from_ns, &ns)) return static_cast<double>(ns);
  return static_cast<double>(to_ns) - static_cast<double>(from_ns);
}

// Times and counts.
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
