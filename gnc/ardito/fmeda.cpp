#include "gnc/ardito/fmeda.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::ardito {
namespace {

constexpr std::uint32_t kDrive = kMotor | kReduction;

std::uint32_t up(std::uint32_t count) noexcept { return std::min(count + 1, 1000000U); }
std::uint32_t down(std::uint32_t count) noexcept { return count > 0 ? count - 1 : 0; }

std::uint32_t sensors_in(std::uint32_t parts) noexcept {
  return (parts & 1U) + ((parts >> 1) & 1U) + ((parts >> 2) & 1U);
}

// Frames for which these parts must be suspected before they are lost.
std::uint32_t frames_for(std::uint32_t parts, std::uint32_t lost, const Parameters& p) noexcept {
  if (sensors_in(parts | lost) == 3 && sensors_in(parts) > 0) return p.all_sensors_frames;
  if ((parts & kDrive) != 0) return p.motor_frames;
  if ((parts & kClutch) != 0) return p.clutch_frames;
  return sensors_in(parts) >= 2 ? p.two_sensors_frames : p.sensor_frames;
}

// When the IMU or the motor's load contradicts the reduction encoder, the encoder has failed, not
// the clutch (17.8.1).
std::uint32_t corrected(std::uint32_t parts, const WheelInputs& in, const WheelEvidence& evidence,
                        const Parameters& p) noexcept {
  if ((parts & kClutch) == 0) return parts;
  const bool loaded = in.load.usable && std::abs(in.load.value) > 2 * p.no_load_tolerance;
  if (!loaded && !evidence.imu_contradicts) return parts;
  return (parts & ~static_cast<std::uint32_t>(kClutch)) | kReductionEncoder;
}

void isolate(WheelHealth& h) noexcept {
  h.service = WheelService::isolated;
  h.candidate = 0;
  h.count = 0;
  h.test = ClutchTest::watch;
  h.quiet = 0;
}

void lose(WheelHealth& h, std::uint32_t parts) noexcept {
  h.lost |= parts;
  h.candidate = 0;
  h.count = 0;
  if ((parts & kReduction) != 0 || sensors_in(h.lost) == 3 || (parts & kClutch) != 0) {
    isolate(h);
  } else if ((parts & kMotor) != 0) {
    h.service = WheelService::testing;
    h.service_frames = 0;
  }
}

// Temperature, current and the drive's own fault need no table.
bool motor_unfit(WheelHealth& h, const WheelInputs& in, const Parameters& p) noexcept {
  const bool over = in.current.usable && std::abs(in.current.value) > p.max_current;
  h.overcurrent = over ? up(h.overcurrent) : down(h.overcurrent);
  const bool hot = in.temperature_C.usable && in.temperature_C.value > p.max_temperature_C;
  h.hot = hot ? up(h.hot) : down(h.hot);
  return in.drive_fault || h.hot >= p.sensor_frames || h.overcurrent >= p.overcurrent_frames;
}

// The clutch just opened under a motor that did not turn. If it turns now, the gear was blocked.
WheelFailure test_motor(WheelHealth& h, const WheelInputs& in, const Parameters& p) noexcept {
  const auto follows = [&](const Sensor& s) {
    const double wanted = (in.ordered.low + in.ordered.high) / 2;
    return s.usable && std::abs(wanted) >= p.still_rad_s && agree(wanted, s.value, p);
  };
  ++h.service_frames;
  if (follows(in.sensors.motor) || follows(in.sensors.hall)) {
    h.lost = (h.lost & ~static_cast<std::uint32_t>(kMotor)) | kReduction;
    isolate(h);
  } else if (h.service_frames >= p.motor_test_frames) {
    isolate(h);
  }
  const Sensor& r = in.sensors.reduction;
  const bool still = r.usable && std::abs(r.value) < p.still_rad_s;
  return still ? WheelFailure::reduction : failure_of(h.lost);
}

// With an open clutch only one check is left: does the wheel roll with the rover?
WheelFailure watch_isolated(WheelHealth& h, const WheelInputs& in, bool counts,
                            const Parameters& p) noexcept {
  const double expected = std::min(std::abs(in.ordered.low), std::abs(in.ordered.high));
  const Sensor& r = in.sensors.reduction;
  const bool stuck = counts && r.usable && (h.lost & kReduction) == 0 && expected >= p.slow_rad_s &&
                     std::abs(r.value) < p.still_rad_s;
  if (!stuck) {
    if (counts) h.count = 0;
    return failure_of(h.lost);
  }
  h.count = up(h.count);
  if (h.count >= p.reduction_frames) {
    h.lost |= kReduction;
    h.error = 1;
  }
  return WheelFailure::reduction;
}

// Failures that end driving when they last (18.1, states 4 and 8).
void count_error(WheelHealth& h, const Parameters& p) noexcept {
  const WheelFailure failure = failure_of(h.lost);
  std::uint32_t frames = 0;
  if (failure == WheelFailure::reduction) frames = p.reduction_frames;
  if (failure == WheelFailure::all_sensors) {
    frames = p.all_sensors_error_frames - p.all_sensors_frames;
  }
  if (frames == 0) return;
  h.error_frames = up(h.error_frames);
  if (h.error_frames >= frames) h.error = 1;
}

}  // namespace

