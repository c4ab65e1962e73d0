#include "tools/lss-sim/talaris/gas.h"

#include <algorithm>

namespace lss::sim::talaris {
namespace {

const Vector3 kLift = Vector3::UnitX(), kAhead = Vector3::UnitZ(), kBack = -Vector3::UnitZ();

}  // namespace

const std::array<Nozzle, kValves>& nozzles() {
  static const std::array<Nozzle, kValves> all = {{{{0, -0.30, -0.40}, kLift},
                                                   {{0, -0.30, -0.42}, kAhead},
                                                   {{0, -0.30, 0.40}, kLift},
                                                   {{0, -0.30, 0.42}, kBack},
                                                   {{0, 0.30, 0.40}, kLift},
                                                   {{0, 0.30, 0.42}, kBack},
                                                   {{0, 0.30, -0.40}, kLift},
                                                   {{0, 0.30, -0.42}, kAhead}}};
  return all;
}

void ColdGas::step(std::uint8_t commanded) {
  double flow = leak_s_per_s;
  for (std::size_t i = 0; i < kValves; ++i) {
    Valve& valve = valves_[i];
    const bool wanted = ((commanded >> i & 1) != 0 || stuck_open[i]) && !stuck_shut[i];
    valve.lagging_ms = wanted == valve.open ? 0 : valve.lagging_ms + 1;
    if (valve.lagging_ms > (wanted ? options_.open_lag_ms : options_.close_lag_ms)) {
      valve.open = wanted;
      valve.lagging_ms = 0;
    }
    const double travel = 1.0 / std::max(1, options_.travel_ms);
    valve.lift = std::clamp(valve.lift + (valve.open ? travel : -travel), 0.0, 1.0);
    flow += valve.lift * pressure_share();
  }
  left_s_ = std::max(0.0, left_s_ - flow * kStep_s);
}

// Thrust and flow are proportional to the regulated pressure.
double ColdGas::pressure_share() const { return regulated_kPa() / kRegulated_kPa; }

double ColdGas::tank_kPa() const { return kFullTank_kPa * left_s_ / options_.budget_s; }

double ColdGas::regulated_kPa() const {
  double open = 0;
  for (const Valve& valve : valves_) open += valve.lift;
  const double drooped = 1 - options_.droop * std::max(open - 1, 0.0);
  return std::min(tank_kPa(), kRegulated_kPa * regulator * drooped);
}

double ColdGas::thrust_N(std::size_t valve) const {
  const double faded = 1 - options_.fade * (1 - left_s_ / options_.budget_s);
  return options_.thrust_N * options_.thrust_scale[valve] * faded * pressure_share() *
         valves_[valve].lift;
}

std::uint8_t ColdGas::open() const {
  unsigned bits = 0;
  for (std::size_t i = 0; i < kValves; ++i) bits |= (valves_[i].lift > 0 ? 1u : 0u) << i;
  return static_cast<std::uint8_t>(bits);
}

Wrench ColdGas::wrench() const {
  Wrench all;
  for (std::size_t i = 0; i < kValves; ++i) {
    if (valves_[i].lift > 0) all.add(nozzles()[i].at_m, thrust_N(i) * nozzles()[i].along);
  }
  return all;
}

}  // namespace lss::sim::talaris
