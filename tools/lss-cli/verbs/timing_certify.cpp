// timing certify: a bound on the lateness of a frame's orders, and the certificate for lssd
// (docs/timing.md).

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "daemon/record/certificate.h"
#include "daemon/replay/records.h"
#include "tools/lss-cli/certify/scheduling.h"
#include "tools/lss-cli/certify/wire.h"
#include "tools/lss-cli/doctor/probes.h"
#include "tools/lss-cli/show/timing.h"
#include "tools/lss-cli/verbs/timing_files.h"

namespace lss::cli {
namespace {

namespace fs = std::filesystem;
using certify::Scheduling;
using certify::Wire;
using Json = nlohmann::ordered_json;
using recording::Flight;

constexpr std::int64_t kCanBit_s = 500'000;  // docs/icd-ardito.md, docs/icd-talaris.md

config::Config read_strictly(const std::string& file) {
  if (file.empty()) {
    throw Failure(ExitCode::usage, "timing certify: for which configuration?",
                  "timing certify --config FILE RECORDING...");
  }
  std::vector<std::string> vehicles;
  for (const Vehicle* vehicle : cli::vehicles()) vehicles.emplace_back(vehicle->name);
  auto config = config::load(file, vehicles, [](const std::string& name, config::Section& own) {
    if (const auto records = vehicle_records(name)) records->replay(own);
  });
  if (!config) throw Failure(ExitCode::usage, config.error(), "lssd would not start with it");
  return *std::move(config);
}

certify::Place place_of(const config::Config& config) {
  certify::Place place{.priority = 99};
  bool anywhere = false;
  for (const config::Thread& thread : config.threads) {
    if (thread.priority == 0) {
      throw Failure(ExitCode::usage,
                    fmt::format("thread {} is no real-time thread: nothing bounds it", thread.name),
                    "give it a priority in [[realtime.thread]]");
    }
    place.priority = std::min(place.priority, thread.priority);
    anywhere |= thread.cpu < 0;
    place.cpus.push_back(thread.cpu);
  }
  std::ranges::sort(place.cpus);
  place.cpus.erase(std::unique(place.cpus.begin(), place.cpus.end()), place.cpus.end());
  if (anywhere) place.cpus.clear();
  return place;
}

std::int64_t can_bit_s(const config::Config& config) {
  for (const config::Port& port : config.ports) {
    const auto link = doctor::ask_can_link(port.path);
    if (link && link->bitrate != 0) return link->bitrate;
  }
  return kCanBit_s;
}

// Nothing: the overlay of the vehicle has no formula.
std::optional<Wire> wire_of(const config::Config& config) {
  const Vehicle* vehicle = find_vehicle(config.vehicle);
  if (vehicle == nullptr || vehicle->overlay == nullptr || vehicle->overlay->wire == nullptr)
    return std::nullopt;
  const toml::table root = toml::parse(config.text);
  config::Errors none;  // it was read before
  config::Section own(root[config.vehicle].as_table(), config.vehicle, config.file, none);
  return vehicle->overlay->wire(config, own, can_bit_s(config));
}

// The largest of the recorded frames.
struct Seen {
  std::uint64_t frames = 0;
  double ready_us = 0, release_us = 0, inputs_us = 0;
  bool simulated_time = true;  // no time passes within a frame
};

void look(const std::string& path, const config::Config& config, Seen& seen) {
  Flight flight(path);
  if (flight.text("vehicle") != config.vehicle) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} is of {}, and the configuration of {}", path,
                              flight.text("vehicle"), config.vehicle),
                  "name recordings of this vehicle");
  }
  flight.layout().choose({"timing"});
  std::int64_t due_ns = 0;
  std::uint64_t last = 0;
  flight.each({}, [&](const Flight::Frame& frame) {
    const Json t = flight.layout().json(frame.record).at("timing");
    const auto ns = [&](const char* name) { return t.at(name).get<std::int64_t>(); };
    const auto most = [](double& to, std::int64_t from_ns) {
      to = std::max(to, us(static_cast<double>(from_ns)));
    };
    ++seen.frames;
    most(seen.ready_us, ns("ready_ns") - ns("boundary_ns"));
    most(seen.inputs_us, ns("read_ns") - ns("woken_ns"));
    if (frame.number == last + 1) most(seen.release_us, ns("released_ns") - due_ns);
    seen.simulated_time &= ns("ready_ns") == ns("woken_ns");
    due_ns = ns("boundary_ns") + ns("offset_ns");
    last = frame.number;
  });
}

// What lssd says of the longest cycle.
struct Cycle {
  double us = 0;
  Json longest;  // the line of lssd
  std::string version;
};

std::string lssd_beside() {
  std::error_code none;
  const fs::path beside = fs::read_symlink("/proc/self/exe", none).parent_path() / "lssd";
  return fs::exists(beside, none) ? beside.string() : "lssd";
}