WheelLook look_at_wheel(const WheelInputs& in, const WheelHealth& h, const Parameters& p) noexcept {
  const WheelSensors& s = in.sensors;
  const unsigned flags = wheel_flags(in.ordered, s, p);
  double nearest = std::numeric_limits<double>::infinity();
  if (flags == kAllDiffer) {  // used in this case only
    for (const Sensor& sensor : {s.motor, s.hall, s.reduction}) {
      if (sensor.usable) nearest = std::min(nearest, distance(in.ordered, sensor.value));
    }
  }
  const double rho = s.reduction.usable ? std::abs(s.reduction.value) : 0;
  WheelLook look;
  // without a reduction encoder nothing is known of the parts behind an open clutch
  const bool engaged = h.service == WheelService::engaged || !s.reduction.usable;
  look.verdict = diagnose_wheel(flags, engaged, rho, nearest, p);
  look.fresh_parts = look.verdict.parts & ~h.lost;
  return look;
}

WheelFailure update_wheel(WheelHealth& h, const WheelLook& look, const WheelInputs& in,
                          const WheelEvidence& evidence, const Parameters& p) noexcept {
  count_error(h, p);
  if (h.service == WheelService::isolated) {
    return watch_isolated(h, in, evidence.counts, p);
  }
  if (!evidence.counts) {
    h.candidate = 0;
    h.count = 0;
    test_clutch(h, in, evidence, p);
    return failure_of(h.lost);
  }
  if (h.service == WheelService::testing) return test_motor(h, in, p);

  if (motor_unfit(h, in, p)) {
    if ((h.candidate & kDrive) == 0) h.count = 0;
    h.candidate = kMotor;
    h.count = up(h.count);
    if (h.count >= p.motor_frames) {
      lose(h, kMotor);
      isolate(h);
    }
    return failure_of(h.lost | kMotor);  // its sensors may be silent with it
  }
  const std::uint32_t by_load = test_clutch(h, in, evidence, p);
  if (by_load != 0) {
    lose(h, by_load);
    isolate(h);
    return failure_of(h.lost);
  }

  if (look.verdict.outcome != Outcome::failure) {
    h.inconclusive = look.verdict.outcome == Outcome::inconclusive ? up(h.inconclusive) : 0;
    return failure_of(h.lost | h.candidate);
  }
  h.inconclusive = 0;
  const std::uint32_t parts = corrected(look.fresh_parts, in, evidence, p) & ~h.lost;
  if (parts == 0) {
    h.count = down(h.count);
    if (h.count == 0) h.candidate = 0;
    const bool contradictory =
        look.verdict.failure != WheelFailure::none && look.verdict.parts == 0;
    return contradictory ? look.verdict.failure : failure_of(h.lost);
  }
  const bool goes_on =
      parts == h.candidate || ((parts & kDrive) != 0 && (h.candidate & kDrive) != 0);
  if (!goes_on) h.count = 0;
  h.candidate = parts;
  // the whole rover may be blocked: a motor is only blamed when the others move (18.1)
  if ((parts & kDrive) == 0 || evidence.incoherent) h.count = up(h.count);
  const WheelFailure suspect = failure_of(h.lost | parts);
  if (h.count >= frames_for(parts, h.lost, p)) lose(h, parts);
  return suspect;
}

