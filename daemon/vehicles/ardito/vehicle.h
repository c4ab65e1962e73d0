#pragma once

// D.I.A.N.A. Ardito in the daemon: the stages of its cycle (daemon/cycle/cycle.h) and its wiring.
// Six wheel drives, four steering drives, an I/O node and an IMU on one CAN bus; the mobility
// controller of gnc/ardito commands them, in three redundant instances. Frame thread; time is data;
// no allocation.

#include <ardito_fields.h>  // of the IDL

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/cycle/cycle.h"
#include "daemon/kit/node_watch.h"
#include "daemon/kit/one_port.h"
#include "daemon/kit/port_watch.h"
#include "daemon/record/fields.h"
#include "daemon/runtime/can_bus.h"
#include "daemon/vehicles/ardito/config.h"
#include "daemon/vehicles/ardito/gate.h"
#include "daemon/vehicles/ardito/modes.h"
#include "daemon/vehicles/ardito/solver.h"
#include "gnc/ardito/redundant.h"

namespace lss::ardito {

using RoverCanBus = CanBus<RoverBus, RoverBusParameters, RoverOrders, RoverSample, RoverStatus>;

// For records.
template <class V, record::Like<RoverOrders> X>
void fields(V& v, X& x) {
  static_assert(kMembers<RoverOrders> == 5);
  record::visit_base<canopen::BusOrders>(v, x);
  v("wheel", x.wheel);
  v("steering", x.steering);
  v("clutches", x.clutches);
  v("beacon", x.beacon);
}
template <class V, record::Like<RoverLink> X>
void fields(V& v, X& x) {
  static_assert(kMembers<RoverLink> == 3);
  record::visit_base<canopen::DriveLink>(v, x);
  v("set_points", x.set_points);
  v("set_points_refused", x.set_points_refused);
}

// A received value and its time.
struct Known {
  double value = 0;
  TimeNs time_ns = 0;  // 0: never
};

class Vehicle final : public Actor {
 public:
  using Sample = RoverSample;
  using BusReport = RoverCanBus::Report;
  using Command = RoverOrders;
  using Telemetry = lss_ArditoTelemetry;
  static constexpr std::size_t kMaxSamples = 128;

  explicit Vehicle(const Parameters& parameters) noexcept;

  void read(const lss::Inputs<Vehicle>& in) noexcept;
  void watch(const lss::Inputs<Vehicle>& in, Supervisor& supervisor) noexcept;
  void act(lc::ActionSet actions, const Request* request) noexcept override;
  Adjusted adjust(std::size_t index, double value, bool really) noexcept override;
  void navigate(TimeNs now) noexcept;
  void guide(TimeNs now) noexcept;
  Command control(TimeNs now) noexcept;
  Command gate(const Command& wanted, Supervisor& supervisor, TimeNs now) noexcept;
  // Fills the telemetry; true when a sample was requested.
  bool describe(const lss::Inputs<Vehicle>& in, const SupervisorState& state,
                Telemetry& out) noexcept;

  // Of a drive that answers: for the end of the daemon (daemon/cycle/ending.h).
  bool powered() const noexcept;

  // For error solving. Sets of nodes as bits: bit i is node i+1.
  TimeNs now() const noexcept { return now_ns_; }
  std::uint16_t faulty_modules() const noexcept;  // nodes in service
  std::uint16_t diagnosed() const noexcept;       // by the failure detection, in service

  const gnc::ardito::Command& command() const noexcept { return command_; }
  const TunableValues& tunables() const noexcept { return tunables_; }
  // For tests that inject soft errors.
  gnc::ardito::Redundant& mobility() noexcept { return mobility_; }

