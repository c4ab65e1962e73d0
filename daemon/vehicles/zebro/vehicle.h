#pragma once

// Lunar Zebro inside the cycle: samples of seven modules in, orders for seven modules out, the
// locomotion algorithm in between. daemon/cycle/cycle.h calls the stages in the order of this file,
// on the frame thread; time is data, nothing allocates. The wiring (port and driver) is Buses,
// below.

#include <zebro_fields.h>  // of the IDL

#include <array>
#include <cstdint>

#include "daemon/cycle/cycle.h"
#include "daemon/cycle/resets.h"
#include "daemon/kit/node_watch.h"
#include "daemon/kit/one_port.h"
#include "daemon/kit/port_watch.h"
#include "daemon/runtime/progress.h"
#include "daemon/runtime/serial_bus.h"
#include "daemon/vehicles/zebro/config.h"
#include "daemon/vehicles/zebro/gate.h"
#include "daemon/vehicles/zebro/modes.h"
#include "daemon/vehicles/zebro/report_check.h"
#include "daemon/vehicles/zebro/rounds.h"
#include "daemon/vehicles/zebro/solver.h"
#include "gnc/zebro/sinking.h"

namespace lss::zebro {

using LegSerialBus = SerialBus<LegBus, LegBusParameters, BusOrders, ModuleReply, BusCounters>;

// State of one module.
struct Module {
  Status status;
  Health health;
  Identity identity;
  TimeNs heard_ns = 0;       // 0: never
  TimeNs status_ns = 0;      // of the last status
  TimeNs over_limit_ns = 0;  // since when the current is above the software limit; 0: it is not
  bool hot = false;
  std::uint16_t reported = 0;  // flags of the last status
  std::uint16_t believed = 0;  // each as in the last two statuses that agree
  bool greeted = false;        // a status was received
  bool reset = false;          // shown by two statuses, in this frame
};

class Vehicle final : public Actor {
 public:
  using Sample = ModuleReply;
  using BusReport = LegSerialBus::Report;
  using Command = BusOrders;
  using Telemetry = lss_ZebroTelemetry;
  static constexpr std::size_t kMaxSamples = 64;

  explicit Vehicle(const Parameters& parameters) noexcept;

  void read(const Inputs<Vehicle>& in) noexcept;
  void watch(const Inputs<Vehicle>& in, Supervisor& supervisor) noexcept;
  void act(lc::ActionSet actions, const Request* request) noexcept override;
  Verdict consider(const Request& request) noexcept override;
  Adjusted adjust(std::size_t index, double value, bool really) noexcept override;
  void navigate(TimeNs now) noexcept;
  void guide(TimeNs now) noexcept;
  Command control(TimeNs now) noexcept;
  Command gate(const Command& wanted, Supervisor& supervisor, TimeNs now) noexcept;
  // Fills the telemetry; true when a sample was requested.
  bool describe(const Inputs<Vehicle>& in, const SupervisorState& state, Telemetry& out) noexcept;

  // For error solving.
  TimeNs now() const noexcept { return now_ns_; }
  bool answers(std::size_t module) const noexcept;
  // What it reports cannot be true (daemon/vehicles/zebro/report_check.h).
  bool doubtful(std::size_t module) const noexcept {
    return checks_[module].finding(now_ns_) != ReportCheck::Finding::none;
  }
  const Status& status(std::size_t module) const noexcept { return modules_[module].status; }
  double temperature_degC(std::size_t module) const noexcept {
    return modules_[module].health.temperature_degC;
  }
  // Bit i: something is wrong with module i+1, and it is in service.
  std::uint8_t faulty_modules() const noexcept;
  std::uint8_t isolated() const noexcept { return static_cast<std::uint8_t>(isolated_); }

  const std::array<Module, kModules>& modules() const noexcept { return modules_; }
  const TunableValues& tunables() const noexcept { return tunables_; }

