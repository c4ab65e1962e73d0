#pragma once

// Files of the log thread in a folder: ID-NUMBER-TIME-WHAT.SUFFIX, numbered by vehicle and suffix,
// so that their order does not depend on a clock that may be set.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lss::record {

class NumberedFiles {
 public:
  NumberedFiles(std::filesystem::path folder, const std::string& vehicle_id, std::string suffix)
      : folder_(std::move(folder)), prefix_(vehicle_id + "-"), suffix_(std::move(suffix)) {}

  std::filesystem::path path(unsigned number, std::int64_t utc_ns, std::string_view what) const;
  // The number of a file of this vehicle and suffix; 0: it is not one.
  unsigned number_of(const std::filesystem::path& path) const;
  // All of them, the oldest first.
  std::vector<std::pair<unsigned, std::filesystem::path>> list() const;
  // Deletes the oldest until there is room for so many more bytes within `total`, but no file that
  // another daemon of this name and folder writes. The number of the next file.
  unsigned make_room(std::uint64_t bytes, std::uint64_t total) const;

 private:
  std::filesystem::path folder_;
  std::string prefix_, suffix_;
};

// Everything in the folder; empty when it cannot be read.
std::vector<std::filesystem::path> entries(const std::filesystem::path& folder);

// A line of a file, with its end. Text may have any bytes: a source chooses its own name.
std::string line_of(const nlohmann::ordered_json& json);

// Parsed JSON of a file: discarded when it is no JSON, or nests deeper than limits.h allows.
nlohmann::ordered_json parse_json(std::string_view text);

// From now on, until it is closed, other processes see that this file is being written.
void mark_being_written(int fd);
bool is_being_written(int fd);

// Whether another program or a person deleted the open file: writing to it is useless.
bool is_removed(int fd);

// Writes everything; 0 or the error's number.
int write_all(int fd, std::string_view text);

}  // namespace lss::record
