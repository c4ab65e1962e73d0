#pragma once

// Limits of a flight recording and of lines of the log, so that no file exhausts its reader; lssd
// writes far less (docs/recording.md). Larger ones are refused. For lssd --replay and lss-cli.

#include <cstddef>
#include <cstdint>

namespace lss::record::most {

inline constexpr std::uint64_t kFileBytes = 2'000'000'000;  // file_mb is at most 1000
inline constexpr std::size_t kChunkBytes = 16'000'000;
inline constexpr std::size_t kHeaderBytes = 4'000'000;  // with the configuration and the schema
inline constexpr int kJsonDepth = 32;                   // of a header, of a line of the log
inline constexpr std::size_t kLineBytes = 4'000'000;    // of the log
inline constexpr std::size_t kSchemaBytes = 1'000'000;
inline constexpr int kSchemaDepth = 32;
inline constexpr std::size_t kName = 64;        // characters of a member
inline constexpr std::size_t kFields = 50'000;  // of a record, the elements of its lists included
inline constexpr std::int64_t kTime_ns = (std::int64_t{1} << 62) - 1;  // the year 2116

// A time that can be added to or subtracted from another.
constexpr bool is_time(std::int64_t ns) { return ns >= 0 && ns <= kTime_ns; }

}  // namespace lss::record::most