  // For records (daemon/record/state.h): every member that the cycle changes.
  template <class V>
  void keep(V& v) {
    v(parameters_, tunables_, mobility_, measured_, request_, command_, wheel_, steering_,
      beta_rad_, rho1_rad_, rho2_rad_, imu_speed_m_s_, imu_sigma_rad_, imu_yaw_rate_rad_s_,
      imu_counter_, inputs_, inputs_ns_, bus_, orders_, sent_, now_ns_, started_ns_, drives_on_,
      limit_m_s_, wanted_m_s_, wanted_rad_, correction_, ramped_m_s_, retry_wheels_,
      retry_steering_, isolated_, stepped_, data_requested_, port_, watched_, failure_,
      steering_failure_, error_, rocker_lost_, imu_lost_, imu_seen_, imu_told_, disagreeing_,
      solver_, distance_m_, yaw_rad_, x_m_, y_m_, beacon_, by_itself_, activated_ns_, rests_ns_,
      slipping_, slip_frames_, most_slip_m_s_, slowed_, most_slip_share_, stuck_, stuck_told_,
      embedded_, embedded_told_, yaw_told_, yaw_good_frames_, hot_, unproven_, unproven_told_,
      proven_frames_, restored_, restored_ns_);
  }

 private:
  friend class Solver;                                            // only error solving does this:
  void reset_faults() noexcept { ++orders_.fault_reset_serial; }  // of drives
  void reset_nodes(std::uint16_t nodes) noexcept;
  void forget(std::uint16_t nodes) noexcept;   // clears the diagnosis, diagnoses again
  bool isolate(std::uint16_t nodes) noexcept;  // false when the locomotion controller refuses

  struct Wheel {
    Known motor_rpm, hall_rpm, reduction_rpm, current_permille, temperature_degC, link_V;
  };
  struct Steering {
    Known motor_rad, reduction_rad, current_permille;
  };

  // read
  void take(const WheelMotion& m, TimeNs time) noexcept;
  void take(const WheelSpeeds& m, TimeNs time) noexcept;
  void take(const WheelHealth& m, TimeNs time) noexcept;
  void take(const SteeringMotion& m, TimeNs time) noexcept;
  void take(const SteeringAngle& m, TimeNs time) noexcept;
  void take(const ardito::Inputs& m, TimeNs time) noexcept;
  void take(const Rocker& m, TimeNs time) noexcept;
  void take(const Imu& m, TimeNs time) noexcept;

  // watch
  void watch_bus(const BusReport& bus, Supervisor& s) noexcept;
  void watch_nodes(Supervisor& s) noexcept;
  void watch_inputs(Supervisor& s) noexcept;
  void watch_mobility(Supervisor& s) noexcept;
  void watch_wheel(std::size_t wheel, Supervisor& s) noexcept;
  void watch_steering(std::size_t system, Supervisor& s) noexcept;
  void watch_imu(Supervisor& s) noexcept;
  void watch_slip(Supervisor& s) noexcept;
  void watch_slowed(Supervisor& s) noexcept;
  void watch_sinking(Supervisor& s) noexcept;
  void watch_yaw(Supervisor& s) noexcept;
  void watch_heat(std::size_t wheel, Supervisor& s) noexcept;
  void watch_unproven(std::size_t wheel, Supervisor& s) noexcept;
  void watch_mode(Supervisor& s) noexcept;
  void watch_solver(Supervisor& s) noexcept;
  void begin_solving(const Supervisor& s) noexcept;
  void set_sense(Supervisor& s) noexcept;
  bool healthy(const Supervisor& s) const noexcept;
  bool all_heard() const noexcept;

  const RoverLink& link(std::size_t node) const noexcept { return bus_.status.link[node]; }
  bool answers(std::size_t node) const noexcept;
  bool in_service(std::size_t node) const noexcept { return (isolated_ >> node & 1u) == 0; }
  bool faulty(std::size_t node) const noexcept;  // a drive
  bool contact() const noexcept;                 // with all nodes that are needed
  bool standing() const noexcept;
  bool wheels_rest() const noexcept;
  bool drives_enabled() const noexcept;
  gnc::ardito::Reading reading(const Known& known, double scale = 1) const noexcept;
  bool has_fault(gnc::ardito::Fault fault) const noexcept;  // of the last frame
  double autonomy_wait_s() const noexcept;
  void measure() noexcept;
  void reckon() noexcept;
  void describe_node(std::size_t node, lss_ArditoNode& out) const noexcept;
  void describe_sunk(Telemetry& out) const noexcept;

