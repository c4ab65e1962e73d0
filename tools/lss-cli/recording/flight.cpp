#include "tools/lss-cli/recording/flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "daemon/record/limits.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli::recording {
namespace {

using lss::record::Item;
using lss::record::RecordingReader;

std::uint64_t load(RecordLayout::Bytes record, std::size_t at) {
  if (record.size() < at + sizeof(std::uint64_t)) {
    throw Failure(ExitCode::failed, "a record in it is too short to be one",
                  "take another copy of the file");
  }
  std::uint64_t x;
  std::memcpy(&x, &record[at], sizeof x);
  return x;
}

// Counts the frames that are missing before the next one.
class Missing {
 public:
  void take(RecordLayout::Bytes item) {
    if (item.size() != sizeof(std::uint64_t)) return;
    const std::uint64_t frames = load(item, 0);
    counted_ += frames;
    unknown_ = unknown_ || frames == 0;
  }
  std::uint64_t before(std::uint64_t frame) {
    const std::uint64_t skipped = unknown_ && last_ && frame > *last_ ? frame - *last_ - 1 : 0;
    last_ = frame;
    unknown_ = false;
    return std::max(std::exchange(counted_, 0), skipped);
  }
  std::uint64_t behind() const { return counted_; }  // the last one
  bool unknown() const { return unknown_; }

 private:
  std::uint64_t counted_ = 0;
  bool unknown_ = false;
  std::optional<std::uint64_t> last_;
};

std::string schema_of(const std::string& path, const nlohmann::ordered_json& header) {
  const auto schema = header.find("schema");
  if (schema != header.end() && schema->is_string()) return schema->get<std::string>();
  throw Failure(ExitCode::failed, path + " does not say what its records are made of",
                "was it made by lssd?");
}

std::int64_t whole(const nlohmann::ordered_json& header, const char* key) {
  const auto found = header.find(key);
  return found != header.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

}  // namespace

FrameRange parse_frames(std::string_view text) {
  FrameRange range;
  const auto number = [&](std::string_view part, std::uint64_t& to) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), to);
    if (error == std::errc{} && end == part.data() + part.size()) return;
    throw Failure(ExitCode::usage, fmt::format("--frame: '{}' is no number of a frame", text),
                  "as 154, 100..200, 100.. or ..200");
  };
  const std::size_t dots = text.find("..");
  if (dots == std::string_view::npos) {
    number(text, range.first);
    range.last = range.first;
    return range;
  }
  const std::string_view first = text.substr(0, dots), last = text.substr(dots + 2);
  if (!first.empty() || last.empty()) number(first, range.first);
  if (!last.empty()) number(last, range.last);
  if (range.first > range.last) {
    throw Failure(ExitCode::usage, fmt::format("--frame: {} begins after its end", text),
                  "the smaller number first");
  }
  return range;
}

bool is_flight(const std::string& path) {
  return begins_with(path, std::as_bytes(std::span(lss::record::kRecordingMagic)));
}

void refuse_recording(const std::string& out) {
  if (!is_flight(out) && !is_recording(out)) return;
  throw Failure(ExitCode::usage, out + " is a recording, which is not overwritten",
                "name another file by --out");
}

RecordingReader Flight::open(const std::string& path) {
  auto reader = RecordingReader::open(path);
  if (reader) return std::move(*reader);
  const std::string& what = reader.error();
  const bool damaged = what.find("damaged") != std::string::npos;
  if (damaged) throw Failure(ExitCode::failed, what, "take another copy of the file");
  throw Failure(ExitCode::usage, what, "list what there is with: lss-cli log list FOLDER");
}

Flight::Flight(const std::string& path) : Flight(path, open(path)) {}

Flight::Flight(const std::string& path, RecordingReader reader)
    : path_(path), header_(reader.header()), layout_(schema_of(path, header_)) {
  const auto frame = layout_.place("in.frame"), time = layout_.place("in.time_ns");
  if (!frame || !time) {
    throw Failure(ExitCode::failed, path + ": its records have no in.frame and in.time_ns",
                  "was it made by lssd?");
  }
  frame_at_ = *frame;
  time_at_ = *time;
  period_ns_ = whole(header_, "period_ns");
  utc_from_time_ns_ = whole(header_, "utc_ns") - whole(header_, "time_ns");
  bytes_ = reader.size();
  read_all(reader);
}

