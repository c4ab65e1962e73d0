#include "daemon/parameters/store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

#include "daemon/record/files.h"
#include "daemon/record/recording.h"
#include "drivers/file.h"

namespace lss {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers in files are little-endian");

// Not text; shows a transfer that changed line ends.
constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'L', 'S', 'S', 'P', 'A', 'R', '\n'};
constexpr std::size_t kIdSize = 16, kNameField = 48;
constexpr std::size_t kHead = kMagic.size() + 4 + 4 + 8 + 8 + 2 * kIdSize;
constexpr std::size_t kEntry = kNameField + 8;
constexpr std::size_t kCrc = 4;
constexpr std::size_t kMostEntries = 1000;
constexpr std::size_t kMostBytes = kHead + kMostEntries * kEntry + kCrc;

using Bytes = std::vector<std::uint8_t>;

template <class T>
void append(Bytes& to, const T& x) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&x);
  to.insert(to.end(), bytes, bytes + sizeof x);
}
void append(Bytes& to, const std::string& text, std::size_t size) {
  const std::size_t length = std::min(text.size(), size - 1);
  to.insert(to.end(), text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length));
  to.insert(to.end(), size - length, 0);
}

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : left_(bytes) {}
  template <class T>
  T get() {
    T x;
    std::memcpy(&x, left_.data(), sizeof x);
    left_ = left_.subspan(sizeof x);
    return x;
  }
  std::string text(std::size_t size) {
    const auto field = left_.first(size);
    left_ = left_.subspan(size);
    return {field.begin(), std::ranges::find(field, 0)};
  }

 private:
  std::span<const std::uint8_t> left_;
};

class Disk final : public StoreFiles {
 public:
  int read(const std::filesystem::path& path, Bytes& bytes) override {
    const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // a pipe has no end
    if (!file) return errno;
    bytes.resize(kMostBytes + 1);  // one more: shows a file that is too long
    std::size_t size = 0;
    int error = 0;
    while (size < bytes.size()) {
      const ssize_t got = ::read(file.get(), &bytes[size], bytes.size() - size);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) error = errno;
      if (got <= 0) break;
      size += static_cast<std::size_t>(got);
    }
    bytes.resize(size);
    return error;
  }

  int write(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) override {
    std::error_code ignored;  // open reports the error
    std::filesystem::create_directories(path.parent_path(), ignored);
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
    if (fd < 0) return errno;
    int error = record::write_all(fd, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (error == 0 && ::fsync(fd) != 0) error = errno;
    if (::close(fd) != 0 && error == 0) error = errno;
    return error;
  }

  int rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
  }

  int sync_folder(const std::filesystem::path& folder) override {
    const File file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!file) return errno;
    const bool synced = ::fsync(file.get()) == 0;
    return synced || errno == EINVAL ? 0 : errno;  // EINVAL: this file system has nothing to sync
  }
};

}  // namespace

StoreFiles& disk() {
  static Disk files;
  return files;
}

Bytes encode(const StoredParameters& stored, const std::string& vehicle,
             const std::string& vehicle_id) {
  Bytes bytes(kMagic.begin(), kMagic.end());
  append(bytes, kStoreSchema);
  append(bytes, static_cast<std::uint32_t>(stored.values.size()));
  append(bytes, stored.number);
  append(bytes, stored.utc_ns);
  append(bytes, vehicle, kIdSize);
  append(bytes, vehicle_id, kIdSize);
  for (const config::SavedValue& value : stored.values) {
    append(bytes, value.name, kNameField);
    append(bytes, value.value);
  }
  append(bytes, record::crc32c(bytes));
  return bytes;
}

