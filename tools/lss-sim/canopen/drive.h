#pragma once

// A drive of CiA 402 on a CANopen node: its power state machine, and a drive in profile velocity
// that any vehicle can use as it is. Written from CiA 402; units of its objects as in
// docs/icd-ardito.md section 3: velocities in rpm of the motor, accelerations in rpm/s, current in
// per mille of the rated one. A drive's own control uses none of the sensors that it reports: it
// commutates by itself, so a failed sensor affects only the values on the bus.

#include "tools/lss-sim/canopen/node.h"

namespace lss::sim::nodes {

inline constexpr double kStep_s = 0.001;
inline constexpr std::uint32_t kServo = 0x0002'0192, kStepper = 0x0004'0192;  // object 0x1000

enum class Power {
  not_ready,           // booting
  switch_on_disabled,  // 0x0006 leads on
  ready,               // 0x0007 leads on
  switched_on,         // 0x000F leads on
  enabled,             // follows its target; quick stop, disable and fault lead out
  quick_stop,  // slows down, then holds position or switches off, by 0x605A; 0x0000 leads out
  fault        // motor off; the rising edge of bit 7 leads out when the cause is gone
};
const char* text(Power power);

enum class OperationMode : std::uint8_t { profile_position = 1, profile_velocity = 3 };

class Drive : public Node {
 public:
  // One RPDO; `objects` are those of its mode and its own.
  Drive(const Identity& identity, OperationMode mode, std::size_t tpdos,
        std::span<const Object> objects, unsigned seed);

  Power power() const { return power_; }
  void set_link_V(double link_V) { link_V_ = link_V; }  // below 10 V and above 32 V it fails
  void fail(std::uint16_t code);                        // to fault, with this EMCY
  void drop() {  // out of operation enabled, as for a moment without its supply
    if (power_ == Power::enabled) power_ = Power::switch_on_disabled;
  }

 protected:
  virtual void begin_motion() = 0;  // operation enabled, from where the shaft is
  virtual void new_control() {}     // after each controlword
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
  double link_V_ = 24;
  bool warm_ = false;

 private:
  void obey(std::uint16_t controlword);
  void begin_quick_stop();

  std::uint16_t last_control_ = 0;
  std::uint16_t cause_ = 0;  // of the fault
};

// A motor as its drive measures it.
struct MotorState {
  double velocity_rad_s = 0;     // of its shaft
  double current_per_mille = 0;  // of the rated one, signed like the torque
  bool at_limit = false;         // of its current; standing so for 3 s is EMCY 0x7121
  double temperature_degC = 25;  // warning above 90, EMCY 0x4310 above 110
};

// Profile velocity: a reference that follows the target velocity by the ramps of 0x6083 to 0x6085.
// Each millisecond: step(), the motor follows reference_rad_s() while on(), feel().
class VelocityDrive : public Drive {
 public:
  explicit VelocityDrive(const Identity& identity, unsigned seed, std::size_t tpdos = 1,
                         std::span<const Object> own_objects = {});

  bool on() const { return moves(); }  // power stage
  double reference_rad_s() const { return reference_rad_s_; }
  void feel(const MotorState& motor);
  Signal* signal(int number) override;  // 1 velocity, 2 current

 protected:
  void measure() override;

  Signal velocity_rpm_, current_;

 private:
  void begin_motion() override { reference_rad_s_ = motor_.velocity_rad_s; }
  std::uint16_t mode_bits() const override;
  bool standing() const override { return reference_rad_s_ == 0; }
  void tick() override;

  MotorState motor_;
  double reference_rad_s_ = 0;
  int blocked_ms_ = 0;
};

}  // namespace lss::sim::nodes
