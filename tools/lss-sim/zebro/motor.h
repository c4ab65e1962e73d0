#pragma once

// Motor, gear and driver of one module of Lunar Zebro: a Faulhaber 1226-012-B brushless motor with
// a 256:1 planetary gear, as measured in the Zebro thesis, appendix A. SI units at the leg's shaft
// unless said. Pure functions and one small state (heat); one thread.

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lss::sim::zebro {

// Zebro thesis A.2.1 (no load at 12 V: 24,172 rpm, 189 mA), A.2.2 (stall: 860 mN m at 1.7 A),
// A.2.3.
namespace motor {
inline constexpr double kSupply_V = 12.0;
inline constexpr double kResistance_Ohm = 5.45;
inline constexpr double kTorqueConstant_Nm_A = 4.12e-3;
inline constexpr double kGear = 256;
inline constexpr double kCurrentLimit_A = 1.7;  // above it for 20 ms the module stops itself
inline constexpr double kDriverLimit_A = 1.75;  // where the driver chops
inline constexpr double kNoLoad_rpm = 24'172;
inline constexpr double kNoLoad_A = 0.189;
inline constexpr double kGearLimit_rpm = 5'000;
inline constexpr double kRpm_rad_s = 2 * std::numbers::pi / 60;
inline constexpr double kMaxSpeed_rad_s = kGearLimit_rpm * kRpm_rad_s / kGear;  // 117.2 deg/s

// Friction seen by the motor: 0.073 mN m at standstill, growing so that no load at 12 V draws 189
// mA.
inline constexpr double kFriction_Nm = 0.073e-3;
inline constexpr double kFriction_Nm_rpm =
    (kNoLoad_A * kTorqueConstant_Nm_A - kFriction_Nm) / kNoLoad_rpm;
// Voltage loss of the driver's switches and the windings' inductance at no load: the part of the 12
// V that the other terms do not explain.
inline constexpr double kDriverDrop_V =
    kSupply_V - kNoLoad_A * kResistance_Ohm - kNoLoad_rpm * kRpm_rad_s * kTorqueConstant_Nm_A;
// Of four planetary stages under load, from the stall torque: 0.485.
inline constexpr double kStall_Nm = 0.860;
inline constexpr double kEfficiency =
    kStall_Nm / (kGear * (kCurrentLimit_A * kTorqueConstant_Nm_A - kFriction_Nm));
// An undriven gear that loses half of its torque does not turn below about this torque.
inline constexpr double kHold_Nm = 0.300;

inline double motor_rpm(double speed_rad_s) { return std::abs(speed_rad_s) * kGear / kRpm_rad_s; }

inline double friction_Nm(double rpm) { return kFriction_Nm + kFriction_Nm_rpm * rpm; }

// The maximum torque at the leg at this speed: from the current limit, or from the remaining
// voltage.
inline double torque_limit_Nm(double speed_rad_s) {
  const double rpm = motor_rpm(speed_rad_s);
  const double left_V = kSupply_V - kDriverDrop_V - rpm * kRpm_rad_s * kTorqueConstant_Nm_A;
  const double current_A = std::clamp(left_V / kResistance_Ohm, 0.0, kDriverLimit_A);
  const double at_motor_Nm = current_A * kTorqueConstant_Nm_A - friction_Nm(rpm);
  return std::max(0.0, at_motor_Nm * kGear * kEfficiency);
}

// Magnitude of the current that gives this torque to the leg at this speed.
inline double current_A(double torque_Nm, double speed_rad_s) {
  const double rpm = motor_rpm(speed_rad_s);
  const double friction = rpm > 1 ? friction_Nm(rpm) : 0;
  const double at_motor_Nm = std::abs(torque_Nm) / (kGear * kEfficiency) + friction;
  return std::min(at_motor_Nm / kTorqueConstant_Nm_A, kDriverLimit_A);
}
}  // namespace motor

// Two nodes, motor and gear, each with a path to the surroundings and a weak one between them.
// Fitted to table A.1 of the Zebro thesis: half an hour from 22.1 degC gives 33.5 and 31.5 at 5000
// rpm, 39.2 and 32.4 at 10000 rpm without load. The heat of turning is a table in speed, because
// two rows cannot separate copper, iron and bearings; what load adds is computed.
class Heat {
 public:
  static constexpr double kAmbient_degC = 22.1;

  void step(double torque_Nm, double speed_rad_s, double dt_s) {
    const double rpm = motor::motor_rpm(speed_rad_s);
    const double load_A = motor::current_A(torque_Nm, speed_rad_s);
    const double idle_A = motor::current_A(0, speed_rad_s);
    const double copper_W = (load_A * load_A - idle_A * idle_A) * motor::kResistance_Ohm;
    const double gear_W = std::abs(torque_Nm * speed_rad_s) * (1 / motor::kEfficiency - 1);
    const double between_W = kBetween_W_K * (motor_degC_ - gear_degC_);
    motor_degC_ += dt_s / kCapacity_J_K *
                   (turning_W(rpm, kMotor5000_W, kMotor10000_W) + copper_W - between_W -
                    kOutside_W_K * (motor_degC_ - kAmbient_degC));
    gear_degC_ += dt_s / kCapacity_J_K *
                  (turning_W(rpm, kGear5000_W, kGear10000_W) + gear_W + between_W -
                   kOutside_W_K * (gear_degC_ - kAmbient_degC));
  }

  double motor_degC() const { return motor_degC_; }
  double gear_degC() const { return gear_degC_; }
  void set_motor_degC(double temperature_degC) { motor_degC_ = temperature_degC; }

 private:
  // 33.7 g of metal, half each; time constant about six minutes.
  static constexpr double kCapacity_J_K = 7.0;
  static constexpr double kOutside_W_K = 0.020;
  static constexpr double kBetween_W_K = 0.0033;
  static constexpr double kMotor5000_W = kOutside_W_K * 11.4 + kBetween_W_K * 2.0;
  static constexpr double kGear5000_W = kOutside_W_K * 9.4 - kBetween_W_K * 2.0;
  static constexpr double kMotor10000_W = kOutside_W_K * 17.1 + kBetween_W_K * 6.8;
  static constexpr double kGear10000_W = kOutside_W_K * 10.3 - kBetween_W_K * 6.8;

  // Through zero and both rows, linear above them.
  static double turning_W(double rpm, double at_5000_W, double at_10000_W) {
    if (rpm < 5000) return at_5000_W * rpm / 5000;
    return at_5000_W + (at_10000_W - at_5000_W) * (rpm - 5000) / 5000;
  }

  double motor_degC_ = kAmbient_degC;
  double gear_degC_ = kAmbient_degC;
};

}  // namespace lss::sim::zebro
