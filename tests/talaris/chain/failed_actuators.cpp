#include "tests/talaris/chain/failed_actuators.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <random>
#include <stdexcept>

#include "idl/talaris/codes.h"

namespace lss::talaris {
namespace {

// Times in a phase of config/talaris/hop.toml, from its begin: the first and the last.
std::pair<double, double> window(Phase phase) {
  switch (phase) {
    case Phase::ascend: return {1.2, 2.8};
    case Phase::hover: return {0.0, 0.19};
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
      const bool lifts = i % 2 == 1;
      list.push_back({fmt::format("{}:{}", name, i), id,
                      static_cast<std::uint16_t>(kFirstValve + i - 1),
                      fmt::format("{} {}", lifts ? "lift" : "side", name),
                      lifts && id == faults::valve_stuck_open});
    };
    for (int i = 1; i <= kValveCount; ++i) valve("valve-stuck-open", faults::valve_stuck_open, i);
    for (int i = 1; i <= kValveCount; ++i) valve("valve-stuck-shut", faults::valve_stuck_shut, i);
    for (const auto& [name, id] : {std::pair("fan-dead", faults::fan_dead),
                                   std::pair("fan-broken", faults::fan_without_thrust)}) {
      for (int i = 1; i <= kFanCount; ++i)
        list.push_back({fmt::format("{}:{}", name, i), id,
                        static_cast<std::uint16_t>(kFirstFan + i - 1), name, true});
    }
    return list;
  }();
  return all;
}

FlightPlan struck_in(Phase phase, unsigned seed, FlightPlan plan) {
  const auto [from_s, to_s] = window(phase);
  std::mt19937 random(seed * 31 + static_cast<unsigned>(phase));
  const double when_s = std::uniform_real_distribution(from_s, to_s)(random);
  // The torque of a fan that fails is no longer that of its neighbours.
  plan.spread.fan_torque_m = sim::talaris::kWide.fan_torque_m;
  plan.spread.fan_torque = sim::talaris::kWide.fan_torque;
  plan.spread.rotor_kg_m2 = sim::talaris::kWide.rotor_kg_m2;
  plan.strike_step = [phase, when_s, begun_ns = TimeNs{0}](Chain& chain) mutable {
    if (begun_ns == 0 && chain.phase() == phase) begun_ns = chain.now();
    return begun_ns != 0 && static_cast<double>(chain.now() - begun_ns) * 1e-9 >= when_s;
  };
  return plan;
}

Struck strike(const ActuatorFailure& failure, Phase phase, unsigned seed) {
  Struck struck;
  double struck_s = 0;
  FlightPlan plan = struck_in(phase, seed, {.faults = {failure.fault}});
  plan.strike_step = [&, due = plan.strike_step](Chain& chain) {
    if (!due(chain)) return false;
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

namespace {

// `fault` lasts for so long, from a time in `phase` on that the seed chooses; then begun(chain).
// "": only that.
Flown fly_through(const std::string& fault, double lasts_s, Phase phase, unsigned seed,
                  FlightPlan plan, const std::function<void(Chain&)>& begun) {
  const auto [from_s, to_s] = window(phase);
  std::mt19937 random(seed * 31 + static_cast<unsigned>(phase));
  const double when_s = std::uniform_real_distribution(from_s, to_s)(random);
  TimeNs begun_ns = 0;
  enum { waits, lasts, over } state = waits;
  plan.faults = {fault};  // so that the step is asked
  plan.strike_step = [&](Chain& chain) {
    if (begun_ns == 0 && chain.phase() == phase) begun_ns = chain.now();
    const double since_s = static_cast<double>(chain.now() - begun_ns) * 1e-9 - when_s;
    if (begun_ns == 0 || since_s < 0) return false;
    if (state == waits) {
      if (!fault.empty()) chain.inject(fault);
      begun(chain);
      state = lasts;
    } else if (state == lasts && since_s >= lasts_s) {
      if (!fault.empty()) chain.inject("clear:" + fault.substr(0, fault.find(':')));
      state = over;
    }
    return false;
  };
  return fly(plan, seed);
}

// Counts orders of the bus master for so long.
void count_stops(Chain& chain, double for_s, Outage& outage) {
  const TimeNs end_ns = chain.now() + testing_support::to_ns(for_s);
  chain.on_master = [&outage, &chain, end_ns](const CanFrame& frame, TimeNs now) {
    if (now > end_ns || chain.phase() == Phase::touchdown) return;
    const bool off = (frame.data[0] | frame.data[1] << 8) == kFanOff_us;
    if (frame.id == 0x221 && off) ++outage.fans_off;
    if (frame.id == 0x000 && frame.data[0] != 1) ++outage.resets;
  };
}

// Of the bus master or the valves' timing, in both copies: by it all orders are too old.
template <class Damaged>
void damage(Chain& chain, TimeNs stale_after_ns) {
  const auto value = std::bit_cast<std::array<std::uint8_t, sizeof(TimeNs)>>(stale_after_ns);
  const std::array<std::uint8_t, 2> flips{0x80, 0xC0};
  std::size_t damaged = 0;
  for (const Chain::Memory& part : chain.memory()) {
    const std::size_t size = part.bytes.size();
    if (size != sizeof(Damaged) && size != sizeof(Twin<sizeof(Damaged)>)) continue;
    const auto found = std::ranges::search(part.bytes, value);
    if (!found.empty()) found.back() ^= flips.at(damaged++);
  }
  if (damaged != flips.size()) throw std::runtime_error("the parameter has not two copies");
}

}  // namespace

Flown fly_through_cut(double cut_s, Phase phase, unsigned seed) {
  return fly_through("bus-cut", cut_s, phase, seed, {}, [](Chain&) {});
}

Outage fly_through_bus_off(double off_s, Phase phase, unsigned seed) {
  constexpr double kFrame_s = 0.2;
  Outage outage;
  outage.flown = fly_through(fmt::format("bus-off:{}", off_s), off_s, phase, seed, {},
                             [&](Chain& chain) { count_stops(chain, off_s + kFrame_s, outage); });
  return outage;
}

Outage fly_through_damage(bool of_valves, Phase phase, unsigned seed) {
  Outage outage;
  outage.flown = fly_through("", 0, phase, seed, {}, [&](Chain& chain) {
    const BusesParameters& p = chain.parameters().buses;
    of_valves ? damage<ValveSequencer>(chain, p.valves.stale_after_ns)
              : damage<HopperBus>(chain, p.can.stale_after_ns);
    count_stops(chain, 0.3, outage);
  });
  return outage;
}

bool survived(const Flown& flown) { return flown.upright() && flown.down_m_s <= kSurvived_m_s; }

}  // namespace lss::talaris
