#pragma once

// Types of files that `log` lists, shows and exports, each behind the same few functions: lines of
// JSON that the daemon writes, its flight recordings, and recordings of messages. A new type is a
// new LogKind in the table of log_verbs.cpp. Main thread.

#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/lss-cli/recording/flight.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/session/context.h"
#include "tools/lss-cli/session/described_vehicle.h"

namespace lss::cli {

// The request.
struct LogWanted {
  std::string what, path;
  recording::FrameRange frames;  // of the daemon's own files
  recording::Filter filter;
  std::vector<std::string> columns;  // with `*`; empty: the default of the file type
  std::string out;
};

struct LogKind {
  bool (*knows)(const std::string& path);  // by its name, or by its first bytes
  // For the list of a folder: path, kind, vehicle_id, what, bytes, begun_utc_ns, written_utc_ns.
  nlohmann::json (*describe)(const std::string& path);
  ExitCode (*list)(Context& context, const LogWanted& wanted);
  ExitCode (*show)(Context& context, const LogWanted& wanted);
  ExitCode (*exports)(Context& context, const LogWanted& wanted);
};

// A flight recording with the names of its vehicle's codes.
struct OpenedFlight {
  explicit OpenedFlight(const std::string& path);
  recording::Flight flight;
  RecordedVehicle vehicle;
};

extern const LogKind kDaemonLog, kFlightLog, kRecordingLog;

// The facts from the file system: path, kind, bytes, written_utc_ns; all others null.
nlohmann::json describe_file(const std::string& path, const char* kind);
// Quotes a text for CSV where needed.
std::string csv_text(const std::string& text);
// A value of a row: a NaN is empty, booleans are 0 and 1.
std::string csv_value(const nlohmann::ordered_json& value);
// write(file) writes rows to --out or stdout, and returns their number. A write error or an
// exception leaves the file of before, or none. Reports the number and `of_what`.
ExitCode export_rows(Context& context, const LogWanted& wanted, const char* of_what,
                     const std::function<std::uint64_t(std::FILE*)>& write);

std::string utc_text(std::int64_t utc_ns, const char* format);  // "{:%F %T}"
// The times of a frame, in us: two after its boundary, and the margin at its end.
struct FrameTimes {
  explicit FrameTimes(const nlohmann::ordered_json& timing);
  std::int64_t boundary_ns;
  double woken_us, ready_us, margin_us;
};
// The inputs and events of a frame, from its recorded parts; true when there was a fault.
bool tell_happened(const nlohmann::ordered_json& frame, std::string& text,
                   const OwnCodes& own = {});
std::string state_name(const nlohmann::ordered_json& frame);

}  // namespace lss::cli
