#include "daemon/record/frame_log.h"

#include <fcntl.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <system_error>

#include "daemon/runtime/clock.h"
#include "drivers/file.h"

namespace lss::record {
namespace {

constexpr const char* kSuffix = ".crash.jsonl";
constexpr const char* kPart = ".part";
constexpr TimeNs kTurn = 50 * kMillisecond;
constexpr TimeNs kNoMoreFrames = 500 * kMillisecond;
constexpr TimeNs kTellDropped = 60 * kSecond;

}  // namespace

FrameLog::FrameLog(FrameLogSettings settings, ToJson to_json)
    : settings_(std::move(settings)),
      files_(settings_.folder, settings_.vehicle_id, kSuffix),
      to_json_(std::move(to_json)) {}

void FrameLog::start() {
  if (!settings_.folder.empty()) prepare_folder();
  for (const config::LogPreset& preset : settings_.presets) {
    run_logs_.push_back(std::make_unique<RunLog>(preset, settings_.folder, settings_.vehicle_id,
                                                 settings_.header, to_json_,
                                                 [this](EventId id) { told_.push(id); }));
    spdlog::info("logging \"{}\" to {}", preset.name, run_logs_.back()->where());
  }
  if (const auto& settings = settings_.recorder) {
    recorder_ = std::make_unique<Recorder>(*settings, [this](EventId id) { told_.push(id); });
    spdlog::info("recording every frame to {}", recorder_->where());
  }
  thread_ = std::thread([this] { run(); });
}

// Makes the folder, removes partial files that no daemon writes, and continues the numbering.
void FrameLog::prepare_folder() {
  std::error_code error;
  std::filesystem::create_directories(settings_.folder, error);
  if (!error && ::access(settings_.folder.c_str(), W_OK | X_OK) != 0)
    error.assign(errno, std::generic_category());
  if (error) {
    spdlog::warn(
        "frames before a fault cannot be kept in {} ({}): make the folder writable or name another "
        "as log.folder",
        settings_.folder.string(), error.message());
    return;
  }
  for (const std::filesystem::path& path : entries(settings_.folder)) {
    number_ = std::max(number_, files_.number_of(path));
    if (path.extension() != kPart || files_.number_of(path.parent_path() / path.stem()) == 0)
      continue;
    const File part(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!part || !is_being_written(part.get())) std::filesystem::remove(path, error);
  }
}

void FrameLog::stop() {
  if (!thread_.joinable()) return;
  stop_ = true;
  thread_.join();
}

void FrameLog::put(const FrameMark& mark, std::span<const std::uint8_t> record) noexcept {
  if (!push({.size = record.size(), .dropped = dropped(), .mark = mark}, record))
    dropped_.fetch_add(1, std::memory_order_relaxed);
}

// Without room it is requested again.
void FrameLog::put_state(std::span<const std::uint8_t> state) noexcept {
  if (push({.item = Item::state, .size = state.size(), .dropped = dropped(), .mark = {}}, state))
    wants_state_.store(false, std::memory_order_relaxed);
}

bool FrameLog::push(const Header& header, std::span<const std::uint8_t> bytes) noexcept {
  std::array<std::uint8_t, sizeof header> head;
  std::memcpy(head.data(), &header, sizeof header);
  if (queue_.write_available() < head.size() + bytes.size()) return false;
  queue_.push(head.data(), head.size());
  queue_.push(bytes.data(), bytes.size());
  return true;
}

void FrameLog::run() {
  ::pthread_setname_np(::pthread_self(), "log");
  const lockstep::Part part("log");
  if (recorder_) recorder_->begin();
  TimeNs heard_ns = now_ns();
  while (!stop_) {
    const std::size_t before = since_;
    drain();
    const TimeNs now = now_ns();
    if (recorder_) {
      recorder_->turn(now);
      wants_state_.store(recorder_->wants_state(), std::memory_order_relaxed);
    }
    if (since_ != before) heard_ns = now;
    const bool keep = keep_.exchange(false);
    if (keep && !last_.empty() && pending_ == FaultId::none) pending_ = FaultId::frame_overrun;
    if (pending_ != FaultId::none && (keep || now - heard_ns >= kNoMoreFrames)) write();
    recording_.store(writes(), std::memory_order_relaxed);
    tell_dropped(now);
    turns_.fetch_add(1, std::memory_order_relaxed);
    sleep_until(now + kTurn);
  }
  drain();
  if (pending_ != FaultId::none) write();
  if (recorder_) recorder_->end();
}

// Everything configured is being written, and something was configured.
bool FrameLog::writes() const {
  const bool trouble =
      std::ranges::any_of(run_logs_, [](const auto& log) { return log->in_trouble(); }) ||
      (recorder_ && recorder_->in_trouble());
  return (!run_logs_.empty() || recorder_) && !trouble;
}

void FrameLog::drain() {
  std::array<std::uint8_t, sizeof(Header)> bytes;
  while (queue_.read_available() >= bytes.size()) {
    queue_.pop(bytes.data(), bytes.size());
    Header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    // The writer pushes a record in two pieces.
    while (queue_.read_available() < header.size) std::this_thread::yield();
    take(header, now_ns());
    if (pending_ != FaultId::none && since_ >= kFrames) write();
  }
}

void FrameLog::take(const Header& header, TimeNs now) {
  if (header.item == Item::state) {
    state_.resize(header.size);
    queue_.pop(state_.data(), header.size);
    if (recorder_) recorder_->put_state(state_, header.dropped, now);
    return;
  }
  if (last_.size() == kFrames) last_.pop_front();
  last_.emplace_back(header.size);
  queue_.pop(last_.back().data(), header.size);
  ++since_;
  if (recorder_) recorder_->put_frame(last_.back(), header.mark.time_ns, header.dropped, now);
  for (const auto& log : run_logs_) log->put(header.mark, last_.back(), header.dropped, now);
  if (pending_ == FaultId::none) pending_ = header.mark.fault;
}

// At most once a minute.
void FrameLog::tell_dropped(TimeNs now) {
  const std::uint64_t all = dropped();
  if (all == told_dropped_ || now < tell_dropped_ns_) return;
  spdlog::warn("{} frames are missing in the log: the disk or the machine was too slow",
               all - told_dropped_);
  told_dropped_ = all;
  tell_dropped_ns_ = now + kTellDropped;
  told_.push(EventId::log_lost);
}

void FrameLog::write() {
  const CodeInfo* fault = info(std::exchange(pending_, FaultId::none));
  since_ = 0;
  if (settings_.folder.empty()) return;
  const std::filesystem::path path =
      files_.path(++number_, utc_ns(), fault != nullptr ? fault->name : "fault");
  std::string error;
  try {
    error = write_file(path);
  } catch (const std::exception& e) {  // memory is exhausted
    error = e.what();
  }
  if (!error.empty()) {
    spdlog::error(
        "the {} frames before the fault could not be kept in {}: {}; free or repair the disk, or "
        "name another log.folder",
        last_.size(), path.string(), error);
    if (!failed_) told_.push(EventId::log_failed);
    failed_ = true;
    return;
  }
  failed_ = false;
  if (first_.empty()) first_ = path;
  keep_newest();
  spdlog::info("the last {} frames are kept: lss-cli log show {}", last_.size(), path.string());
  told_.push(EventId::frames_kept);
}

// Empty, or the error. A partial file never has the name of a complete one.
std::string FrameLog::write_file(const std::filesystem::path& path) const {
  nlohmann::ordered_json first = {{"lss", "crash"}, {"schema_version", 1}, {"utc_ns", utc_ns()}};
  first.update(settings_.header);
  first["frames"] = last_.size();
  first["dropped_since_start"] = dropped();
  std::string text = line_of(first);
  for (const std::vector<std::uint8_t>& record : last_) text += line_of(to_json_(record));

  const std::string temporary = path.string() + kPart;
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return std::strerror(errno);
  mark_being_written(fd);
  int error = write_all(fd, text);
  if (error == 0 && ::fsync(fd) != 0) error = errno;
  // Before it is closed, which unlocks it: another daemon deletes an unlocked one.
  if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (::close(fd) != 0 && error == 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    return std::strerror(error);
  }
  // The name must survive a power cut, too.
  const File folder(::open(settings_.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder) ::fsync(folder.get());
  return {};
}

void FrameLog::keep_newest() const {
  auto files = files_.list();
  std::erase_if(files, [this](const auto& file) { return file.second == first_; });
  std::error_code error;
  for (std::size_t i = 0; i + settings_.files < files.size() + 1; ++i)
    std::filesystem::remove(files[i].second, error);
}

}  // namespace lss::record
