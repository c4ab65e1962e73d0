// timing trace: the frames of a flight recording, on the tracks of their threads.

#include <fmt/format.h>

#include <algorithm>

#include "idl/timing_statistics.h"
#include "tools/lss-cli/show/timing.h"
#include "tools/lss-cli/verbs/timing_files.h"

namespace lss::cli {
namespace {

using recording::Flight;
using Json = nlohmann::ordered_json;

// In the order of their priorities.
enum Track : int { actuate = 1, bus, frame, listener };
constexpr const char* kTracks[] = {"", "actuate", "bus", "frame", "DDS listener"};

// The points of TimingPoints that a trace shows.
struct Points {
  explicit Points(const Json& t)
      : boundary_ns(t.at("boundary_ns")),
        woken_ns(t.at("woken_ns")),
        read_ns(t.at("read_ns")),
        navigated_ns(t.at("navigated_ns")),
        ready_ns(t.at("ready_ns")),
        released_ns(t.at("released_ns")),
        margin_ns(t.at("margin_ns")),
        offset_ns(t.at("offset_ns")),
        overruns(t.at("overruns")),
        skipped(t.at("frames_skipped")),
        held(t.at("frames_held")) {}

  std::int64_t boundary_ns, woken_ns, read_ns, navigated_ns, ready_ns, released_ns, margin_ns,
      offset_ns;
  std::uint64_t overruns, skipped, held;
};

class Trace {
 public:
  Trace(std::FILE* file, const Flight& flight) : file_(file) {
    fmt::print(file_, "{{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n");
    const std::string process =
        fmt::format("{}, lssd {}", flight.text("vehicle_id"), flight.text("version"));
    write({{"ph", "M"}, {"pid", 1}, {"name", "process_name"}, {"args", {{"name", process}}}});
    for (int track = actuate; track <= listener; ++track) {
      const auto about = [&](const char* what, Json args) {
        write({{"ph", "M"}, {"pid", 1}, {"tid", track}, {"name", what}, {"args", std::move(args)}});
      };
      about("thread_name", {{"name", kTracks[track]}});
      about("thread_sort_index", {{"sort_index", track}});
    }
  }
  void end() { fmt::print(file_, "\n]}}\n"); }

  void slice(Track track, const char* name, std::int64_t from_ns, std::int64_t to_ns,
             Json args = Json::object()) {
    const double dur_us = us(static_cast<double>(std::max(to_ns, from_ns) - from_ns));
    event({{"ph", "X"},
           {"pid", 1},
           {"tid", track},
           {"name", name},
           {"dur", dur_us},
           {"args", std::move(args)}},
          from_ns);
  }
  void instant(Track track, const std::string& name, std::int64_t at_ns,
               Json args = Json::object()) {
    event({{"ph", "i"},
           {"s", "t"},
           {"pid", 1},
           {"tid", track},
           {"name", name},
           {"args", std::move(args)}},
          at_ns);
  }
  void counter(const char* name, std::int64_t at_ns, double value) {
    event({{"ph", "C"}, {"pid", 1}, {"name", name}, {"args", {{"us", value}}}}, at_ns);
  }

