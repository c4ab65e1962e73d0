#pragma once

// The whole chain of Lunar Zebro in virtual time, one thread, nothing waits for a clock: a command
// passes armour, supervisor, vehicle and bus master as in lssd, bytes pass the line at its rate,
// and lss-sim's modules and robot follow their orders. The parts are the shipping ones, parameters
// are read from config/zebro.toml as lssd reads them; what is made here is only the order of events
// that the threads have in daemon/app/runtime.h: samples up to T_k into the frame that begins at
// T_k, its orders to the bus at T_k + offset. The same options give the same run, to the bit.
//
//   Chain chain({.seed = 7});
//   chain.stand();
//   chain.walk(forward, heading_rad, speed);
//   chain.run(3.217);
//   chain.inject("module-reset:3");                       // as `lss-sim fault`
//   chain.run_until(State::fatal_error, 0.5);
//   chain.wire();                                         // the master's frames, with their times

#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/runtime/command_port.h"
#include "tests/zebro/chain/bus_line.h"
#include "tests/zebro/chain/frame_bus.h"
#include "tools/lss-sim/frame/faults.h"
#include "tools/lss-sim/zebro/plant.h"

namespace lss::sim::zebro {
class Zebro;
}

namespace lss::zebro {

class Chain {
 public:
  struct Options {
    unsigned seed = 1;  // of legs at boot, stones, noise, and the phases of the clocks
    sim::zebro::TerrainOptions terrain{};  // its seed is the one above
    // Rigid bodies cost some 55 ms a second, kinematics 2 ms.
    sim::zebro::PlantKind plant = sim::zebro::PlantKind::dart;
    // The plant behind the line; empty: the plant above on that terrain, as in `lss-sim zebro`.
    std::function<std::unique_ptr<sim::zebro::Zebro>(const sim::zebro::TerrainOptions&)> vehicle{};
    // Frames on the line as a whole, for missions (frame_bus.h).
    bool whole_frames = false;
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
  void run(double seconds);
  // Looks after every frame. False: not within the limit.
  bool run_until(const std::function<bool()>& condition, double limit_s);
  bool run_until(State state, double limit_s);
  bool run_until(Mode mode, double limit_s);
  std::uint64_t frames() const { return in_.frame; }

  // Given every frame, when it is set: a flight recording (tests/support/tape.h).
  std::function<void(const lss::Inputs<Vehicle>&, const Outputs<Vehicle>&, Supervisor&, Vehicle&)>
      tape{};

  // ---- Actions of an operator. Each command is from `from`, with a lease of 2 s.
  template <class Kind>
  std::uint64_t send(Kind kind, std::initializer_list<double> parameters = {},
                     const char* from = "test", std::uint16_t flags = 0) {
    return send(static_cast<std::uint16_t>(kind), std::span(parameters.begin(), parameters.size()),
                from, flags);
  }
  std::uint64_t send(std::uint16_t kind, std::span<const double> parameters,
                     const char* from = "test", std::uint16_t flags = 0);
  void heartbeat(bool on) { heartbeat_ = on; }  // of "test", five times a second; on at first
  // From Idle to Standing, to Walking; false when it does not come to that in its time.
  bool stand();
  bool walk(bool forward = true, double heading_rad = 0,
            gnc::zebro::Speed speed = gnc::zebro::Speed::high);
  // From FatalError to Idle.
  bool solve(double limit_s = 120);

  // ---- Faults, written as for lss-sim: "module-dead:3", "noise:0.01", "clear:noise", "clear".
  void inject(const std::string& fault);
  std::span<const sim::FaultKind> fault_kinds() const { return fault_kinds_; }
  std::vector<std::string> attached() { return board_->attached(); }

  // ---- Output of the daemon.
  const SupervisorState& supervisor() const { return supervisor_.state(); }
  State state() const { return supervisor_.controller().state; }
  Mode mode() const { return static_cast<Mode>(supervisor_.controller().mode); }
  bool has(FaultId id, std::uint16_t subject = 0) const;
  bool has_fatal() const;
  const lss_ZebroTelemetry& telemetry() const { return out_.telemetry; }
  const BusOrders& orders() const { return out_.command; }
  const BusCounters& bus() const { return bus_->report().counters; }
  const Vehicle& vehicle() const { return *vehicle_; }
  const Ack* last_ack(std::uint64_t sequence) const;  // nullptr: none yet
  const EventRecord* last(EventId id) const;
  std::vector<Ack> acks;
  std::vector<EventRecord> events;

  // ---- True state.
  sim::zebro::Zebro& world() { return *world_; }
  // For the next chain, as its vehicle: the daemon ends, the world does not. Nothing else may be
  // done with this one after.
  std::unique_ptr<sim::zebro::Zebro> take_world();
  sim::zebro::BodyState body() const;
  // Every frame of the master so far, in order; forget() when it is no longer wanted.
  const std::vector<WireFrame>& wire() const { return bus_->wire; }
  void forget();  // wire, acks and events so far

  const config::Config& config() const { return config_; }
  const Parameters& parameters() const { return parameters_; }

 private:
  static constexpr TimeNs kBegin = 1000 * kSecond;
  static constexpr TimeNs kNever = INT64_MAX;

  void post(Request request);
  void act(const sim::Fault& fault, bool attach);
  bool in_force(const sim::Fault& fault) const;
  TimeNs next_event() const;
  void pass(TimeNs until);
  void happen();
  void frame();

  config::Config config_;
  Parameters parameters_;
  TimeNs now_ns_ = kBegin;

  // The world.
  std::unique_ptr<sim::zebro::Zebro> world_;
  std::unique_ptr<sim::Uart> line_;
  std::unique_ptr<sim::FaultBoard> board_;
  std::vector<sim::FaultKind> fault_kinds_;
  FrameBus* frame_bus_ = nullptr;  // with whole frames, else line_
  TimeNs step_ns_ = kBegin;        // of the next step of the physics
  TimeNs plug_ns_ = kNever;        // when an unplugged port is there again

  // The daemon.
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Vehicle> vehicle_;
  Supervisor supervisor_;
  CommandPort port_;
  Inputs<Vehicle> in_{};
  Outputs<Vehicle> out_{};
  TimeNs frame_ns_ = 0;         // of the next frame
  TimeNs release_ns_ = kNever;  // of the orders of the last one

  bool heartbeat_ = true;
  TimeNs heartbeat_ns_ = kBegin;
  std::uint64_t sequence_ = 0;
};

}  // namespace lss::zebro
