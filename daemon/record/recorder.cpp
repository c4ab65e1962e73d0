#include "daemon/record/recorder.h"

#include <spdlog/spdlog.h>

#include <cstring>
#include <system_error>
#include <utility>

#include "daemon/record/build.h"
#include "daemon/runtime/clock.h"

namespace lss::record {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kChunk = 256 * 1024;  // bytes in memory before a write, at most

// Saved parameters that replaced those of the configuration.
nlohmann::ordered_json saved_parameters(const config::Config& config) {
  auto all = nlohmann::ordered_json::object();
  for (const config::SavedValue& saved : config.saved) all[saved.name] = saved.value;
  return all;
}

}  // namespace

RecorderSettings recorder_settings(const config::Config& config, const std::string& version,
                                   const std::string& schema, const std::string& state_layout,
                                   const std::string& dictionary) {
  return {.folder = config.log_folder,
          .vehicle_id = config.vehicle_id,
          .name = config.vehicle,
          .file_bytes = config.recorder.file_bytes,
          .total_bytes = config.recorder.total_bytes,
          .sync = config.recorder.sync,
          .header = {{"vehicle", config.vehicle},
                     {"vehicle_id", config.vehicle_id},
                     {"version", version},
                     {"build", this_build()},
                     {"period_ns", config.period_ns},
                     {"config_file", config.file},
                     {"config", config.text},
                     {"parameters", saved_parameters(config)},
                     {"dictionary", dictionary},
                     {"state_layout", state_layout},
                     {"schema", schema}}};
}

Recorder::Recorder(RecorderSettings settings, std::function<void(EventId)> tell)
    : settings_(std::move(settings)),
      tell_(std::move(tell)),
      files_(settings_.folder, settings_.vehicle_id, kRecordingSuffix) {}

void Recorder::begin() {
  run_utc_ns_ = utc_ns();
  std::error_code ignored;
  fs::create_directories(settings_.folder, ignored);  // the first file reports the error
  const auto files = files_.list();
  if (files.empty()) return;
  const fs::path& last = files.back().second;
  const auto torn = cut_recording(last);
  if (!torn) {
    spdlog::warn("the last recording stays as it is: {}", torn.error());
  } else if (*torn > 0) {
    spdlog::warn("the last recording was not written to its end: {} bytes are cut off {}", *torn,
                 last.string());
  } else {
    return;
  }
  tell_(EventId::recording_cut);
}

void Recorder::put_frame(std::span<const std::uint8_t> record, TimeNs time_ns,
                         std::uint64_t dropped, TimeNs now) {
  note_dropped(dropped);
  if (!file_.is_open() && in_run_ == 0 && lost_ == 0 && !trouble_) open(true, now);
  if (!file_.is_open()) {
    ++lost_;
    ++lost_in_trouble_;
    wants_state_ = now >= retry_ns_;
    return;
  }
  file_.add_frame(record, time_ns);
  // A little before the limit: the state comes with the next frame.
  if (file_.size() > settings_.file_bytes - settings_.file_bytes / 16) wants_state_ = true;
  if (file_.pending() > kChunk) flush(now);
}

void Recorder::put_state(std::span<const std::uint8_t> state, std::uint64_t dropped, TimeNs now) {
  note_dropped(dropped);
  wants_state_ = false;
  if (file_.is_open() && file_.size() > settings_.file_bytes / 2) {
    if (const int error = file_.end(); error != 0) return fail(error, now);
  }
  if (!file_.is_open() && now >= retry_ns_) open(false, now);
  if (file_.is_open()) file_.add(Item::state, state);
}

// A gap: frames after it cannot be replayed until there is a state again.
void Recorder::note_dropped(std::uint64_t dropped) {
  const std::uint64_t more = dropped - std::exchange(dropped_, dropped);
  if (more == 0) return;
  wants_state_ = true;
  if (file_.is_open()) {
    file_.add_lost(more);
  } else {
    lost_ += more;
  }
}

void Recorder::turn(TimeNs now) {
  if (!file_.is_open()) return;
  if (file_.removed()) {  // writing to it is useless
    lost_ += file_.pending_frames();
    file_.abandon();
    wants_state_ = true;
    return;
  }
  if (file_.pending() == 0) return;
  flush(now);
  if (!file_.is_open()) return;
  if (const int error = settings_.sync ? file_.sync() : 0; error != 0) return fail(error, now);
  if (trouble_ && told_) spdlog::info("frames are recorded again; {} are lost", lost_in_trouble_);
  trouble_ = told_ = false;
}

void Recorder::end() {
  if (!file_.is_open()) return;
  // The run ends with the file: the next one would contain only a state.
  const RecordingEnd& held = file_.so_far();
  if (in_run_ > 1 && held.frames + held.lost + lost_before_ == 0) {
    file_.abandon();
    std::error_code ignored;
    fs::remove(path_, ignored);
    return;
  }
  if (const int error = file_.end(); error != 0) fail(error, now_ns());
}

void Recorder::flush(TimeNs now) {
  if (const int error = file_.flush(); error != 0) fail(error, now);
}

void Recorder::open(bool start, TimeNs now) {
  const unsigned number = files_.make_room(settings_.file_bytes, settings_.total_bytes);
  nlohmann::ordered_json header = {{"lss", "recording"},  {"utc_ns", utc_ns()},
                                   {"time_ns", now},      {"run_utc_ns", run_utc_ns_},
                                   {"file", in_run_ + 1}, {"start", start},
                                   {"lost_before", lost_}};
  header.update(settings_.header);
  path_ = files_.path(number, utc_ns(), settings_.name);
  const int error = file_.begin(path_, header, settings_.file_bytes);
  if (error != 0) return fail(error, now);
  ++in_run_;
  lost_before_ = lost_;
  lost_ = 0;
}

void Recorder::fail(int error, TimeNs now) {
  if (!trouble_) lost_in_trouble_ = 0;
  lost_ += file_.pending_frames();
  lost_in_trouble_ += file_.pending_frames();
  file_.abandon();
  trouble_ = true;
  wants_state_ = false;
  retry_ns_ = now + kRetry;
  if (told_ || now < tell_again_ns_) return;
  told_ = true;
  tell_again_ns_ = now + kTellAgain;
  spdlog::error(
      "frames cannot be recorded in {}: {}; free or repair the disk, make the folder writable, or "
      "name another log.folder",
      settings_.folder.string(), std::strerror(error));
  tell_(EventId::recording_failed);
}

}  // namespace lss::record
