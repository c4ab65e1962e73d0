#pragma once

// The base of a vehicle whose actuators are velocity drives (CiA 402) on one CAN bus: reads and
// supervises the nodes, solves errors, carries out the actions of every vehicle, checks the orders
// at the gate. The vehicle adds its modes, guidance and telemetry: docs/tutorial-vehicle.md.
// Module i+1 is drive i. Frame thread; time is data; no allocation.

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "daemon/config/section.h"
#include "daemon/cycle/cycle.h"
#include "daemon/cycle/solving.h"
#include "daemon/cycle/strategies.h"
#include "daemon/kit/node_watch.h"
#include "daemon/kit/one_port.h"
#include "daemon/kit/port_watch.h"
#include "daemon/record/fields.h"
#include "daemon/runtime/can_bus.h"
#include "drivers/canopen/velocity_bus.h"

namespace lss::canopen {

// For records.
template <class V, record::Like<VelocityOrders> X>
void fields(V& v, X& x) {
  static_assert(kMembers<VelocityOrders> == 2);
  record::visit_base<BusOrders>(v, x);
  v("drive", x.drive);
}

}  // namespace lss::canopen

namespace lss::kit {

using DriveCanBus =
    CanBus<canopen::VelocityBus, canopen::VelocityBusParameters, canopen::VelocityOrders,
           canopen::VelocitySample, canopen::VelocityStatus>;

// Strategies of error solving: all of them, in this order.
enum class DriveStrategy : std::uint8_t {
  none,
  reconnect,    // contact is tried all the time: wait for it
  reset_fault,  // of drives
  reset_node,   // those that do not answer or are in fault
};
inline constexpr const char* kDriveStrategyNames[] = {"none", "reconnect", "reset_fault",
                                                      "reset_node"};

struct DriveParameters {
  canopen::VelocityBusParameters bus;
  double max_motor_rpm = 3000;      // the gate lets no more pass
  double slew_rpm_s = 4000;         // nor a faster change
  TimeNs budget_ns = 10 * kSecond;  // for one strategy of error solving
  TimeNs reset_ns = 10 * kSecond;   // a node that a command resets has to answer again within it
};

// Drives with these numbers on the bus.
inline DriveParameters drives(std::initializer_list<std::uint8_t> nodes) {
  DriveParameters parameters;
  std::ranges::copy(nodes, parameters.bus.node.begin());
  return parameters;
}

// The keys nodes, master_node, stale_ms, heartbeat_timeout_ms, acceleration_rpm_s of the section.
void read_drive_bus(config::Section section, DriveParameters& parameters);

// What the gate found; numbers as in the event of a closed gate.
enum class DriveGate : std::uint8_t { passed, fresh, state, finite, range, slew };

class DriveVehicle : public Actor {
 public:
  using Sample = canopen::VelocitySample;
  using BusReport = DriveCanBus::Report;
  using Command = canopen::VelocityOrders;
  static constexpr std::size_t kMaxSamples = canopen::VelocityBus::kMaxSamples;

  template <class Vehicle>
  void read(const Inputs<Vehicle>& in) noexcept {
    begin(in.time_ns, in.bus);
    for (std::uint32_t i = 0; i < in.sample_count; ++i) take(in.samples[i]);
  }
  template <class Vehicle>
  void watch(const Inputs<Vehicle>& in, Supervisor& s) noexcept {
    supervise(in.overrun_limit, s);
    watch_own(s);
  }
  void act(lc::ActionSet actions, const Request* request) noexcept override;
  Command gate(const Command& wanted, Supervisor& supervisor, TimeNs now) noexcept;

  // Of a drive that answers: for the end of the daemon (daemon/cycle/ending.h).
  bool powered() const noexcept;

  // For tests: an order behind the back of the controller.
  Command& wanted() noexcept { return orders_; }

 protected:
  // A drive and its last values.
  struct Motion {
    double motor_rpm = 0, current_permille = 0;
    TimeNs time_ns = 0;  // 0: never
  };

  DriveVehicle(const DriveParameters& parameters, std::size_t drives) noexcept
      : drive_(parameters), drives_(drives) {
    orders_.serial = 1;
  }
  ~DriveVehicle() = default;

