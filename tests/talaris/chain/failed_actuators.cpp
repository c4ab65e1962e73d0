#include "tests/talaris/chain/failed_actuators.h"

#include <fmt/format.h>

#include <cstdio>
#include <map>

#include "idl/talaris/codes.h"
#include "tests/talaris/chain/many.h"

namespace lss::talaris {
namespace {

// Times in a phase, from its begin: the first and the last.
std::pair<double, double> window(Phase phase) {
  switch (phase) {
    case Phase::ascend: return {1.2, 3.8};
    case Phase::hover: return {0.0, 0.9};
    case Phase::traverse: return {0.0, 9.5};
    default: return {0.0, 2.5};
  }
}

bool of_actuators(FaultId id) {
  return id == faults::valve_stuck_open || id == faults::valve_stuck_shut ||
         id == faults::fan_dead || id == faults::fan_without_thrust;
}

}  // namespace

const std::vector<ActuatorFailure>& actuator_failures() {
  static const std::vector<ActuatorFailure> all = [] {
    std::vector<ActuatorFailure> list;
    const auto valve = [&](const char* name, FaultId id, int i) {
      list.push_back({fmt::format("{}:{}", name, i), id,
                      static_cast<std::uint16_t>(kFirstValve + i - 1),
                      fmt::format("{} {}", i % 2 == 1 ? "lift" : "side", name)});
    };
    for (int i = 1; i <= kValveCount; ++i) valve("valve-stuck-open", faults::valve_stuck_open, i);
    for (int i = 1; i <= kValveCount; ++i) valve("valve-stuck-shut", faults::valve_stuck_shut, i);
    for (const auto& [name, id] : {std::pair("fan-dead", faults::fan_dead),
                                   std::pair("fan-broken", faults::fan_without_thrust)}) {
      for (int i = 1; i <= kFanCount; ++i)
        list.push_back({fmt::format("{}:{}", name, i), id,
                        static_cast<std::uint16_t>(kFirstFan + i - 1), name});
    }
    return list;
  }();
  return all;
}

Struck strike(const ActuatorFailure& failure, Phase phase, unsigned seed) {
  const auto [from_s, to_s] = window(phase);
  std::mt19937 random(seed * 31 + static_cast<unsigned>(phase));
  const double when_s = std::uniform_real_distribution(from_s, to_s)(random);
  Struck struck;
  double struck_s = 0;
  TimeNs begun_ns = 0;
  FlightPlan plan;
  plan.faults = {failure.fault};
  plan.strike_step = [&](Chain& chain) {
    if (begun_ns == 0 && chain.phase() == phase) begun_ns = chain.now();
    if (begun_ns == 0 || static_cast<double>(chain.now() - begun_ns) * 1e-9 < when_s) return false;
    struck_s = chain.seconds();
    return true;
  };
  plan.each_frame = [&](Chain& chain) {
    for (const FaultRecord& fault : chain.supervisor().faults) {
      if (!of_actuators(fault.id)) continue;
      const bool right = fault.id == failure.id && fault.subject == failure.subject;
      if (right && !struck.found) {
        struck.found = true;
        struck.found_after_s = chain.seconds() - struck_s;
      }
      struck.wrong = struck.wrong || !right;
    }
  };
  struck.flown = fly(plan, seed);
  return struck;
}

Flown fly_through_cut(double cut_s, Phase phase, unsigned seed) {
  const auto [from_s, to_s] = window(phase);
  std::mt19937 random(seed * 31 + static_cast<unsigned>(phase));
  const double when_s = std::uniform_real_distribution(from_s, to_s)(random);
  TimeNs begun_ns = 0;
  enum { waits, cut, over } state = waits;
  FlightPlan plan;
  plan.faults = {"bus-cut"};
  plan.strike_step = [&](Chain& chain) {
    if (begun_ns == 0 && chain.phase() == phase) begun_ns = chain.now();
    const double since_s = static_cast<double>(chain.now() - begun_ns) * 1e-9 - when_s;
    if (begun_ns == 0 || since_s < 0) return false;
    if (state == waits) {
      chain.inject("bus-cut");
      state = cut;
    } else if (state == cut && since_s >= cut_s) {
      chain.inject("clear:bus-cut");
      state = over;
    }
    return false;
  };
  return fly(plan, seed);
}

bool survived(const Struck& struck) { return struck.flown.upright() && struck.flown.down_m_s <= 2; }

std::string failed_actuators_section(unsigned seeds) {
  std::string text =
      "| failure | phase | at most 2 m/s, upright | upright | down, m/s: median | most | sideways, "
      "m/s: median | "
      "most | found | after, s: median | most | another one found |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  std::map<std::string, std::vector<const ActuatorFailure*>> kinds;
  for (const ActuatorFailure& failure : actuator_failures())
    kinds[failure.kind].push_back(&failure);
  for (const auto& [kind, failures] : kinds) {
    for (const Phase phase : kStruckPhases) {
      const auto all = runs(seeds, [&, &failures = failures](unsigned seed) {
        const Struck struck = strike(*failures[seed % failures.size()], phase, seed);
        if (!survived(struck) || struck.wrong)
          fmt::print(
              "{} {} {}{}: {}\n", failures[seed % failures.size()]->fault,
              kPhaseNames[static_cast<std::size_t>(phase)],
              struck.found ? fmt::format("found {:.2f} s", struck.found_after_s) : "not found",
              struck.wrong ? " WRONG" : "", struck.flown.text());
        return struck;
      });
      const auto down = figures(all, [](const Struck& s) { return s.flown.down_m_s; });
      const auto sideways = figures(all, [](const Struck& s) { return s.flown.sideways_m_s; });
      Figures after;
      for (const Struck& s : all)
        if (s.found) after.add(s.found_after_s);
      const std::string line = fmt::format(
          "| {} | {} | {} of {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} | {:.2f} | {:.2f} | "
          "{} |\n",
          kind, kPhaseNames[static_cast<std::size_t>(phase)], count(all, survived), seeds,
          count(all, [](const Struck& s) { return s.flown.upright(); }), down.share(0.5),
          down.most(), sideways.share(0.5), sideways.most(), after.size(), after.share(0.5),
          after.most(), count(all, [](const Struck& s) { return s.wrong; }));
      std::fputs(line.c_str(), stdout);
      std::fflush(stdout);
      text += line;
    }
  }
  return text;
}

}  // namespace lss::talaris
