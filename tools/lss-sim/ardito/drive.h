#pragma once

// The drives of D.I.A.N.A. Ardito: profile velocity for wheels, with more sensors, and profile
// position for steering, on the shared drive of CiA 402. Written from docs/icd-ardito.md sections
// 5, 7 and 9.

#include "tools/lss-sim/ardito/node.h"
#include "tools/lss-sim/ardito/train.h"
#include "tools/lss-sim/canopen/drive.h"

namespace lss::sim::ardito {

class WheelDrive final : public VelocityDrive {
 public:
  WheelDrive(std::uint8_t id, unsigned seed);
  // The order for the motor in this millisecond.
  MotorOrder order() const { return {on(), reference_rad_s()}; }
  void feel(const WheelTrain& train, const ShaftState& wheel);
  Signal* signal(int number) override;

 private:
  void measure() override;

  Signal hall_rpm_, reduction_crpm_, temperature_, link_;
};

class SteeringDrive final : public Drive {
 public:
  SteeringDrive(std::uint8_t id, unsigned seed);
  MotorOrder order() const;
  void feel(const SteeringTrain& train, const ShaftState& shaft);
  Signal* signal(int number) override;

 private:
  void begin_motion() override;
  void new_control() override;
  std::uint16_t mode_bits() const override;
  bool standing() const override { return velocity_rad_s_ == 0; }
  void reset() override;
  void measure() override;
  void tick() override;
  void advance();
  bool arrived() const;

  Signal encoder_, reduction_, current_;
  double motor_rad_ = 0, zero_rad_ = 0;  // of the train; the offset of its count
  double reference_rad_ = 0, velocity_rad_s_ = 0, goal_rad_ = 0;
  std::optional<double> next_rad_;  // a set-point that waits for the end of the current one
  bool acknowledged_ = false, last_bit4_ = false;
  int behind_ms_ = 0;
};

}  // namespace lss::sim::ardito
