// log show for files that the daemon writes as lines of JSON: the continuous log, and the frames
// before a fault. Also the wording that lines of other file types share.

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "daemon/record/files.h"
#include "daemon/record/json.h"
#include "daemon/record/limits.h"
#include "idl/codes.h"
#include "tools/lss-cli/verbs/log_files.h"

namespace lss::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCrash = ".crash.jsonl";  // complete, or absent
constexpr std::string_view kLog = ".log.jsonl";      // may end in the middle of a line
using Json = nlohmann::ordered_json;

// Reads at most the limit and one byte of a line. False: there is no line.
bool get_line(std::istream& file, std::string& line) {
  line.clear();
  for (int c = file.get(); c != std::istream::traits_type::eof(); c = file.get()) {
    if (c == '\n') return true;
    line.push_back(static_cast<char>(c));
    if (line.size() > record::most::kLineBytes) return true;
  }
  return !line.empty();
}

// Line by line: the header first.
class LogFile {
 public:
  explicit LogFile(const std::string& path) : path_(path) {
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) file_.open(path);  // a pipe might never deliver a line
    if (!file_.is_open()) {
      throw Failure(ExitCode::usage, fmt::format("{} cannot be read", path),
                    "list what there is with: lss-cli log list FOLDER");
    }
    auto first = next();
    if (!first) throw Failure(ExitCode::usage, path + " is empty", "");
    header_ = std::move(*first);
    const Json kind = header_.is_object() ? header_["lss"] : Json();
    crash_ = kind == "crash";
    if (!crash_ && kind != "log") refuse();
  }

  const Json& header() const { return header_; }
  // Of its vehicle itself.
  OwnCodes codes() const { return codes_of(header_.value("vehicle", "")); }
  bool crash() const { return crash_; }
  bool cut() const { return cut_; }  // the last line was torn, and is left out

  std::optional<Json> frame() {
    std::optional<Json> line = next();
    const char* number = crash() ? "timing" : "frame";
    if (line && !(line->is_object() && line->contains(number))) {
      // The daemon was killed, or is writing now.
      if (crash() || !file_.eof() || !line->is_discarded()) refuse();
      cut_ = true;
      line.reset();
    }
    return line;
  }

 private:
  std::optional<Json> next() {
    std::string line;
    if (!get_line(file_, line)) return std::nullopt;
    ++line_;
    if (line.size() > record::most::kLineBytes) {
      throw Failure(ExitCode::usage,
                    fmt::format("{}:{}: a line is longer than {} bytes", path_, line_,
                                record::most::kLineBytes),
                    "was it written by lssd?");
    }
    return record::parse_json(line);
  }
  [[noreturn]] void refuse() const {
    throw Failure(ExitCode::usage,
                  fmt::format("{}:{}: no log of lssd, or a damaged one", path_, line_),
                  fmt::format("name a file that ends in {}, {}, .lssrec or .mcap", kLog, kCrash));
  }

  std::string path_;
  std::ifstream file_;
  std::size_t line_ = 0;
  Json header_;
  bool crash_ = false, cut_ = false;
};

std::string crash_line(const Json& frame, std::int64_t last_ns, const OwnCodes& own,
                       const Style& style) {
  const FrameTimes t(frame.at("timing"));
  std::string line =
      fmt::format("{:>8} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>8}  {:<11}",
                  frame.at("timing").at("frame").get<std::uint64_t>(),
                  recording::ns_between(last_ns, t.boundary_ns) * 1e-6, t.woken_us, t.ready_us,
                  t.margin_us, frame.at("timing").at("samples").get<int>(), state_name(frame));
  const bool fault = tell_happened(frame, line, own);
  return (fault ? style.bad(line) : t.margin_us < 0 ? style.warning(line) : line) + "\n";
}

std::string log_line(const Json& frame, const OwnCodes& own, const Style& style) {
  const std::int64_t utc_ns = frame.at("utc_ns");
  std::string line =
      fmt::format("{:>8} {}.{:03}  {:<11}", frame.at("frame").get<std::uint64_t>(),
                  utc_text(utc_ns, "{:%F %T}"), utc_ns / 1'000'000 % 1000, state_name(frame));
  const bool fault = tell_happened(frame, line, own);
  std::string lost;
  for (const char* what : {"lost_frames", "lost_lines"}) {
    if (const auto count = frame.find(what); count != frame.end())
      lost += fmt::format(" {} {}", what, count->get<std::uint64_t>());
  }
  return (fault ? style.bad(line) : line) + style.warning(lost) + "\n";
}

std::uint64_t number_of(const Json& frame, const LogFile& file) {
  return (file.crash() ? frame.at("timing") : frame).at("frame").get<std::uint64_t>();
}

void print_header(Context& context, const LogFile& file, const std::string& columns) {
  const Json& first = file.header();
  context.output.print(fmt::format(
      "{} ({}), lssd {}: {}\n", first.value("vehicle_id", "?"), first.value("vehicle", "?"),
      first.value("version", "?"),
      file.crash() ? "the frames before a fault" : "log \"" + first.value("preset", "?") + "\""));
  context.output.print(context.output.style().dim(columns) + "\n");
}

// A few frames, timed by the last.
void show_crash(Context& context, LogFile& file, const LogWanted& wanted) {
  print_header(context, file,
               fmt::format("{:>8} {:>9} {:>9} {:>9} {:>9} {:>8}  {}", "frame", "ms", "woken us",
                           "ready us", "margin us", "samples", "state"));
  Json frames = Json::array();
  while (auto frame = file.frame()) {
    if (wanted.frames.holds(number_of(*frame, file))) frames.push_back(std::move(*frame));
  }
  const std::int64_t last_ns =
      frames.empty() ? 0 : frames.back().at("timing").at("boundary_ns").get<std::int64_t>();
  for (const Json& frame : frames)
    context.output.print(crash_line(frame, last_ns, file.codes(), context.output.style()));
  context.output.document({{"header", file.header()}, {"frames", frames}});
}

