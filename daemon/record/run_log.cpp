#include "daemon/record/run_log.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

#include "daemon/runtime/clock.h"

namespace lss::record {
namespace {

using config::LogPart;

constexpr TimeNs kTellAgain = 60 * kSecond;  // an intermittent error is reported at most so often
constexpr TimeNs kOver = 2 * kSecond;        // without an error for so long: the log goes on

// The parts as the record names them, in the order of LogPart.
constexpr std::array kKeys = {"in", "command", "outbox", "state", "telemetry", "timing"};
static_assert(kKeys.size() == config::kLogParts.size());

}  // namespace

RunLog::RunLog(const config::LogPreset& preset, const std::filesystem::path& folder,
               const std::string& vehicle_id, nlohmann::ordered_json header, ToJson to_json,
               std::function<void(EventId)> tell)
    : preset_(preset),
      header_(std::move(header)),
      to_json_(std::move(to_json)),
      tell_(std::move(tell)),
      sink_(make_sink(preset_, folder, vehicle_id, [this] { return first_line(); })) {}

std::string RunLog::first_line() const {
  nlohmann::ordered_json first = {{"lss", "log"}, {"schema_version", 1}, {"utc_ns", utc_ns()}};
  first.update(header_);
  first["preset"] = preset_.name;
  first["what"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < config::kLogParts.size(); ++i) {
    if ((preset_.what >> i & 1u) != 0) first["what"].push_back(config::kLogParts[i]);
  }
  first["every_ms"] = preset_.every_ns / kMillisecond;
  first["lost_frames_since_start"] = dropped_;
  first["lost_lines_since_start"] = lost_;
  return line_of(first);
}

void RunLog::put(const FrameMark& mark, std::span<const std::uint8_t> record, std::uint64_t dropped,
                 TimeNs now) noexcept {
  dropped_ = dropped;
  const unsigned periodic = preset_.what & ~bit(LogPart::events);
  unsigned what = mark.events ? preset_.what & bit(LogPart::events) : 0;
  if (mark.time_ns >= next_ns_) what |= periodic;
  if (what == 0) return;
  if (preset_.every_ns > 0 && (what & periodic) != 0)
    next_ns_ = mark.time_ns - mark.time_ns % preset_.every_ns + preset_.every_ns;
  std::string error;
  try {
    error = sink_->put(line(mark, record, what, now), now);
  } catch (const std::exception& e) {  // memory is out
    error = e.what();
  }
  judge(error, now);
}

std::string RunLog::line(const FrameMark& mark, std::span<const std::uint8_t> record, unsigned what,
                         TimeNs now) const {
  nlohmann::ordered_json frame = to_json_(record);
  nlohmann::ordered_json line = {{"frame", frame.at("in").at("frame")},
                                 {"time_ns", mark.time_ns},
                                 {"utc_ns", utc_ns() - (now - mark.time_ns)}};
  if (dropped_ != said_dropped_) line["lost_frames"] = dropped_ - said_dropped_;
  if (lost_ != said_lost_) line["lost_lines"] = lost_ - said_lost_;
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    if ((what >> i & 1u) != 0) line[kKeys[i]] = std::move(frame.at(kKeys[i]));
  }
  return line_of(line);
}

// Updates the error state after a line.
void RunLog::judge(const std::string& error, TimeNs now) {
  if (error.empty()) {
    said_dropped_ = dropped_;
    said_lost_ = lost_;
    if (!trouble_ || now - trouble_ns_ < kOver) return;
    trouble_ = false;
    if (std::exchange(told_, false))
      spdlog::info("the log goes on; {} lines are lost", lost_ - told_lost_);
    return;
  }
  trouble_ = true;
  if (!told_ && now >= tell_again_ns_) {
    told_ = true;
    tell_again_ns_ = now + kTellAgain;
    told_lost_ = lost_;
    spdlog::error("the log cannot be written to {}: {}; lines are lost until it can", where(),
                  error);
    tell_(EventId::log_failed);
  }
  trouble_ns_ = now;
  ++lost_;
}

}  // namespace lss::record
