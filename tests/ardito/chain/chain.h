#pragma once

// The whole chain of D.I.A.N.A. Ardito in virtual time, one thread, nothing waits for a clock: a
// command passes armour, supervisor, vehicle and bus master as in lssd, frames pass the CAN bus bit
// by bit, and lss-sim's nodes and rover follow their orders, in physics. The parts are the shipping
// ones, parameters are read from config/ardito.toml as lssd reads them; what is made here is only
// the order of events that the threads have in daemon/app/runtime.h and can_bus.h: samples before
// T_k into the frame that begins at T_k, its orders to the bus at T_k + offset. The same options
// give the same run, to the bit.
//
//   Chain chain({.rover = {.ground = sim::ardito::Ground::rough}, .seed = 7});
//   chain.start();
//   chain.drive(0.5);
//   chain.inject("E-TM:2");                               // as `lss-sim fault`
//   chain.run_until([&] { return chain.telemetry().wheels[1].state != 0; }, 1);

#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/runtime/command_port.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/stop_latch.h"
#include "daemon/vehicles/ardito/vehicle.h"
#include "tools/lss-sim/ardito/vehicle.h"

namespace lss::ardito {

class Chain {
 public:
  struct Options {
    sim::ardito::RoverOptions rover{};  // its seed is the one below
    unsigned seed = 1;                  // of the ground, noise, and the phases of the clocks
    // A last change of the configuration.
    std::function<void(Parameters&)> adjust{};
  };

  Chain() : Chain(Options{}) {}
  // Throws std::runtime_error when the configuration cannot be read.
  explicit Chain(const Options& options);
  ~Chain();
  Chain(const Chain&) = delete;
  Chain& operator=(const Chain&) = delete;

  // ---- Time. Frames begin every period; a run may end between them.
  TimeNs now() const { return now_ns_; }
  double seconds() const { return static_cast<double>(now_ns_ - kBegin) * 1e-9; }
  TimeNs frame_ns() const { return in_.time_ns; }  // of the last frame
  std::uint64_t frames() const { return in_.frame; }
  void run(double seconds);
  // Looks after every frame. False: not within the limit.
  bool run_until(const std::function<bool()>& condition, double limit_s);
  bool run_until(State state, double limit_s);
  bool run_until(Mode mode, double limit_s);

  // Given every frame, when it is set: a flight recording (tests/support/tape.h).
  std::function<void(const lss::Inputs<Vehicle>&, const Outputs<Vehicle>&, Supervisor&, Vehicle&)>
      tape{};

  // ---- Actions of an operator. Each command is from "test".
  template <class Kind>
  std::uint64_t send(Kind kind, std::initializer_list<double> parameters = {}) {
    return send(static_cast<std::uint16_t>(kind), std::span(parameters.begin(), parameters.size()));
  }
  std::uint64_t send(std::uint16_t kind, std::span<const double> parameters);
  void heartbeat(bool on) { heartbeat_ = on; }  // of "test", five times a second; on at first
  std::uint32_t lease_ms = 10'000;              // of commands
  // What of the daemon goes on: halted, its bus thread alone; killed, nothing.
  enum class Daemon { runs, halted, killed } daemon = Daemon::runs;
  // From Idle to Stopped with all motors on; to Running, which is not yet at speed. False when it
  // does not come to that in its time.
  bool start(SpeedLimit limit = SpeedLimit::erc);
  bool drive(double speed_m_s, double heading_rad = 0, bool correction = true);

  // ---- Faults, written as for lss-sim: "E-TM:2", "noise:0.01", "clear:noise", "clear".
  void inject(const std::string& fault);
  std::vector<std::string> attached() { return board_->attached(); }
  std::span<const sim::FaultKind> fault_kinds() const { return fault_kinds_; }

  // ---- Output of the daemon.
  const SupervisorState& supervisor() const { return supervisor_.state(); }
  State state() const { return supervisor_.controller().state; }
  Mode mode() const { return static_cast<Mode>(supervisor_.controller().mode); }
  bool has(FaultId id, std::uint16_t subject = 0) const;
  const lss_ArditoTelemetry& telemetry() const { return out_.telemetry; }
  const RoverOrders& orders() const { return out_.command; }
  const gnc::ardito::Command& mobility() const { return vehicle_.command(); }
  std::vector<Ack> acks;
  std::vector<EventRecord> events;

  // ---- True state.
  const sim::ardito::Ardito& world() const { return *world_; }
  nlohmann::ordered_json truth() const { return world_->truth(); }
  const config::Config& config() const { return config_; }
  const Parameters& parameters() const { return parameters_; }
  // For soft errors of the mobility controller.
  gnc::ardito::Redundant& instances() { return vehicle_.mobility(); }

 private:
  static constexpr TimeNs kBegin = 1000 * kSecond;
  static constexpr TimeNs kNever = INT64_MAX;

  void post(Request request);
  void act(const sim::Fault& fault, bool attach);
  TimeNs next_event();
  void pass(TimeNs until);
  void happen();
  void turn();
  void all_stop();
  void frame();

  Parameters parameters_;
  config::Config config_;
  TimeNs now_ns_ = kBegin;

  // The world.
  std::unique_ptr<sim::ardito::Ardito> world_;
  std::unique_ptr<sim::CanBus> line_;
  std::vector<sim::FaultKind> fault_kinds_;
  std::unique_ptr<sim::FaultBoard> board_;
  TimeNs step_ns_ = kBegin;  // of the next step of the physics

  // The daemon.
  RoverBus master_;
  StopLatch latch_;
  Vehicle::BusReport report_{};
  Ring<RoverSample, 256> samples_;
  Vehicle vehicle_;
  Supervisor supervisor_;
  CommandPort port_;
  lss::Inputs<Vehicle> in_{};
  Outputs<Vehicle> out_{};
  TimeNs frame_ns_ = 0;         // of the next frame
  TimeNs release_ns_ = kNever;  // of the orders of the last one

  bool heartbeat_ = true;
  TimeNs heartbeat_ns_ = kBegin;
  std::uint64_t sequence_ = 0;
};

}  // namespace lss::ardito
