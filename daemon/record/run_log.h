#pragma once

// The log that goes on while the daemon runs: what of each frame is written, how often and where
// says a preset of the configuration (Zebro thesis 7.2.1). The log thread alone calls it. A line of
// JSON holds the number of the frame, its times, and the parts that were chosen, as the record has
// them; lost_frames and lost_lines say what is missing since the line before. Events and
// acknowledgements are written with the frame that has them, whatever the period.

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

// Makes JSON of a record.
using ToJson = std::function<nlohmann::ordered_json(std::span<const std::uint8_t>)>;

// What the log thread needs to know of a frame before it reads the record.
struct FrameMark {
  FaultId fault = FaultId::none;  // the first that was raised in it
  bool events = false;            // it has events or acknowledgements
  TimeNs time_ns = 0;
};

class RunLog {
 public:
  // `header`: more for the first line. `tell`: what shall be told as an event.
  RunLog(const config::LogPreset& preset, const std::filesystem::path& folder,
         const std::string& vehicle_id, nlohmann::ordered_json header, ToJson to_json,
         std::function<void(EventId)> tell);

  // A frame; `dropped`: how many before it could not be taken, since the start.
  void put(const FrameMark& mark, std::span<const std::uint8_t> record, std::uint64_t dropped,
           TimeNs now) noexcept;

  std::string where() const { return sink_->where(); }
  bool in_trouble() const { return told_; }  // lines are lost

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
  std::uint64_t dropped_ = 0, said_dropped_ = 0;  // frames; said: in a line
  std::uint64_t lost_ = 0, said_lost_ = 0;        // lines
  bool told_ = false;                             // that lines are lost
  std::uint64_t told_lost_ = 0;                   // lost before that
  TimeNs tell_again_ns_ = 0;                      // not before
  TimeNs trouble_ns_ = 0;                         // the last line that was lost
};

}  // namespace lss::record
