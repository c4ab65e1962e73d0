#include "daemon/record/frame_log.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>

#include "daemon/core/clock.h"

namespace lss::record {
namespace {

constexpr const char* kSuffix = ".crash.jsonl";
constexpr TimeNs kTurn = 50 * kMillisecond;

// Everything to the disk, or the error's number.
int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return ::fsync(fd) == 0 ? 0 : errno;
}

}  // namespace

FrameLog::FrameLog(FrameLogSettings settings, ToJson to_json)
    : settings_(std::move(settings)), to_json_(std::move(to_json)) {}

void FrameLog::start() {
  if (!settings_.folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(settings_.folder, error);
    if (!error && ::access(settings_.folder.c_str(), W_OK | X_OK) != 0)
      error.assign(errno, std::generic_category());
    if (error) {
      spdlog::warn(
          "frames before a fault cannot be kept in {} ({}): make the folder writable or name "
          "another as log.folder",
          settings_.folder.string(), error.message());
    }
  }
  thread_ = std::thread([this] { run(); });
}

void FrameLog::stop() {
  if (!thread_.joinable()) return;
  stop_ = true;
  thread_.join();
}

void FrameLog::put(FaultId fault, std::span<const std::uint8_t> record) noexcept {
  const Header header{static_cast<std::uint32_t>(record.size()), fault};
  std::array<std::uint8_t, sizeof header> bytes;
  std::memcpy(bytes.data(), &header, sizeof header);
  if (queue_.write_available() < bytes.size() + record.size()) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  queue_.push(bytes.data(), bytes.size());
  queue_.push(record.data(), record.size());
}

void FrameLog::run() {
  ::pthread_setname_np(::pthread_self(), "log");
  while (!stop_) {
    drain();
    turns_.fetch_add(1, std::memory_order_relaxed);
    sleep_until(now_ns() + kTurn);
  }
  drain();
  if (pending_ != FaultId::none) write();
}

void FrameLog::drain() {
  std::array<std::uint8_t, sizeof(Header)> bytes;
  while (queue_.read_available() >= bytes.size()) {
    queue_.pop(bytes.data(), bytes.size());
    Header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    // The writer pushes a record in two pieces.
    while (queue_.read_available() < header.size) std::this_thread::yield();
    if (last_.size() == kFrames) last_.pop_front();
    last_.emplace_back(header.size);
    queue_.pop(last_.back().data(), header.size);
    ++since_;
    if (pending_ == FaultId::none) pending_ = header.fault;
    if (pending_ != FaultId::none && since_ >= kFrames) write();
  }
}

void FrameLog::write() {
  const CodeInfo* fault = info(std::exchange(pending_, FaultId::none));
  since_ = 0;
  if (settings_.folder.empty()) return;
  const TimeNs utc = utc_ns();
  const std::string name = fmt::format(
      "{}-{:%Y%m%dT%H%M%S}.{:03}Z-{:04}-{}{}", settings_.vehicle_id,
      fmt::gmtime(static_cast<std::time_t>(utc / kSecond)), utc % kSecond / kMillisecond,
      ++written_, fault != nullptr ? fault->name : "fault", kSuffix);
  const std::filesystem::path path = settings_.folder / name;
  if (const std::string error = write_file(path); !error.empty()) {
    spdlog::error(
        "the {} frames before the fault could not be kept in {}: {}; free or mend the "
        "disk, or name another log.folder",
        last_.size(), path.string(), error);
    if (!failed_) told_.push(EventId::log_failed);
    failed_ = true;
    return;
  }
  failed_ = false;
  spdlog::info("the last {} frames are kept: lss-cli log show {}", last_.size(), path.string());
  told_.push(EventId::frames_kept);
  keep_newest();
}

// Empty, or what went wrong. Half a file never has the name of a whole one.
std::string FrameLog::write_file(const std::filesystem::path& path) const {
  nlohmann::ordered_json first = {{"lss", "crash"}, {"schema_version", 1}, {"utc_ns", utc_ns()}};
  first.update(settings_.header);
  first["frames"] = last_.size();
  std::string text = first.dump() + "\n";
  for (const std::vector<std::uint8_t>& record : last_) text += to_json_(record).dump() + "\n";

  const std::string temporary = path.string() + ".part";
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return std::strerror(errno);
  int error = write_all(fd, text);
  if (::close(fd) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return {};
  ::unlink(temporary.c_str());
  return std::strerror(error);
}

void FrameLog::keep_newest() const {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(settings_.folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(settings_.vehicle_id + "-") && name.ends_with(kSuffix))
      files.push_back(entry.path());
  }
  std::ranges::sort(files);  // the time of their making stands in their names
  for (std::size_t i = 0; i + settings_.files < files.size(); ++i)
    std::filesystem::remove(files[i], error);
}

}  // namespace lss::record
