#include <algorithm>
#include <cmath>

#include "gnc/ardito/fmeda.h"

namespace lss::gnc::ardito {
namespace {

double no_load_current(double speed_rad_s, const Parameters& p) noexcept {
  const auto& x = p.no_load_rad_s;
  const auto& y = p.no_load_current;
  if (speed_rad_s <= x[0]) return y[0];
  for (std::size_t i = 1; i < kNoLoadPoints; ++i) {
    if (speed_rad_s < x[i]) {
      return y[i - 1] + (y[i] - y[i - 1]) * (speed_rad_s - x[i - 1]) / (x[i] - x[i - 1]);
    }
  }
  return y[kNoLoadPoints - 1];
}

const Sensor& motor_speed(const WheelSensors& s) noexcept {
  return s.motor.usable ? s.motor : s.hall;
}

void back_to_watch(WheelHealth& h, std::uint32_t pause) noexcept {
  h.test = ClutchTest::watch;
  h.quiet = 0;
  h.probed = 0;
  h.pause = pause;
  h.drift_rad = 0;
  h.astray_rad_s = 0;
}

bool at_no_load(double load, const Parameters& p) noexcept {
  return std::abs(load) <= p.no_load_tolerance;
}

}  // namespace

Sensor load_current(const WheelInputs& inputs, const Parameters& p) noexcept {
  const Sensor& motor = motor_speed(inputs.sensors);
  const double speed = motor.usable ? motor.value : (inputs.ordered.low + inputs.ordered.high) / 2;
  if (!inputs.current.usable || std::abs(speed) < p.clutch_min_rad_s) return {};
  const double forward = std::copysign(inputs.current.value, inputs.current.value * speed);
  return {forward - no_load_current(std::abs(speed), p), true};
}

double probe_speed_rad_s(double ordered_rad_s, const Parameters& p) noexcept {
  const double slower = std::max(p.probe_share * std::abs(ordered_rad_s), p.probe_rad_s);
  return std::copysign(std::max(std::abs(ordered_rad_s) - slower, 0.0), ordered_rad_s);
}

std::uint32_t test_clutch(WheelHealth& h, const WheelInputs& in, const WheelEvidence& evidence,
                          const Parameters& p) noexcept {
  const Sensor& load = in.load;
  if (h.test == ClutchTest::watch) {
    if (h.pause > 0) --h.pause;
    const bool testable = evidence.counts && evidence.rover_drives && evidence.others_loaded &&
                          load.usable && h.pause == 0 && h.candidate == 0;
    // no current at all is suspect, too: the drive may be dead and the wheel dragged along
    const bool quiet =
        testable && load.value <= p.no_load_tolerance &&
        load.value >= -p.no_load_tolerance - no_load_current(std::abs(in.ordered.high), p);
    if (!quiet) {
      h.quiet = 0;
      return 0;
    }
    ++h.quiet;
    if (h.quiet >= p.quiet_frames && !evidence.other_probe) {
      back_to_watch(h, 0);
      h.test = ClutchTest::probe;
    }
    return 0;
  }

  if (!evidence.counts || !evidence.rover_drives) {
    back_to_watch(h, 0);
    return 0;
  }
  ++h.probed;
  const WheelSensors& s = in.sensors;
  const Sensor& motor = motor_speed(s);
  if (motor.usable && s.reduction.usable) {
    h.drift_rad += (motor.value - s.reduction.value) * kFrame_s;
  }
  if (!load.usable || at_no_load(load.value, p)) ++h.quiet;
  const std::uint32_t frames = s.reduction.usable ? p.probe_frames : 2 * p.probe_frames;
  if (h.probed > frames / 2 && motor.usable) {
    h.astray_rad_s += distance(in.ordered, motor.value);
  }
  if (h.probed < frames) return 0;

  const double astray = h.astray_rad_s / (frames - frames / 2);
  const double drift = std::abs(h.drift_rad);
  const bool no_load = h.quiet + 1 >= frames;
  back_to_watch(h, p.probe_pause_frames);
  // coupled to the rover, and does not follow its drive: the drive moves nothing
  if (motor.usable && astray >= p.probe_rad_s / 2) return kMotor;
  if (s.reduction.usable) return drift > p.clutch_drift_rad ? kClutch : 0U;
  return in.current.usable && no_load ? kClutch : 0U;
}

}  // namespace lss::gnc::ardito