  Parameters parameters_;
  TunableValues tunables_;  // of the parameters
  gnc::ardito::Redundant mobility_;
  gnc::ardito::Measured measured_;
  gnc::ardito::Request request_;
  gnc::ardito::Command command_;
  double radius_m_;  // no state: constant
  double gear_;      // no state: constant

  std::array<Wheel, kWheels> wheel_{};
  std::array<Steering, kSteered> steering_{};
  Known beta_rad_, rho1_rad_, rho2_rad_;
  Known imu_speed_m_s_, imu_sigma_rad_, imu_yaw_rate_rad_s_;
  std::uint16_t imu_counter_ = 0;
  ardito::Inputs inputs_{};
  TimeNs inputs_ns_ = 0;

  BusReport bus_{};  // of the frame
  Supervisor* supervisor_ = nullptr;
  RoverOrders orders_{};  // as wanted
  RoverOrders sent_{};    // as they left the gate

  TimeNs now_ns_ = 0;
  TimeNs started_ns_ = 0;  // the beacon went on
  bool beacon_ = false;
  bool by_itself_ = false;  // autonomous driving, since activated_ns_
  TimeNs activated_ns_ = 0;
  TimeNs rests_ns_ = 0;  // since then it has rested in Idle with its drives braking
  bool drives_on_ = false;
  double limit_m_s_ = kSpeedLimits_m_s[0];
  double wanted_m_s_ = 0, wanted_rad_ = 0;  // commanded
  bool correction_ = true;
  double ramped_m_s_ = 0;  // on its way to the commanded one
  std::uint32_t retry_wheels_ = 0, retry_steering_ = 0;
  std::uint16_t isolated_ = 0;  // by the locomotion controller
  std::uint16_t restored_ = 0;  // nodes, last at restored_ns_
  TimeNs restored_ns_ = 0;
  bool stepped_ = false;  // the mobility controller, in the last frame
  bool data_requested_ = false;

  // State already reported.
  kit::PortWatch port_;
  kit::NodeWatch watched_;
  std::array<gnc::ardito::WheelFailure, kWheels> failure_{};
  std::array<gnc::ardito::SteeringFailure, kSteered> steering_failure_{};
  bool error_ = false, rocker_lost_ = false;
  bool imu_lost_ = true, imu_seen_ = false, imu_told_ = false;
  std::uint16_t embedded_ = 0;    // the wheel that dug itself in, as a module; 0: none
  std::uint8_t disagreeing_ = 0;  // 1..3; 0: none
  bool slipping_ = false, stuck_ = false, stuck_told_ = false, embedded_told_ = false,
       yaw_told_ = false;
  int slip_frames_ = 0, yaw_good_frames_ = 0;
  double most_slip_m_s_ = 0;    // since it began
  bool slowed_ = false;         // by slip
  double most_slip_share_ = 0;  // since then
  std::uint32_t hot_ = 0;       // wheels
  // Wheels whose failure error solving forgot, and for how long each has worked since.
  std::uint32_t unproven_ = 0, unproven_told_ = 0;
  std::array<int, kWheels> proven_frames_{};

  Solver solver_;
  double distance_m_ = 0, yaw_rad_ = 0, x_m_ = 0, y_m_ = 0;
};

// The wiring: one port, one bus of nodes.
class Buses final : public kit::OnePort<Vehicle, RoverCanBus> {
 public:
  using Parameters = ardito::Parameters;

  Buses(const config::Config& config, const Parameters& parameters);
  std::string wrong_configuration() const;  // its period of frames

 private:
  TimeNs period_ns_;
};

}  // namespace lss::ardito
