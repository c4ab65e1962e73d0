#pragma once

// Drives the simulated Lunar Zebro open loop by the bytes of its modules, as a script: no gait
// library, no feedback, faster than real time. Angles are positions on the bus: 0 down, growing
// with forward rotation.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::sim::zebro {

using Groups = std::vector<std::vector<int>>;  // legs 1..6 that swing together, in order
inline const Groups kTripod = {{1, 4, 5}, {2, 3, 6}};
inline const Groups kTetrapod = {{1, 4}, {2, 5}, {3, 6}};
inline const Groups kWave = {{5}, {3}, {1}, {6}, {4}, {2}};

struct Pose {
  double ahead_m, left_m, height_m, yaw_deg, tilt_deg;
};

class RobotDriver {
 public:
  explicit RobotDriver(const TerrainOptions& terrain, PlantKind plant = PlantKind::dart,
                       long step_ms = 1)
      : zebro_({.terrain = terrain, .plant = plant, .step_ns = step_ms * kMillisecond}),
        step_ms_(step_ms) {}

  void run(double seconds) {
    const long end_ms = time_ms_ + std::lround(seconds / kStep_s);
    while (time_ms_ < end_ms) step();
  }

  // Turns every leg forward until it has passed its sensor, all to the front, then pushes the body
  // up.
  void stand_up() {
    std::array<bool, kLegs> found{};
    for (int leg = 1; leg <= kLegs; ++leg) command(leg, 0x01);
    for (const double position_deg : {120.0, 240.0, 359.0, 119.0}) {
      for (int leg = 1; leg <= kLegs; ++leg) {
        if (!calibrated(leg)) rotate(leg, +1, position_deg, 1.3);
      }
      for (int i = 0; i < 70; ++i) {
        run(0.02);
        for (int leg = 1; leg <= kLegs; ++leg) {
          if (!calibrated(leg) || std::exchange(found[index(leg)], true)) continue;
          rotate(leg, +1, 270, 1);
        }
      }
    }
    ASSERT_TRUE(std::ranges::all_of(found, [](bool f) { return f; }));
    run(1);
    for (int leg = 1; leg <= kLegs; ++leg) rotate(leg, +1, 0, 3);
    run(3.5);
  }

  // From standing, rolling forward on all legs.
  void lay_down() {
    for (int leg = 1; leg <= kLegs; ++leg) rotate(leg, -1, 254, 3);
    run(3.5);
  }

  // Gait of 3 s flight and 0.3 s double stance, sweep 40 deg, whole cycles; `left` and `right` -1
  // or +1.
  void walk(const Groups& groups, int cycles, int left, int right) {
    const double slot_s = kFlight_s + kDouble_s;
    const auto slots = static_cast<double>(groups.size());
    const double stance_s = slots * slot_s - kFlight_s;
    for (int cycle = 0; cycle < cycles; ++cycle) {
      for (const auto& group : groups) {
        for (const int leg : group) swing(leg, leg % 2 == 1 ? left : right);
        run(kFlight_s);
        for (const int leg : group) push(leg, leg % 2 == 1 ? left : right, stance_s);
        run(kDouble_s);
      }
    }
  }

  // All legs straight down, the short way.
  void align() {
    for (int leg = 1; leg <= kLegs; ++leg) {
      const double past_rad =
          std::remainder(zebro_.robot().shafts()[index(leg)].angle_rad, 2 * std::numbers::pi);
      rotate(leg, past_rad < 0 ? +1 : -1, 0, 1);
    }
    run(1.2);
  }

  // Since `from`, along its heading.
  Pose moved(const BodyState& from) const {
    const BodyState now = zebro_.robot().body();
    const Eigen::Vector3d way = from.attitude.conjugate() * (now.position_m - from.position_m);
    const Eigen::Matrix3d turned = (from.attitude.conjugate() * now.attitude).toRotationMatrix();
    return {way.x(), way.y(), now.position_m.z(), std::atan2(turned(1, 0), turned(0, 0)) / kDegree,
            std::acos(std::min(1.0, now.attitude.toRotationMatrix()(2, 2))) / kDegree};
  }

  BodyState body() const { return zebro_.robot().body(); }
  double now_s() const { return static_cast<double>(time_ms_) * kStep_s; }

  // A frame as the master writes it; returns the reply's data.
  std::array<std::uint8_t, 8> command(int address, std::uint8_t code,
                                      const std::array<std::uint8_t, 8>& data = {}) {
    lss::zebro::Receiver receiver(lss::zebro::Check::lrc, lss::zebro::Stop::lf);
    std::array<std::uint8_t, lss::zebro::kMaxFrameCharacters> buffer{};
    const lss::zebro::Frame frame{
        .address = static_cast<std::uint8_t>(address), .code = code, .data = data};
    for (const std::uint8_t c :
         lss::zebro::encode(frame, lss::zebro::Check::lrc, lss::zebro::Stop::lf, buffer)) {
      receiver.receive(zebro_.receive(c, 0), 0);
    }
    const auto reply = receiver.take();
    return reply ? reply->frame.data : std::array<std::uint8_t, 8>{};
  }

  Zebro& zebro() { return zebro_; }
  std::function<void()> after_step = [] {};

 private:
  static constexpr double kFlight_s = 3.0, kDouble_s = 0.3;
  static constexpr double kHalfSweep_deg = 20;

  static std::size_t index(int leg) { return static_cast<std::size_t>(leg - 1); }
  static std::uint8_t byte(long value) { return static_cast<std::uint8_t>(value & 0xFF); }

  void step() {
    zebro_.step();
    time_ms_ += step_ms_;
    after_step();
    if (time_ms_ % 1000 == 0) {
      for (int leg = 1; leg <= kLegs; ++leg) command(leg, 0x05);  // feeds the watchdogs
    }
  }

  bool calibrated(int leg) { return (command(leg, 0x05)[1] & 2) != 0; }

  void rotate(int leg, int sense, double position_deg, double seconds) {
    const long position = std::lround(position_deg * 100), time = std::lround(seconds * 1000);
    command(leg, sense > 0 ? 0x03 : 0x04,
            {byte(position >> 8), byte(position), byte(time >> 8), byte(time)});
  }

  void swing(int leg, int sense) {
    rotate(leg, sense, sense > 0 ? 360 - kHalfSweep_deg : kHalfSweep_deg, kFlight_s);
  }
  void push(int leg, int sense, double seconds) {
    rotate(leg, sense, sense > 0 ? kHalfSweep_deg : 360 - kHalfSweep_deg, seconds);
  }

  Zebro zebro_;
  long step_ms_;
  long time_ms_ = 0;
};

}  // namespace lss::sim::zebro
