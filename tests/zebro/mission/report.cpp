#include "tests/zebro/mission/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace lss::zebro::mission {
namespace {

using Measure = std::function<double(const Result&)>;

struct Quantity {
  const char* name;
  int digits;
  Measure measure;
};

const Quantity kQuantities[] = {
    {"way along the course, true, m", 1, [](const Result& r) { return r.true_m; }},
    {"aside of the course, true, m", 1, [](const Result& r) { return r.aside_m; }},
    {"way by dead reckoning, m", 1, [](const Result& r) { return r.course_m; }},
    {"days until the end", 2, [](const Result& r) { return r.elapsed_h / 24; }},
    {"hours in Walking", 1, [](const Result& r) { return r.walked_h; }},
    {"hours asleep, charging", 1, [](const Result& r) { return r.rested_h; }},
    {"least charge, %", 0, [](const Result& r) { return r.least_charge * 100; }},
    {"rests", 0, [](const Result& r) { return r.count.rests; }},
    {"faults injected", 0, [](const Result& r) { return r.fault_total(); }},
    {"times in FatalError", 0, [](const Result& r) { return r.emergencies; }},
    {"recovered by the daemon", 0, [](const Result& r) { return r.count.recoveries; }},
    {"legs isolated", 0, [](const Result& r) { return r.isolations; }},
    {"resets of everything", 0, [](const Result& r) { return r.count.resets; }},
    {"interventions of a person", 0, [](const Result& r) { return r.count.interventions; }},
};

double quantile(std::vector<double> sorted, double q) {
  return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1) + 0.5)];
}

std::vector<double> sorted(std::span<const Result> results, const Measure& measure) {
  std::vector<double> values;
  for (const Result& result : results) values.push_back(measure(result));
  std::ranges::sort(values);
  return values;
}

std::string quantiles(std::span<const Result> results) {
  std::string text =
      "| of each mission | least | 5 % | median | 95 % | most |\n"
      "|---|---:|---:|---:|---:|---:|\n";
  for (const Quantity& quantity : kQuantities) {
    const std::vector<double> values = sorted(results, quantity.measure);
    text += fmt::format("| {} |", quantity.name);
    for (const double q : {0.0, 0.05, 0.5, 0.95, 1.0})
      text += fmt::format(" {:.{}f} |", quantile(values, q), quantity.digits);
    text += "\n";
  }
  return text;
}

std::string faults(std::span<const Result> results) {
  std::string text =
      "| fault | injected | in Operational | of these FatalError within 10 s |\n"
      "|---|---:|---:|---:|\n";
  for (std::size_t i = 0; i < kFaultShapes.size(); ++i) {
    FaultCount sum;
    for (const Result& result : results) {
      sum.begun += result.faults[i].begun;
      sum.operational += result.faults[i].operational;
      sum.fatal += result.faults[i].fatal;
    }
    text += fmt::format("| {} | {} | {} | {} |\n", kFaultShapes[i].name, sum.begun, sum.operational,
                        sum.fatal);
  }
  return text;
}

}  // namespace

std::string line(const Result& r) {
  return fmt::format(
      "seed {:>3}: {} {:.1f} m (true {:.1f}, aside {:.1f}) in {:.2f} d, walked {:.1f} h, rested "
      "{:.1f} h, {} faults, {} emergencies, {} recovered, {} isolated, {} resets, {} "
      "interventions, {} violations, {:.1f} s",
      r.seed, r.arrived ? "arrived" : "ENDED", r.course_m, r.true_m, r.aside_m, r.elapsed_h / 24,
      r.walked_h, r.rested_h, r.fault_total(), r.emergencies, r.count.recoveries, r.isolations,
      r.count.resets, r.count.interventions, r.violations.size(), r.wall_s);
}

std::string document(std::span<const Result> results, const Options& options,
                     const std::string& command, const std::string& stamp) {
  const auto count = [&](auto of) { return std::ranges::count_if(results, of); };
  std::size_t violations = 0;
  double hours = 0, wall_s = 0;
  for (const Result& result : results) {
    violations += result.violations.size();
    hours += result.elapsed_h - result.rested_h;
    wall_s += result.wall_s;
  }
  const Power power;
  std::string text = fmt::format(
      R"(# Missions of Lunar Zebro

Does Lunar Zebro arrive in spite of faults?
Made by `{}`, {}; do not edit.
{} missions of {:.0f} m on the level Moon, each with another seed, within a lunar day of {:.0f} days: shipping cycle and error
solving, kinematic [plant](simulator.md), [autopilot](../tests/zebro/mission/). Speed "{}", flight {:.1f} s.

- **Rest**: at {:.0f} % of {:.0f} Wh it lies down, deploys the panel ({:.0f} W) and sleeps until {:.0f} %, without faults.
- **Faults**: at random, every {:.1f} h of operation on average.
- **A person** repairs everything in two hours when solving and resetting did not help (`autopilot.cpp`).
- Power, panel and faults are our assumptions (`mission.h`, `faults.h`).

{} of {} arrived. Conditions of every frame, violated {} times: outside Operational no order to move (except of a leg by
error solving, and of the panel in Idle); not operational with the panel out or a fatal fault latched; a reset or driver
fault of a leg stops the vehicle within three seconds.

)",
      command, stamp, results.size(), options.autopilot.course_m, options.day_h / 24,
      kSpeeds[static_cast<std::size_t>(options.autopilot.speed)], options.flight_s,
      options.autopilot.rest_below * 100, power.capacity_Wh, power.panel_W,
      options.autopilot.rest_until * 100, options.fault_mean_h,
      count([](const Result& r) { return r.arrived; }), results.size(), violations);
  text += quantiles(results) + "\n" + faults(results) + "\n";
  for (const Result& result : results) {
    for (const std::string& violation : result.violations)
      text += fmt::format("- seed {}, {}\n", result.seed, violation);
  }
  text += fmt::format("{:.0f} hours awake took {:.0f} s of wall-clock: {:.0f} times real time.\n",
                      hours, wall_s, hours * 3600 / wall_s);
  return text;
}

}  // namespace lss::zebro::mission
