#include "tools/lss-sim/talaris/fans.h"

#include <algorithm>
#include <numbers>

namespace lss::sim::talaris {
namespace {

constexpr int kNone_us = 1'000, kFull_us = 2'000;
constexpr int kSaysFull_us = 1'950, kSaysNone_us = 1'050;  // of the start-up procedure
constexpr double kFull_rpm = 33'000;                       // of FanOptions::thrust_N
constexpr int kStartUp_ms = 350;
constexpr int kSilent_ms = 100;          // the motor is off after this time without pulses
constexpr double kLeastThrottle = 0.02;  // below it the motor does not turn

}  // namespace

const std::array<Vector3, kFans>& fan_places_m() {
  static const std::array<Vector3, kFans> all = {
      {{0, -0.33, -0.44}, {0, -0.33, 0.44}, {0, 0.33, 0.44}, {0, 0.33, -0.44}}};
  return all;
}

Fans::Fans(const FanOptions& options) : options_(options) {
  if (!options.started) return;
  for (Fan& fan : fans_) fan.phase = Phase::armed;
}

void Fans::step(const std::array<std::uint16_t, kFans>& pulse_us) {
  for (std::size_t i = 0; i < kFans; ++i) {
    Fan& fan = fans_[i];
    fan.last_rpm = fan.rpm;
    const int pulse = pulse_us[i];
    fan.silent_ms = pulse == 0 ? fan.silent_ms + 1 : 0;
    fan.full_ms = pulse >= kSaysFull_us ? fan.full_ms + 1 : 0;
    switch (fan.phase) {
      case Phase::waiting:
        if (fan.full_ms >= kStartUp_ms) fan.phase = Phase::learning;
        break;
      case Phase::learning:
        if (pulse > 0 && pulse <= kSaysNone_us) fan.phase = Phase::armed;
        break;
      case Phase::armed: break;
    }
    double throttle =
        std::clamp(static_cast<double>(pulse - kNone_us) / (kFull_us - kNone_us), 0.0, 1.0);
    const bool turns = fan.phase == Phase::armed && !dead[i] && fan.silent_ms < kSilent_ms;
    if (!turns || throttle < kLeastThrottle) throttle = 0;
    // A missing pulse within the controller's timeout has no effect.
    if (turns && fan.silent_ms > 0) continue;
    const double rpm = options_.max_rpm * throttle * (1 + options_.bend * (1 - throttle));
    fan.rpm += (rpm - fan.rpm) * std::min(1.0, kStep_s / options_.lag_s);
  }
}

double Fans::thrust_N(std::size_t fan) const {
  if (broken[fan]) return 0;
  const double share = fans_[fan].rpm / kFull_rpm;
  return options_.thrust_N * options_.thrust_scale[fan] * share * share;
}

Wrench Fans::wrench(const Vector3& rate_B_rad_s) const {
  constexpr double kRad_s = 2 * std::numbers::pi / 60;  // of a turn a minute
  Wrench all;
  double turning_Nms = 0;
  for (std::size_t i = 0; i < kFans; ++i) {
    all.add(fan_places_m()[i], Vector3(thrust_N(i), 0, 0));
    const double sense = i % 2 == 0 ? 1 : -1;
    const double faster_rad_s2 = (fans_[i].rpm - fans_[i].last_rpm) * kRad_s / kStep_s;
    all.torque_Nm.x() -= sense * (options_.torque_m * options_.torque_scale[i] * thrust_N(i) +
                                  options_.rotor_kg_m2 * faster_rad_s2);
    turning_Nms += sense * options_.rotor_kg_m2 * fans_[i].rpm * kRad_s;
  }
  all.torque_Nm -= rate_B_rad_s.cross(Vector3(turning_Nms, 0, 0));
  return all;
}

}  // namespace lss::sim::talaris