  // For records (daemon/record/state.h): every member that the cycle changes.
  template <class V>
  void keep(V& v) {
    v(parameters_, tunables_, locomotion_, measured_, modules_, checks_, lateness_, found_,
      flags_before_, disobeyed_, resends_before_, segment_, orders_, sent_, walk_, solver_, rounds_,
      operated_ns_, isolated_, walks_without_, epoch_ns_, now_ns_, before_ns_, walking_legs_,
      in_motion_, port_, motors_on_ns_, over_sum_ns_, noise_window_ns_, noise_frames_, bridge_,
      panel_, resets_, resets_seen_, data_requested_, sinking_, deep_strides_, side_strides_,
      in_soil_);
  }

 private:
  friend class ResetModules;  // only error solving does this:
  friend class MoveFree;
  friend class CoolDown;
  friend class Isolate;
  friend class Solver;
  void reset(std::size_t module) noexcept {
    if (in_service(module)) order(module, ModuleOrder::Kind::reset);
  }
  // False when the locomotion controller refuses.
  bool isolate(std::uint8_t modules) noexcept;
  // One leg may move until rest(); false when the locomotion controller refuses.
  bool begin_move(std::size_t leg) noexcept;
  void order_move(std::size_t module, double position_rad, TimeNs arrive_ns, bool forward) noexcept;
  void rest() noexcept;

  static constexpr std::size_t kPanel = kModules - 1;
  static constexpr unsigned kAllLegs = (1u << kLegs) - 1;  // as bits
  static constexpr std::uint16_t kStopFlags = kFlagOverCurrent | kFlagDriverFault | kFlagWatchdog;
  static constexpr TimeNs kMoveGrace = 3 * kSecond;  // a direct movement this late has failed

  struct Symptoms {
    std::array<Symptom, kMaxFaults + 6 * kModules> items;
    std::size_t count = 0;
    void add(const Symptom& symptom) noexcept { items[count++] = symptom; }
    std::span<const Symptom> all() const noexcept { return std::span(items).first(count); }
  };

  static constexpr std::uint16_t number(std::size_t module) noexcept {
    return static_cast<std::uint16_t>(module + 1);
  }

  double seconds(TimeNs time) const noexcept {
    return static_cast<double>(time - epoch_ns_) * 1e-9;
  }
  TimeNs nanoseconds(double time_s) const noexcept {
    return epoch_ns_ + static_cast<TimeNs>(time_s * 1e9);
  }
  void order_all(ModuleOrder::Kind kind) noexcept;
  void order(std::size_t module, ModuleOrder::Kind kind) noexcept;
  bool in_service(std::size_t module) const noexcept { return (isolated_ >> module & 1u) == 0; }

  void watch_resets(Supervisor& s) noexcept;
  void watch_modules(Supervisor& s) noexcept;
  void watch_reports(std::size_t module, Supervisor& s) noexcept;
  void watch_flags(std::size_t module, Supervisor& s) noexcept;
  void watch_current(std::size_t module, Supervisor& s) noexcept;
  void watch_current_sum(Supervisor& s) noexcept;
  void watch_bus(const BusReport& bus, Supervisor& s) noexcept;
  void watch_temperature(std::size_t module, Supervisor& s) noexcept;
  void watch_motor(std::size_t module, const ModuleLink& link) noexcept;
  void watch_obedience(std::size_t module, const ModuleLink& link, Supervisor& s) noexcept;
  void watch_motion(Supervisor& s) noexcept;
  void watch_ground(Supervisor& s) noexcept;
  void watch_solver(Supervisor& s) noexcept;
  void watch_rounds(Supervisor& s) noexcept;
  Symptoms symptoms(const Supervisor& s) const noexcept;
  void report_uncalibrated(Supervisor& s) noexcept;
  bool motors_confirmed() const noexcept;
  void describe_module(std::size_t module, const ModuleLink& link,
                       lss_ZebroModule& out) const noexcept;
  void watch_panel(Supervisor& s) noexcept;
  bool panel_known() const noexcept;
  bool panel_in() const noexcept;
  void seek_panel_sensor() noexcept;
  void creep_over_panel_sensor() noexcept;
  void drive_panel() noexcept;
  void begin_motion(lc::ActionSet actions, const Request* request) noexcept;
  void move_leg(const Request& request) noexcept;
  void watch_bridge(Supervisor& s) noexcept;
  void end_bridge() noexcept;
  void restore(const Request* request) noexcept;
  void move_panel(bool deploy) noexcept;
  void stop_panel() noexcept;
  void reset_modules(const Request& request) noexcept;
  void take(const ModuleReply& reply) noexcept;
  void begin_walk(const Request* request) noexcept;
  void feel_ground() noexcept;
  bool feels_soil() const noexcept { return (isolated_ & kAllLegs) == 0; }  // needs all legs

