#pragma once

// Kinds of files that `log` lists, shows and exports, each behind the same few functions: lines of
// JSON that the daemon writes, and recordings of messages. Another kind is another LogKind in
// log_verbs.cpp. Main thread.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/lss-cli/context.h"
#include "tools/lss-cli/recording/recording.h"

namespace lss::cli {

// What was asked for.
struct LogWanted {
  std::string what, path;
  std::int64_t frame = -1;  // of the daemon's own files
  recording::Filter filter;
  std::vector<std::string> columns;  // with `*`; empty: all
  std::string out;
};

struct LogKind {
  bool (*knows)(const std::string& path);  // by its name
  // For the list of a folder: path, kind, vehicle_id, what, bytes, begun_utc_ns, written_utc_ns.
  nlohmann::json (*describe)(const std::string& path);
  ExitCode (*list)(Context& context, const LogWanted& wanted);
  ExitCode (*show)(Context& context, const LogWanted& wanted);
  ExitCode (*exports)(Context& context, const LogWanted& wanted);
};

extern const LogKind kRecordingLog;

// What the file system says of a file: path, kind, bytes, written_utc_ns; the rest null.
nlohmann::json describe_file(const std::string& path, const char* kind);
// A quotation as CSV wants it, where it must be.
std::string csv_text(const std::string& text);

}  // namespace lss::cli