// Long files: output goes line by line where possible.
void show_log(Context& context, LogFile& file, const LogWanted& wanted) {
  print_header(context, file, fmt::format("{:>8} {:<23}  {}", "frame", "UTC", "state"));
  context.output.record({{"header", file.header()}});
  nlohmann::json frames = nlohmann::json::array();
  while (auto frame = file.frame()) {
    if (!wanted.frames.holds(number_of(*frame, file))) continue;
    context.output.print(log_line(*frame, file.codes(), context.output.style()));
    if (context.output.stream()) {
      context.output.record(*frame);
    } else if (context.output.machine()) {
      frames.emplace_back(*frame);
    }
  }
  if (!context.output.stream())
    context.output.document({{"header", file.header()}, {"frames", std::move(frames)}});
}

void show_frame(Context& context, LogFile& file, const LogWanted& wanted) {
  while (const auto frame = file.frame()) {
    if (number_of(*frame, file) != wanted.frames.first) continue;
    context.output.document(*frame);
    context.output.print(frame->dump(2) + "\n");
    return;
  }
  throw Failure(ExitCode::unknown_name,
                fmt::format("there is no frame {} in it", wanted.frames.first),
                "see them all with: lss-cli log show " + wanted.path);
}

ExitCode show(Context& context, const LogWanted& wanted) {
  LogFile file(wanted.path);
  try {
    if (wanted.frames.one()) {
      show_frame(context, file, wanted);
    } else if (file.crash()) {
      show_crash(context, file, wanted);
    } else {
      show_log(context, file, wanted);
    }
  } catch (const Json::exception& e) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} lacks what a frame has: {}", wanted.path, e.what()),
                  "was it written by another version of lssd?");
  }
  if (file.cut()) context.output.note("its last line is cut off");
  return ExitCode::completed;
}

// From its name, its first line and the file system.
nlohmann::json describe(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  const bool crash = name.ends_with(kCrash);
  std::string line;
  std::ifstream file(path);
  get_line(file, line);
  const Json first = record::parse_json(line);
  const auto field = [&](const char* key) -> nlohmann::json {
    return first.is_object() && first.contains(key) ? nlohmann::json(first.at(key)) : nullptr;
  };
  const std::string fault = name.substr(name.rfind('-') + 1);
  nlohmann::json result = describe_file(path, crash ? "crash" : "log");
  result["vehicle_id"] = field("vehicle_id");
  result["what"] = crash ? nlohmann::json(fault.substr(0, fault.find('.'))) : field("preset");
  result["begun_utc_ns"] = field("utc_ns");
  return result;
}

bool knows(const std::string& path) { return path.ends_with(kCrash) || path.ends_with(kLog); }

[[noreturn]] void cannot(const char* what) {
  throw Failure(ExitCode::usage,
                fmt::format("log {} is for recordings, files in .lssrec and .mcap", what),
                "see a log of the daemon with: lss-cli log show FILE");
}

ExitCode list_one(Context&, const LogWanted&) { cannot("list FILE"); }
ExitCode export_one(Context&, const LogWanted&) { cannot("export"); }

}  // namespace

const LogKind kDaemonLog{knows, describe, list_one, show, export_one};

// ---- wording of lines of all types of files

std::string utc_text(std::int64_t utc_ns, const char* format) {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  return fmt::format(fmt::runtime(format), fmt::gmtime(static_cast<std::time_t>(utc_ns / kNsPerS)));
}

namespace {

std::string event_name(const Json& event, const OwnCodes& own) {
  const auto id = event.at("id").get<std::uint16_t>();
  const Json named = event.contains("name") ? event.at("name") : record::event_name(id, own);
  std::string name = named.is_string() ? named.get<std::string>() : named.dump();
  if (id >= kFaultEventBase) name = "FAULT " + name;
  if (const int subject = event.at("subject"); subject != 0) name += fmt::format(" {}", subject);
  return name;
}

}  // namespace

FrameTimes::FrameTimes(const Json& timing)
    : boundary_ns(timing.at("boundary_ns").get<std::int64_t>()),
      margin_us(static_cast<double>(timing.at("margin_ns").get<std::int64_t>()) * 1e-3) {
  const auto us = [&](const char* point) {
    return recording::ns_between(boundary_ns, timing.at(point).get<std::int64_t>()) * 1e-3;
  };
  woken_us = us("woken_ns");
  ready_us = us("ready_ns");
}

bool tell_happened(const Json& frame, std::string& text, const OwnCodes& own) {
  if (const auto in = frame.find("in"); in != frame.end()) {
    for (const Json& request : in->at("requests"))
      text += fmt::format(" <{} {}>", request.at("source").get<std::string>(),
                          request.at("kind").get<int>() == 0
                              ? "heartbeat"
                              : fmt::format("command {}", request.at("kind").get<int>()));
  }
  bool fault = false;
  if (const auto outbox = frame.find("outbox"); outbox != frame.end()) {
    for (const Json& event : outbox->at("events")) {
      text += " " + event_name(event, own);
      fault |= event.at("id").get<int>() >= kFaultEventBase;
    }
  }
  return fault;
}

std::string state_name(const Json& frame) {
  const auto state = frame.find("state");
  return state == frame.end() ? "" : state->at("controller").at("state").get<std::string>();
}

}  // namespace lss::cli
