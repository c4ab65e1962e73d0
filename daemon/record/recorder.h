#pragma once

// The flight recorder: every complete frame, in files that suffice for a replay
// (docs/recording.md). Called only by the log thread. A file begins with the start of the daemon,
// or with the state of the vehicle, which the frame thread provides when wants_state() is true. An
// error of the disk is reported once and retried; frames until then are lost and counted.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "daemon/config/config.h"
#include "daemon/record/files.h"
#include "daemon/record/recording.h"
#include "drivers/time.h"
#include "idl/codes.h"

namespace lss::record {

struct RecorderSettings {
  std::filesystem::path folder;
  std::string vehicle_id;
  std::string name;  // in the names of the files
  std::uint64_t file_bytes = 16'000'000, total_bytes = 512'000'000;
  bool sync = true;               // each turn is synced to the disk
  nlohmann::ordered_json header;  // more for the header, for a replay
};

// Of a daemon with this configuration; schema and layout: schema.h, state.h. `dictionary`: what the
// daemon says of itself, for readers that do not know the vehicle.
RecorderSettings recorder_settings(const config::Config& config, const std::string& version,
                                   const std::string& schema, const std::string& state_layout,
                                   const std::string& dictionary = {});

class Recorder {
 public:
  static constexpr TimeNs kRetry = 5 * kSecond;
  static constexpr TimeNs kTellAgain = 60 * kSecond;  // repeated reports of an intermittent error

  // `tell`: reports an event.
  Recorder(RecorderSettings settings, std::function<void(EventId)> tell);
  ~Recorder() { end(); }

  // Truncates the file of a killed daemon to its last complete chunk.
  void begin();
  // `dropped`: frames dropped before this one since the start.
  void put_frame(std::span<const std::uint8_t> record, TimeNs time_ns, std::uint64_t dropped,
                 TimeNs now);
  void put_state(std::span<const std::uint8_t> state, std::uint64_t dropped, TimeNs now);
  // What was put is readable from now on, even if this process is killed.
  void turn(TimeNs now);
  void end();

  bool wants_state() const noexcept { return wants_state_; }
  bool in_trouble() const noexcept { return trouble_; }  // frames are lost
  std::string where() const { return settings_.folder.string(); }

 private:
  void open(bool start, TimeNs now);
  void note_dropped(std::uint64_t dropped);
  void flush(TimeNs now);
  void fail(int error, TimeNs now);

  RecorderSettings settings_;
  std::function<void(EventId)> tell_;
  NumberedFiles files_;
  RecordingWriter file_;
  std::filesystem::path path_;     // of the file
  std::uint64_t lost_before_ = 0;  // as in its header
  unsigned in_run_ = 0;            // files of this run so far
  std::int64_t run_utc_ns_ = 0;
  bool wants_state_ = false;
  std::uint64_t dropped_ = 0;  // by the frame thread, so far
  std::uint64_t lost_ = 0;     // not written since the last file was open
  std::uint64_t lost_in_trouble_ = 0;
  bool trouble_ = false, told_ = false;
  TimeNs retry_ns_ = 0, tell_again_ns_ = 0;
};

}  // namespace lss::record
