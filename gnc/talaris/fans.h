#pragma once

// Speed of the four fans: PI on the rpm, on top of the throttle for the speed (TALARIS thesis
// 5.2.2). The sensor has steps of 200 rpm and the fan a lag of a quarter of a second; the
// controller compares the measured speed with the expected one, so that a change of the command is
// not taken for an error.

#include <array>

#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

using PerFan = std::array<double, kFans>;

class FanSpeed {
 public:
  FanSpeed(const Fans& fans, const Gains& gains) noexcept : fans_(fans), gains_(gains) {}

  // One frame; throttles 0..1. The speed follows a ramp of `ramp_rpm_s` to `goal_rpm`; a goal of 0
  // switches the fan off at once.
  PerFan ramp(const PerFan& goal_rpm, double ramp_rpm_s, const PerFan& measured_rpm) noexcept;
  // The same without ramp; for outer loops that know the lag.
  PerFan direct(const PerFan& command_rpm, const PerFan& measured_rpm) noexcept;
  // The speed node is silent: the throttle of the command, plus the last integral of the PI.
  PerFan blind(const PerFan& command_rpm) noexcept;

  // Expected speeds now.
  const PerFan& reference_rpm() const noexcept { return reference_; }
  void set_gains(const Gains& gains) noexcept { gains_ = gains; }
  void reset() noexcept;

 private:
  double throttle(std::size_t i, double command_rpm, double error_rpm) noexcept;

  Fans fans_;
  Gains gains_;
  PerFan reference_{};  // rpm at T_k
  PerFan trim_{};       // throttle of the integral
};

double fan_thrust_N(double rpm, const Fans& fans) noexcept;
// Sum over the four; a value that is not a number or negative counts as 0.
double fan_thrust_N(const PerFan& rpm, const Fans& fans) noexcept;

}  // namespace lss::gnc::talaris