Cycle count(const CertifyWanted& wanted) {
  std::vector<std::string> words = {wanted.lssd.empty() ? lssd_beside() : wanted.lssd, "--cost",
                                    std::to_string(wanted.frames), "--replay"};
  words.insert(words.end(), wanted.recordings.begin(), wanted.recordings.end());
  const certify::Ran ran = certify::run_program(words);
  if (ran.code != 0) {
    throw Failure(ExitCode::failed,
                  fmt::format("{} cannot count the frames (exit code {}): {}", words.front(),
                              ran.code, ran.output),
                  "name the program that is to be certified by --lssd FILE");
  }
  Cycle cycle;
  double instructions = 0, rate = 0;
  std::istringstream lines(ran.output);
  for (std::string line; std::getline(lines, line);) {
    const Json one = Json::parse(line);
    rate = std::max(rate, one.at("ns_per_instruction").get<double>());
    if (one.at("instructions").get<double>() <= instructions) continue;
    instructions = one.at("instructions");
    cycle.longest = one;
    cycle.version = one.at("version");
  }
  cycle.us = us(instructions * rate);
  cycle.longest["ns_per_instruction"] = rate;
  return cycle;
}

struct Bound {
  Scheduling scheduling;
  Cycle cycle;
  Seen seen;
  std::optional<Wire> wire;
  double ready_us = 0, release_us = 0, orders_us = 0;
};

// The frame thread wakes up by its timer, or the bus thread by the last byte of a packet and then
// the frame thread. The command is computed within the offset. Then the actuate thread wakes up,
// and a bus thread.
Bound bound_of(Scheduling scheduling, Cycle cycle, const Seen& seen, std::optional<Wire> wire) {
  const double packet_us = wire ? wire->packet_us : 0;
  const double wake_ups = packet_us > 0 ? 2 : 1;
  Bound b{.scheduling = std::move(scheduling),
          .cycle = std::move(cycle),
          .seen = seen,
          .wire = std::move(wire)};
  b.ready_us = packet_us + wake_ups * b.scheduling.us + seen.inputs_us + b.cycle.us;
  b.release_us = 2 * b.scheduling.us;
  b.orders_us = b.release_us + (b.wire ? b.wire->orders_us : 0);
  return b;
}

double tenth(double us) { return std::round(us * 10) / 10; }

Json document(const Bound& b, const config::Config& config, int seconds) {
  const auto on = record::certified_here(b.cycle.version, config.text);
  const double offset_us = us(static_cast<double>(config.offset_ns));
  const double period_us = us(static_cast<double>(config.period_ns));
  const certify::Place place = place_of(config);
  Json json = {
      {"lss", "timing certificate"},
      {"vehicle", config.vehicle},
      {"machine", on.machine},
      {"kernel", on.kernel},
      {"version", on.version},
      {"configuration", on.configuration},
      {"period", {{"us", period_us}}},
      {"offset", {{"us", offset_us}}},
      {"scheduling",
       {{"us", tenth(b.scheduling.us)},
        {"tool", b.scheduling.tool},
        {"seconds", seconds},
        {"note", b.scheduling.note},
        {"priority", place.priority},
        {"cpus", place.cpus}}},
      {"inputs",
       {{"us", tenth(b.seen.inputs_us)},
        {"note", b.seen.simulated_time ? "not measured: the recordings are of simulated time"
                                       : "the largest of the recorded frames: a sample"}}},
      {"cycle",
       {{"us", tenth(b.cycle.us)},
        {"instructions", b.cycle.longest.at("instructions")},
        {"ns_per_instruction", b.cycle.longest.at("ns_per_instruction")},
        {"recording", b.cycle.longest.at("file")},
        {"frame", b.cycle.longest.at("frame")},
        {"frames", b.seen.frames},
        {"counted", b.cycle.longest.at("counted")}}}};
  if (b.wire) {
    json["packet"] = {{"us", tenth(b.wire->packet_us)}};
    json["wire"] = {{"us", tenth(b.wire->orders_us)}, {"formula", b.wire->formula}};
  }
  json["ready"] = {{"us", tenth(b.ready_us)},
                   {"slack_us", tenth(offset_us - b.ready_us)},
                   {"seen_us", tenth(b.seen.ready_us)}};
  json["release"] = {{"us", tenth(b.release_us)}, {"seen_us", tenth(b.seen.release_us)}};
  json["orders"] = {{"us", tenth(b.orders_us)},
                    {"slack_us", tenth(period_us - offset_us - b.orders_us)}};
  return json;
}

