// log list, show and export for flight recordings (*.lssrec), which lssd writes frame by frame.

#include <fmt/format.h>

#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/log_files.h"

namespace lss::cli {
namespace {

using recording::Flight;
using recording::RecordLayout;
using Json = nlohmann::ordered_json;

// The fields in the line of a frame.
const std::vector<std::string> kOfLine = {"in.requests", "outbox.events", "state.controller.state",
                                          "timing"};

recording::Part part_of(const LogWanted& wanted) {
  return {.frames = wanted.frames,
          .from_s = wanted.filter.from_s,
          .until_s = wanted.filter.until_s,
          .damaged = true};
}

void refuse_topics(const LogWanted& wanted) {
  if (wanted.filter.topics.empty()) return;
  throw Failure(ExitCode::usage, "a flight recording has frames and no topics",
                "name fields by --columns; see them with: lss-cli log list FILE --columns '*'");
}

template <class T>
T header(const Flight& flight, const char* key, T otherwise) {
  const auto found = flight.header().find(key);
  if (found == flight.header().end()) return otherwise;
  if constexpr (std::is_same_v<T, bool>) {
    return found->is_boolean() ? found->template get<bool>() : otherwise;
  } else if constexpr (std::is_same_v<T, std::string>) {
    return found->is_string() ? found->template get<std::string>() : otherwise;
  } else {
    return found->is_number_integer() ? found->template get<T>() : otherwise;
  }
}

std::string build(const Flight& flight) {
  const auto found = flight.header().find("build");
  if (found == flight.header().end() || !found->is_object()) return "?";
  return fmt::format("{} ({})", found->value("id", "?").substr(0, 12), found->value("type", "?"));
}

ExitCode code_of(const Flight& flight) {
  return flight.end() == Flight::End::damaged ? ExitCode::failed : ExitCode::completed;
}

void print_who(Context& context, const Flight& flight) {
  context.output.print(fmt::format("{} ({}), lssd {}, build {}\n", flight.text("vehicle_id"),
                                   flight.text("vehicle"), flight.text("version"), build(flight)));
}

// ---- list

std::string summary(const Flight& flight, const Style& style) {
  const auto begun = header<std::int64_t>(flight, "utc_ns", 0);
  const auto file = header<std::int64_t>(flight, "file", 1);
  std::string text = fmt::format("begun   {} UTC, {}\n", utc_text(begun, "{:%F %T}"),
                                 header(flight, "start", false)
                                     ? "with the start of lssd"
                                     : fmt::format("in the middle of a run: its file {}", file));
  text +=
      fmt::format("data    {} frames in {}, {:.1f} MB", flight.frames(),
                  format_duration(flight.duration_s()), static_cast<double>(flight.bytes()) * 1e-6);
  if (flight.frames() > 0)
    text += fmt::format("; frames {} to {}", flight.first().number, flight.last().number);
  const auto before = header<std::uint64_t>(flight, "lost_before", 0);
  const bool known = flight.lost_known();
  const std::string lost = fmt::format("lost    {}{} frames in it, {} before it",
                                       known ? "" : "at least ", flight.lost(), before);
  text += "\n" + (!known || flight.lost() + before > 0 ? style.warning(lost) : lost) + "\n";
  const std::string complaint = flight.complaint();
  const std::string end = "end     " + (complaint.empty() ? "ended" : complaint);
  const bool bad = flight.end() == Flight::End::damaged;
  return text + (bad ? style.bad(end) : complaint.empty() ? end : style.warning(end)) + "\n";
}

nlohmann::json fields(Context& context, Flight& flight) {
  nlohmann::json list = nlohmann::json::array();
  for (const RecordLayout::Column& column : flight.layout().columns()) {
    context.output.print(fmt::format("{:<4}  {}\n", column.type, column.name));
    list.push_back({{"name", column.name}, {"type", column.type}});
  }
  return list;
}

ExitCode list(Context& context, const LogWanted& wanted) {
  refuse_topics(wanted);
  OpenedFlight opened(wanted.path);
  Flight& flight = opened.flight;
  print_who(context, flight);
  context.output.print(summary(flight, context.output.style()));
  nlohmann::json document = {{"path", wanted.path},
                             {"kind", "lssrec"},
                             {"vehicle", flight.text("vehicle")},
                             {"vehicle_id", flight.text("vehicle_id")},
                             {"version", flight.text("version")},
                             {"build", flight.header().value("build", Json())},
                             {"begun_utc_ns", header<std::int64_t>(flight, "utc_ns", 0)},
                             {"run_utc_ns", header<std::int64_t>(flight, "run_utc_ns", 0)},
                             {"file", header<std::int64_t>(flight, "file", 1)},
                             {"start", header(flight, "start", false)},
                             {"period_ns", header<std::int64_t>(flight, "period_ns", 0)},
                             {"frames", flight.frames()},
                             {"first_frame", flight.first().number},
                             {"last_frame", flight.last().number},
                             {"first_ns", flight.first().time_ns},
                             {"last_ns", flight.last().time_ns},
                             {"duration_s", flight.duration_s()},
                             {"lost", flight.lost()},
                             {"lost_known", flight.lost_known()},
                             {"lost_before", header<std::uint64_t>(flight, "lost_before", 0)},
                             {"bytes", flight.bytes()},
                             {"end", flight.end_name()},
                             {"whole", flight.end() == Flight::End::whole},
                             {"complaint", flight.complaint()}};
  if (!wanted.columns.empty()) {
    flight.layout().choose(wanted.columns);
    document["fields"] = fields(context, flight);
  }
  context.output.document(std::move(document));
  return code_of(flight);
}

// ---- show

Json frame_json(Flight& flight, const Flight::Frame& frame) {
  Json json = {{"frame", frame.number},
               {"t_s", frame.t_s},
               {"time_ns", frame.time_ns},
               {"utc_ns", frame.utc_ns}};
  if (frame.lost > 0) json["lost_frames"] = frame.lost;
  json.update(flight.layout().json(frame.record));
  return json;
}

std::string frame_line(const Json& frame, const Style& style) {
  const FrameTimes t(frame.at("timing"));
  std::string line = fmt::format(
      "{:>8} {:>10.3f} {:>9.1f} {:>9.1f} {:>9.1f}  {:<11}", frame.at("frame").get<std::uint64_t>(),
      frame.at("t_s").get<double>(), t.woken_us, t.ready_us, t.margin_us, state_name(frame));
  const bool fault = tell_happened(frame, line);
  std::string lost;
  if (frame.contains("lost_frames"))
    lost = fmt::format(" lost_frames {}", frame.at("lost_frames").get<std::uint64_t>());
  return (fault             ? style.bad(line)
          : t.margin_us < 0 ? style.warning(line)
                            : line) +
         style.warning(lost) + "\n";
}

std::string line_of(const Json& frame, const Style& style) {
  try {
    return frame_line(frame, style);
  } catch (const Json::exception& e) {
    throw Failure(ExitCode::failed, fmt::format("its records lack what a line shows: {}", e.what()),
                  "name fields by --columns; see them with: lss-cli log list FILE --columns '*'");
  }
}

std::string columns_of_lines() {
  return fmt::format("{:>8} {:>10} {:>9} {:>9} {:>9}  {}", "frame", "s", "woken us", "ready us",
                     "margin us", "state");
}

void choose_line(Flight& flight) {
  try {
    flight.layout().choose(kOfLine);
  } catch (const Failure&) {
    throw Failure(ExitCode::failed, "its records lack what the line of a frame is made of",
                  "name fields by --columns; see them with: lss-cli log list FILE --columns '*'");
  }
}

// A line for each frame. With named fields, or for a single frame, its content as JSON.
ExitCode show(Context& context, const LogWanted& wanted) {
  refuse_topics(wanted);
  OpenedFlight opened(wanted.path);
  Flight& flight = opened.flight;
  Output& output = context.output;
  const bool one = wanted.frames.one() && wanted.columns.empty();
  const bool lines = !output.machine() && wanted.columns.empty() && !one;
  if (lines) {
    choose_line(flight);
    print_who(context, flight);
    output.print(output.style().dim(columns_of_lines()) + "\n");
  } else if (!wanted.columns.empty()) {
    flight.layout().choose(wanted.columns);
  }
  nlohmann::json frames = nlohmann::json::array();
  flight.each(part_of(wanted), [&](const Flight::Frame& frame) {
    const Json json = frame_json(flight, frame);
    if (lines) {
      output.print(line_of(json, output.style()));
    } else if (output.stream()) {
      output.record(json);
    } else if (one) {
      output.print(json.dump(2) + "\n");
      output.document(json);
    } else if (output.machine()) {
      frames.emplace_back(json);
    } else {
      output.print(json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    }
  });
  if (!output.stream() && !one) {
    Json about = flight.header();
    for (const char* long_one : {"config", "dictionary", "schema", "state_layout"})
      about.erase(long_one);
    output.document({{"header", std::move(about)}, {"frames", std::move(frames)}});
  }
  if (!flight.complaint().empty()) output.note(flight.complaint());
  return code_of(flight);
}

// ---- export

std::uint64_t write_csv(Flight& flight, const LogWanted& wanted, std::FILE* file) {
  RecordLayout& layout = flight.layout();
  if (wanted.columns.empty()) {
    layout.choose_what_is_always_there();
  } else {
    layout.choose(wanted.columns);
  }
  flight.each(part_of(wanted), [&](const Flight::Frame& frame) { layout.look(frame.record); });
  std::string line = "t_s,frame,time_ns,utc_ns";
  for (const RecordLayout::Column& column : layout.columns()) line += "," + csv_text(column.name);
  fmt::print(file, "{}\n", line);
  std::uint64_t rows = 0;
  std::vector<Json> values;
  flight.each(part_of(wanted), [&](const Flight::Frame& frame) {
    line = fmt::format("{:.6f},{},{},{}", frame.t_s, frame.number, frame.time_ns, frame.utc_ns);
    layout.values(frame.record, values);
    for (const Json& value : values) line += "," + csv_value(value);
    fmt::print(file, "{}\n", line);
    ++rows;
  });
  return rows;
}

ExitCode exports(Context& context, const LogWanted& wanted) {
  refuse_topics(wanted);
  if (wanted.out.ends_with(".mcap")) {
    throw Failure(ExitCode::usage, "frames are no topics: a flight recording does not become MCAP",
                  "export it as .csv, or record topics with: lss-cli record --out FILE.mcap");
  }
  if (!wanted.out.empty() && !wanted.out.ends_with(".csv")) {
    throw Failure(ExitCode::usage, fmt::format("do not know how to write {}", wanted.out),
                  "end its name in .csv");
  }
  OpenedFlight opened(wanted.path);
  Flight& flight = opened.flight;
  const ExitCode code = export_rows(
      context, wanted, "frames", [&](std::FILE* file) { return write_csv(flight, wanted, file); });
  if (!flight.complaint().empty()) context.output.note(flight.complaint());
  return code == ExitCode::completed ? code_of(flight) : code;
}

// ---- in a folder

bool knows(const std::string& path) {
  return path.ends_with(record::kRecordingSuffix) || recording::is_flight(path);
}

// From its header and its last chunk only.
nlohmann::json describe(const std::string& path) {
  nlohmann::json file = describe_file(path, "lssrec");
  const auto reader = record::RecordingReader::open(path);
  if (!reader) return file;  // listed here; the error appears when it is shown
  const auto& header = reader->header();
  if (header.contains("vehicle_id")) file["vehicle_id"] = header["vehicle_id"];
  if (header.contains("utc_ns")) file["begun_utc_ns"] = header["utc_ns"];
  record::RecordingEnd end;
  file["what"] = reader->last_words(end) ? fmt::format("{} frames", end.frames) : "not ended";
  return file;
}

}  // namespace

OpenedFlight::OpenedFlight(const std::string& path)
    : flight(path), vehicle(header(flight, "dictionary", std::string()), flight.text("vehicle")) {
  flight.layout().name_codes(vehicle.codes());
}

const LogKind kFlightLog{knows, describe, list, show, exports};

}  // namespace lss::cli
