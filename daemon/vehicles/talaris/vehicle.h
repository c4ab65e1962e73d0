#pragma once

// TALARIS in the daemon: the stages of its cycle (daemon/cycle/cycle.h). An IMU and an altimeter on
// serial lines, eight valves and four fans on a CAN bus; navigation, guidance and control of
// gnc/talaris fly the plan; valves and fans are also moved by hand and by scripts. Faults in the
// air are reported at once and become an emergency on the ground. Frame thread; time is data; no
// allocation.

#include <talaris_fields.h>  // of the IDL

#include <algorithm>
#include <array>
#include <cstdint>

#include "daemon/cycle/cycle.h"
#include "daemon/cycle/resets.h"
#include "daemon/kit/port_watch.h"
#include "daemon/vehicles/talaris/buses.h"
#include "daemon/vehicles/talaris/config.h"
#include "daemon/vehicles/talaris/gate.h"
#include "daemon/vehicles/talaris/hand.h"
#include "daemon/vehicles/talaris/modes.h"
#include "daemon/vehicles/talaris/script.h"
#include "daemon/vehicles/talaris/sensors.h"
#include "daemon/vehicles/talaris/solver.h"
#include "gnc/talaris/checked_navigation.h"
#include "gnc/talaris/contact.h"
#include "gnc/talaris/flight.h"

namespace lss::talaris {

class Vehicle final : public Actor {
 public:
  using Sample = TalarisSample;
  using BusReport = talaris::BusReport;
  using Command = TalarisOrders;
  using Telemetry = lss_TalarisTelemetry;
  static constexpr std::size_t kMaxSamples = 256;

  explicit Vehicle(const Parameters& parameters) noexcept;

  void read(const lss::Inputs<Vehicle>& in) noexcept;
  void watch(const lss::Inputs<Vehicle>& in, Supervisor& supervisor) noexcept;
  Verdict consider(const Request& request) noexcept override;
  void act(lc::ActionSet actions, const Request* request) noexcept override;
  Adjusted adjust(std::size_t index, double value, bool really) noexcept override;
  void navigate(TimeNs now) noexcept;
  void guide(TimeNs now) noexcept;
  Command control(TimeNs now) noexcept;
  Command gate(const Command& wanted, Supervisor& supervisor, TimeNs now) noexcept;
  // Fills the telemetry; true when a sample was requested.
  bool describe(const lss::Inputs<Vehicle>& in, const SupervisorState& state,
                Telemetry& out) noexcept;

  const gnc::talaris::FlightOutput& flight() const noexcept { return output_; }
  const TunableValues& tunables() const noexcept { return tunables_; }
  const gnc::talaris::NavState& nav() const noexcept { return navigation_.state(); }

  // For records (daemon/record/state.h): every member that the cycle changes.
  template <class V>
  void keep(V& v) {
    v(parameters_, tunables_, sensors_, navigation_, flight_, contact_, output_, hand_, script_,
      solver_, bus_, orders_, sent_, enabled_, now_ns_, executed_ns_, data_requested_, overrun_,
      arming_, gate_failed_, cut_ns_, begun_, program_, port_, reboots_, emcys_, begun_ns_, resets_,
      imu_silent_told_, imu_stuck_told_, lossy_told_, test_told_, altimeter_told_,
      altimeter_stuck_told_, doubted_told_, uneven_told_, corner_told_, camera_told_, standby_told_,
      disagree_told_, disagreed_, supply_told_, load_cell_told_, script_told_, phase_, reaction_,
      faults_, pending_);
  }

 private:
  // Commands (commands.cpp).
  Verdict consider_execute() const noexcept;
  Verdict consider_valves(std::uint8_t valves) const noexcept;
  gnc::talaris::PlanRequest plan_request(const Request& request) const noexcept;
  void carry_out(const Request& request) noexcept;
  void plan(const Request& request) noexcept;
  void end_script() noexcept;
  void tell(EventId id, double a = 0, double b = 0, double c = 0, double d = 0) const noexcept;

