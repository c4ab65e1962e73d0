#include "gnc/talaris/fans.h"

#include <algorithm>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::talaris {

double fan_thrust_N(double rpm, const Fans& fans) noexcept {
  return rpm > 0 && std::isfinite(rpm) ? fans.thrust_N_per_rpm2 * rpm * rpm : 0;
}

double fan_thrust_N(const PerFan& rpm, const Fans& fans) noexcept {
  double sum = 0;
  for (const double n : rpm) sum += fan_thrust_N(n, fans);
  return sum;
}

double rpm_for(double force_N, const Fans& fans) noexcept {
  return std::sqrt(std::max(force_N, 0.0) / kFans / fans.thrust_N_per_rpm2);
}

void FanSpeed::reset() noexcept {
  reference_ = {};
  trim_ = {};
}

double FanSpeed::throttle(std::size_t i, double command_rpm, double error_rpm) noexcept {
  const double error = std::isfinite(error_rpm) ? error_rpm / fans_.max_rpm : 0;
  const double plain = command_rpm / fans_.max_rpm + gains_.rpm_kp * error + trim_[i];
  const bool stuck = (plain >= 1 && error > 0) || (plain <= 0 && error < 0);
  if (!stuck) trim_[i] = std::clamp(trim_[i] + gains_.rpm_ki_1_s * kFrame_s * error, -0.3, 0.3);
  return std::clamp(plain, 0.0, 1.0);
}

PerFan FanSpeed::ramp(const PerFan& goal_rpm, double ramp_rpm_s,
                      const PerFan& measured_rpm) noexcept {
  const double a = math::exp(-kFrame_s / fans_.lag_s);
  PerFan out{};
  for (std::size_t i = 0; i < kFans; ++i) {
    const double goal =
        std::isfinite(goal_rpm[i]) ? std::clamp(goal_rpm[i], 0.0, fans_.max_rpm) : 0;
    if (goal <= 0) {
      reference_[i] *= a;
      trim_[i] = 0;
      continue;
    }
    // the command that moves a fan with this lag from one point of the ramp to the next
    const double step =
        std::clamp(goal - reference_[i], -ramp_rpm_s * kFrame_s, ramp_rpm_s * kFrame_s);
    const double command = std::clamp(reference_[i] + step / (1 - a), 0.0, fans_.max_rpm);
    out[i] = throttle(i, command, reference_[i] - measured_rpm[i]);
    reference_[i] = a * reference_[i] + (1 - a) * command;
  }
  return out;
}

PerFan FanSpeed::direct(const PerFan& command_rpm, const PerFan& measured_rpm) noexcept {
  const double a = math::exp(-kFrame_s / fans_.lag_s);
  PerFan out{};
  for (std::size_t i = 0; i < kFans; ++i) {
    const double command =
        std::isfinite(command_rpm[i]) ? std::clamp(command_rpm[i], 0.0, fans_.max_rpm) : 0;
    if (command > 0) out[i] = throttle(i, command, reference_[i] - measured_rpm[i]);
    reference_[i] = a * reference_[i] + (1 - a) * command;
  }
  return out;
}

PerFan FanSpeed::blind(const PerFan& command_rpm) noexcept {
  return direct(command_rpm, reference_);
}

}  // namespace lss::gnc::talaris
