// Row xii: simulation against the wall-clock. A mission of 200 m, some 60 h of walking, on the
// kinematic plant with cycle, bus, modules, faults and an autopilot (tests/zebro/mission); and the
// same chain on rigid bodies, every byte at its instant (tests/zebro/chain). And the fault
// campaigns of all vehicles, by CPU time.

#include <fmt/format.h>

#include <regex>

#include "daemon/runtime/clock.h"
#include "tests/bench/programs.h"
#include "tests/zebro/chain/chain.h"
#include "tests/zebro/mission/mission.h"

namespace lss::bench {
namespace {

constexpr double kCourse_m = 200;
constexpr double kGoal_s = 30;
constexpr double kTimesRealTime = 5;
constexpr double kCampaignTimes = 1000;

// --quick: a shorter one, and so many times its wall-clock.
Figure whole_mission(const Options& options) {
  zebro::mission::Options wanted;
  const double course_m = options.count(200, 4);
  wanted.autopilot.course_m = course_m;
  const zebro::mission::Result result = zebro::mission::run(wanted);
  if (!result.arrived || !result.violations.empty())
    throw std::runtime_error(result.violations.empty() ? "the mission did not arrive"
                                                       : result.violations.front());
  const double times = kCourse_m / course_m;
  const double awake_s = (result.elapsed_h - result.rested_h) * 3600;
  Figure figure = figure_of(
      "xii", "legged mission of 200 m, kinematic plant", "s", result.wall_s * times,
      awake_s * times, kGoal_s,
      fmt::format("{:.0f} times real time; reference: its {:.0f} h awake, "
                  "{:.0f} h of them walking; {} faults{}",
                  awake_s / result.wall_s, awake_s * times / 3600, result.walked_h * times,
                  result.fault_total(), options.quick ? "; extrapolated from 4 m" : ""));
  figure.absolute = true;
  return figure;
}

// Of one simulated second while it walks.
Figure rigid_bodies(const Options& options) {
  zebro::Chain chain;
  if (!chain.stand() || !chain.walk()) throw std::runtime_error("the simulated robot fell");
  Samples wall_ms;
  for (int i = 0; i < options.count(20, 2); ++i) {
    const TimeNs begin = now_ns();
    chain.run(1);
    wall_ms.push_back(static_cast<double>(now_ns() - begin) * 1e-6);
  }
  const double ms = median(wall_ms);
  return figure_of(
      "xii", "a simulated second, rigid bodies", "ms", ms, 1000, 1 / kTimesRealTime,
      fmt::format("{:.1f} times real time, with cycle and bytes, on one CPU", 1000 / ms));
}

// `lss-campaign` says itself how many times real time it was.
Figure campaign(const std::string& vehicle, int runs) {
  const Folder folder;
  Process played({program("lss-campaign"), vehicle, "--runs", std::to_string(runs)},
                 folder / "campaign.log");
  if (played.wait(std::chrono::minutes(10)) != 0)
    throw std::runtime_error("lss-campaign: " + read_file(folder / "campaign.log"));
  const std::string said = read_file(folder / "campaign.log");
  std::smatch found;
  if (!std::regex_search(said, found, std::regex("([0-9]+) times real time")))
    throw std::runtime_error("lss-campaign does not say how fast it was: " + said);
  const double times = std::stod(found[1]);
  Figure figure = figure_of("xii", "campaign of " + vehicle + ", CPU of a simulated second", "ms",
                            1000 / times, 1000, 1000 / kCampaignTimes,
                            fmt::format("{:.0f} times real time, {} scenarios", times, runs));
  figure.absolute = true;
  return figure;
}

}  // namespace

Figures simulation_speed(const Options& options) {
  Figures figures{whole_mission(options), rigid_bodies(options)};
  for (const char* vehicle : kVehicles) figures.push_back(campaign(vehicle, options.count(30, 1)));
  return figures;
}

}  // namespace lss::bench
