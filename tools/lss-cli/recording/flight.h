#pragma once

// A recording of the flight recorder (*.lssrec, docs/recording.md): its description and its frames.
// It is read completely when it is opened, so that damage is known before its content is used. One
// thread. Errors in a file are thrown as a Failure that names it.

#include <cstdint>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/record/recording.h"
#include "tools/lss-cli/recording/record_layout.h"

namespace lss::cli::recording {

// Numbers of frames, both included.
struct FrameRange {
  std::uint64_t first = 0, last = std::numeric_limits<std::uint64_t>::max();

  bool all() const { return first == 0 && last == std::numeric_limits<std::uint64_t>::max(); }
  bool one() const { return first == last; }
  bool holds(std::uint64_t frame) const { return frame >= first && frame <= last; }
};
// "154", "100..200", "100..", "..200"; a Failure with ExitCode::usage.
FrameRange parse_frames(std::string_view text);

// Of a flight recording. Times in s since its first frame.
struct Part {
  FrameRange frames{};
  double from_s = -std::numeric_limits<double>::infinity();
  double until_s = std::numeric_limits<double>::infinity();
  bool damaged = false;  // also of a damaged file, what is whole; otherwise only what is before
};

class Flight {
 public:
  using End = lss::record::RecordingReader::End;
  struct Frame {
    std::uint64_t number = 0;
    std::int64_t time_ns = 0, utc_ns = 0;  // T_k
    double t_s = 0;                        // since the first one
    std::uint64_t lost = 0;                // missing frames before it
    RecordLayout::Bytes record{};
  };

  explicit Flight(const std::string& path);

  const nlohmann::ordered_json& header() const { return header_; }
  std::string text(const char* key) const;  // of the header; "?" when absent
  RecordLayout& layout() { return layout_; }

  std::uint64_t frames() const { return frames_; }
  std::uint64_t lost() const { return lost_; }     // in it
  bool lost_known() const { return lost_known_; }  // else there may be more
  const Frame& first() const { return first_; }    // whose records are missing
  const Frame& last() const { return last_; }
  double duration_s() const;  // with the last frame
  std::uint64_t bytes() const { return bytes_; }
  End end() const { return end_; }
  const char* end_name() const;  // ended, open, torn, damaged
  // A note about its end; empty: it was ended.
  std::string complaint() const;

  // In their order. A part without a frame is an error, and one that extends past damage, unless
  // Part::damaged.
  void each(const Part& part, const std::function<void(const Frame&)>& take) const;

 private:
  static lss::record::RecordingReader open(const std::string& path);
  Flight(const std::string& path, lss::record::RecordingReader reader);
  void read_all(lss::record::RecordingReader& reader);
  Frame frame(RecordLayout::Bytes record) const;
  bool in(const Part& part, const Frame& frame) const;
  void refuse_damage(const Part& part) const;
  [[noreturn]] void refuse_emptiness(const Part& part) const;

  std::string path_;
  nlohmann::ordered_json header_;
  RecordLayout layout_;
  std::size_t frame_at_ = 0, time_at_ = 0;
  std::int64_t period_ns_ = 0, utc_from_time_ns_ = 0;
  std::uint64_t frames_ = 0, lost_ = 0, bytes_ = 0;
  Frame first_, last_;
  bool lost_known_ = true;
  std::optional<Frame> sound_;  // the last one before damage
  End end_ = End::none;
  std::string trouble_;
};

bool is_flight(const std::string& path);  // by its first bytes
// For a file to be written: a Failure with ExitCode::usage when a recording is there, of any type.
void refuse_recording(const std::string& out);

}  // namespace lss::cli::recording