 private:
  void event(Json event, std::int64_t at_ns) {
    event["ts"] = us(static_cast<double>(at_ns));
    write(event);
  }
  void write(const Json& event) {
    fmt::print(file_, "{}{}", std::exchange(first_, false) ? "" : ",\n",
               event.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  std::FILE* file_;
  bool first_ = true;
};

// The threads' work in one frame. `before`: the frame before it, when that was recorded.
void show_threads(Trace& trace, std::uint64_t number, const Points& t,
                  const std::optional<Points>& before) {
  // A packet that makes a frame may arrive while the frame before is still computed.
  const std::int64_t from_ns = before ? std::max(t.boundary_ns, before->ready_ns) : t.boundary_ns;
  trace.slice(frame, "frame", from_ns, t.ready_ns,
              {{"frame", number}, {"margin_us", us(static_cast<double>(t.margin_ns))}});
  const std::int64_t ends[] = {t.woken_ns, t.read_ns, t.navigated_ns, t.ready_ns};
  std::int64_t begin_ns = from_ns;
  for (std::size_t i = 0; i < std::size(ends); ++i) {
    trace.slice(frame, kTimingSteps[i].name, begin_ns, ends[i]);
    begin_ns = std::max(begin_ns, ends[i]);
  }
  trace.counter("margin", t.ready_ns, us(static_cast<double>(t.margin_ns)));
  if (!before) return;
  const std::int64_t due_ns = before->boundary_ns + before->offset_ns;
  if (t.released_ns >= due_ns) {
    trace.slice(actuate, kTimingSteps[5].name, due_ns, t.released_ns, {{"frame", number - 1}});
  }
  const auto missed = [&](Track track, const char* what, std::uint64_t now, std::uint64_t then) {
    if (now > then) trace.instant(track, what, t.boundary_ns, {{"count", now - then}});
  };
  missed(actuate, "command late", t.overruns, before->overruns);
  missed(frame, "frames skipped", t.skipped, before->skipped);
  missed(frame, "begun by the clock", t.held, before->held);
}

void show_inputs_and_events(Trace& trace, const Json& record) {
  for (const Json& sample : record.at("in").at("samples"))
    trace.instant(bus, "sample", sample.at("time_ns"));
  for (const Json& request : record.at("in").at("requests")) {
    const int kind = request.at("kind");
    trace.instant(listener, kind == 0 ? "heartbeat" : fmt::format("command {}", kind),
                  request.at("arrival_ns"), {{"source", request.at("source")}});
  }
  for (const Json& event : record.at("outbox").at("events")) {
    const Json& id = event.at("id");
    const Json& name = event.at("name");
    trace.instant(frame, name.is_string() ? name.get<std::string>() : "event " + id.dump(),
                  event.at("time_ns"), {{"subject", event.at("subject")}});
  }
}

std::uint64_t write_trace(Flight& flight, const recording::Part& part, std::FILE* file) {
  Trace trace(file, flight);
  std::uint64_t frames = 0, last = 0;
  std::optional<Points> before;
  flight.each(part, [&](const Flight::Frame& frame) {
    const Json record = flight.layout().json(frame.record);
    const Points points(record.at("timing"));
    if (frame.lost != 0 || frame.number != last + 1) before.reset();
    if (frame.lost != 0)
      trace.instant(Track::frame, "not recorded", points.boundary_ns, {{"frames", frame.lost}});
    show_threads(trace, frame.number, points, before);
    show_inputs_and_events(trace, record);
    before = points;
    last = frame.number;
    ++frames;
  });
  trace.end();
  return frames;
}

}  // namespace

ExitCode timing_trace(Context& context, const LogWanted& wanted) {
  if (!recording::is_flight(wanted.path)) {
    throw Failure(ExitCode::usage, wanted.path + " is no flight recording",
                  "name a file of the flight recorder, *.lssrec; find them with: lss-cli log list");
  }
  OpenedFlight opened(wanted.path);
  Flight& flight = opened.flight;
  const char* const kAdvice =
      "was it made by lssd? See its fields with: lss-cli log list FILE --columns '*'";
  try {
    flight.layout().choose({"in.samples[*].time_ns", "in.requests", "outbox.events", "timing"});
    return export_rows(context, wanted, "frames", [&](std::FILE* file) {
      return write_trace(flight,
                         {.frames = wanted.frames,
                          .from_s = wanted.filter.from_s,
                          .until_s = wanted.filter.until_s},
                         file);
    });
  } catch (const Json::exception& e) {
    throw Failure(ExitCode::failed,
                  fmt::format("its records lack what a trace shows: {}", e.what()), kAdvice);
  }
}

}  // namespace lss::cli
