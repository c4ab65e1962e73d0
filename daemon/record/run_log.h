#pragma once

// The log that runs with the daemon: a preset of the configuration selects parts of each frame,
// period and target (Zebro thesis 7.2.1). Called only by the log thread. A line of JSON has the
// number of the frame, its times, and the selected parts, as in the record; lost_frames and
// lost_lines count what is missing since the line before. Events and acknowledgements are written
// with their frame, at any period.

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "daemon/config/config.h"
#include "daemon/record/log_sink.h"
#include "idl/codes.h"

namespace lss::record {

// Converts a record to JSON.
using ToJson = std::function<nlohmann::ordered_json(std::span<const std::uint8_t>)>;

// Facts of a frame for the log thread, without reading the record.
struct FrameMark {
  FaultId fault = FaultId::none;  // the first that was raised in it
  bool events = false;            // it has events or acknowledgements
  TimeNs time_ns = 0;
};

class RunLog {
 public:
  // `header`: more for the first line. `tell`: reports an event.
  RunLog(const config::LogPreset& preset, const std::filesystem::path& folder,
         const std::string& vehicle_id, nlohmann::ordered_json header, ToJson to_json,
         std::function<void(EventId)> tell);

  // A frame; `dropped`: frames dropped before it since the start.
  void put(const FrameMark& mark, std::span<const std::uint8_t> record, std::uint64_t dropped,
           TimeNs now) noexcept;

  std::string where() const { return sink_->where(); }
  bool in_trouble() const { return trouble_; }  // lines are lost

 private:
  std::string first_line() const;
  std::string line(const FrameMark& mark, std::span<const std::uint8_t> record, unsigned what,
                   TimeNs now) const;
  void judge(const std::string& error, TimeNs now);

  config::LogPreset preset_;
  nlohmann::ordered_json header_;
  ToJson to_json_;
  std::function<void(EventId)> tell_;
  std::unique_ptr<LogSink> sink_;
  TimeNs next_ns_ = 0;                            // a line is due
  std::uint64_t dropped_ = 0, said_dropped_ = 0;  // frames; said: written in a line
  std::uint64_t lost_ = 0, said_lost_ = 0;        // lines
  bool trouble_ = false;                          // lines are lost
  bool told_ = false;                             // that was reported
  std::uint64_t told_lost_ = 0;                   // lost before that
  TimeNs tell_again_ns_ = 0;                      // not before
  TimeNs trouble_ns_ = 0;                         // the last line that was lost
};

}  // namespace lss::record