std::string screen(const Json& json, const Style& style) {
  std::string text;
  const auto row = [&](const char* name, double value_us, const std::string& what) {
    text += fmt::format("{:<12} {:>10.1f} us  {}\n", name, value_us, style.dim(what));
  };
  for (const char* name : {"machine", "kernel", "version", "configuration"})
    text += fmt::format("{:<14} {}\n", name, json.at(name).get<std::string>());
  const auto us_of = [&](const char* name) { return json.at(name).at("us").get<double>(); };
  const auto note = [&](const char* name, const char* key) {
    return json.at(name).at(key).get<std::string>();
  };
  row("scheduling", us_of("scheduling"),
      fmt::format("{}; {}", note("scheduling", "tool"), note("scheduling", "note")));
  if (json.contains("packet") && us_of("packet") > 0)
    row("packet", us_of("packet"), "of the sensor that begins a frame");
  row("inputs", us_of("inputs"), note("inputs", "note"));
  const Json& cycle = json.at("cycle");
  row("cycle", us_of("cycle"),
      fmt::format("{} instructions of {:.3f} ns: frame {} of {}; {} of {} frames counted",
                  cycle.at("instructions").get<std::uint64_t>(),
                  cycle.at("ns_per_instruction").get<double>(),
                  cycle.at("frame").get<std::uint64_t>(), cycle.at("recording").get<std::string>(),
                  cycle.at("counted").get<std::uint64_t>(),
                  cycle.at("frames").get<std::uint64_t>()));
  if (json.contains("wire")) {
    row("wire", us_of("wire"), note("wire", "formula"));
  } else {
    text += "wire          unknown: this program has no formula for the vehicle's bus\n";
  }
  const auto sum = [&](const char* name, const char* what) {
    const Json& bound = json.at(name);
    std::string line = fmt::format("{:<12} {:>10.1f} us  {}", name, us_of(name), what);
    if (bound.contains("seen_us"))
      line += fmt::format("; {:.1f} seen at most", bound.at("seen_us").get<double>());
    if (!bound.contains("slack_us")) {
      text += style.bold(line) + "\n";
      return;
    }
    const auto slack_us = bound.at("slack_us").get<double>();
    line += fmt::format("; slack {:.1f}", slack_us);
    text += (slack_us < 0 ? style.warning(line) : style.bold(line)) + "\n";
  };
  sum("ready", "frame boundary to the command being ready, against the offset");
  sum("release", "lateness of handing it to the bus, after T_k + offset");
  sum("orders", "lateness of the last byte of its orders, against the period");
  return text;
}

void save(const std::string& path, const Json& json) {
  std::ofstream file(path);
  file << json.dump(2) << "\n";
  file.close();
  if (!file) {
    throw Failure(ExitCode::failed, path + " cannot be written",
                  "name a file in a folder that you may write to, by --out");
  }
}

void complain_of_doubts(Context& context, const Bound& b, const config::Config& config) {
  if (b.seen.ready_us > b.ready_us || b.seen.release_us > b.release_us) {
    throw Failure(ExitCode::failed,
                  fmt::format("no certificate: a recorded frame was later ({:.1f} us ready, {:.1f} "
                              "us late) than the bound ({:.1f}, {:.1f})",
                              b.seen.ready_us, b.seen.release_us, b.ready_us, b.release_us),
                  "measure the kernel for longer and under load (--seconds), and see lss-cli "
                  "doctor; recordings of another machine do not count");
  }
  if (b.ready_us > us(static_cast<double>(config.offset_ns)))
    context.output.note("the bound is longer than the offset: a command may be late");
  if (b.orders_us > us(static_cast<double>(config.period_ns - config.offset_ns)))
    context.output.note("the last orders of a frame may be on the wire when the next one begins");
}

}  // namespace

ExitCode timing_certify(Context& context, const CertifyWanted& wanted) {
  recording::refuse_recording(wanted.out);
  const config::Config config = read_strictly(wanted.config);
  if (wanted.recordings.empty()) {
    throw Failure(ExitCode::usage, "timing certify: of which frames is the longest counted?",
                  "name recordings with the modes and faults that may come, *.lssrec");
  }
  const certify::Place place = place_of(config);
  Seen seen;
  Cycle cycle;
  try {
    for (const std::string& path : wanted.recordings) look(path, config, seen);
    cycle = count(wanted);
  } catch (const Json::exception& e) {
    throw Failure(ExitCode::failed,
                  fmt::format("the frames cannot be read or counted as expected: {}", e.what()),
                  "are recordings and lssd of this version? See: lss-cli log list FILE");
  }
  Scheduling scheduling =
      wanted.latency_us
          ? Scheduling{.us = *wanted.latency_us, .tool = "--latency-us", .note = "as given"}
          : certify::measure_scheduling(place, wanted.seconds);
  const Bound bound = bound_of(std::move(scheduling), std::move(cycle), seen, wire_of(config));
  const Json json = document(bound, config, wanted.latency_us ? 0 : wanted.seconds);
  context.output.print(screen(json, context.output.style()));
  context.output.document(json);
  complain_of_doubts(context, bound, config);
  const std::string out = wanted.out.empty() ? config.certificate.string() : wanted.out;
  if (!out.empty()) {
    save(out, json);
    context.output.print(fmt::format("written: {}\n", out));
  }
  return ExitCode::completed;
}

}  // namespace lss::cli
