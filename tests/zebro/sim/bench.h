#pragma once

// A module on a bench: its firmware, and a shaft that follows its driver exactly, or is blocked.

#include <cmath>
#include <cstdint>

#include "idl/angles.h"
#include "tools/lss-sim/zebro/module.h"

namespace lss::sim::zebro {

struct Status {
  unsigned flags;
  double position_deg, velocity_deg_s, current_A;
  bool operator&(unsigned flag) const { return (flags & flag) != 0; }
};

// Bits of docs/icd-zebro.md section 5.
enum : unsigned {
  kMotionControl = 1,
  kCalibrated = 2,
  kMoving = 4,
  kOverCurrent = 8,
  kDriverFault = 16,
  kWatchdog = 32,
  kHallLevel = 64,
  kWasReset = 128,
  kHot = 256,
};

enum class Power { off, on };
inline constexpr Power kOn = Power::on;

class Bench {
 public:
  explicit Bench(double boot_deg = 200, Power power = Power::off, double hall_deg = 180)
      : module(hall_deg * kDegree, boot_deg * kDegree) {
    shaft.angle_rad = boot_deg * kDegree;
    if (power == Power::on) start();
  }

  std::optional<Reply> send(std::uint8_t code, const Payload& data = {}) {
    return module.handle(code, data, true);
  }
  void start() { send(0x01); }
  void rotate(int sense, double position_deg, double seconds) {
    const auto position = static_cast<unsigned>(std::lround(position_deg * 100));
    const auto time = static_cast<unsigned>(std::lround(seconds * 1000));
    send(sense > 0 ? 0x03 : 0x04,
         {byte(position >> 8), byte(position), byte(time >> 8), byte(time)});
  }

  // Time passes; the LC asks for the status every 20 ms unless it is silent.
  void run(double seconds, bool polled = true) {
    const long steps = std::lround(seconds / kStep_s);
    for (long i = 0; i < steps; ++i) {
      const ShaftDrive drive = module.step(shaft);
      const bool pushing = std::abs(drive.velocity_rad_s) > 1e-3;
      shaft.velocity_rad_s = blocked ? 0 : drive.velocity_rad_s;
      shaft.angle_rad += shaft.velocity_rad_s * kStep_s;
      shaft.torque_Nm = blocked && pushing ? drive.torque_limit_Nm : load_Nm;
      if (polled && i % 20 == 0) send(0x05);
    }
  }

  // Rotates to a position in a time, and lets another time pass.
  void turn(int sense, double position_deg, double seconds, double pass_s) {
    rotate(sense, position_deg, seconds);
    run(pass_s);
  }

  Status status() { return decode(send(0x05)->data); }
  double shaft_deg() const {
    const double turned = std::fmod(shaft.angle_rad / kDegree, 360);
    return turned < 0 ? turned + 360 : turned;
  }
  static unsigned u16(const Payload& data, std::size_t at) {
    return data[at] * 256u + data[at + 1];
  }

  Module module;
  ShaftState shaft;
  bool blocked = false;
  double load_Nm = 0;

 private:
  static std::uint8_t byte(unsigned value) { return static_cast<std::uint8_t>(value & 0xFF); }
  static Status decode(const Payload& data) {
    return {u16(data, 0), u16(data, 2) * 0.01, static_cast<std::int16_t>(u16(data, 4)) * 0.1,
            u16(data, 6) * 1e-3};
  }
};

}  // namespace lss::sim::zebro
