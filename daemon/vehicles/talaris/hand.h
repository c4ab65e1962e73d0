#pragma once

// Actuation of TALARIS by hand or by a script: valves open for a time, pulses in every frame, fans
// by throttle or speed, the start-up of their speed controllers (TALARIS thesis 4.4.6, 4.4.8). One
// call a frame; time is data; no allocation.

#include <array>
#include <cstdint>

#include "daemon/vehicles/talaris/script.h"
#include "drivers/talaris/orders.h"
#include "gnc/talaris/fans.h"

namespace lss::talaris {

class Hand {
 public:
  Hand(const gnc::talaris::Fans& fans, const gnc::talaris::Gains& gains) noexcept
      : speed_(fans, gains), ramp_rpm_s_(fans.ramp_rpm_s) {}

  void shut() noexcept;  // everything, fans off

  void valve(std::uint8_t valves, bool open, double time_s) noexcept;
  void pulse(std::uint8_t valves, double on_s, double delay_s, int frames) noexcept;
  void throttle(std::uint8_t fans, double throttle) noexcept;
  void rpm(std::uint8_t fans, double rpm, double ramp_rpm_s) noexcept;
  void rpm(std::uint8_t fans, double rpm) noexcept { this->rpm(fans, rpm, default_ramp_rpm_s_); }
  void arm() noexcept;
  void limit(std::uint8_t valves) noexcept;  // other valves are shut and stay so
  void set_gains(const gnc::talaris::Gains& gains) noexcept { speed_.set_gains(gains); }

  // Into orders whose release_ns is set. `measured_rpm`: nullptr when the speeds are unknown.
  void step(TalarisOrders& orders, const gnc::talaris::PerFan* measured_rpm) noexcept;

  bool arming() const noexcept { return arming_ != 0; }
  bool armed() const noexcept { return armed_; }  // the start-up ended in the last frame
  bool idle() const noexcept;                     // fans
  std::uint8_t open() const noexcept;             // valves, by hand
  // Valves are open by hand, or pulses are left.
  bool pulsing() const noexcept { return frames_ > 0 || open() != 0; }
  std::uint8_t timed_out() const noexcept { return timed_out_; }  // in the last frame
  double target_rpm(std::size_t fan) const noexcept { return by_rpm_[fan] ? rpm_[fan] : 0; }

 private:
  // Pulses of 2 ms for at least 380 ms, then of 1 ms: in whole frames 400 ms.
  static constexpr int kFullFrames = 2, kQuietFrames = 1;

  gnc::talaris::FanSpeed speed_;
  double ramp_rpm_s_, default_ramp_rpm_s_ = ramp_rpm_s_;
  std::array<TimeNs, kHopperValves> wanted_ns_{};  // to open at the next release, for so long
  std::array<TimeNs, kHopperValves> until_ns_{};   // 0: shut
  std::uint8_t timed_out_ = 0;
  std::uint8_t pulsed_ = 0;
  ValvePulse pulse_{};
  int frames_ = 0;
  gnc::talaris::PerFan throttle_{}, rpm_{};
  std::array<bool, kHopperFans> by_rpm_{};
  int arming_ = 0;  // frames left
  bool armed_ = false;
};

// Pulse width of a throttle of 0..1; a throttle that is no number: off.
std::uint16_t fan_us(double throttle) noexcept;

}  // namespace lss::talaris
