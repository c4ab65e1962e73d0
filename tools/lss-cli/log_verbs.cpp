// log: the frames before a fault, as the daemon kept them.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "idl/codes.h"
#include "tools/lss-cli/verbs.h"

namespace lss::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".crash.jsonl";
using Json = nlohmann::ordered_json;

struct Wanted {
  std::string what, path;
  std::int64_t frame = -1;
};

// The header, then the frames.
std::vector<Json> read_log(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    throw Failure(ExitCode::usage, fmt::format("{} cannot be read", path),
                  "list what there is with: lss-cli log list FOLDER");
  }
  std::vector<Json> lines;
  for (std::string line; std::getline(file, line);) {
    lines.push_back(Json::parse(line, nullptr, false));
    const bool good =
        lines.back().is_object() && (lines.size() == 1 ? lines.back().value("lss", "") == "crash"
                                                       : lines.back().contains("timing"));
    if (!good) {
      throw Failure(ExitCode::usage,
                    fmt::format("{}:{}: no log of lssd, or a damaged one", path, lines.size()),
                    "name a file that ends in " + std::string(kSuffix));
    }
  }
  if (lines.empty()) throw Failure(ExitCode::usage, path + " is empty", "");
  return lines;
}

std::string event_name(const Json& event) {
  const auto id = event.at("id").get<std::uint16_t>();
  const CodeInfo* code = id >= kFaultEventBase ? info(static_cast<FaultId>(id - kFaultEventBase))
                                               : info(static_cast<EventId>(id));
  std::string name = code != nullptr ? code->name : std::to_string(id);
  if (id >= kFaultEventBase) name = "FAULT " + name;
  if (const int subject = event.at("subject"); subject != 0) name += fmt::format(" {}", subject);
  return name;
}

std::string frame_line(const Json& frame, std::int64_t last_ns, const Style& style) {
  const Json& t = frame.at("timing");
  const std::int64_t boundary = t.at("boundary_ns");
  const auto us = [&](const char* point) {
    return static_cast<double>(t.at(point).get<std::int64_t>() - boundary) * 1e-3;
  };
  std::string happened;
  for (const Json& request : frame.at("in").at("requests"))
    happened += fmt::format(" <{} {}>", request.at("source").get<std::string>(),
                            request.at("kind").get<int>() == 0
                                ? "heartbeat"
                                : fmt::format("command {}", request.at("kind").get<int>()));
  bool fault = false;
  for (const Json& event : frame.at("outbox").at("events")) {
    happened += " " + event_name(event);
    fault |= event.at("id").get<int>() >= kFaultEventBase;
  }
  const double margin_us = static_cast<double>(t.at("margin_ns").get<std::int64_t>()) * 1e-3;
  std::string line = fmt::format(
      "{:>8} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>8}  {:<11}{}",
      t.at("frame").get<std::uint64_t>(), static_cast<double>(boundary - last_ns) * 1e-6,
      us("woken_ns"), us("ready_ns"), margin_us, t.at("samples").get<int>(),
      frame.at("state").at("controller").at("state").get<std::string>(), happened);
  return (fault ? style.bad(line) : margin_us < 0 ? style.warning(line) : line) + "\n";
}

ExitCode show(Context& context, const Wanted& wanted, const std::vector<Json>& lines) {
  const Style& style = context.output.style();
  if (wanted.frame >= 0) {
    const auto found = std::find_if(lines.begin() + 1, lines.end(), [&](const Json& frame) {
      return frame.at("timing").at("frame") == wanted.frame;
    });
    if (found == lines.end()) {
      throw Failure(ExitCode::unknown_name, fmt::format("there is no frame {} in it", wanted.frame),
                    "see them all with: lss-cli log show " + wanted.path);
    }
    context.output.document(*found);
    context.output.print(found->dump(2) + "\n");
    return ExitCode::completed;
  }
  const Json& first = lines.front();
  context.output.print(fmt::format("{} ({}), lssd {}: {} frames\n", first.value("vehicle_id", "?"),
                                   first.value("vehicle", "?"), first.value("version", "?"),
                                   lines.size() - 1));
  context.output.print(
      style.dim(fmt::format("{:>8} {:>9} {:>9} {:>9} {:>9} {:>8}  {}", "frame", "ms", "woken us",
                            "ready us", "margin us", "samples", "state")) +
      "\n");
  const std::int64_t last_ns =
      lines.size() > 1 ? lines.back().at("timing").at("boundary_ns").get<std::int64_t>() : 0;
  Json document = {{"header", first}, {"frames", Json::array()}};
  for (std::size_t i = 1; i < lines.size(); ++i) {
    context.output.print(frame_line(lines[i], last_ns, style));
    document["frames"].push_back(lines[i]);
  }
  context.output.document(document);
  return ExitCode::completed;
}

ExitCode list(Context& context, const Wanted& wanted) {
  const fs::path folder = wanted.path.empty() ? "/var/lib/lss" : wanted.path;
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().ends_with(kSuffix)) files.push_back(entry.path());
  }
  if (error) {
    throw Failure(ExitCode::usage, fmt::format("{}: {}", folder.string(), error.message()),
                  "name the folder: log.folder of the configuration, else --run-dir of lssd");
  }
  std::ranges::sort(files);
  nlohmann::json names = nlohmann::json::array();
  for (const fs::path& file : files) {
    names.push_back(file.string());
    context.output.print(file.string() + "\n");
  }
  if (files.empty()) context.output.note("no frames were kept in " + folder.string());
  context.output.document({{"folder", folder.string()}, {"files", names}});
  return ExitCode::completed;
}

}  // namespace

void add_log_verbs(Grammar& grammar) {
  CLI::App& sub = grammar.verb("log", "the last frames before a fault: list [FOLDER], show FILE",
                               "  lss-cli log list /run/lss\n  lss-cli log show FILE\n  lss-cli "
                               "log show FILE --frame 154\n");
  auto wanted = std::make_shared<Wanted>();
  sub.add_option("what", wanted->what, "list or show")->required();
  sub.add_option("path", wanted->path, "folder (default /var/lib/lss) or file");
  sub.add_option("--frame", wanted->frame, "only this one, with everything in it");
  grammar.values(sub, "", {"list", "show"});
  grammar.on(sub, [wanted](Context& context) {
    if (wanted->what == "list") return list(context, *wanted);
    if (wanted->what == "show" && !wanted->path.empty()) {
      const std::vector<Json> lines = read_log(wanted->path);
      try {
        return show(context, *wanted, lines);
      } catch (const Json::exception& e) {
        throw Failure(ExitCode::usage,
                      fmt::format("{} lacks what a frame has: {}", wanted->path, e.what()),
                      "was it written by another version of lssd?");
      }
    }
    throw Failure(ExitCode::usage,
                  fmt::format("log {} {}: what is that?", wanted->what, wanted->path),
                  "log list [FOLDER], or log show FILE");
  });
}

}  // namespace lss::cli
