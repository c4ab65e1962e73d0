#include "gnc/ardito/slip.h"

#include <algorithm>
#include <cmath>

#include "gnc/ardito/mobility_controller.h"

namespace lss::gnc::ardito {
namespace {

constexpr std::uint32_t kSlowFrames = 5;  // with more slip than allowed, before it slows down
constexpr double kRolls = 0.8;            // times slip_load: motors that push less roll easily

}  // namespace

// Of the motors that drive: how hard they push against the ground, positive along their motion.
double MobilityController::mean_load(const Inputs& inputs) const noexcept {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const bool driven = state_.wheels[i].service == WheelService::engaged;
    if (!driven || !inputs.wheels[i].load.usable) continue;
    sum += inputs.wheels[i].load.value;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

// Wheels and IMU contradict each other. The rover turns as the wheels say, and by far more than its
// speed fits: the IMU's speed is wrong. It does not turn, or its motors push against the ground in
// the sense of the slip: the wheels slip. All other contradictions are the IMU's (watch_imu).
// Judged by the sums over all frames of the contradiction.
void MobilityController::watch_slip(const Inputs& inputs, const Motion& motion,
                                    Command& command) noexcept {
  SlipWatch& w = state_.slip;
  const double load = mean_load(inputs);
  command.estimate.load = load;
  command.estimate.slip_m_s = motion.slip_m_s;
  const double v = motion.mean.v_m_s * motion.v_to_hub;
  const bool lost = std::abs(v) > parameters_.slip_speed_m_s &&
                    motion.slip_m_s * v > parameters_.slip_share * v * v;
  const bool begins = drives(state_.mode) || w.frames > 0;  // it goes on while they slow down
  if (!inputs.imu.usable || !begins || !(lost || motion.imu_contradicts)) {
    w = {};
    return;
  }
  w.frames = std::min(w.frames + 1, 1000000U);
  w.stuck_frames = lost ? std::min(w.stuck_frames + 1, 1000000U) : 0;
  w.load += load;
  w.wheels_m_s += std::abs(v);
  w.imu_m_s += std::sqrt((v - motion.slip_m_s) * (v - motion.slip_m_s) +
                         motion.sliding_m_s * motion.sliding_m_s);
  const double yaw_rad_s = yaw_rate_rad_s(motion.mean, parameters_.geometry);
  w.wheels_yaw_rad_s += yaw_rad_s;
  w.imu_yaw_rad_s += inputs.imu.yaw_rate_rad_s.value;

  const double pushing = w.load * (motion.slip_m_s * v > 0 ? 1 : -1);
  const bool spot = motion.v_to_hub != 1;  // there the yaw rate is what is in question
  const bool along = lost || std::abs(motion.slip_m_s) > motion.sliding_m_s;  // not sideways
  // Wheels that push and lose speed lose their hold sideways, too: as far as half of a right angle.
  const double ahead = (v - motion.slip_m_s) * (v > 0 ? 1 : -1);
  const bool slides = !along && motion.sliding_m_s < ahead &&
                      w.load > parameters_.slip_load * w.frames &&
                      w.wheels_m_s - w.imu_m_s > parameters_.slide_lost_share * w.wheels_m_s;
  bool wheels = slides || (along && pushing > parameters_.slip_load * w.frames);
  // now and in those frames: on a straight after a curve the yaw rate shows nothing
  const double turning_rad_s =
      std::min(std::abs(yaw_rad_s), std::abs(w.wheels_yaw_rad_s) / w.frames);
  if (!spot && turning_rad_s > parameters_.turning_rad_s) {
    // Wheels that slip lose yaw rate and speed together; uphill on soil more speed than yaw rate.
    const double share = w.imu_yaw_rad_s / w.wheels_yaw_rad_s;
    const double speed_share = 1 - motion.slip_m_s / v;
    if (share < 0.35) wheels = true;
    if (share > 0.65 && share - speed_share > 0.35) wheels = false;
  }
  if (!wheels) return;
  command.faults |= kWheelsSlip;
  if (w.stuck_frames >= parameters_.stuck_frames) command.faults |= kStuck;
}

double slip_share(const SlipSpeed& slip, const Parameters& parameters) noexcept {
  const bool measured = slip.wheels_m_s > parameters.slip_speed_m_s;
  return measured ? slip.lost_m_s / slip.wheels_m_s : 0;
}

// How much of the wheels' speed is lost, and whether that is more than allowed. Motors that roll
// easily do not slip, even if the IMU reports a lower speed. Single frames without an IMU change
// nothing.
void MobilityController::measure_slip(const Inputs& inputs, const Motion& motion,
                                      Command& command) noexcept {
  const Parameters& p = parameters_;
  SlipSpeed& s = state_.slip_speed;
  if (!drives(state_.mode)) {
    s = {};
    return;
  }
  if (!inputs.imu.usable || (command.faults & kImuImplausible) != 0) {
    s.unmeasured = std::min(s.unmeasured + 1, p.imu_frames);
    if (s.unmeasured >= p.imu_frames) s = {.factor = s.factor, .unmeasured = s.unmeasured};
    if (s.factor < 1) command.faults |= kSlipSlows;
    return;
  }
  s.unmeasured = 0;
  const double v = motion.mean.v_m_s * motion.v_to_hub, gain = kFrame_s / p.slow_filter_s;
  s.lost_m_s += ((v > 0 ? motion.slip_m_s : -motion.slip_m_s) - s.lost_m_s) * gain;
  s.wheels_m_s += (std::abs(v) - s.wheels_m_s) * gain;
  s.load += (command.estimate.load - s.load) * gain;
  const double share = slip_share(s, p);
  const bool above = share > p.slow_share && s.load > p.slip_load;
  // a rover that is about to be found stuck stops: until then it is not slowed
  if (!above || state_.slip.stuck_frames == 0)
    s.above = above ? std::min(s.above + 1, kSlowFrames) : 0;
  if (s.above >= kSlowFrames) s.slows = 1;
  if (share < p.slow_share - p.slow_hysteresis || s.load < kRolls * p.slip_load) s.slows = 0;
  if (s.slows != 0) command.faults |= kWheelsSlip;  // also when slow wheels lose little
  if (s.factor < 1) command.faults |= kSlipSlows;
}

// The factor of the requested speed, on its way to what measure_slip() found. A stop does not wait
// for it: then nothing is requested. The way back is another drive.
void MobilityController::slow_by_slip(const PlaneMotion& target) noexcept {
  const Parameters& p = parameters_;
  SlipSpeed& s = state_.slip_speed;
  if (!drives(state_.mode) || target.v_m_s * state_.v_m_s < 0) {
    s = {};
    return;
  }
  const double asked_m_s = std::abs(target.v_m_s) * v_to_hub(target.direction, p);
  double aim = 1;
  if (s.slows != 0 && asked_m_s > p.slow_least_m_s) {
    aim = std::max(p.slow_factor, p.slow_least_m_s / asked_m_s);
  }
  const double step = p.slow_rate_1_s * kFrame_s;
  s.factor = std::clamp(aim, s.factor - step, s.factor + step);
}

}  // namespace lss::gnc::ardito
