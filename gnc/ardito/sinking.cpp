// One wheel that digs itself in while the others hold: a stage of MobilityController.

#include <algorithm>
#include <cmath>

#include "gnc/ardito/mobility_controller.h"
#include "gnc/ardito/slip.h"

namespace lss::gnc::ardito {
namespace {

constexpr std::uint32_t kFrames = 4;  // in a row, before the wheel counts as dug in

// What the load of this wheel's motor is compared with, of the other wheels that drive.
double others_load(const PerWheel<double>& load, WheelSet driven, std::size_t wheel,
                   const Parameters& p) noexcept {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (i == wheel || !contains(driven, i)) continue;
    sum += load[i];
    ++count;
  }
  double others = count > 0 ? sum / count : 0;
  const std::size_t beside = wheel ^ 1U;
  if (contains(driven, beside)) others = std::min(others, load[beside]);
  return std::max(others, p.loaded_current);
}

}  // namespace

PerWheel<double> lower_than_others_m(const PerWheel<double>& z_m) noexcept {
  // A plane through all six, least squares; what is left of one, without it in the plane.
  constexpr PerWheel<double> kAlong = {1, 1, 0, 0, -1, -1}, kAcross = {-1, 1, -1, 1, -1, 1};
  constexpr double kLevel = kWheels, kPitch = 4, kRoll = kWheels;  // sums of squares
  double level = 0, pitch = 0, roll = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    level += z_m[i] / kLevel;
    pitch += z_m[i] * kAlong[i] / kPitch;
    roll += z_m[i] * kAcross[i] / kRoll;
  }
  PerWheel<double> lower_m{};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const double own = 1 / kLevel + kAlong[i] * kAlong[i] / kPitch + 1 / kRoll;
    lower_m[i] = (z_m[i] - level - pitch * kAlong[i] - roll * kAcross[i]) / (1 - own);
  }
  return lower_m;
}

double sink_strain_limit(double lower_m, const Parameters& p) noexcept {
  const double deep = (lower_m / p.sink_m - 1) / (p.sink_deep - 1);
  return std::lerp(p.sink_strain, p.sink_strain_deep, std::clamp(deep, 0.0, 1.0));
}

// Dug in is a wheel that is lower than the plane of the others, by the suspension, whose motor
// pushes harder than theirs, while the rover loses speed; over half a second, longer than over a
// bump. No one of them is enough:
// - All wheels are ordered to the same speed: slip does not show which one sinks. The depth does,
//   but any hole of the ground has it.
// - A wheel in soil pushes against what is in front of it and shears over more of its rim. Uphill
//   all of them shear as much as the soil carries, and the ratio falls: the deeper the wheel is,
//   the less is asked for. Weight is on the rear wheels then and the middle ones push little, so
//   the others are their mean or, where that is less, the wheel beside it.
// - Out of a hole of hard ground a wheel pushes, too, but there hardly any speed is lost.
// On the way back a wheel is not judged until it is out.
void MobilityController::watch_sinking(const Inputs& inputs, const Motion& motion,
                                       Command& command) noexcept {
  const Parameters& p = parameters_;
  SinkWatch& w = state_.sinking;
  if (!inputs.rocker || state_.mode != Mode::running) {
    w = {.held = w.held, .way = w.way};
    return;
  }
  const double gain = kFrame_s / p.sink_filter_s;
  const PerWheel<double> lower_m = lower_than_others_m(state_.poses.z_m);
  WheelSet driven = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    w.lower_m[i] += (lower_m[i] - w.lower_m[i]) * gain;
    if (lower_m[i] < p.sink_m / 2) w.held &= ~only(i);
    const Sensor& load = inputs.wheels[i].load;
    if (state_.wheels[i].service != WheelService::engaged || !load.usable) continue;
    w.load[i] += (load.value - w.load[i]) * gain;
    driven |= only(i);
  }
  const auto lowest = std::max_element(w.lower_m.begin(), w.lower_m.end());
  const auto i = static_cast<std::size_t>(lowest - w.lower_m.begin());
  const double strain = w.load[i] / others_load(w.load, driven, i, p);
  const double limit = sink_strain_limit(*lowest, p);
  const bool back = contains(w.held, i) && motion.mean.v_m_s * w.way < 0;
  const bool digs = *lowest > p.sink_m && contains(driven, i) && strain > limit &&
                    slip_share(state_.slip_speed, p) > p.sink_slip && !back;
  w.frames = digs ? std::min(w.frames + 1, kFrames) : 0;
  if (w.frames < kFrames) return;
  w.held |= only(i);
  w.way = motion.mean.v_m_s;
  command.faults |= kWheelSinks;
  command.sinking = only(i);
  command.estimate.sunk_m = *lowest;
  command.estimate.strain = strain;
  command.estimate.strain_limit = limit;
}

}  // namespace lss::gnc::ardito
