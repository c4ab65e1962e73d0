#pragma once

// lssd --replay: this program executes recordings again and compares every output bit. Ordinary
// thread, no DDS, no ports.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/record/vehicle_records.h"

namespace lss::record {

// Also exit codes: docs/man/lssd.8.
enum class Replayed : int {
  equal = 0,
  unreadable = 1,  // no file, or no recording
  different = 2,
  damaged = 3,     // bytes were changed since it was written
  foreign = 4,     // of another format, layout, vehicle or configuration
  incomplete = 5,  // frames without a known state before them, which cannot be compared
};

// One line of text at a time, with its end.
using Print = std::function<void(const std::string& line)>;

Replayed replay_file(const std::filesystem::path& path, const Print& print, Probe* probe = nullptr);
// In a separate process. A file contains the state of a vehicle as it is in memory: a forged one,
// or one whose bytes were changed with their checksums, ends only that process and is refused as
// damaged.
Replayed apart(const std::function<Replayed()>& replay, const Print& print);
// Each in its own process. The first result that is not equal.
Replayed replay_files(const std::vector<std::filesystem::path>& paths, const Print& print);

}  // namespace lss::record
