#include "tools/lss-sim/ardito/train.h"

#include <algorithm>
#include <cmath>

namespace lss::sim::ardito {
namespace {

// Friction of the gear at the wheel; additional friction of an undriven motor; holding torque of a
// blocked shaft.
constexpr double kGear_Nm = 0.5, kCoast_Nm = 1.2, kBlocked_Nm = 100;
constexpr double kStill_rad_s = 1.0;
constexpr double kAlone_s = 0.02;  // time constant of a motor without load
constexpr double kRundown_s = 0.3;
constexpr double kCurrent_s = 0.008;  // of the winding and the filter of its sensor
constexpr double kLeastLink_V = 8;

constexpr double kAmbient_degC = 25, kThermal_K_W = 2.2, kCapacity_J_K = 180;

constexpr double kSteering_Nm = 20, kLocked_Nm = 40, kLoose_Nm = 0.5;
constexpr double kSteeringEfficiency = 0.6;

void approach(double& value, double goal, double time_s) {
  value += (goal - value) * std::min(1.0, kStep_s / time_s);
}

}  // namespace

namespace motor {

double no_load_A(double speed_rad_s) {
  constexpr double kStill_A = 0.20, kSpeed_A_rad_s = 0.0008;
  const double fade = std::min(1.0, std::abs(speed_rad_s) / 5);
  return (kStill_A + kSpeed_A_rad_s * std::abs(speed_rad_s)) * fade;
}

double torque_limit_Nm(double speed_rad_s, double link_V) {
  const double left_V = link_V - std::abs(speed_rad_s) * kTorque_Nm_A;
  const double current_A = std::clamp(left_V / kResistance_Ohm, 0.0, kLimit_A);
  const double usable_A = std::max(0.0, current_A - no_load_A(speed_rad_s));
  return std::max(0.0, usable_A * kTorque_Nm_A * kGear * kEfficiency - kGear_Nm);
}

}  // namespace motor

bool WheelTrain::connected() const {
  if (gear_fault == GearFault::loose || clutch_fault == ClutchFault::open) return false;
  return clutch_ordered || clutch_fault == ClutchFault::closed;
}

ShaftDrive WheelTrain::step(const MotorOrder& order, const ShaftState& wheel, double link_V) {
  coupled_ = connected();
  at_limit_ = false;
  const bool driven = order.on && motor_fault == MotorFault::none && link_V > kLeastLink_V;
  const bool wanting = driven && std::abs(order.velocity_rad_s) > kStill_rad_s;
  heat();
  if (gear_fault == GearFault::jammed) {
    if (coupled_) {
      motor_rad_s_ = 0;
      at_limit_ = wanting;
      const double stall_A = wanting ? std::copysign(motor::kLimit_A, order.velocity_rad_s) : 0;
      approach(current_A_, stall_A, kCurrent_s);
    } else {
      turn_alone(driven, order.velocity_rad_s);
    }
    return {.velocity_rad_s = 0, .torque_limit_Nm = kBlocked_Nm};
  }
  if (!coupled_) {
    turn_alone(driven, order.velocity_rad_s);
    return {.velocity_rad_s = 0, .torque_limit_Nm = kGear_Nm};
  }
  if (motor_fault == MotorFault::blocked) {
    motor_rad_s_ = 0;
    approach(current_A_, 0, kCurrent_s);
    return {.velocity_rad_s = 0, .torque_limit_Nm = kBlocked_Nm};
  }
  motor_rad_s_ = wheel.velocity_rad_s * kGear;
  if (!driven) {
    approach(current_A_, 0, kCurrent_s);
    return {.velocity_rad_s = 0, .torque_limit_Nm = kCoast_Nm};
  }
  const double limit_Nm = motor::torque_limit_Nm(motor_rad_s_, link_V);
  at_limit_ = std::abs(wheel.torque_Nm) > 0.95 * limit_Nm;
  load(std::clamp(wheel.torque_Nm, -limit_Nm, limit_Nm));
  return {.velocity_rad_s = order.velocity_rad_s / kGear, .torque_limit_Nm = limit_Nm};
}

// The gear has losses in both directions.
void WheelTrain::load(double torque_Nm) {
  const bool stands = std::abs(motor_rad_s_) < kStill_rad_s;
  const double way = std::clamp(stands ? torque_Nm / kGear_Nm : motor_rad_s_, -1.0, 1.0);
  const double before_Nm = torque_Nm + kGear_Nm * way;
  const bool drives = before_Nm * motor_rad_s_ >= 0;
  const double at_motor_Nm =
      before_Nm / kGear * (drives ? 1 / motor::kEfficiency : motor::kEfficiency);
  const double wanted_A =
      at_motor_Nm / motor::kTorque_Nm_A + std::copysign(motor::no_load_A(motor_rad_s_), way);
  approach(current_A_, std::clamp(wanted_A, -motor::kLimit_A, motor::kLimit_A), kCurrent_s);
}

void WheelTrain::turn_alone(bool driven, double wanted_rad_s) {
  if (motor_fault == MotorFault::blocked) motor_rad_s_ = 0;
  approach(motor_rad_s_, driven ? wanted_rad_s : 0, driven ? kAlone_s : kRundown_s);
  const double alone_A = std::copysign(motor::no_load_A(motor_rad_s_), motor_rad_s_);
  approach(current_A_, driven ? alone_A : 0, kCurrent_s);
}

void WheelTrain::heat() {
  const double power_W = current_A_ * current_A_ * motor::kResistance_Ohm;
  const double lost_W = (temperature_degC_ - kAmbient_degC) / kThermal_K_W;
  temperature_degC_ += (power_W - lost_W) / kCapacity_J_K * kStep_s;
}

ShaftDrive SteeringTrain::step(const MotorOrder& order, const ShaftState& shaft, double link_V) {
  const bool driven = order.on && motor_fault == MotorFault::none && link_V > kLeastLink_V;
  const bool jammed = gear_fault == GearFault::jammed;
  double torque_Nm = 0;
  if (gear_fault == GearFault::loose) {
    if (driven) motor_rad_ += order.velocity_rad_s * kStep_s;
  } else {
    motor_rad_ = shaft.angle_rad * kGear;
    if (driven) torque_Nm = shaft.torque_Nm;
    if (driven && jammed && std::abs(order.velocity_rad_s) > kStill_rad_s) {
      torque_Nm = std::copysign(kSteering_Nm, order.velocity_rad_s);
    }
  }
  const double wanted_A = std::clamp(torque_Nm, -kSteering_Nm, kSteering_Nm) /
                          (kGear * kSteeringEfficiency) / motor::kTorque_Nm_A;
  approach(current_A_, wanted_A, kCurrent_s);
  if (jammed) return {.velocity_rad_s = 0, .torque_limit_Nm = kBlocked_Nm};
  if (gear_fault == GearFault::loose) return {.velocity_rad_s = 0, .torque_limit_Nm = kLoose_Nm};
  if (!driven) return {.velocity_rad_s = 0, .torque_limit_Nm = kLocked_Nm};
  return {.velocity_rad_s = order.velocity_rad_s / kGear, .torque_limit_Nm = kSteering_Nm};
}

}  // namespace lss::sim::ardito