  Parameters parameters_;
  TunableValues tunables_;  // of the parameters
  gnc::zebro::Locomotion locomotion_;
  std::array<gnc::zebro::LegMeasured, kLegs> measured_{};
  std::array<Module, kModules> modules_{};
  std::array<ReportCheck, kModules> checks_{};
  std::array<Lateness, kModules> lateness_{};
  std::array<ReportCheck::Finding, kModules> found_{};  // in the frame before
  std::array<std::uint16_t, kModules> flags_before_{};
  std::array<bool, kModules> disobeyed_{};
  std::array<std::uint64_t, kModules> resends_before_{};
  std::array<std::uint32_t, kLegs> segment_{};  // the last one that was ordered

  BusOrders orders_{};  // as wanted
  BusOrders sent_{};    // as they left the gate
  gnc::zebro::WalkRequest walk_{};
  Solver solver_;
  Rounds rounds_;
  TimeNs operated_ns_ = 0;                         // since the last emergency
  Supervisor* supervisor_ = nullptr;               // of the frame
  std::uint16_t isolated_ = 0;                     // by the locomotion controller
  std::array<bool, 1u << kLegs> walks_without_{};  // with the configured gait, by set of legs
  TimeNs epoch_ns_ = 0;                            // of the locomotion's clock; 0: not begun
  TimeNs now_ns_ = 0, before_ns_ = 0;              // of this frame, of the last one
  bool walking_legs_ = false;                      // the legs follow the locomotion algorithm
  bool in_motion_ = false;                         // a motion of the algorithm has not ended yet
  kit::PortWatch port_;
  TimeNs motors_on_ns_ = 0;
  TimeNs over_sum_ns_ = 0;  // since when all motors draw too much; 0: they do not
  TimeNs noise_window_ns_ = 0;
  std::uint64_t noise_frames_ = 0;

  struct Bridge {
    std::size_t leg = 0;
    TimeNs due_ns = 0;  // 0: no leg moves by direct command
    // Of a leg out of service, whose motor comes on first and goes off after.
    bool switching_on = false;
    double position_rad = 0;
    TimeNs duration_ns = 0;
    bool forward = true;
  } bridge_;
  struct Panel {
    enum class Step : std::uint8_t {
      rest,
      switching_on,
      seeking,
      creeping,
      moving,
      ended  // its module is being reset: it stops on its way, and counts as out
    } step = Step::rest;
    bool deploy = false;
    TimeNs due_ns = 0;
  } panel_;
  Resets resets_;                                      // by command
  std::array<std::uint64_t, kModules> resets_seen_{};  // by the bus, in all
  bool data_requested_ = false;

  static constexpr int kDeepStrides = 2, kSideStrides = 3;  // in a row, of both sides; of one
  static constexpr double kSideShare = 2;  // of soil_share: turning on the spot tilts it to a side
  static constexpr unsigned kBothSides = 3;
  gnc::zebro::Sinking sinking_;        // belly and legs stay as constructed
  std::array<int, 2> deep_strides_{};  // in a row with the left, the right side in the soil
  std::array<int, 2> side_strides_{};  // so deep that it is reported of this side alone
  unsigned in_soil_ = 0;               // what is reported: bit 0 left, bit 1 right
};

// The wiring: one port, one bus of leg modules.
class Buses final : public kit::OnePort<Vehicle, LegSerialBus> {
 public:
  using Parameters = zebro::Parameters;

  Buses(const config::Config& config, const Parameters& parameters);

  // Frames that are too long, or a link that would break off a safe stop.
  const std::string& wrong_configuration() const { return wrong_times_; }

 private:
  std::string wrong_times_;
};

}  // namespace lss::zebro
