// Row xiv: simulated time in lockstep. lss-sim, lssd and lss-cli as they ship, as fast as this
// machine goes: wall-clock of a simulated second of motion, against real time and, with rigid
// bodies, against the same chain in one process (tests/zebro/chain).

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>

#include "daemon/runtime/clock.h"
#include "tests/bench/programs.h"
#include "tests/zebro/chain/chain.h"

namespace lss::bench {
namespace {

constexpr double kGoalTimes = 20;      // with the kinematic plant
constexpr double kOfOneProcess = 0.8;  // of its speed, with rigid bodies
constexpr double kFrame_us = 600;
constexpr double kAt_s = 2;  // when the client comes in

struct Moving {
  const char* vehicle;
  const char* begin;
  const char* motion;
};
constexpr Moving kWalk{"zebro", "start; stand", "walk forward --speed high"};
constexpr Moving kDrive{"ardito", "start", "drive 0.3"};

// The three programs once, from the start of the client to its end, while the vehicle moves for
// so many simulated seconds.
double wall_ms(const Moving& moving, const std::string& plant, int seconds) {
  Folder folder;
  const std::filesystem::path run = folder / "run", log = folder / "lss-sim.log";
  const std::string id = std::to_string(domain(0));
  const std::string can = "udp://127.0.0.1:" + std::to_string(21000 + domain(0));
  std::vector<std::string> words{
      program("lss-sim"), moving.vehicle, "--dir",       run,
      "--pace",           "--lockstep",   "--speed",     "max",
      "--plant",          plant,          "--client-at", fmt::format("{}", kAt_s)};
  std::string config = edited(shipped_config(moving.vehicle), "shared_memory", "false");
  if (moving.vehicle != std::string("zebro")) {
    words.insert(words.end(), {"--can", can});
    const std::string shipped = "udp://127.0.0.1:20000";
    config.replace(config.find(shipped), shipped.size(), can);
  }
  std::ofstream(folder / "config.toml") << config;
  Process simulator(words, log);
  if (!eventually([&] { return simulator.said("ready"); }))
    throw NotHere("lss-sim does not start here");
  ReadySocket ready(folder);
  Process daemon({program("lssd"), "--lockstep", "--config", folder / "config.toml", "--run-dir",
                  run, "--domain", id},
                 folder / "lssd.log", Process::Environment{loopback(), ready.variable()});
  ready.wait();
  Process client({program("lss-cli"), "--domain", id, "run", "--lockstep", "--dir", run, "-e",
                  fmt::format("{}; {} --for {}s; stop", moving.begin, moving.motion, seconds)},
                 folder / "lss-cli.log", Process::Environment{loopback()});
  if (const int code = client.wait(std::chrono::seconds(300)); code != 0)
    throw std::runtime_error(fmt::format("{} in lockstep: lss-cli ended with {}: {}",
                                         moving.vehicle, code, read_file(folder / "lss-cli.log")));
  return static_cast<double>(now_ns() - client.started_ns()) * 1e-6;
}

// Of a simulated second of motion: what a longer motion takes more.
Samples second_ms(const Moving& moving, const std::string& plant, int seconds) {
  const int little = 2;
  const double begin = wall_ms(moving, plant, little);
  return {(wall_ms(moving, plant, little + seconds) - begin) / seconds};
}

Samples one_process_ms(int seconds) {
  zebro::Chain chain;
  if (!chain.stand() || !chain.walk()) throw std::runtime_error("the simulated robot fell");
  const TimeNs begin = now_ns();
  chain.run(seconds);
  return {static_cast<double>(now_ns() - begin) * 1e-6 / seconds};
}

double period_ms(const std::string& vehicle) {
  const std::string text = shipped_config(vehicle);
  const std::string key = "period_ms = ";
  return std::strtod(text.c_str() + text.find(key) + key.size(), nullptr);
}

void kinematic(const Moving& moving, const Options& options, Figures& figures) {
  Samples all;
  for (int i = 0; i < options.count(kRounds, 1); ++i)
    all.push_back(second_ms(moving, "kinematic", options.count(30, 10)).front());
  const double ms = median(all);
  figures.push_back(figure_of(
      "xiv", fmt::format("{} in lockstep, kinematic plant, a simulated second", moving.vehicle),
      "ms", ms, 1000, 1 / kGoalTimes,
      fmt::format("{:.0f} times real time; lss-sim, lssd and lss-cli", 1000 / ms)));
  const double frame_ms = period_ms(moving.vehicle);
  Figure frame =
      figure_of("xiv", fmt::format("{} in lockstep, kinematic plant, a frame", moving.vehicle),
                "us", ms * frame_ms, kNone, kFrame_us,
                fmt::format("of {:.0f} ms; hand-overs, cycle, bus and plant together", frame_ms));
  frame.absolute = true;
  figures.push_back(frame);
}

}  // namespace

Figures lockstep_speed(const Options& options) {
  Figures figures;
  kinematic(kWalk, options, figures);
#ifdef LSS_BENCH_ARDITO
  kinematic(kDrive, options, figures);
#endif
  const int seconds = options.count(10, 5);
  const Rounds rounds =
      turn_by_turn([&] { return second_ms(kWalk, "dart", seconds); },
                   [&] { return one_process_ms(seconds); }, options.count(kRounds, 1));
  figures.push_back(
      noted(figure("xiv", "zebro in lockstep, rigid bodies, a simulated second", "ms", rounds,
                   median, 1 / kOfOneProcess),
            "reference: the same chain in one process, with pieces of 8 characters instead of 64"));
  return figures;
}

}  // namespace lss::bench
