#include "daemon/config/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/config/document.h"
#include "daemon/config/syntax.h"

namespace lss::config {
namespace {

constexpr int kFramePriority = 70;
constexpr int kBusPriority = 80;
constexpr int kActuatePriority = 85;
constexpr std::int64_t kMaxDomain = 230;  // Cyclone's, by its port numbers
constexpr std::int64_t kMaxSpinUs = 500;
constexpr std::int64_t kMaxLeaseMs = 3'600'000;

TimeNs ns_from(double value, TimeNs unit) {
  return std::llround(value * static_cast<double>(unit));
}

void read_identity(Section& root, const std::vector<std::string>& vehicles, Config& config) {
  config.vehicle = root.required_text("vehicle");
  const bool known = std::ranges::find(vehicles, config.vehicle) != vehicles.end();
  if (!known && !config.vehicle.empty()) {
    root.error("vehicle", fmt::format("\"{}\" is not built into this daemon; it has: {}",
                                      config.vehicle, join(vehicles)));
  }
  config.vehicle_id = root.text("vehicle_id", config.vehicle + "-1");
  if (known && !is_name(config.vehicle_id, 15, "_-")) {
    root.error("vehicle_id",
               fmt::format("\"{}\" must be 1 to 15 letters, digits, - or _", config.vehicle_id));
  }
}

void read_frame(Section frame, Config& config) {
  const double period_ms = frame.number("period_ms", 20, 1, 1000);
  const double offset_ms = frame.number("offset_ms", 5, 0.1, 1000);
  if (offset_ms >= period_ms) {
    frame.error("offset_ms", fmt::format("{} must be shorter than the period of {} ms: a command "
                                         "is released within its frame",
                                         offset_ms, period_ms));
  }
  config.period_ns = ns_from(period_ms, kMillisecond);
  config.offset_ns = ns_from(offset_ms, kMillisecond);
  config.max_consecutive_overruns =
      static_cast<int>(frame.integer("max_consecutive_overruns", 5, 1, 1000));
}

void check_port(Section& section, const Port& port, const std::vector<Port>& others) {
  constexpr std::size_t kLongest = 11;  // "bus/" + 11: the kernel's thread names
  if (!port.name.empty() && !is_name(port.name, kLongest, "_-")) {
    section.error("name", fmt::format("\"{}\" must be 1 to 11 letters, digits, - or _", port.name));
  }
  if (const auto fault = path_fault(port.path); fault && !port.path.empty()) {
    section.error("path", fmt::format("\"{}\" {}", port.path, *fault));
  }
  for (const Port& other : others) {
    if (!port.name.empty() && other.name == port.name) {
      section.error("name", fmt::format("\"{}\" names a port already", port.name));
    }
    if (!port.path.empty() && other.path == port.path) {
      section.error(
          "path", fmt::format("\"{}\" is the path of port \"{}\" already", port.path, other.name));
    }
  }
}

void read_ports(Section& root, Config& config) {
  std::vector<Section> sections = root.sections("port");
  if (sections.empty()) root.error("port", "is missing; name at least one [[port]]");
  for (Section& section : sections) {
    Port port;
    port.name = section.required_text("name");
    port.path = section.required_text("path");
    port.baud = section.integer("baud", 115'200, 1200, 4'000'000);
    port.half_duplex = section.choice("duplex", 0, {"full", "half"}) == 1;
    check_port(section, port, config.ports);
    config.ports.push_back(std::move(port));
  }
}

// After the ports: each has a thread.
void read_realtime(Section realtime, Config& config) {
  config.realtime_enforce = realtime.choice("policy", 0, {"degrade", "enforce"}) == 1;
  config.threads = {{"frame", kFramePriority}, {"actuate", kActuatePriority}};
  for (const Port& port : config.ports) {
    config.threads.push_back({"bus/" + port.name, kBusPriority});
  }
  std::vector<std::string> names;
  for (const Thread& thread : config.threads) names.push_back(thread.name);

  std::vector<std::string> seen;
  for (Section& section : realtime.sections("thread")) {
    const std::string name = section.required_text("name");
    Thread unknown;
    const auto found = std::ranges::find(config.threads, name, &Thread::name);
    Thread& thread = found == config.threads.end() ? unknown : *found;
    thread.priority = static_cast<int>(section.integer("priority", thread.priority, 0, 99));
    thread.cpu = static_cast<int>(section.integer("cpu", -1, -1, 1023));
    thread.spin_ns = section.integer("spin_us", 0, 0, kMaxSpinUs) * kMicrosecond;
    if (thread.spin_ns != 0 && name.starts_with("bus/")) {
      section.error("spin_us", "is for frame and actuate: a bus thread waits for bytes");
    }
    if (name.empty()) continue;
    if (found == config.threads.end()) {
      section.error("name", fmt::format("\"{}\" is no thread; there are: {}", name, join(names)));
    } else if (std::ranges::find(seen, name) != seen.end()) {
      section.error("name", fmt::format("\"{}\" stands in the table twice", name));
    }
    seen.push_back(name);
  }
}

void read_dds(Section dds, Config& config) {
  config.domain = static_cast<int>(dds.integer("domain", 0, 0, kMaxDomain));
  config.interfaces = dds.texts("interfaces", {"lo"});
  if (config.interfaces.empty()) {
    dds.error("interfaces", "is empty; [\"lo\"] stays on this machine");
  }
  for (const std::string& name : config.interfaces) {
    if (!is_name(name, 45, "._:@-")) {  // goes into an XML attribute
      dds.error("interfaces", fmt::format("\"{}\" is no name of a network interface", name));
    }
  }
  config.shared_memory = dds.flag("shared_memory", true);
  config.restart_for_shared_memory = dds.flag("restart_for_shared_memory", false);
  Section security = dds.section("security");
  config.enclave = security.text("enclave", "");
  constexpr std::int64_t kMaxSlackDays = 36'500;
  config.clock_slack_days =
      static_cast<int>(security.integer("clock_slack_days", 0, 0, kMaxSlackDays));
}

void read_link(Section link, Config& config) {
  config.obc_timeout_ns = ns_from(link.number("obc_timeout_s", 30, 0.1, 86'400), kSecond);
  config.stop_falls = link.choice("stop_in_flight", 0, {"land", "fall"}) == 1;
  config.lease_min_ms = link.integer("lease_min_ms", 200, 10, kMaxLeaseMs);
  config.lease_max_ms = link.integer("lease_max_ms", 60'000, 10, kMaxLeaseMs);
  if (config.lease_min_ms > config.lease_max_ms) {
    link.error("lease_min_ms", fmt::format("{} is longer than lease_max_ms, {}",
                                           config.lease_min_ms, config.lease_max_ms));
  }
}

// A list of parts, or "all".
unsigned read_what(Section& section, unsigned fallback) {
  std::vector<std::string> names(kLogParts.begin(), kLogParts.end());
  std::vector<std::string> fallback_names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if ((fallback >> i & 1u) != 0) fallback_names.push_back(names[i]);
  }
  unsigned what = 0;
  const std::vector<std::string> chosen = section.texts("what", fallback_names);
  if (chosen.empty()) section.error("what", "is empty; choose of: " + join(names) + ", all");
  for (const std::string& word : chosen) {
    const auto found = std::ranges::find(names, word);
    if (word == "all") {
      what |= kAllLogParts;
    } else if (found != names.end()) {
      what |= 1u << static_cast<unsigned>(found - names.begin());
    } else {
      const std::string* meant = nearest(word, names);
      section.error(
          "what",
          meant != nullptr
              ? fmt::format("\"{}\" is no part of a frame; did you mean \"{}\"?", word, *meant)
              : fmt::format("\"{}\" is no part of a frame; choose of: {}, all", word, join(names)));
    }
  }
  return what;
}

void check_address(Section& section, const std::string& address) {
  constexpr std::size_t kLongest = 107;  // size of a UNIX address
  const auto udp = udp_address(address);
  const auto fault = path_fault(address);
  if (udp && udp->host.starts_with("127.") && udp->rest.empty() &&
      (!fault || !fault->starts_with("is no port"))) {
    if (fault) section.error("address", fmt::format("\"{}\" {}", address, *fault));
  } else if (!is_path(address, kLongest)) {
    section.error("address", fmt::format("\"{}\" is no socket; write /run/lss/NAME, at most 107 "
                                         "characters, or udp://127.0.0.1:PORT",
                                         address));
  }
}

void read_sizes(Section& section, std::uint64_t& file_bytes, std::uint64_t& total_bytes) {
  constexpr std::int64_t kMega = 1'000'000;
  const auto size = [&](const char* key, std::uint64_t& bytes, std::int64_t max) {
    bytes = static_cast<std::uint64_t>(
        section.integer(key, static_cast<std::int64_t>(bytes) / kMega, 1, max) * kMega);
  };
  size("file_mb", file_bytes, 1000);
  size("total_mb", total_bytes, 1'000'000);
  if (total_bytes < 2 * file_bytes) {
    section.error("total_mb", fmt::format("{} must be at least twice file_mb, {}: the oldest file "
                                          "goes before the next one begins",
                                          total_bytes / kMega, file_bytes / kMega));
  }
}

LogPreset read_preset(Section& section, LogPreset preset) {
  preset.what = read_what(section, preset.what);
  preset.every_ns =
      section.integer("every_ms", preset.every_ns / kMillisecond, 0, 3'600'000) * kMillisecond;
  const bool socket = section.choice("to", preset.address.empty() ? 0 : 1, {"file", "socket"}) == 1;
  preset.address = section.text("address", socket ? preset.address : "");
  if (socket) {
    check_address(section, preset.address);
  } else if (!preset.address.empty()) {
    section.error("address", "is for to = \"socket\"; files are in log.folder");
    preset.address.clear();
  }
  read_sizes(section, preset.file_bytes, preset.total_bytes);
  return preset;
}

// The presets without a configuration; config/NAME.toml shows them.
std::vector<LogPreset> shipped_presets() {
  const unsigned events = bit(LogPart::events);
  return {{.name = "quiet", .what = events},
          {.name = "standard", .what = events | bit(LogPart::state) | bit(LogPart::telemetry)},
          {.name = "timing",
           .what = events | bit(LogPart::timing),
           .every_ns = 0,
           .file_bytes = 50'000'000,
           .total_bytes = 500'000'000},
          {.name = "everything",
           .what = kAllLogParts,
           .every_ns = 0,
           .file_bytes = 50'000'000,
           .total_bytes = 1'000'000'000},
          {.name = "stream",
           .what = events | bit(LogPart::telemetry),
           .every_ns = 100 * kMillisecond,
           .address = "/run/lss/log"}};
}

auto find_preset(auto& presets, const std::string& name) {
  return std::ranges::find(presets, name, &LogPreset::name);
}

void read_presets(Section& log, Config& config) {
  config.log_presets = shipped_presets();
  std::vector<std::string> seen;
  for (Section& section : log.sections("preset")) {
    const std::string name = section.required_text("name");
    const auto found = find_preset(config.log_presets, name);
    const bool known = found != config.log_presets.end();
    LogPreset preset = read_preset(section, known ? *found : LogPreset{.name = name});
    if (name.empty()) continue;
    if (!is_name(name, 24, "_-")) {  // goes into the names of files
      section.error("name", fmt::format("\"{}\" must be 1 to 24 letters, digits, - or _", name));
    } else if (std::ranges::find(seen, name) != seen.end()) {
      section.error("name", fmt::format("\"{}\" stands in the list twice", name));
    }
    seen.push_back(name);
    if (known) {
      *found = std::move(preset);
    } else {
      config.log_presets.push_back(std::move(preset));
    }
  }
  config.log_use = log.text("use", "standard");
  config.log_also = log.texts("also", {});
  std::vector<std::string> names;
  for (const LogPreset& preset : config.log_presets) names.push_back(preset.name);
  const auto is_preset = [&](const std::string& name) {
    return std::ranges::count(names, name) > 0;
  };
  if (!config.log_use.empty() && !is_preset(config.log_use))
    log.error("use", fmt::format("\"{}\" is no preset; there are: {}; \"\" logs nothing",
                                 config.log_use, join(names)));
  for (const std::string& name : config.log_also) {
    if (!is_preset(name)) {
      log.error("also", fmt::format("\"{}\" is no preset; there are: {}", name, join(names)));
    } else if (find_preset(config.log_presets, name)->address.empty()) {
      log.error("also",
                fmt::format("\"{}\" logs to files, as only `use` may: give it a socket", name));
    }
  }
}

void read_log(Section log, Config& config) {
  const std::vector<std::string> levels = {"trace", "debug", "info", "warning", "error"};
  config.log_level = static_cast<std::int64_t>(log.choice("level", 2, levels));
  config.log_folder = log.text("folder", "");
  config.log_files = static_cast<std::size_t>(log.integer("files", 32, 1, 10'000));
  read_presets(log, config);
}

void read_recorder(Section section, Recorder& recorder) {
  recorder.record = section.flag("record", true);
  recorder.sync = section.flag("sync", true);
  read_sizes(section, recorder.file_bytes, recorder.total_bytes);
}

void read_all(Section root, const std::vector<std::string>& vehicles,
              const VehicleReader& read_vehicle, Config& config) {
  read_identity(root, vehicles, config);
  read_frame(root.section("frame"), config);
  read_ports(root, config);
  read_realtime(root.section("realtime"), config);
  read_dds(root.section("dds"), config);
  {
    Section telemetry = root.section("telemetry");
    config.telemetry_periodic = telemetry.choice("mode", 0, {"periodic", "on_request"}) == 0;
  }
  read_log(root.section("log"), config);
  read_recorder(root.section("recorder"), config.recorder);
  config.certificate = root.section("timing").text("certificate", "");
  config.parameters_folder = root.section("parameters").text("folder", "");
  read_link(root.section("link"), config);
  if (std::ranges::find(vehicles, config.vehicle) != vehicles.end()) {
    Section own = root.section(config.vehicle);
    read_vehicle(config.vehicle, own);
  } else {
    for (const std::string& name : vehicles) root.skip(name);  // one error is enough
  }
}

}  // namespace

std::vector<LogPreset> Config::running_log_presets() const {
  std::vector<LogPreset> running;
  if (!log_use.empty()) running.push_back(*find_preset(log_presets, log_use));
  for (const std::string& name : log_also) running.push_back(*find_preset(log_presets, name));
  return running;
}

tl::expected<Config, std::string> load(const std::filesystem::path& file,
                                       const std::vector<std::string>& vehicles,
                                       const VehicleReader& read_vehicle) {
  auto text = read_document(file);
  if (!text) {
    return tl::unexpected(fmt::format("{}: {}; name the configuration with --config FILE\n",
                                      file.string(), text.error()));
  }
  return parse(*std::move(text), file.string(), vehicles, read_vehicle);
}

tl::expected<Config, std::string> parse(std::string text, const std::string& name,
                                        const std::vector<std::string>& vehicles,
                                        const VehicleReader& read_vehicle) {
  if (const auto why = too_much(text)) return tl::unexpected(fmt::format("{}: {}\n", name, *why));
  Config config;
  config.file = name;
  config.text = std::move(text);
  Errors errors;
  try {
    const toml::table root = toml::parse(config.text, config.file);
    read_all(Section(&root, "", config.file, errors), vehicles, read_vehicle, config);
  } catch (const toml::parse_error& fault) {
    errors.add(config.file, fault.source(), fmt::format("not TOML: {}", fault.description()));
  }
  if (!errors.empty()) return tl::unexpected(errors.text());
  return config;
}

}  // namespace lss::config
