#pragma once

// A vehicle that deviates from its parameters, by a seed.

#include "tests/talaris/gnc/hopper.h"

namespace lss::gnc::talaris::test {

struct Spread {
  double mass = 0.01, inertia = 0.2, thrust = 0.05, jet = 0.02;  // shares; jet: from one to another
  double fan_thrust = 0.01, fan_speed = 0.01;
  Vector3 moment_N_m = {0.2, 0.4, 0.3};
  double drift_m_s2 = 0.01;
};

inline World dispersed(unsigned seed, const Spread& s, World world = {}) {
  std::mt19937 random(seed);
  const auto any = [&](double most) {
    return std::uniform_real_distribution<double>(-most, most)(random);
  };
  world.seed = seed;
  world.mass_kg *= 1 + any(s.mass);
  for (int i = 0; i < 3; ++i) world.inertia_kg_m2[i] *= 1 + any(s.inertia);
  const double all = any(s.thrust);
  for (double& force : world.force_N) force *= 1 + all + any(s.jet);
  world.fan_scale = 1 + any(s.fan_thrust);
  for (double& speed : world.fan_speed) speed = 1 + any(s.fan_speed);
  for (int i = 0; i < 3; ++i) world.moment_N_m[i] = any(s.moment_N_m[i]);
  world.drift_m_s2 = Vector3(0, any(s.drift_m_s2), any(s.drift_m_s2));
  world.valve_lag_s += any(0.003);
  world.fan_lag_s += any(0.05);
  return world;
}

// Minimum, mean and maximum of the collected values, and a line about them for the record.
struct Statistics {
  double sum = 0, least = 1e9, most = -1e9;
  int n = 0;
  void add(double x) {
    sum += x;
    least = std::min(least, x);
    most = std::max(most, x);
    ++n;
  }
  double mean() const { return n > 0 ? sum / n : 0; }
};

}  // namespace lss::gnc::talaris::test
