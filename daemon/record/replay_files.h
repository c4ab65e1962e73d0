#pragma once

// lssd --replay: recordings are executed again by this program, and every bit that it makes is
// compared. Ordinary thread, no DDS, no ports.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lss::record {

// Also exit codes: docs/man/lssd.8.
enum class Replayed : int {
  equal = 0,
  unreadable = 1,  // no file, or no recording
  different = 2,
  damaged = 3,     // bytes were changed since it was written
  foreign = 4,     // of another format, layout, vehicle or configuration
  incomplete = 5,  // frames that nothing is known before, and so cannot be compared
};

// One line of text at a time, with its end.
using Print = std::function<void(const std::string& line)>;

Replayed replay_file(const std::filesystem::path& path, const Print& print);
// The result of the first one that is not equal.
Replayed replay_files(const std::vector<std::filesystem::path>& paths, const Print& print);

}  // namespace lss::record
