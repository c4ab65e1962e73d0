#pragma once

// The drives of D.I.A.N.A. Ardito: CiA 402's state machine on a CANopen node, with profile velocity
// for wheels and profile position for steering. Written from docs/icd-ardito.md sections 5, 7 and
// 9. A drive's own control uses none of the sensors that it reports: it commutates and counts steps
// by itself, so a failed encoder affects only the values on the bus.

#include "tools/lss-sim/ardito/node.h"
#include "tools/lss-sim/ardito/train.h"

namespace lss::sim::ardito {

enum class Power {
  not_ready,           // booting
  switch_on_disabled,  // 0x0006 leads on
  ready,               // 0x0007 leads on
  switched_on,         // 0x000F leads on
  enabled,             // follows its target; quick stop, disable and fault lead out
  quick_stop,  // slows down, then holds position or switches off, by 0x605A; 0x0000 leads out
  fault        // motor off; the rising edge of bit 7 leads out when the cause is gone
};

class Drive : public Node {
 public:
  Drive(std::uint8_t id, std::uint32_t device_type, std::size_t tpdos,
        std::span<const Object> objects, unsigned seed)
      : Node({.id = id, .device_type = device_type, .product = kProduct}, 1, tpdos, objects, seed) {
  }

  Power power() const { return power_; }
  void set_link_V(double link_V) { link_V_ = link_V; }
  void fail(std::uint16_t code);  // to fault, with this EMCY

 protected:
  virtual void begin_motion() = 0;  // operation enabled, from where the shaft is
  virtual void new_control() = 0;   // after each controlword
  virtual std::uint16_t mode_bits() const = 0;
  virtual bool standing() const = 0;

  void written(std::uint16_t index, std::uint8_t sub) override;
  void left_operational(bool communication_error) override;
  void reset() override;
  void tick_power();  // each millisecond

  std::uint16_t statusword() const;
  std::uint16_t controlword() const { return static_cast<std::uint16_t>(objects_.get(0x6040, 0)); }
  bool moves() const { return power_ == Power::enabled || power_ == Power::quick_stop; }

  Power power_ = Power::not_ready;
  double link_V_ = 0;
  bool warm_ = false;

 private:
  void obey(std::uint16_t controlword);
  void begin_quick_stop();

  std::uint16_t last_control_ = 0;
  std::uint16_t cause_ = 0;  // of the fault
};

class WheelDrive final : public Drive {
 public:
  WheelDrive(std::uint8_t id, unsigned seed);
  // The order for the motor in this millisecond.
  MotorOrder order() const { return {moves(), reference_rad_s_}; }
  void feel(const WheelTrain& train, const ShaftState& wheel);
  Signal* signal(int number) override;

 private:
  void begin_motion() override { reference_rad_s_ = motor_rad_s_; }
  void new_control() override {}
  std::uint16_t mode_bits() const override;
  bool standing() const override { return reference_rad_s_ == 0; }
  void measure() override;
  void tick() override;

  Signal encoder_rpm_, hall_rpm_, reduction_crpm_, current_, temperature_, link_;
  double reference_rad_s_ = 0, motor_rad_s_ = 0;
  double temperature_degC_ = 25;
  bool at_limit_ = false;
  int blocked_ms_ = 0;
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