  // Watch (watch.cpp, watch_flight.cpp).
  void watch_bus(const HopperCan::Report& bus, Supervisor& s) noexcept;
  void watch_resets(Supervisor& s) noexcept;
  void watch_nodes(Supervisor& s) noexcept;
  void watch_node(std::size_t node, Supervisor& s) noexcept;
  void watch_link(std::size_t node, Supervisor& s) noexcept;
  void watch_imu(Supervisor& s) noexcept;
  void watch_altimeter(Supervisor& s) noexcept;
  void watch_corners(Supervisor& s) noexcept;
  void watch_camera(Supervisor& s) noexcept;
  void watch_supply(Supervisor& s) noexcept;
  void tell_sense(Supervisor& s) const noexcept;
  void watch_hand(Supervisor& s) noexcept;
  void watch_script(Supervisor& s) noexcept;
  void watch_calibration(Supervisor& s) noexcept;
  void watch_flight(Supervisor& s) noexcept;
  void watch_faults(Supervisor& s) noexcept;
  void watch_actuators(Supervisor& s) noexcept;
  void watch_solver(Supervisor& s) noexcept;
  void begin_solving(const Supervisor& s) noexcept;
  void warn(bool wrong, bool& told, FaultId id, std::uint16_t subject, Supervisor& s) noexcept;

  // For error solving. Sets of modules as bits: bit i is module i+1.
  std::uint16_t faulty_modules() const noexcept;  // modules that are needed
  void reset_modules(std::uint16_t modules) noexcept;
  void realign() noexcept;

  Mode mode() const noexcept;
  const HopperLink& link(std::size_t node) const noexcept { return bus_.can.status.link[node]; }
  bool answers(std::size_t node) const noexcept;
  // A frame wakes after its T_k and may know later messages.
  TimeNs age_of(TimeNs heard_ns) const noexcept { return std::max<TimeNs>(now_ns_ - heard_ns, 0); }
  bool flying() const noexcept;  // the flight commands valves and fans
  int fan_step_us() const noexcept;
  void feel_ground(gnc::talaris::FlightInputs& in) noexcept;
  bool altimeter_repeats() const noexcept;
  gnc::talaris::RangeSample range_by_corners() const noexcept;
  void actuate_flight() noexcept;
  void count_gas() noexcept;
  void describe_modules(Telemetry& out) const noexcept;
  void describe_flight(Telemetry& out) const noexcept;
  void describe_actuators(Telemetry& out) const noexcept;

  Parameters parameters_;
  TunableValues tunables_;  // of the parameters
  Sensors sensors_;
  gnc::talaris::CheckedNavigation navigation_;
  gnc::talaris::Flight flight_;
  gnc::talaris::Contact contact_;
  gnc::talaris::FlightOutput output_;  // of the last frame, at the latest
  Hand hand_;
  Script script_;
  Solver solver_;

  BusReport bus_{};  // of the frame
  Supervisor* supervisor_ = nullptr;
  TalarisOrders orders_{};  // as wanted
  TalarisOrders sent_{};    // as they left the gate
  std::uint8_t enabled_ = 0xFF;
  TimeNs now_ns_ = 0;
  TimeNs executed_ns_ = 0;
  bool data_requested_ = false;
  bool overrun_ = false;
  bool arming_ = false;  // the start-up of the fans' speed controllers is running
  int gate_failed_ = 0;  // frames in a row, in the air
  TimeNs cut_ns_ = 0;    // since when both nodes are away: the bus; 0: they are not
  bool begun_ = false;   // execute found a plan
  std::uint8_t program_ = 0;

  // State already reported.
  kit::PortWatch port_;
  std::array<std::uint64_t, kHopperNodes> reboots_{}, emcys_{};
  TimeNs begun_ns_ = 0;  // for sensors: the first frame
  Resets resets_;        // of modules
  bool camera_told_ = false, standby_told_ = false, disagree_told_ = false, disagreed_ = false,
       imu_silent_told_ = false, imu_stuck_told_ = false, lossy_told_ = false, test_told_ = false;
  bool altimeter_told_ = false, altimeter_stuck_told_ = false, doubted_told_ = false,
       uneven_told_ = false, supply_told_ = false, load_cell_told_ = false;
  std::array<bool, kCornerAltimeters> corner_told_{};
  std::uint16_t script_told_ = 0;
  gnc::talaris::Phase phase_ = gnc::talaris::Phase::none;
  gnc::talaris::Reaction reaction_ = gnc::talaris::Reaction::none;
  gnc::talaris::FaultSet faults_ = 0, pending_ = 0;  // reported; not yet an emergency
};

}  // namespace lss::talaris
