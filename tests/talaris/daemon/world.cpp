#include "world.h"

#include <cmath>

namespace lss::talaris {

Parameters quick() {
  Parameters p;
  p.navigation.calibration_s = 4;
  return p;
}

World::World(const Parameters& parameters, const Supervisor::Parameters& links)
    : CycleWorld(parameters, talaris::logic(), links, kFrame), parameters_(parameters) {
  in_.bus.can.was_open = in_.bus.can.open = true;
  in_.bus.imu.open = in_.bus.altimeter.open = true;
  for (HopperLink& link : in_.bus.can.status.link)
    link.node.state = canopen::NodeState::operational;
}

double World::noise() {
  seed_ = seed_ * 1664525 + 1013904223;
  return (seed_ >> 8) / double(1 << 24) * 2 - 1;
}

// 5 ms under the last orders.
void World::move(double into_s, double& up_m_s2, double& along_m_s2) {
  const gnc::talaris::Parameters& p = parameters_.flight;
  constexpr double kStep_s = 0.005;
  const TalarisOrders& o = out_.command;
  const auto open = [&](std::size_t i) {
    if (!valves_alive || (o.enabled >> i & 1u) == 0) return false;
    const TimeNs t = static_cast<TimeNs>(std::lround(into_s * 1e3)) * kMillisecond;
    if (o.hold[i].open) return o.release_ns + t < o.hold[i].until_ns;
    return t >= o.pulse[i].delay_ns && t < o.pulse[i].delay_ns + o.pulse[i].on_ns;
  };
  double up_N = 0, along_N = 0;
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (!open(i)) continue;
    gas_s += kStep_s;
    const double force_N = gas_works ? p.thrusters.force_N : 0;
    if (i % 2 == 0) up_N += force_N;
    if (i == 1 || i == 7) along_N += force_N;
    if (i == 3 || i == 5) along_N -= force_N;
  }
  for (std::size_t i = 0; i < kHopperFans; ++i) {
    const double throttle = fans_alive ? (o.fan_us[i] - 1000) / 1000.0 : 0;
    rpm[i] += (throttle * p.fans.max_rpm - rpm[i]) * kStep_s / p.fans.lag_s;
    up_N += p.fans.thrust_N_per_rpm2 * rpm[i] * rpm[i];
  }
  const double mass_kg = p.body.mass_kg - p.gas.mass_kg * gas_s / p.gas.budget_s;
  up_m_s2 = up_N / mass_kg;
  along_m_s2 = along_N / mass_kg;
  const double g = gnc::talaris::kGravity_m_s2;
  if (height_m <= 0 && up_m_s2 < g) {
    if (speed_m_s < -0.01) landing_m_s = -speed_m_s;
    up_m_s2 = g - speed_m_s / kStep_s;  // the IMU feels the shock
    along_m_s2 = -along_m_s / kStep_s;
    height_m = speed_m_s = along_m_s = 0;
    return;
  }
  speed_m_s += (up_m_s2 - g) * kStep_s;
  height_m += speed_m_s * kStep_s;
  along_m_s += along_m_s2 * kStep_s;
  along_m += along_m_s * kStep_s;
}

void World::sense() {
  in_.bus.can.time_ns = time_ns_ - kMillisecond;
  std::vector<TalarisSample> samples;
  const TimeNs from_ns = time_ns_ - kFrame;
  const auto say = [&](double at_s, const Reading& reading) {
    samples.push_back({from_ns + static_cast<TimeNs>(at_s * 1e9), reading});
  };
  for (int i = 0; i < 40; ++i) {
    double up_m_s2 = 0, along_m_s2 = 0;
    move(i * 0.005, up_m_s2, along_m_s2);
    ++imu_count;
    const auto rate = [&] { return 1e-4 * noise() + shake * noise(); };
    const auto force = [&](double x) { return x + 1e-3 * noise() + shake * noise(); };
    const std::array<double, 3> rates = {rate(), rate(), rate()};
    if (imu_alive)
      say(i * 0.005, ImuPacket{.rate_rad_s = rates,
                               .force_m_s2 = {force(up_m_s2), force(0), force(along_m_s2)},
                               .temperature_degC = 25,
                               .count = imu_count});
    if (i % 20 == 10 && altimeter_alive)
      say(i * 0.005, Range{.range_m = 0.5 + height_m + 1e-3 * noise(), .error = 0});
    if (i % 4 == 3 && fans_alive)
      say(i * 0.005, FanSpeeds{{std::round(rpm[0] / 200) * 200, std::round(rpm[1] / 200) * 200,
                                std::round(rpm[2] / 200) * 200, std::round(rpm[3] / 200) * 200}});
  }
  if (valves_alive)
    say(0.15, GasState{.tank_Pa = tank_kPa * 1e3,
                       .regulated_Pa = regulated_kPa * 1e3,
                       .voltage_V = voltage_V,
                       .temperature_degC = 20});
  if (distort) distort(samples);
  for (const TalarisSample& sample : samples) {
    if (in_.sample_count < in_.samples.size()) in_.samples[in_.sample_count++] = sample;
  }
  for (std::size_t i = 0; i < kHopperNodes; ++i) {
    if (node(i).state == canopen::NodeState::operational)
      node(i).heartbeat_ns = time_ns_ - kMillisecond;
  }
}

bool World::start() {
  run(1);
  send(lss::CommandKind::start);
  return run_until(Mode::manual, 2);
}

bool World::arm() {
  send(CommandKind::edf_arm, {0});
  return run_until([&] { return out_.telemetry.fans[0].armed; }, 3);
}

bool World::calibrate() {
  send(CommandKind::gnc, {0});
  if (!run_until(Mode::standby, 1)) return false;
  send(CommandKind::gnc, {1});
  if (!run_until(Mode::calibrate, 1)) return false;
  return run_until(Mode::standby, parameters_.navigation.calibration_s + 5) &&
         out_.telemetry.calibrated;
}

bool World::fly(Program program, double height, double distance) {
  if (!start() || !arm() || !calibrate()) return false;
  send(CommandKind::plan, {double(program), height, distance, 0, 0});
  if (!run_until([&] { return out_.telemetry.planned; }, 1)) return false;
  send(CommandKind::gnc, {2});
  return run_until([&] { return airborne() && height_m > 0.5; }, 30);
}

}  // namespace lss::talaris
