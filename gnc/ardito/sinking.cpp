// One wheel that digs itself in while the others hold: a stage of MobilityController.

#include <algorithm>
#include <cmath>
#include <limits>

#include "gnc/ardito/mobility_controller.h"
#include "gnc/ardito/slip.h"

namespace lss::gnc::ardito {
namespace {

constexpr std::uint32_t kFrames = 4;  // in a row, before the wheel counts as dug in
constexpr double kUnknownWay = 2;     // SinkWatch::way

// Least share of the median of what the pushing ones push: a motor that pushes less belongs to a
// wheel that carries nothing, over a hole or on its way down from a rock, and says nothing of the
// ground.
constexpr double kCarries = 0.4;

// What the load of this wheel's motor is compared with, of the other wheels that drive and carry:
// their mean or, where that is less, the wheel beside it. None carries: the least load that means
// anything, loaded_current.
double others_load(const PerWheel<double>& load, WheelSet driven, std::size_t wheel,
                   const Parameters& p) noexcept {
  PerWheel<double> pushing;
  pushing.fill(std::numeric_limits<double>::infinity());  // the others, behind those that push
  std::size_t count = 0;
  for (std::size_t i = 0; i < kWheels; ++i)
    if (i != wheel && contains(driven, i) && load[i] > 0) pushing[count++] = load[i];
  if (count == 0) return p.loaded_current;
  std::ranges::sort(pushing);
  const double carries = kCarries * pushing[count / 2];
  double sum = 0, carrying = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (pushing[i] <= carries) continue;
    sum += pushing[i];
    ++carrying;
  }
  double others = sum / carrying;
  // Uphill the middle wheels push little, also where they carry.
  const std::size_t beside = wheel ^ 1U;
  if (contains(driven, beside) && load[beside] > std::min(carries, p.loaded_current))
    others = std::min(others, load[beside]);
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
// Against the way that it went in by a wheel is not judged until it is out, nor when nobody saw it
// go in: out of soil it would look the same.
void MobilityController::watch_sinking(const Inputs& inputs, const Motion& motion,
                                       Command& command) noexcept {
  const Parameters& p = parameters_;
  SinkWatch& w = state_.sinking;
  if (!inputs.rocker || state_.mode != Mode::running) {
    w.running = 0;
    return;
  }
  const bool begins = w.running == 0;
  if (begins) {
    w.frames = {};
    w.load = {};
  }
  w.running = 1;
  const double gain = kFrame_s / p.sink_filter_s, v_m_s = motion.mean.v_m_s;
  const PerWheel<double> lower_m = lower_than_others_m(state_.poses.z_m);
  WheelSet driven = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    w.lower_m[i] += (lower_m[i] - w.lower_m[i]) * (begins ? 1 : gain);
    if (w.lower_m[i] < p.sink_m / 2) {
      w.way[i] = 0;
    } else if (w.way[i] == 0) {
      w.way[i] = begins ? kUnknownWay : std::copysign(1, v_m_s);
    }
    const Sensor& load = inputs.wheels[i].load;
    if (state_.wheels[i].service != WheelService::engaged || !load.usable) continue;
    w.load[i] += (load.value - w.load[i]) * gain;
    driven |= only(i);
  }
  const bool slips = slip_share(state_.slip_speed, p) > p.sink_slip;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const double strain = w.load[i] / others_load(w.load, driven, i, p);
    const double limit = sink_strain_limit(w.lower_m[i], p);
    const bool out = w.way[i] == kUnknownWay || w.way[i] * v_m_s < 0;
    const bool digs =
        w.lower_m[i] > p.sink_m && contains(driven, i) && strain > limit && slips && !out;
    w.frames[i] = digs ? std::min(w.frames[i] + 1, kFrames) : 0;
    const bool deepest = command.sinking == 0 || w.lower_m[i] > command.estimate.sunk_m;
    if (w.frames[i] < kFrames || !deepest) continue;
    command.faults |= kWheelSinks;
    command.sinking = only(i);
    command.estimate.sunk_m = w.lower_m[i];
    command.estimate.strain = strain;
    command.estimate.strain_limit = limit;
  }
}

}  // namespace lss::gnc::ardito