SteeringFailure failure_of(const SteeringHealth& h) noexcept {
  if (h.lost == 3) return SteeringFailure::both_encoders;
  if (h.critical != 0) return SteeringFailure::critical;
  if (h.lost == 1) return SteeringFailure::motor_encoder;
  return h.lost == 2 ? SteeringFailure::reduction_encoder : SteeringFailure::none;
}

namespace {

// Stores both encoders for the next frame.
SteeringFailure compare_steps(SteeringHealth& h, const SteeringInputs& in,
                              const Parameters& p) noexcept {
  const bool both = in.motor.usable && in.reduction.usable;
  SteeringFailure found = SteeringFailure::none;
  if (both && h.compared != 0) {
    const double middle = (h.motor_rad + h.reduction_rad) / 2;
    const double asked = std::abs(in.ordered.high - middle) > std::abs(in.ordered.low - middle)
                             ? in.ordered.high
                             : in.ordered.low;
    found = standing_encoder(in.motor.value - h.motor_rad, in.reduction.value - h.reduction_rad,
                             asked - middle, p);
  }
  h.compared = both ? 1 : 0;
  h.motor_rad = in.motor.value;
  h.reduction_rad = in.reduction.value;
  return found;
}

}  // namespace

SteeringFailure update_steering(SteeringHealth& h, const SteeringInputs& in, bool counts,
                                const Parameters& p) noexcept {
  const SteeringFailure stands = compare_steps(h, in, p);
  const bool over = in.current.usable && std::abs(in.current.value) > p.max_steering_current;
  h.overcurrent = over ? up(h.overcurrent) : down(h.overcurrent);
  if (!counts) {
    h.candidate = SteeringFailure::none;
    h.count = 0;
    return failure_of(h);
  }
  SteeringVerdict verdict =
      diagnose_steering(steering_flags(in.ordered, in.motor, in.reduction, p));
  if (in.drive_fault || h.overcurrent >= p.overcurrent_frames) {
    verdict = {Outcome::failure, SteeringFailure::critical};
  }
  if (verdict.failure == SteeringFailure::none && stands != SteeringFailure::none) {
    verdict = {.outcome = Outcome::failure, .failure = stands};
  }
  if (verdict.outcome != Outcome::failure) return std::max(failure_of(h), h.candidate);
  const SteeringFailure found = verdict.failure;
  // a lost encoder keeps disagreeing
  if (found == SteeringFailure::none || found <= failure_of(h)) {
    h.count = down(h.count);
    if (h.count == 0) h.candidate = SteeringFailure::none;
    return failure_of(h);
  }
  if (found != h.candidate) h.count = 0;
  h.candidate = found;
  h.count = up(h.count);
  const bool encoder =
      found == SteeringFailure::motor_encoder || found == SteeringFailure::reduction_encoder;
  if (h.count >= (encoder ? p.steering_encoder_frames : p.steering_frames)) {
    if (found == SteeringFailure::motor_encoder) h.lost |= 1U;
    if (found == SteeringFailure::reduction_encoder) h.lost |= 2U;
    if (found == SteeringFailure::critical) h.critical = 1;
    if (found == SteeringFailure::both_encoders) h.lost = 3;
    if (!encoder) h.error = 1;
    h.candidate = SteeringFailure::none;
    h.count = 0;
  }
  return found;
}

}  // namespace lss::gnc::ardito
