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
#include <memory>
#include <random>
#include <span>
#include <string>
#include <string_view>

#include "daemon/runtime/frames.h"
#include "daemon/runtime/stop_latch.h"
#include "daemon/vehicles/talaris/vehicle.h"
#include "tests/support/virtual_chain.h"
#include "tests/talaris/chain/line.h"
#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::talaris {

// Commands have a lease of 60 s.
class Chain final : public testing_support::VirtualChain<Vehicle, Mode, Parameters> {
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

  using VirtualChain::run_until;
  bool run_until(const std::function<bool()>& condition, double limit_s) override;
  bool run_until(Phase phase, double limit_s);
  // Called after every frame, and after every step of the physics.
  std::function<void()> after_frame{}, after_step{};

  // From Idle to Manual; the fans' start-up; to Standby, calibrated. False: not in its time.
  bool start();
  bool arm();
  bool calibrate();
  bool prepare(bool fans = true) { return start() && (!fans || arm()) && calibrate(); }
  // From Standby: plans and executes. False: refused.
  bool fly(Program program, const HopRequest& request);
  // The reason of the last reject, none when there is none.
  Reason rejected() const;

  // ---- Output of the daemon.
  Phase phase() const { return Phase{out_.telemetry.phase}; }
  bool airborne() const { return supervisor_.airborne(); }
  const EdgeReport& edges_now() const { return edges_; }
  // Input of the last frame.
  std::span<const TalarisSample> samples() const {
    return std::span(in_.samples).first(in_.sample_count);
  }

  // ---- True state.
  sim::talaris::Talaris& world() { return *world_; }
  const sim::talaris::Talaris& world() const { return *world_; }
  const sim::talaris::BodyState& body() const { return world_->plant().body(); }
  std::vector<Memory> memory() override;
  std::vector<Memory> more_memory() override;
  bool rests() const;  // Execute is over, or everything was stopped, and the vehicle is still

 private:
  void act(const sim::Fault& fault, bool attach) override;
  bool in_force(const sim::Fault& fault) const override {
    const bool off = std::string_view(fault.kind->name) == "bus-off";
    return off ? wire_->is_off() : world_->in_force(fault);
  }
  TimeNs next_event() override;
  void dispatch() override;
  void all_stop() override { latch_.ask(now_ns_); }
  void release();
  void obey();
  void check_valves();
  void send_edges(TimeNs due_ns);
  void forget();
  void turn_can();
  void begin_frame();
  void frame(const Boundary& boundary);

  std::unique_ptr<sim::talaris::Talaris> world_;
  std::unique_ptr<sim::CanBus> wire_;
  double late_share_, late_s_;
  std::mt19937 lateness_;

  // The daemon's buses and the actuate thread's part.
  Line imu_, altimeter_;
  std::optional<Line> camera_, standby_;
  std::vector<std::unique_ptr<Line>> corners_;
  HopperBus master_;
  Twin<sizeof(HopperBus)> master_twin_;
  HopperCan::Report can_{};
  TalarisOrders ordered_{};  // that the bus thread had last
  SampleQueue<TalarisSample> samples_;
  ValveSequencer valves_;
  Twin<sizeof(ValveSequencer)> valves_twin_;
  StopLatch latch_;
  EdgeReport edges_{};
  std::uint32_t reset_serial_ = 0;
  std::uint64_t restarts_ = 0;  // of the CAN port, seen by the actuate thread
  SensorGrid grid_;
  Twin<sizeof(SensorGrid)> grid_twin_;
  TimeNs
      deadline_ns_;  // until then the frame thread sleeps, even if a flip changes the grid's memory
  Boundary boundary_{};
};

}  // namespace lss::talaris