  // The vehicle's own reports, after those of the base.
  virtual void watch_own(Supervisor& supervisor) noexcept = 0;

  // All drives answer and are in operation enabled.
  bool enabled() const noexcept;
  // No drive turns faster than this.
  bool standing(double motor_rpm) const noexcept;
  const Motion& motion(std::size_t drive) const noexcept { return motion_[drive]; }
  bool answers(std::size_t drive) const noexcept;
  // Motors on: after a row of the vehicle said so.
  void motors_on() noexcept;
  // The orders of this frame: speeds of the motors, enabled while motors are on.
  Command order(std::span<const double> motor_rpm, TimeNs now) noexcept;
  bool data_requested() const noexcept { return data_requested_; }
  const Supervisor& supervisor() const noexcept { return *supervisor_; }
  TimeNs now() const noexcept { return now_ns_; }

  // Telemetry members that such vehicles have in common (examples/scout/scout.idl).
  template <class Vehicle, class Telemetry>
  void describe_common(const Inputs<Vehicle>& in, const SupervisorState& state,
                       Telemetry& out) const noexcept {
    out.time_ns = in.time_ns;
    out.frame = in.frame;
    out.state = static_cast<std::uint8_t>(state.controller.state);
    out.mode = state.controller.mode;
    out.port_open = bus_.open;
    out.bus_frames_sent = bus_.port.sent;
    out.bus_frames_received = bus_.port.received;
    for (std::size_t i = 0; i < drives_; ++i) {
      auto& drive = out.drives[i];
      const canopen::DriveLink& link = bus_.status.link[i];
      drive.id = static_cast<std::uint8_t>(i + 1);
      drive.online = answers(i);
      drive.link = static_cast<std::uint8_t>(link.node.state);
      drive.drive = static_cast<std::uint8_t>(link.drive);
      drive.target_rpm = sent_.drive[i].motor_rpm;
      drive.motor_rpm = motion_[i].motor_rpm;
      drive.current_permille = motion_[i].current_permille;
      drive.age_ms = age_ms(link.node);
    }
  }

  // For records (daemon/record/state.h): a vehicle calls it in its own keep().
  template <class V>
  void keep_base(V& v) {
    v(drive_, motion_, bus_, orders_, sent_, now_ns_, on_, data_requested_, port_, nodes_, solver_);
  }

 private:
  void begin(TimeNs now, const BusReport& bus) noexcept;
  void take(const Sample& sample) noexcept;
  void supervise(bool overrun_limit, Supervisor& s) noexcept;
  void watch_solver(Supervisor& s) noexcept;
  bool faulty(std::size_t drive) const noexcept;
  std::uint16_t faulty_modules() const noexcept;
  void reset_nodes(std::uint16_t nodes) noexcept;
  void make_safe(TimeNs now) noexcept;
  DriveGate check(const Command& orders, TimeNs now) const noexcept;
  std::uint64_t age_ms(const canopen::NodeStatus& node) const noexcept;

  DriveParameters drive_;
  std::size_t drives_;
  std::array<Motion, canopen::kMostVelocityDrives> motion_{};
  BusReport bus_{};  // of the frame
  Supervisor* supervisor_ = nullptr;
  Command orders_{};  // as wanted
  Command sent_{};    // as they left the gate
  TimeNs now_ns_ = 0;
  bool on_ = false;  // motors
  bool data_requested_ = false;
  PortWatch port_;
  NodeWatch nodes_;
  Strategies<DriveStrategy> solver_;
};

// Fills in what comes from the frame. Parameters derive from DriveParameters.
template <class Parameters>
Parameters with_frame(Parameters parameters, const config::Config& config) {
  parameters.bus.period_ns = config.period_ns;
  return parameters;
}

// The wiring: the first port of the configuration.
template <class Vehicle, class AllParameters>
class DrivePort : public OnePort<Vehicle, DriveCanBus> {
 public:
  using Parameters = AllParameters;

  DrivePort(const config::Config& config, const Parameters& parameters)
      : OnePort<Vehicle, DriveCanBus>(config.ports.front(), parameters.bus,
                                      config.ports.front().path, canopen::filters()) {}
};

}  // namespace lss::kit
