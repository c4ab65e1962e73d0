#pragma once

// One module of Lunar Zebro's leg bus from the view of its firmware: frames in, a reply out, an
// encoder, a Hall sensor and a motor driver. Written only from docs/icd-zebro.md, not from the
// daemon's driver. Time is the module's own: it passes in step(), 1 ms a call like the control
// cycle of the firmware; up to 20 ms for fast mission simulations. One thread at a time; nothing
// allocates.

#include <array>
#include <cstdint>
#include <optional>

#include "idl/angles.h"
#include "tools/lss-sim/zebro/motor.h"
#include "tools/lss-sim/zebro/plant.h"

namespace lss::sim::zebro {

using Payload = std::array<std::uint8_t, 8>;

struct Reply {
  std::uint8_t code = 0;
  Payload data{};
};

// Reset causes of the identity page (ICD section 5).
enum class ResetCause : std::uint8_t { power_on, cpu_watchdog, brown_out, command, software };

// The angle at which the magnet passes the sensor: of the shaft, and the position that the module
// then adopts.
struct HallSensor {
  double at_rad = 0;
  bool broken = false;
};

// Faults of the encoder: what it counts is not how the motor turned.
struct EncoderFault {
  bool frozen = false;
  bool random = false;  // the position in each status is any
  double jump_rad = 0;  // once a second
  double drift_rad_s = 0;
};

class Module {
 public:
  // `hall_rad`: pi for a leg (straight up), 0 for the panel (retracted). `shaft_rad`: shaft angle
  // at boot.
  Module(double hall_rad, double shaft_rad, double step_s = kStep_s);

  // A valid frame to this module's address or to all (`own` false), executed at once.
  std::optional<Reply> handle(std::uint8_t code, const Payload& data, bool own);
  // A frame that the receiver dropped.
  void count_dropped() { ++dropped_; }

  // One step: `shaft` is the motion of the plant in the last one, with the torque on the motor;
  // `slipped_rad`: how far the motor has turned more than the leg so far.
  ShaftDrive step(const ShaftState& shaft, double slipped_rad = 0);

  void reset(ResetCause cause);
  // Time passes without steps, while motion control is off.
  void rest(double seconds);

  // Faults of the hardware around the firmware.
  void set_dead(bool dead) { dead_ = dead; }
  void set_driver_broken(bool broken) { driver_broken_ = broken; }
  void set_hall_broken(bool broken) { hall_.broken = broken; }
  void set_encoder(const EncoderFault& fault) { encoder_ = fault; }
  void set_temperature_degC(std::optional<double> held) { held_degC_ = held; }
  bool driver_broken() const { return driver_broken_; }

  bool motion_control() const { return motion_control_; }
  bool calibrated() const { return calibrated_; }
  double current_A() const { return current_A_; }

 private:
  static constexpr double kBoot_s =
      0.2;  // after a reset it receives and sends nothing for this time

  std::optional<Reply> request(std::uint8_t page);
  void rotate(const Payload& data, int sense);
  void plan();
  void stop(std::uint16_t because);
  void sense(double shaft_rad);
  void turn_encoder(double motor_rad);
  void protect(double shaft_torque_Nm, double shaft_speed_rad_s);
  double advance_reference();
  std::uint16_t flags() const;
  std::uint16_t random_cdeg();
  Reply status();
  Reply health() const;
  Reply identity() const;
  bool hall_level() const;

  double step_s_;

  // Hardware.
  HallSensor hall_;
  Heat heat_;
  bool dead_ = false, driver_broken_ = false;
  std::optional<double> held_degC_;
  EncoderFault encoder_;
  double motor_rad_ = 0;    // of the motor, at the shaft
  double encoder_rad_ = 0;  // as the encoder has it
  double jump_due_s_ = 0;
  std::uint32_t random_ = 1;
  double shaft_rad_ = 0;
  double from_hall_rad_ = 0;  // the same from the magnet, within half a turn

  // Firmware: measured.
  double measured_rad_ = 0;  // from the encoder, continuous; 0 at boot until calibrated
  double offset_rad_ = 0;    // from counted to measured
  double velocity_rad_s_ = 0, current_A_ = 0;
  bool calibrated_ = false;
  bool hot_ = false;

  // Firmware: commanded.
  bool motion_control_ = false;
  bool rotating_ = false;     // a rotate was executed since motion control came on
  int sense_ = 1;             // of it
  double set_point_rad_ = 0;  // as commanded, [0, 2 pi)
  double goal_rad_ = 0;       // the same, continuous
  double reference_rad_ = 0, reference_rad_s_ = 0;
  double time_left_s_ = 0;

  // Firmware: about itself.
  std::uint16_t stops_ = 0;  // flags 3..5
  bool was_reset_ = true;
  ResetCause cause_ = ResetCause::power_on;
  std::uint8_t dropped_ = 0;
  double boot_left_s_ = 0, uptime_s_ = 0, unheard_s_ = 0, over_current_s_ = 0;
};

}  // namespace lss::sim::zebro
