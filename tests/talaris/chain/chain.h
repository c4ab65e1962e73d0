#pragma once

// The whole chain of TALARIS in virtual time, one thread, nothing waits for a clock: a command
// passes armour, supervisor, vehicle and bus master as in lssd, bytes pass the serial lines at
// their rate and frames the CAN bus bit by bit, and lss-sim's sensors, nodes and hopper
// follow their orders, in physics. The parts are the shipping ones, parameters are read from a file
// in config/talaris/ as lssd reads it; what is made here is only the order of events that the
// threads have in daemon/app/runtime.h and daemon/vehicles/talaris/buses.h: the IMU's packets
// begin the frames, samples before T_k go into the frame that begins at T_k, its orders to the
// buses at T_k + offset, the edges of valves at their own times. The same options give the same
// run, to the bit.
//
//   Chain chain({.config = "hop", .world = dispersed({}, 7), .seed = 7});
//   chain.prepare();                                      // started, armed, calibrated
//   chain.fly(Program::hop, {.height_m = 2, .distance_m = 30});
//   chain.inject("altimeter-silent");                     // as `lss-sim fault`
//   chain.run_until([&] { return chain.rests(); }, 60);

#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/runtime/command_port.h"
#include "daemon/runtime/frames.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/stop_latch.h"
#include "daemon/vehicles/talaris/vehicle.h"
#include "tests/talaris/chain/line.h"
#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::talaris {

class Chain {
 public:
  struct Options {
    std::string config = "hop";            // config/talaris/NAME.toml
    sim::talaris::TalarisOptions world{};  // its seed is the one below
    unsigned seed = 1;                     // of noise, biases, and the phases of the clocks
    // Share of the frames whose orders are released late, and by how much at most.
    double late_share = 0, late_s = 0;
    // A last change of the configuration.
    std::function<void(Parameters&)> adjust{};
  };
  struct HopRequest {
    double height_m = 2, distance_m = 30, turn_rad = 0, time_s = 0;
  };

  // Throws std::runtime_error when the configuration cannot be read.
  explicit Chain(const Options& options);
  ~Chain();
  Chain(const Chain&) = delete;
  Chain& operator=(const Chain&) = delete;

  // ---- Time. A run may end between frames.
  TimeNs now() const { return now_ns_; }
  double seconds() const { return static_cast<double>(now_ns_ - kBegin) * 1e-9; }
  std::uint64_t frames() const { return in_.frame; }
  TimeNs frame_ns() const { return in_.time_ns; }  // of the last frame
  void run(double seconds);
  // Looks after every frame. False: not within the limit.
  bool run_until(const std::function<bool()>& condition, double limit_s);
  bool run_until(State state, double limit_s);
  bool run_until(Mode mode, double limit_s);
  bool run_until(Phase phase, double limit_s);
  // Called after every frame, and after every step of the physics.
  std::function<void()> after_frame{}, after_step{};

  // Given every frame, when it is set: a flight recording (tests/support/tape.h).
  std::function<void(const lss::Inputs<Vehicle>&, const Outputs<Vehicle>&, Supervisor&, Vehicle&)>
      tape{};

  // ---- Actions of an operator. Each command is from "test", with a lease of 60 s.
  template <class Kind>
  std::uint64_t send(Kind kind, std::initializer_list<double> parameters = {}) {
    return send(static_cast<std::uint16_t>(kind), std::span(parameters.begin(), parameters.size()));
  }
  std::uint64_t send(std::uint16_t kind, std::span<const double> parameters);
  void heartbeat(bool on) { heartbeat_ = on; }  // of "test", five times a second; on at first
  // From Idle to Manual; the fans' start-up; to Standby, calibrated. False: not in its time.
  bool start();
  bool arm();
  bool calibrate();
  bool prepare(bool fans = true) { return start() && (!fans || arm()) && calibrate(); }
  // From Standby: plans and executes. False: refused.
  bool fly(Program program, const HopRequest& request);
  // The reason of the last reject, none when there is none.
  Reason rejected() const;

  // ---- Faults, written as for lss-sim: "node-silent:0x20", "clear:push", "clear".
  void inject(const std::string& fault);
  std::vector<std::string> attached() { return board_->attached(); }
  std::span<const sim::FaultKind> fault_kinds() const { return fault_kinds_; }

  // ---- Output of the daemon.
  const SupervisorState& supervisor() const { return supervisor_.state(); }
  State state() const { return supervisor_.controller().state; }
  Mode mode() const { return static_cast<Mode>(supervisor_.controller().mode); }
  Phase phase() const { return Phase{out_.telemetry.phase}; }
  bool airborne() const { return supervisor_.airborne(); }
  bool has(FaultId id, std::uint16_t subject = 0) const;
  const lss_TalarisTelemetry& telemetry() const { return out_.telemetry; }
  const TalarisOrders& orders() const { return out_.command; }
  const Vehicle& vehicle() const { return vehicle_; }
  const EdgeReport& edges_now() const { return edges_; }
  // Input of the last frame.
  std::span<const TalarisSample> samples() const {
    return std::span(in_.samples).first(in_.sample_count);
  }
  std::vector<Ack> acks;
  std::vector<EventRecord> events;

  // ---- True state.
  sim::talaris::Talaris& world() { return *world_; }
  const sim::talaris::Talaris& world() const { return *world_; }
  const sim::talaris::BodyState& body() const { return world_->plant().body(); }
  bool rests() const;  // Execute is over, or everything was stopped, and the vehicle is still
  const config::Config& config() const { return config_; }
  const Parameters& parameters() const { return parameters_; }

 private:
  static constexpr TimeNs kBegin = 1000 * kSecond;
  static constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();

  void post(Request request);
  void act(const sim::Fault& fault, bool attach);
  TimeNs next_event();
  void pass(TimeNs until);
  void happen();
  void release();
  void obey();
  void send_edges(TimeNs due_ns);
  void turn_can();
  void begin_frame();
  void frame(const Boundary& boundary);
  void collect(const Boundary& boundary);

  Parameters parameters_;
  config::Config config_;
  double late_share_, late_s_;
  std::mt19937 lateness_;
  TimeNs now_ns_ = kBegin;

  // The world.
  std::unique_ptr<sim::talaris::Talaris> world_;
  std::unique_ptr<sim::CanBus> wire_;
  std::vector<sim::FaultKind> fault_kinds_;
  std::unique_ptr<sim::FaultBoard> board_;
  TimeNs step_ns_ = kBegin;  // of the next step of the physics

  // The daemon's buses and the actuate thread's part.
  Line imu_, altimeter_;
  HopperBus master_;
  HopperCan::Report can_{};
  Ring<TalarisSample, 256> samples_;
  ValveSequencer valves_;
  StopLatch latch_;
  EdgeReport edges_{};
  std::uint32_t reset_serial_ = 0;
  SensorGrid grid_;
  Boundary boundary_{};

  // Its cycle.
  Vehicle vehicle_;
  Supervisor supervisor_;
  CommandPort port_;
  lss::Inputs<Vehicle> in_{};
  Outputs<Vehicle> out_{};
  TimeNs release_ns_ = kNever;  // of the orders of the last frame

  bool heartbeat_ = true;
  TimeNs heartbeat_ns_ = kBegin;
  std::uint64_t sequence_ = 0;
};

}  // namespace lss::talaris
