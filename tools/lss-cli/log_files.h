#pragma once

// Kinds of files that `log` lists, shows and exports, each behind the same few functions: lines of
// JSON that the daemon writes, its flight recordings, and recordings of messages. Another kind is
// another LogKind in the table of log_verbs.cpp. Main thread.

#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/lss-cli/context.h"
#include "tools/lss-cli/recording/flight.h"
#include "tools/lss-cli/recording/recording.h"

namespace lss::cli {

// What was asked for.
struct LogWanted {
  std::string what, path;
  recording::FrameRange frames;  // of the daemon's own files
  recording::Filter filter;
  std::vector<std::string> columns;  // with `*`; empty: as the kind of file sees fit
  std::string out;
};

struct LogKind {
  bool (*knows)(const std::string& path);  // by its name, or by what it begins with
  // For the list of a folder: path, kind, vehicle_id, what, bytes, begun_utc_ns, written_utc_ns.
  nlohmann::json (*describe)(const std::string& path);
  ExitCode (*list)(Context& context, const LogWanted& wanted);
  ExitCode (*show)(Context& context, const LogWanted& wanted);
  ExitCode (*exports)(Context& context, const LogWanted& wanted);
};

extern const LogKind kDaemonLog, kFlightLog, kRecordingLog;

// What the file system says of a file: path, kind, bytes, written_utc_ns; the rest null.
nlohmann::json describe_file(const std::string& path, const char* kind);
// A quotation as CSV wants it, where it must be.
std::string csv_text(const std::string& text);
// A value of a row: a NaN is empty, booleans are 0 and 1.
std::string csv_value(const nlohmann::ordered_json& value);
// write(file) puts the rows into --out, or to stdout; what cannot be written, or is thrown, leaves
// no file. Says how many rows and of what.
ExitCode export_csv(Context& context, const LogWanted& wanted, const char* of_what,
                    const std::function<std::uint64_t(std::FILE*)>& write);

std::string utc_text(std::int64_t utc_ns, const char* format);  // "{:%F %T}"
// What came in and what happened, of the parts of a frame that are there; true when there was a
// fault.
bool tell_happened(const nlohmann::ordered_json& frame, std::string& text);
std::string state_name(const nlohmann::ordered_json& frame);

}  // namespace lss::cli
