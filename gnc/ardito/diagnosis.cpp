#include "gnc/ardito/diagnosis.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::ardito {
namespace {

bool differ(const Ordered& ordered, const Sensor& sensor, const Parameters& p) noexcept {
  return !sensor.usable ||
         !agree(std::clamp(sensor.value, ordered.low, ordered.high), sensor.value, p);
}

bool differ(const Sensor& a, const Sensor& b, const Parameters& p) noexcept {
  return !a.usable || !b.usable || !agree(a.value, b.value, p);
}

unsigned bit(bool flag, unsigned place) noexcept { return flag ? 1U << place : 0U; }

WheelVerdict lost(std::uint32_t parts) noexcept {
  return {Outcome::failure, failure_of(parts), parts};
}
// TM while the clutch transmits; with the clutch open a wheel that does not turn is TRG (E16).
WheelVerdict motor_or_reduction(bool engaged, bool still, std::uint32_t sensor) noexcept {
  return lost(sensor | (!engaged && still ? kReduction : kMotor));
}

}  // namespace

bool agree(double a_rad_s, double b_rad_s, const Parameters& parameters) noexcept {
  const double difference = std::abs(a_rad_s - b_rad_s);
  return difference < parameters.agree_rad_s ||
         difference < parameters.agree_share * std::max(std::abs(a_rad_s), std::abs(b_rad_s));
}

unsigned wheel_flags(const Ordered& ordered, const WheelSensors& s, const Parameters& p) noexcept {
  // usually all ordered and measured values agree
  if (s.motor.usable && s.hall.usable && s.reduction.usable) {
    const double m = s.motor.value, h = s.hall.value, r = s.reduction.value;
    const double low = std::min(std::min(m, h), std::min(r, ordered.low));
    const double high = std::max(std::max(m, h), std::max(r, ordered.high));
    if (high - low < p.agree_rad_s) return kAllAgree;
  }
  return bit(differ(ordered, s.motor, p), 5) | bit(differ(ordered, s.hall, p), 4) |
         bit(differ(s.hall, s.motor, p), 3) | bit(differ(s.motor, s.reduction, p), 2) |
         bit(differ(s.reduction, s.hall, p), 1) | bit(differ(ordered, s.reduction, p), 0);
}

WheelVerdict diagnose_wheel(unsigned flags, bool clutch_engaged, double rho_rad_s,
                            double nearest_rad_s, const Parameters& p) noexcept {
  const bool silent = rho_rad_s == 0;
  const bool still = rho_rad_s < p.still_rad_s;
  const bool slow = rho_rad_s < p.slow_rad_s;
  switch (flags) {
    case kAllAgree: return lost(0);
    case 0b101100:  // M alone
      return lost(kMotorEncoder);
    case 0b011010:  // H alone
      return lost(kHall);
    case 0b000111:  // R alone
      if (silent && clutch_engaged) return lost(kReductionEncoder);
      return lost(slow ? kReduction : kClutch);
    case 0b110001:  // C alone
      return motor_or_reduction(clutch_engaged, still, 0);
    case 0b110110:  // {C,R} {M,H}: both sensors of the motor, perhaps their supply
      if (!clutch_engaged) return {Outcome::hold};
      return lost(kMotorEncoder | kHall);
    case 0b101011:  // {C,H} {M,R}
      return lost(kMotorEncoder | kReductionEncoder);
    case 0b011101:  // {C,M} {H,R}
      return lost(kHall | kReductionEncoder);
    case 0b101111:  // {C,H} M R
      if (silent) return lost(kMotorEncoder | kReductionEncoder);
      return lost(kMotorEncoder | (slow ? kReduction : kClutch));
    case 0b011111:  // {C,M} H R
      if (silent) return lost(kHall | kReductionEncoder);
      return lost(kHall | (slow ? kReduction : kClutch));
    case 0b111110:  // {C,R} M H
      return lost(kMotorEncoder | kHall);
    case 0b110111:  // {M,H} C R: the motor does not follow
      if (!clutch_engaged) return {Outcome::hold};
      return lost(kMotor);
    case 0b111011:  // {M,R} C H
      return motor_or_reduction(clutch_engaged, still, kHall);
    case 0b111101:  // {H,R} C M
      return motor_or_reduction(clutch_engaged, still, kMotorEncoder);
    case kAllDiffer:
      // no two agree. Which of the sensors that left the ordered values failed is unknown.
      if (nearest_rad_s < p.agree_rad_s) return {Outcome::failure, WheelFailure::two_sensors, 0};
      return lost(kSensors);
    default: return {Outcome::inconclusive};
  }
}

WheelFailure failure_of_any(std::uint32_t parts) noexcept {
  const std::uint32_t sensors = parts & kSensors;
  const int lost_sensors =
      static_cast<int>((sensors & 1U) + ((sensors >> 1) & 1U) + (sensors >> 2));
  if (lost_sensors == 3) return WheelFailure::all_sensors;
  if ((parts & kReduction) != 0) return WheelFailure::reduction;
  if ((parts & kMotor) != 0) return WheelFailure::motor;
  if ((parts & kClutch) != 0) {
    return (sensors & (kMotorEncoder | kHall)) != 0 ? WheelFailure::clutch_and_sensor
                                                    : WheelFailure::clutch;
  }
  if (lost_sensors == 2) return WheelFailure::two_sensors;
  if (sensors == kReductionEncoder) return WheelFailure::reduction_encoder;
  return sensors != 0 ? WheelFailure::motor_sensor : WheelFailure::none;
}

unsigned steering_flags(const Ordered& ordered, const Sensor& motor, const Sensor& reduction,
                        const Parameters& p) noexcept {
  const auto from_ordered = [&](const Sensor& sensor) {
    return !sensor.usable || distance(ordered, sensor.value) >= p.steering_agree_rad;
  };
  const bool apart = !motor.usable || !reduction.usable ||
                     std::abs(motor.value - reduction.value) >= p.steering_agree_rad;
  return bit(from_ordered(motor), 2) | bit(apart, 1) | bit(from_ordered(reduction), 0);
}

SteeringVerdict diagnose_steering(unsigned flags) noexcept {
  switch (flags) {
    case 0b000: return {};
    case 0b110: return {Outcome::failure, SteeringFailure::motor_encoder};
    case 0b011: return {Outcome::failure, SteeringFailure::reduction_encoder};
    case 0b101: return {Outcome::failure, SteeringFailure::critical};
    case 0b111: return {Outcome::failure, SteeringFailure::both_encoders};
    default: return {Outcome::inconclusive};
  }
}

SteeringFailure standing_encoder(double motor_rad, double reduction_rad, double ordered_rad,
                                 const Parameters& p) noexcept {
  const auto stands = [&](double way) { return std::abs(way) < p.steering_step_rad / 5; };
  const auto turns = [&](double way) {
    return std::abs(way) >= p.steering_step_rad && way * ordered_rad > 0;
  };
  if (std::abs(ordered_rad) < p.steering_step_rad) return SteeringFailure::none;
  if (stands(motor_rad) && turns(reduction_rad)) return SteeringFailure::motor_encoder;
  if (turns(motor_rad) && stands(reduction_rad)) return SteeringFailure::reduction_encoder;
  return SteeringFailure::none;
}

}  // namespace lss::gnc::ardito
