#pragma once

// The configuration shared by all vehicles: config/NAME.toml without its [NAME] table, which the
// vehicle reads itself. Start-up only.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/config/section.h"
#include "drivers/time.h"

namespace lss::config {

struct Thread {
  std::string name;    // "frame", "actuate", "bus/legs", ...
  int priority = 0;    // SCHED_FIFO 1..99; 0: SCHED_OTHER
  int cpu = -1;        // -1: any
  TimeNs spin_ns = 0;  // frame and actuate: busy wait before a deadline
};

struct Port {
  std::string name;  // "legs"; the bus thread is "bus/legs"
  std::string path;  // sim:NAME, a device, can0, udp://...
  std::int64_t baud = 115'200;
  bool half_duplex = false;
};

// Parts of a frame's record that a line of the log may have. events: its events and
// acknowledgements, written as soon as there are some; the other parts at the preset's period.
enum class LogPart : std::uint8_t { inputs, command, events, state, telemetry, timing };
inline constexpr std::array kLogParts = {"inputs", "command",   "events",
                                         "state",  "telemetry", "timing"};
constexpr unsigned bit(LogPart part) { return 1u << static_cast<unsigned>(part); }
inline constexpr unsigned kAllLogParts = (1u << kLogParts.size()) - 1;

struct LogPreset {
  std::string name;
  unsigned what = bit(LogPart::events);
  TimeNs every_ns = kSecond;                                         // 0: every frame
  std::string address{};                                             // of a socket; empty: to files
  std::uint64_t file_bytes = 10'000'000, total_bytes = 100'000'000;  // the oldest files go
};

// The flight recorder.
struct Recorder {
  bool record = true;
  std::uint64_t file_bytes = 16'000'000, total_bytes = 512'000'000;  // the oldest files go
  bool sync = true;  // to the disk every 50 ms; else when the kernel decides
};

// A saved parameter: it replaces the value of the file.
struct SavedValue {
  std::string name;  // dotted, in the vehicle's table
  double value = 0;
};

struct Config {
  std::string file;
  std::string text;  // the whole text as read
  std::string vehicle;
  std::string vehicle_id;
  TimeNs period_ns = 0, offset_ns = 0;
  int max_consecutive_overruns = 5;
  bool realtime_enforce = false;
  std::vector<Thread>
      threads;  // frame, actuate, and one bus/PORT for each port; completed with defaults
  std::vector<Port> ports;
  int domain = 0;
  std::vector<std::string> interfaces{"lo"};
  bool shared_memory = true;
  bool telemetry_periodic = true;  // telemetry.mode = "periodic" | "on_request"
  bool restart_for_shared_memory = false;
  TimeNs obc_timeout_ns = 30 * kSecond;
  std::int64_t lease_min_ms = 200, lease_max_ms = 60'000;
  bool stop_falls = false;           // link.stop_in_flight = "land" | "fall"
  std::filesystem::path log_folder;  // empty: $STATE_DIRECTORY, else the run directory
  std::size_t log_files = 32;        // of frames before a fault; the oldest go
  std::int64_t log_level = 2;        // 0 trace, 1 debug, 2 info, 3 warning, 4 error
  std::vector<LogPreset> log_presets;
  std::string log_use;                // one of them; empty: none
  std::vector<std::string> log_also;  // those that run beside it, to sockets
  std::vector<LogPreset> running_log_presets() const;
  Recorder recorder;
  std::filesystem::path certificate;        // of timing; empty: none
  std::filesystem::path parameters_folder;  // of saved parameters; empty: as log_folder
  std::vector<SavedValue> saved;            // not in the file
  std::filesystem::path enclave;            // of DDS Security; empty: none
  int clock_slack_days = 0;                 // of its certificates
};

// Reads the vehicle's own [NAME] table; called with that Section, to record errors there.
using VehicleReader = std::function<void(const std::string& vehicle, Section& section)>;

// Reads and checks the file; `read_vehicle` runs in the same pass, so that all errors are reported
// together. The error text has a line for each error: FILE:LINE:COLUMN: what and what to do.
tl::expected<Config, std::string> load(const std::filesystem::path& file,
                                       const std::vector<std::string>& vehicles,
                                       const VehicleReader& read_vehicle);
// The same for a text; `name` is for the errors.
tl::expected<Config, std::string> parse(std::string text, const std::string& name,
                                        const std::vector<std::string>& vehicles,
                                        const VehicleReader& read_vehicle);

}  // namespace lss::config
