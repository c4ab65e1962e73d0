#pragma once

// Saved parameters, in two identical files (byte format: docs/parameters.md). A copy is written
// under another name, synced to the disk and then renamed, one copy after the other and the newest
// good one last: a power cut at any moment leaves a good one. The file system is behind StoreFiles,
// so that tests can cut the power. One thread at a time.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/cycle/tunables.h"

namespace lss {

// Functions give 0 or the error's number.
class StoreFiles {
 public:
  virtual ~StoreFiles() = default;
  virtual int read(const std::filesystem::path& path, std::vector<std::uint8_t>& bytes) = 0;
  // Writes the whole file; on the disk when it returns.
  virtual int write(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) = 0;
  virtual int rename(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
  // Syncs the names in it.
  virtual int sync_folder(const std::filesystem::path& folder) = 0;
};
StoreFiles& disk();

struct StoredParameters {
  std::uint64_t number = 0;  // of the save, counted up from 1
  std::int64_t utc_ns = 0;
  std::vector<config::SavedValue> values;
};

inline constexpr std::uint32_t kStoreSchema = 1;

std::vector<std::uint8_t> encode(const StoredParameters& stored, const std::string& vehicle,
                                 const std::string& vehicle_id);

// A copy as found. trouble: what is wrong with it; then there is nothing in it.
struct StoredCopy {
  bool absent = false;
  std::string trouble;
  StoredParameters stored;
  bool good() const { return !absent && trouble.empty(); }
};
StoredCopy decode(std::span<const std::uint8_t> bytes, const std::string& vehicle,
                  const std::string& vehicle_id);

class ParameterStore {
 public:
  static constexpr std::size_t kCopies = 2;

  // `what`: in the names of the files.
  ParameterStore(std::filesystem::path folder, std::string vehicle, std::string vehicle_id,
                 StoreFiles& files = disk(), std::string what = "parameters");

  std::filesystem::path path(std::size_t copy) const;  // 0, 1

  struct Loaded {
    SavedState state = SavedState::none;
    std::optional<StoredParameters> taken;  // of the newest good copy
    std::vector<std::string> troubles;      // sentences; for each copy that is not good
  };
  Loaded load();
  // Saves under the next number; 0 when both copies are on the disk. `number`: its number.
  int save(const std::vector<config::SavedValue>& values, std::int64_t utc_ns,
           std::uint64_t& number);

 private:
  StoredCopy read(std::size_t copy);
  int write(std::size_t copy, std::span<const std::uint8_t> bytes);

  std::filesystem::path folder_;
  std::string vehicle_, vehicle_id_, what_;
  StoreFiles& files_;
  std::uint64_t number_ = 0;  // the highest seen
  std::size_t newest_ = 0;    // copy that is written last
};

}  // namespace lss
