// log list, show and export for recordings of lss-cli record.

#include <fmt/format.h>

#include "tools/lss-cli/recording/mcap_scan.h"
#include "tools/lss-cli/show/names.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/log_files.h"

namespace lss::cli {
namespace {

using recording::Column;
using recording::Message;
using recording::Recording;
using recording::Topic;
using Json = nlohmann::ordered_json;

double duration_s(const recording::Span& span) {
  return recording::ns_between(span.first_ns, span.last_ns) * 1e-9;
}

double rate_Hz(const recording::Span& span) {
  const double long_s = duration_s(span);
  return long_s > 0 ? static_cast<double>(span.messages - 1) / long_s : 0;
}

nlohmann::json topic_json(const Topic& topic) {
  return {{"topic", topic.name},           {"type", topic.type_name},
          {"encoding", topic.encoding},    {"messages", topic.span.messages},
          {"missing", topic.gaps},         {"first_ns", topic.span.first_ns},
          {"last_ns", topic.span.last_ns}, {"rate_Hz", rate_Hz(topic.span)}};
}

nlohmann::json about(const Recording& recording) {
  nlohmann::json texts = recording.about();
  texts.erase("dictionary");  // long
  return texts;
}

ExitCode list(Context& context, const LogWanted& wanted) {
  const auto recording = recording::open(wanted.path);
  Output& output = context.output;
  const recording::Span& span = recording->span();
  output.print(fmt::format(
      "{} ({}), lssd {}: {} to {} UTC, {}, {} messages\n", recording->about("vehicle_id"),
      recording->about("vehicle"), recording->about("version"), utc_text(span.first_ns, "{:%F %T}"),
      utc_text(span.last_ns, "{:%F %T}"), format_duration(duration_s(span)), span.messages));
  output.print(output.style().dim(fmt::format("{:<28} {:<24} {:>9} {:>8} {:>9}", "topic", "type",
                                              "messages", "missing", "per s")) +
               "\n");
  nlohmann::json topics = nlohmann::json::array();
  for (const Topic& topic : recording->topics()) {
    const std::string line =
        fmt::format("{:<28} {:<24} {:>9} {:>8} {:>9.2f}", topic.name, topic.type_name,
                    topic.span.messages, topic.gaps, rate_Hz(topic.span));
    output.print((topic.gaps > 0 ? output.style().warning(line) : line) + "\n");
    topics.push_back(topic_json(topic));
  }
  if (!recording->complaint().empty()) output.note(recording->complaint());
  output.document({{"path", wanted.path},
                   {"kind", recording->kind()},
                   {"about", about(*recording)},
                   {"whole", recording->complaint().empty()},
                   {"complaint", recording->complaint()},
                   {"messages", span.messages},
                   {"first_ns", span.first_ns},
                   {"last_ns", span.last_ns},
                   {"duration_s", duration_s(span)},
                   {"topics", std::move(topics)}});
  return ExitCode::completed;
}

Json message_json(const Recording& recording, const Message& message) {
  Json json = {{"topic", message.topic.name},
               {"sequence", message.sequence},
               {"t_s", recording.seconds(message.log_ns)},
               {"log_ns", message.log_ns},
               {"publish_ns", message.publish_ns},
               {"data", nullptr}};
  if (message.topic.layout != nullptr) json["data"] = message.topic.layout->json(message.data);
  return json;
}

// A JSON line for each message, also for people: the content differs from topic to topic.
ExitCode show(Context& context, const LogWanted& wanted) {
  const auto recording = recording::open(wanted.path);
  Output& output = context.output;
  Json messages = Json::array();
  recording->each(wanted.filter, [&](const Message& message) {
    Json json = message_json(*recording, message);
    if (output.stream()) {
      output.record(nlohmann::json(json));
    } else if (output.machine()) {
      messages.push_back(std::move(json));
    } else {
      output.print(json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    }
  });
  if (!output.stream())
    output.document({{"about", about(*recording)}, {"messages", std::move(messages)}});
  if (!recording->complaint().empty()) output.note(recording->complaint());
  return ExitCode::completed;
}

std::vector<const Column*> columns_of(const Topic& topic, const LogWanted& wanted) {
  if (topic.layout == nullptr) {
    throw Failure(
        ExitCode::usage,
        fmt::format("{} is encoded as {}, which cannot be read here", topic.name, topic.encoding),
        "export it as .mcap");
  }
  std::vector<std::string> names;
  std::vector<const Column*> columns;
  for (const Column& column : topic.layout->columns()) {
    names.push_back(column.name);
    const auto meant = [&](const std::string& pattern) {
      return recording::matches(pattern, column.name);
    };
    if (wanted.columns.empty() || std::ranges::any_of(wanted.columns, meant))
      columns.push_back(&column);
  }
  for (const std::string& pattern : wanted.columns) {
    const auto known = [&](const std::string& name) { return recording::matches(pattern, name); };
    if (std::ranges::any_of(names, known)) continue;
    throw Failure(ExitCode::unknown_name, fmt::format("{} has no column '{}'", topic.name, pattern),
                  did_you_mean(pattern, names));
  }
  return columns;
}

std::uint64_t write_csv(const Recording& recording, const LogWanted& wanted, std::FILE* file) {
  const std::vector<const Topic*> topics = recording::select(recording, wanted.filter);
  if (topics.size() != 1) {
    std::vector<std::string> names;
    for (const Topic* topic : topics) names.push_back(topic->name);
    throw Failure(ExitCode::usage, "a CSV file has the columns of one topic",
                  fmt::format("name one by --topic: {}", fmt::join(names, ", ")));
  }
  const std::vector<const Column*> columns = columns_of(*topics.front(), wanted);
  std::string line = "t_s,log_ns,publish_ns,sequence";
  for (const Column* column : columns) line += "," + csv_text(column->name);
  fmt::print(file, "{}\n", line);
  std::uint64_t rows = 0;
  recording.each(wanted.filter, [&](const Message& message) {
    line = fmt::format("{:.6f},{},{},{}", recording.seconds(message.log_ns), message.log_ns,
                       message.publish_ns, message.sequence);
    for (const Column* column : columns)
      line += "," + csv_value(message.topic.layout->json(*column, message.data));
    fmt::print(file, "{}\n", line);
    ++rows;
  });
  return rows;
}

ExitCode exports(Context& context, const LogWanted& wanted) {
  const auto recording = recording::open(wanted.path);
  const bool mcap = wanted.out.ends_with(".mcap");
  if (!mcap && !wanted.out.empty() && !wanted.out.ends_with(".csv")) {
    throw Failure(ExitCode::usage, fmt::format("do not know how to write {}", wanted.out),
                  "end its name in .csv or .mcap");
  }
  if (mcap && !wanted.columns.empty())
    throw Failure(ExitCode::usage, "--columns are of CSV: messages of MCAP stay whole");
  if (mcap) {
    const std::uint64_t messages = recording->copy(wanted.filter, wanted.out);
    context.output.print(fmt::format("{}: {} messages\n", wanted.out, messages));
    context.output.document({{"path", wanted.path}, {"out", wanted.out}, {"messages", messages}});
  } else {
    export_rows(context, wanted, "messages",
                [&](std::FILE* file) { return write_csv(*recording, wanted, file); });
  }
  if (!recording->complaint().empty()) context.output.note(recording->complaint());
  return ExitCode::completed;
}

bool knows(const std::string& path) {
  return path.ends_with(".mcap") || recording::is_recording(path);
}

// For a folder with many long files: only their headers are read.
nlohmann::json describe(const std::string& path) {
  nlohmann::json file = describe_file(path, "mcap");
  constexpr std::size_t kBegin = 64 * 1024;
  try {
    const recording::MappedFile mapped(path);
    const auto begin = mapped.data().first(std::min(kBegin, mapped.data().size()));
    const recording::Scan scan = recording::scan(path, begin);
    if (scan.all.messages > 0) file["begun_utc_ns"] = scan.all.first_ns;
    for (const auto& metadata : scan.metadata) {
      const auto id = metadata.values.find("vehicle_id");
      if (id != metadata.values.end()) file["vehicle_id"] = id->second;
    }
    file["what"] = scan.library;
  } catch (const Failure&) {  // listed here; the error appears when it is shown
  }
  return file;
}

}  // namespace

const LogKind kRecordingLog{knows, describe, list, show, exports};

}  // namespace lss::cli
