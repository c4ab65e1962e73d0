// record: DDS topics into an MCAP file.

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <csignal>
#include <ctime>

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/recorder.h"
#include "tools/lss-cli/verbs/recording_verbs.h"

namespace lss::cli {
namespace {

using recording::McapWriter;

constexpr double kProgress_s = 0.2;
constexpr double kMega = 1e6;

const std::vector<std::string> kTopics = {"status",     "event",     "command", "command_ack",
                                          "parameters", "heartbeat", "timing",  "timing_statistics",
                                          "telemetry"};

struct RecordWanted {
  std::string out;
  std::vector<std::string> topics;
  std::optional<double> for_s;
  double max_MB = 1000;
  bool append = false, ros2 = false;
};

enum class End { time, size, interrupted };
constexpr const char* kEnds[] = {"time", "size", "interrupted"};

std::string now_text(const char* format) {
  return fmt::format(fmt::runtime(format), fmt::gmtime(std::time(nullptr)));
}

McapWriter open(const RecordWanted& wanted, const std::string& path) {
  const std::string library = std::string(recording::kLibrary) + " " + LSS_VERSION;
  const char* profile = wanted.ros2 ? "ros2" : "";
  return wanted.append ? McapWriter::append(path, library, profile)
                       : McapWriter::create(path, library, profile);
}

void check_topics(const RecordWanted& wanted) {
  for (const std::string& name : wanted.topics) {
    const auto known = [&](const std::string& topic) {
      return recording::names(name, "lss/" + topic) || name.starts_with("lss/" + topic + "/");
    };
    if (std::ranges::any_of(kTopics, known)) continue;
    throw Failure(ExitCode::unknown_name, fmt::format("there is no topic '{}'", name),
                  fmt::format("there are: {}", fmt::join(kTopics, ", ")));
  }
}

// The channels of a file are of one vehicle.
void check_vehicle(const McapWriter& writer, const std::string& path, const std::string& id) {
  for (const recording::MetadataAt& metadata : writer.all_metadata()) {
    const auto known = metadata.values.find("vehicle_id");
    if (known == metadata.values.end() || known->second == id) continue;
    throw Failure(ExitCode::usage, fmt::format("{} is of {}, not of {}", path, known->second, id),
                  "name another file: --out FILE");
  }
}

End loop(Context& context, Recorder& recorder, const McapWriter& writer,
         const RecordWanted& wanted) {
  Link& link = context.session().link();
  const Clock::time_point begin = Clock::now();
  const Clock::time_point end =
      wanted.for_s ? begin + seconds(*wanted.for_s) : Clock::time_point::max();
  Clock::time_point progress = begin;
  bool away = false;
  while (true) {
    if (recorder.wait(end)) return End::interrupted;
    const Clock::time_point now = Clock::now();
    if (now >= end) return End::time;
    if (static_cast<double>(writer.size()) >= wanted.max_MB * kMega) return End::size;
    link.status();
    if (link.daemon_left() != away) {
      away = !away;
      context.output.note(away ? "the daemon went away: waiting for it" : "the daemon is back");
    }
    if (now >= progress) {
      const double taken_s = std::chrono::duration<double>(now - begin).count();
      context.output.progress(
          fmt::format("recording: {}, {:.1f} MB, {} messages, {} missing (Ctrl-C ends it)",
                      format_duration(taken_s), static_cast<double>(writer.size()) / kMega,
                      recorder.messages(), recorder.lost()));
      progress = now + seconds(kProgress_s);
    }
  }
}

// Writes the end of this run into the file.
void finish(McapWriter& writer, const Recorder& recorder, End end) {
  recording::Texts values = {{"ended", kEnds[static_cast<int>(end)]},
                             {"ended_utc", now_text("{:%FT%TZ}")}};
  for (const Recorder::Source& source : recorder.sources()) {
    values["messages " + source.topic] = std::to_string(source.messages);
    values["missing " + source.topic] = std::to_string(source.gaps);
    values["lost_by_dds " + source.topic] = std::to_string(source.lost);
  }
  writer.metadata(std::string(recording::kEndMetadata), values);
  writer.close();
}

// On a full disk the file keeps its data, and is complete if there is room for the summary.
void rescue(McapWriter& writer) {
  try {
    writer.close();
  } catch (const Failure&) {
  }
}

void tell(Context& context, const Recorder& recorder, const std::string& path, End end,
          std::uint64_t bytes, double taken_s) {
  Output& output = context.output;
  output.end_progress();
  output.print(fmt::format("{}: {}, {:.1f} MB{}\n", path, format_duration(taken_s),
                           static_cast<double>(bytes) / kMega,
                           end == End::size ? ", ended by --max-size" : ""));
  output.print(
      output.style().dim(fmt::format("{:<28} {:>9} {:>8}", "topic", "messages", "missing")) + "\n");
  nlohmann::json topics = nlohmann::json::array();
  for (const Recorder::Source& source : recorder.sources()) {
    const std::string line =
        fmt::format("{:<28} {:>9} {:>8}", source.topic, source.messages, source.gaps);
    output.print((source.gaps > 0 ? output.style().warning(line) : line) + "\n");
    topics.push_back({{"topic", source.topic},
                      {"messages", source.messages},
                      {"missing", source.gaps},
                      {"lost_by_dds", source.lost}});
  }
  output.document({{"path", path},
                   {"ended", kEnds[static_cast<int>(end)]},
                   {"bytes", bytes},
                   {"duration_s", taken_s},
                   {"messages", recorder.messages()},
                   {"missing", recorder.lost()},
                   {"topics", std::move(topics)}});
}

ExitCode record(Context& context, const RecordWanted& wanted) {
  check_topics(wanted);
  if (context.options.shared_memory) {
    throw Failure(ExitCode::usage, "record receives the bytes of the network, which --shm bypasses",
                  "omit --shm: record also receives from a daemon with shared memory");
  }
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is reported like a full disk
  Session& session = context.session();
  Link& link = session.link();
  const std::string id(text(link.status().vehicle_id));
  const std::string path = wanted.out.empty()
                               ? fmt::format("{}-{}.mcap", id, now_text("{:%Y%m%dT%H%M%SZ}"))
                               : wanted.out;
  McapWriter writer = open(wanted, path);
  if (writer.cut() > 0) {
    context.output.note(
        fmt::format("{} was torn: {} bytes at its end are cut off, {} messages kept", path,
                    writer.cut(), writer.all().messages));
  }
  const Clock::time_point begin = Clock::now();
  End end = End::time;
  std::optional<Recorder> recorder;
  try {
    check_vehicle(writer, path, id);
    writer.metadata(std::string(recording::kMetadata),
                    {{"vehicle", std::string(link.vehicle().name)},
                     {"vehicle_id", id},
                     {"version", std::string(text(link.status().version))},
                     {"recorder", LSS_VERSION},
                     {"begun_utc", now_text("{:%FT%TZ}")},
                     {"dictionary", link.dictionary()}});
    recorder.emplace(context.options, link.vehicle(), id, writer, wanted.topics, wanted.ros2);
    end = loop(context, *recorder, writer, wanted);
    finish(writer, *recorder, end);
  } catch (const Failure&) {
    rescue(writer);
    throw;
  }
  const double taken_s = std::chrono::duration<double>(Clock::now() - begin).count();
  tell(context, *recorder, path, end, writer.size(), taken_s);
  if (end == End::interrupted && wanted.for_s) {
    throw Failure(ExitCode::failed, "interrupted before the time of --for was over",
                  "the file is whole; go on with: lss-cli record --append --out " + path);
  }
  return ExitCode::completed;
}

}  // namespace

void add_record_verb(Grammar& grammar) {
  // In a sequence it would delay the heartbeat.
  if (grammar.scope() != Grammar::Scope::program) return;
  CLI::App& sub = grammar.verb("record", "DDS topics into an MCAP file, until Ctrl-C", R"(
  lss-cli record --for 60s --out run.mcap
  lss-cli record --topics telemetry,event
  lss-cli record --append --out run.mcap
  lss-cli record --ros2 --for 60s
  lss-cli log list run.mcap
)");
  auto wanted = std::make_shared<RecordWanted>();
  sub.add_option("-o,--out", wanted->out, "file; without it VEHICLE_ID-TIME.mcap, here");
  add_list(sub, "--topics", wanted->topics, "only these, divided by commas: telemetry,event,...");
  sub.add_option("--max-size", wanted->max_MB, "end at so many MB")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
  sub.add_flag("--append", wanted->append, "continue the file; a torn file is repaired first");
  sub.add_flag("--ros2", wanted->ros2,
               "also as messages of ROS 2, for ros2 bag, PlotJuggler and Foxglove");
  const auto for_s = add_duration(sub, "--for", "end after so long");
  grammar.values(sub, "--topics", kTopics);
  grammar.on(sub, [wanted, for_s](Context& context) {
    wanted->for_s = *for_s;
    return record(context, *wanted);
  });
}

}  // namespace lss::cli
