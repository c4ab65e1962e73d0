#pragma once

// Motor, clutch and gear of a wheel, and motor and gear of a steering shaft, as D.I.A.N.A. Ardito
// has them (Ardito thesis 7.1, 7.2): the effect of a drive's order on the shaft behind the gear of
// 50, and its current. The thesis names neither motors nor gears: the figures are those of a 100 W
// brushless motor at 24 V that pulls the rover at 1 m/s. SI units at the motor's shaft unless said.
// Each is one small state; one thread.

#include "tools/lss-sim/ardito/rover.h"

namespace lss::sim::ardito {

inline constexpr double kGear = 50;

namespace motor {
inline constexpr double kTorque_Nm_A = 0.055;  // and V s/rad
inline constexpr double kResistance_Ohm = 0.45;
inline constexpr double kRated_A = 4;
inline constexpr double kLimit_A = 10;
inline constexpr double kEfficiency = 0.80;  // of the gear

// No load: bearings, iron and brushless controller. The thesis would measure this in an experiment
// to detect a failed clutch (its part VII).
double no_load_A(double speed_rad_s);
// The maximum torque of the gear at this motor speed and voltage.
double torque_limit_Nm(double speed_rad_s, double link_V);
}  // namespace motor

// The order of a drive to its motor.
struct MotorOrder {
  bool on = false;  // power stage
  double velocity_rad_s = 0;
};

enum class MotorFault {
  none,
  blocked,  // burnt and stuck: no torque, does not turn
  open      // a winding is open: no torque, turns freely
};
enum class GearFault {
  none,
  jammed,  // the wheel is blocked, and so is the motor while the clutch is engaged
  loose    // coupling broken: both turn, neither drives the other
};
enum class ClutchFault {
  none,
  open,   // always disconnected, ignores orders
  closed  // always connected, ignores orders
};

class WheelTrain {
 public:
  // One millisecond: `wheel` is the motion of the wheel in the last one.
  ShaftDrive step(const MotorOrder& order, const ShaftState& wheel, double link_V);

  double motor_rad_s() const { return motor_rad_s_; }
  double current_A() const { return current_A_; }  // signed like the torque
  double temperature_degC() const { return temperature_degC_; }
  bool at_limit() const { return at_limit_; }
  bool coupled() const { return coupled_; }

  bool clutch_ordered = false;
  MotorFault motor_fault = MotorFault::none;
  GearFault gear_fault = GearFault::none;
  ClutchFault clutch_fault = ClutchFault::none;
  void heat_to(double temperature_degC) { temperature_degC_ = temperature_degC; }

 private:
  bool connected() const;
  void turn_alone(bool driven, double wanted_rad_s);
  void load(double torque_Nm);
  void heat();

  double motor_rad_s_ = 0, current_A_ = 0, temperature_degC_ = 25;
  bool coupled_ = false, at_limit_ = false;
};

// A stepper with a self-locking gear: without power the wheel keeps its angle.
class SteeringTrain {
 public:
  ShaftDrive step(const MotorOrder& order, const ShaftState& shaft, double link_V);

  double motor_rad() const { return motor_rad_; }
  double current_A() const { return current_A_; }

  MotorFault motor_fault = MotorFault::none;
  GearFault gear_fault = GearFault::none;

 private:
  double motor_rad_ = 0, current_A_ = 0;
};

}  // namespace lss::sim::ardito