void Flight::read_all(RecordingReader& reader) {
  Item kind;
  RecordLayout::Bytes bytes;
  Missing missing;
  bool sound = true;
  while (reader.next(kind, bytes)) {
    if (kind == Item::lost) missing.take(bytes);
    sound = sound && !missing.unknown();
    if (kind != Item::frame) continue;
    last_ = frame(bytes);
    last_.record = {};
    if (sound) sound_ = last_;
    lost_ += missing.before(last_.number);
    if (frames_++ == 0) first_ = last_;
  }
  last_.t_s = static_cast<double>(last_.time_ns - first_.time_ns) / 1e9;
  first_.t_s = 0;
  if (sound_) sound_->t_s = static_cast<double>(sound_->time_ns - first_.time_ns) / 1e9;
  lost_ += missing.behind();
  end_ = reader.end();
  trouble_ = reader.trouble();
  // Before the first frame and behind the last one no number shows what damage took.
  lss::record::RecordingEnd all;
  const bool ended = reader.last_words(all);
  const std::uint64_t written = all.frames + all.lost;
  if (ended && end_ == End::damaged && written > frames_ + lost_) lost_ = written - frames_;
  lost_known_ = ended || (end_ != End::damaged && end_ != End::torn);
}

Flight::Frame Flight::frame(RecordLayout::Bytes record) const {
  Frame frame{.number = load(record, frame_at_),
              .time_ns = static_cast<std::int64_t>(load(record, time_at_))};
  if (!lss::record::most::is_time(frame.time_ns)) {
    throw Failure(ExitCode::failed, fmt::format("a record in it has the time {} ns", frame.time_ns),
                  "was the file made by lssd? Take another copy of it");
  }
  frame.utc_ns = frame.time_ns + utc_from_time_ns_;
  frame.t_s = static_cast<double>(frame.time_ns - first_.time_ns) / 1e9;
  frame.record = record;
  return frame;
}

std::string Flight::text(const char* key) const {
  const auto found = header_.find(key);
  return found != header_.end() && found->is_string() ? found->get<std::string>() : "?";
}

double Flight::duration_s() const {
  return frames_ == 0 ? 0 : last_.t_s + static_cast<double>(period_ns_) * 1e-9;
}

const char* Flight::end_name() const {
  static constexpr const char* kNames[] = {"open", "ended", "open", "torn", "damaged"};
  return kNames[static_cast<unsigned>(end_)];
}

std::string Flight::complaint() const {
  switch (end_) {
    case End::whole: return "";
    case End::torn: return "torn: " + trouble_ + "; what is whole is read";
    case End::damaged: return trouble_ + "; what is whole is read";
    default:
      return "not ended: the daemon runs still, was killed, or lost its power; what is whole is "
             "read";
  }
}

bool Flight::in(const Part& part, const Frame& frame) const {
  return part.frames.holds(frame.number) && frame.t_s >= part.from_s && frame.t_s <= part.until_s;
}

void Flight::refuse_damage(const Part& part) const {
  if (end_ != End::damaged || (part.damaged && frames_ > 0)) return;
  if (sound_ && (part.until_s <= sound_->t_s || part.frames.last <= sound_->number)) return;
  const std::string what = fmt::format("{} is {}", path_, trouble_);
  if (!sound_) throw Failure(ExitCode::failed, what, "take another copy of the file");
  throw Failure(ExitCode::failed, what,
                fmt::format("take another copy of the file, or what is before it by: --frame ..{}",
                            sound_->number));
}

void Flight::refuse_emptiness(const Part& part) const {
  if (frames_ == 0) {
    throw Failure(ExitCode::usage, "no frame is in " + path_,
                  "was the daemon stopped at once? See: lss-cli log list " + path_);
  }
  if (end_ == End::damaged) {
    throw Failure(ExitCode::failed, fmt::format("{} is {}", path_, trouble_),
                  "take another copy of the file: no frame of this range is in what is whole");
  }
  const std::string there = fmt::format("it has frames {} to {}, from 0 to {:.3f} s", first_.number,
                                        last_.number, last_.t_s);
  if (part.frames.one())
    throw Failure(ExitCode::unknown_name,
                  fmt::format("there is no frame {} in it", part.frames.first), there);
  throw Failure(ExitCode::usage, "there is no frame in this range", there);
}

void Flight::each(const Part& part, const std::function<void(const Frame&)>& take) const {
  if (part.from_s > part.until_s) {
    throw Failure(ExitCode::usage,
                  fmt::format("--from {} s is after --to {} s", part.from_s, part.until_s),
                  "the smaller one is --from");
  }
  refuse_damage(part);
  RecordingReader reader = open(path_);
  Item kind;
  RecordLayout::Bytes bytes;
  Missing missing;
  std::uint64_t taken = 0;
  for (std::uint64_t seen = 0; seen < frames_ && reader.next(kind, bytes);) {
    if (kind == Item::lost) missing.take(bytes);
    if (kind != Item::frame) continue;
    ++seen;
    Frame now = frame(bytes);
    now.lost = missing.before(now.number);
    if (!in(part, now)) continue;
    ++taken;
    take(now);
  }
  if (taken == 0) refuse_emptiness(part);
}

}  // namespace lss::cli::recording
