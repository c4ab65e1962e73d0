// log: recorded files, and folders of them. The types: daemon_log.cpp, flight_log.cpp and
// recording_log.cpp.

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "tools/lss-cli/verbs/log_files.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

namespace fs = std::filesystem;

const LogKind* const kKinds[] = {&kDaemonLog, &kFlightLog, &kRecordingLog};

// nullptr: a file with an unknown name counts as a file of the daemon.
const LogKind* kind_of(const std::string& path) {
  for (const LogKind* kind : kKinds) {
    if (kind->knows(path)) return kind;
  }
  return nullptr;
}

std::string list_line(const nlohmann::json& file) {
  const auto time = [&](const char* key) {
    return file[key].is_number_integer() ? utc_text(file[key], "{:%F %T}") : std::string("?");
  };
  return fmt::format("{:<19}  {:<19}  {:>10}  {:<6}  {:<16}  {}\n", time("begun_utc_ns"),
                     time("written_utc_ns"), file["bytes"].get<std::uint64_t>(),
                     file["kind"].get<std::string>(),
                     file["what"].is_string() ? file["what"].get<std::string>() : "?",
                     file["path"].get<std::string>());
}

ExitCode list_folder(Context& context, const LogWanted& wanted) {
  const fs::path folder = wanted.path.empty() ? "/var/lib/lss" : wanted.path;
  std::error_code error;
  std::vector<std::string> paths;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->is_regular_file() && kind_of(at->path().string()) != nullptr)
      paths.push_back(at->path().string());
  }
  if (error) {
    throw Failure(ExitCode::usage, fmt::format("{}: {}", folder.string(), error.message()),
                  "name the folder: log.folder of the configuration, else --run-dir of lssd");
  }
  std::ranges::sort(paths);
  nlohmann::json files = nlohmann::json::array();
  for (const std::string& path : paths) files.push_back(kind_of(path)->describe(path));
  if (files.empty()) {
    context.output.note("there is no log in " + folder.string());
  } else {
    context.output.print(context.output.style().dim(
                             fmt::format("{:<19}  {:<19}  {:>10}  {:<6}  {:<16}  {}", "begun (UTC)",
                                         "written (UTC)", "bytes", "kind", "what", "file")) +
                         "\n");
  }
  for (const nlohmann::json& file : files) context.output.print(list_line(file));
  context.output.document({{"folder", folder.string()}, {"files", std::move(files)}});
  return ExitCode::completed;
}

}  // namespace

nlohmann::json describe_file(const std::string& path, const char* kind) {
  struct stat info {};
  ::stat(path.c_str(), &info);
  return {{"path", path},
          {"kind", kind},
          {"vehicle_id", nullptr},
          {"what", nullptr},
          {"bytes", info.st_size},
          {"begun_utc_ns", nullptr},
          {"written_utc_ns", info.st_mtim.tv_sec * 1'000'000'000 + info.st_mtim.tv_nsec}};
}

namespace {

ExitCode run_log(Context& context, const LogWanted& wanted) {
  const bool named = !wanted.path.empty();
  const LogKind* known = named ? kind_of(wanted.path) : nullptr;
  const LogKind& kind = known == nullptr ? kDaemonLog : *known;
  if (wanted.what == "list")
    return fs::is_regular_file(wanted.path) ? kind.list(context, wanted)
                                            : list_folder(context, wanted);
  if (wanted.what == "show" && named) return kind.show(context, wanted);
  if (wanted.what == "export" && named) return kind.exports(context, wanted);
  throw no_form(fmt::format("log {} {}", wanted.what, wanted.path),
                "log list [FOLDER|FILE], log show FILE, or log export FILE");
}

}  // namespace

void add_log_verbs(Grammar& grammar) {
  CLI::App& sub =
      grammar.verb("log", "files of what happened: list [FOLDER|FILE], show FILE, export FILE", R"(
  lss-cli log list /run/lss
  lss-cli log show FILE
  lss-cli log show FILE --frame 154
  lss-cli --jsonl log show FILE | jq '.telemetry.distance_m'
flight recordings:
  lss-cli log list run.lssrec --columns 'telemetry.*'
  lss-cli log show run.lssrec --columns 'modules[*].current_A,timing' --from 5s --to 6s
  lss-cli log export run.lssrec --columns distance_m,timing.margin_ns --out run.csv
recordings of topics:
  lss-cli log list run.mcap
  lss-cli log show run.mcap --topic event --from 5s
  lss-cli log export run.mcap --topic telemetry --columns 'modules[*].current_A' --out run.csv
  lss-cli log export run.mcap --from 10s --to 20s --out part.mcap
)");
  auto wanted = std::make_shared<LogWanted>();
  sub.add_option("what", wanted->what, "list, show or export")->required();
  sub.add_option("path", wanted->path,
                 "folder (default /var/lib/lss), or a file: of the log that runs, of the frames "
                 "before a fault, or a recording");
  sub.add_option_function<std::string>(
      "--frame",
      [wanted](const std::string& text) { wanted->frames = recording::parse_frames(text); },
      "only this one, with everything in it; or as 100..200");
  add_list(sub, "--topic", wanted->filter.topics,
           "recordings of topics: only these, divided by commas");
  add_span(sub, wanted->filter, "recordings: since the first frame or message");
  add_list(sub, "--columns", wanted->columns,
           "flight recordings, CSV: only these, divided by commas; * is anything");
  sub.add_option("-o,--out", wanted->out,
                 "export: FILE.csv, of topics also FILE.mcap; without it CSV to stdout");
  grammar.values(sub, "", {"list", "show", "export"});
  grammar.on(sub, [wanted](Context& context) { return run_log(context, *wanted); });
}

}  // namespace lss::cli
