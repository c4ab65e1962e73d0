#pragma once

// A world for the cycle of D.I.A.N.A. Ardito without threads, frames or physics: twelve nodes that
// run, ten drives that execute their orders within a frame, in virtual time. Tests break them by
// hand.

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "daemon/vehicles/ardito/vehicle.h"
#include "tests/safety/cycle_world.h"

namespace lss::ardito {

using safety::source;

class World : public safety::CycleWorld<World, Vehicle, Mode> {
 public:
  static constexpr TimeNs kPeriod = 100 * kMillisecond;

  explicit World(const Parameters& parameters = {}, const Supervisor::Parameters& links = {})
      : CycleWorld(parameters, ardito::logic(), links, kPeriod), parameters_(parameters) {
    in_.bus.was_open = in_.bus.open = true;
    for (RoverLink& link : in_.bus.status.link) link.node.state = canopen::NodeState::operational;
    for (std::size_t i = 0; i < kWheels + kSteered; ++i)
      drive(i) = canopen::DriveState::switch_on_disabled;
  }

  canopen::DriveState& drive(std::size_t i) { return in_.bus.status.link[i].drive; }
  canopen::NodeStatus& node(std::size_t i) { return in_.bus.status.link[i].node; }

  void sense() {
    in_.bus.time_ns = time_ns_ - kMillisecond;
    boot();
    if (in_.bus.open) measure();
  }
  void obey() { obey(out_.command); }

  // From Idle to Stopped with all motors on.
  bool start(double limit = 0) {
    run(0.5);
    send(lss::CommandKind::start, {limit});
    return run_until([&] { return last(Phase::completed) != nullptr && mode() == Mode::stopped; },
                     10);
  }
  bool drive_at(double speed, double heading = 0) {
    send(CommandKind::drive, {speed, heading, 1, 0});
    return run_until(Mode::running, 20);
  }
  bool start_and_drive(double speed, double heading = 0) {
    return start() && drive_at(speed, heading);
  }

  bool all_stopped() const {
    const auto off = [](const auto& drive) { return !drive.enabled; };
    return out_.command.quick_stop && std::ranges::all_of(out_.command.wheel, off) &&
           std::ranges::all_of(out_.command.steering, off);
  }
  double wheel_rpm(std::size_t i) const { return out_.command.wheel[i].motor_rpm; }

  // The measurements before they are sent; a test alters them here.
  std::function<void(std::vector<Reading>&)> distort;

  Parameters parameters_;
  ardito::Inputs inputs{.emergency_button = false, .power_good = true};
  bool imu_alive = true;
  std::array<TimeNs, kNodes> boot_ns{};  // of a node that is reset; 0: it takes no notice
  std::array<double, kWheels> rpm{};     // of the motors
  std::array<double, kSteered> angle_rad{};

 private:
  void boot() {
    for (std::size_t i = 0; i < kNodes; ++i) {
      if (booted_ns_[i] == 0 || time_ns_ < booted_ns_[i]) continue;
      booted_ns_[i] = 0;
      node(i).state = canopen::NodeState::operational;
      node(i).since_ns = time_ns_;
      ++node(i).boots;
    }
  }

  void measure() {
    const double gear = parameters_.mobility.geometry.gear_ratio;
    std::vector<Reading> readings;
    double sum = 0;
    for (std::uint8_t i = 0; i < kWheels; ++i) {
      readings.push_back(WheelMotion{.wheel = i,
                                     .statusword = 0,
                                     .motor_rpm = rpm[i],
                                     .current_permille = std::copysign(200, rpm[i])});
      readings.push_back(
          WheelSpeeds{.wheel = i, .hall_rpm = rpm[i], .reduction_rpm = rpm[i] / gear});
      readings.push_back(WheelHealth{.wheel = i, .temperature_degC = 25, .link_V = 24});
      sum += rpm[i];
    }
    for (std::size_t i = 0; i < kSteered; ++i) {
      const auto wheel = static_cast<std::uint8_t>(kSteeredWheel[i]);
      readings.push_back(SteeringMotion{.wheel = wheel,
                                        .statusword = 0,
                                        .motor_rad = angle_rad[i] * gear,
                                        .current_permille = 0});
      readings.push_back(SteeringAngle{.wheel = wheel, .reduction_rad = angle_rad[i]});
    }
    readings.push_back(inputs);
    readings.push_back(Rocker{});
    const double m_s = sum / kWheels / gear * 2 * 3.14159265358979 / 60 *
                       parameters_.mobility.geometry.wheel_radius_m;
    const gnc::ardito::Estimate& e = vehicle_.command().estimate;
    const bool parking = vehicle_.command().mode == gnc::ardito::Mode::parking;
    if (imu_alive)
      readings.push_back(Imu{.Vtan_mm_s = parking ? e.speed_m_s * 1e3 : m_s * 1e3,
                             .sigma_rad = e.sigma_rad,
                             .yaw_rate_rad_s = e.yaw_rate_rad_s,
                             .counter = ++counter_});
    if (distort) distort(readings);
    for (const Reading& reading : readings) {
      if (in_.sample_count < in_.samples.size())
        in_.samples[in_.sample_count++] = {.time_ns = time_ns_ - kMillisecond, .reading = reading};
    }
    for (std::size_t i = 0; i < kNodes; ++i) {
      if (node(i).state == canopen::NodeState::operational)
        node(i).heartbeat_ns = time_ns_ - kMillisecond;
    }
  }

  void obey(const RoverOrders& orders) {
    using canopen::DriveState;
    for (std::size_t i = 0; i < kWheels + kSteered; ++i) {
      const bool enabled =
          i < kWheels ? orders.wheel[i].enabled : orders.steering[i - kWheels].enabled;
      if (drive(i) == DriveState::fault) {
        if (orders.fault_reset_serial == resets_) continue;
        drive(i) = DriveState::switch_on_disabled;
      }
      drive(i) = enabled             ? DriveState::operation_enabled
                 : orders.quick_stop ? DriveState::quick_stop_active
                                     : DriveState::switch_on_disabled;
      if (i < kWheels) rpm[i] = enabled ? orders.wheel[i].motor_rpm : 0;
      if (i >= kWheels && enabled)
        angle_rad[i - kWheels] = orders.steering[i - kWheels].position_rad;
    }
    resets_ = orders.fault_reset_serial;
    for (std::size_t i = 0; i < kNodes && orders.node_reset_serial != node_resets_; ++i) {
      if (boot_ns[i] == 0 || (orders.reset_nodes >> i & 1u) == 0) continue;
      node(i).state = canopen::NodeState::booting;
      booted_ns_[i] = time_ns_ + boot_ns[i];
    }
    node_resets_ = orders.node_reset_serial;
  }

  std::uint16_t counter_ = 0;
  std::uint32_t resets_ = 0, node_resets_ = 0;
  std::array<TimeNs, kNodes> booted_ns_{};  // when it runs again; 0: it does
};

}  // namespace lss::ardito