// The checksum is the last four bytes in every schema: first the bytes are verified, then the
// vehicle.
StoredCopy decode(std::span<const std::uint8_t> bytes, const std::string& vehicle,
                  const std::string& vehicle_id) {
  StoredCopy copy;
  const auto refuse = [&](std::string why) {
    copy.trouble = std::move(why);
    return copy;
  };
  if (bytes.size() < kMagic.size() + kCrc || bytes.size() > kMostBytes)
    return refuse(fmt::format("is damaged: {} bytes", bytes.size()));
  if (!std::ranges::equal(bytes.first(kMagic.size()), kMagic))
    return refuse("is damaged: it does not begin as such a file does");
  const auto body = bytes.first(bytes.size() - kCrc);
  if (Reader(bytes.last(kCrc)).get<std::uint32_t>() != record::crc32c(body))
    return refuse("is damaged: its checksum is wrong");
  Reader reader(body.subspan(kMagic.size()));
  if (const auto schema = body.size() < kHead ? 0 : reader.get<std::uint32_t>();
      schema != kStoreSchema)
    return refuse(fmt::format("has schema version {}, this program has {}", schema, kStoreSchema));
  const auto count = reader.get<std::uint32_t>();
  if (body.size() != kHead + count * kEntry) return refuse("is damaged: its count is wrong");
  copy.stored.number = reader.get<std::uint64_t>();
  copy.stored.utc_ns = reader.get<std::int64_t>();
  const std::string theirs = reader.text(kIdSize), their_id = reader.text(kIdSize);
  if (theirs != vehicle || their_id != vehicle_id)
    return refuse(
        fmt::format("is of {} ({}), this is {} ({})", their_id, theirs, vehicle_id, vehicle));
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string name = reader.text(kNameField);
    if (name.size() == kNameField) {
      copy.stored.values.clear();
      return refuse("is damaged: a name has no end");
    }
    copy.stored.values.push_back({.name = std::move(name), .value = reader.get<double>()});
  }
  return copy;
}

ParameterStore::ParameterStore(std::filesystem::path folder, std::string vehicle,
                               std::string vehicle_id, StoreFiles& files, std::string what)
    : folder_(std::move(folder)),
      vehicle_(std::move(vehicle)),
      vehicle_id_(std::move(vehicle_id)),
      what_(std::move(what)),
      files_(files) {}

std::filesystem::path ParameterStore::path(std::size_t copy) const {
  return folder_ / fmt::format("{}-{}-{}.bin", vehicle_id_, what_, copy + 1);
}

StoredCopy ParameterStore::read(std::size_t copy) {
  Bytes bytes;
  const int error = files_.read(path(copy), bytes);
  if (error == ENOENT) return {.absent = true, .trouble = {}, .stored = {}};
  if (error != 0) {
    return {.absent = false,
            .trouble = "cannot be read: " + std::generic_category().message(error),
            .stored = {}};
  }
  return decode(bytes, vehicle_, vehicle_id_);
}

ParameterStore::Loaded ParameterStore::load() {
  std::array<StoredCopy, kCopies> copies{read(0), read(1)};
  Loaded loaded;
  std::size_t absent = 0, good = 0;
  for (std::size_t i = 0; i < kCopies; ++i) {
    StoredCopy& copy = copies[i];
    absent += copy.absent ? 1 : 0;
    if (!copy.good()) {
      if (!copy.absent)
        loaded.troubles.push_back(fmt::format("copy {} {}", path(i).string(), copy.trouble));
      continue;
    }
    ++good;
    const bool newer = !loaded.taken || copy.stored.number > loaded.taken->number;
    if (!newer) continue;
    number_ = copy.stored.number;
    newest_ = i;
    loaded.taken = std::move(copy.stored);
  }
  if (absent == 1 && good == 1)  // the power was cut in the very first save, or it was removed
    loaded.troubles.push_back(fmt::format("copy {} is not there", path(1 - newest_).string()));
  loaded.state = absent == kCopies         ? SavedState::none
                 : good == 0               ? SavedState::lost
                 : loaded.troubles.empty() ? SavedState::good
                                           : SavedState::one_copy;
  return loaded;
}

int ParameterStore::write(std::size_t copy, std::span<const std::uint8_t> bytes) {
  const std::filesystem::path to = path(copy);
  std::filesystem::path fresh = to;
  fresh += ".new";
  int error = files_.write(fresh, bytes);
  if (error == 0) error = files_.rename(fresh, to);
  if (error == 0) error = files_.sync_folder(folder_);
  return error;
}

int ParameterStore::save(const std::vector<config::SavedValue>& values, std::int64_t utc_ns,
                         std::uint64_t& number) {
  number = ++number_;
  const Bytes bytes =
      encode({.number = number, .utc_ns = utc_ns, .values = values}, vehicle_, vehicle_id_);
  const std::size_t first = 1 - newest_;
  if (const int error = write(first, bytes); error != 0) return error;
  newest_ = first;
  return write(1 - first, bytes);
}

}  // namespace lss
