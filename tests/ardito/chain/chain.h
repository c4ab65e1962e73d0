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
#include <memory>

#include "daemon/runtime/stop_latch.h"
#include "daemon/vehicles/ardito/vehicle.h"
#include "tests/support/virtual_chain.h"
#include "tools/lss-sim/ardito/vehicle.h"

namespace lss::ardito {

// Commands have a lease of 10 s.
class Chain final : public testing_support::VirtualChain<Vehicle, Mode, Parameters> {
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

  // What of the daemon goes on: halted, its bus thread alone; killed, nothing.
  enum class Daemon { runs, halted, killed } daemon = Daemon::runs;

  // From Idle to Stopped with all motors on; to Running, which is not yet at speed. False when it
  // does not come to that in its time.
  bool start(SpeedLimit limit = SpeedLimit::erc);
  bool drive(double speed_m_s, double heading_rad = 0, bool correction = true);

  const gnc::ardito::Command& mobility() const { return vehicle_.command(); }

  // ---- True state.
  const sim::ardito::Ardito& world() const { return *world_; }
  nlohmann::ordered_json truth() const { return world_->truth(); }
  // For soft errors of the mobility controller, which its own vote has to treat.
  gnc::ardito::Redundant& instances() {
    protect(false);
    return vehicle_.mobility();
  }
  std::vector<Memory> memory() override;

 private:
  void act(const sim::Fault& fault, bool attach) override;
  bool in_force(const sim::Fault& fault) const override { return world_->in_force(fault); }
  TimeNs next_event() override;
  void dispatch() override;
  void all_stop() override;
  void turn();
  void forget();

  std::unique_ptr<sim::ardito::Ardito> world_;
  std::unique_ptr<sim::CanBus> line_;
  RoverBus master_;
  Twin<sizeof(RoverBus)> master_twin_;
  StopLatch latch_;
  Vehicle::BusReport report_{};
  SampleQueue<RoverSample> samples_;
};

}  // namespace lss::ardito
