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
#include <memory>
#include <vector>

#include "tests/support/virtual_chain.h"
#include "tests/zebro/chain/bus_line.h"
#include "tests/zebro/chain/frame_bus.h"
#include "tools/lss-sim/zebro/plant.h"

namespace lss::sim::zebro {
class Zebro;
}

namespace lss::zebro {

// Commands have a lease of 2 s.
class Chain final : public testing_support::VirtualChain<Vehicle, Mode, Parameters> {
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

  // From Idle to Standing, to Walking; false when it does not come to that in its time.
  bool stand();
  bool walk(bool forward = true, double heading_rad = 0,
            gnc::zebro::Speed speed = gnc::zebro::Speed::high);
  // From FatalError to Idle.
  bool solve(double limit_s = 120);

  // ---- Output of the daemon.
  bool has_fatal() const;
  const BusCounters& bus() const { return bus_->report().counters; }
  const Ack* last_ack(std::uint64_t sequence) const;  // nullptr: none yet
  const EventRecord* last(EventId id) const;

  // ---- True state.
  sim::zebro::Zebro& world() { return *world_; }
  // For the next chain, as its vehicle: the daemon ends, the world does not. Nothing else may be
  // done with this one after.
  std::unique_ptr<sim::zebro::Zebro> take_world();
  sim::zebro::BodyState body() const;
  // Every frame of the master so far, in order; forget() when it is no longer wanted.
  const std::vector<WireFrame>& wire() const { return bus_->wire; }
  void forget();  // wire, acks and events so far
  std::vector<Memory> memory() override;
  void protect(bool on) override {
    VirtualChain::protect(on);
    bus_->protect = on;
  }

 private:
  void act(const sim::Fault& fault, bool attach) override;
  bool in_force(const sim::Fault& fault) const override;
  TimeNs next_event() override;
  void dispatch() override;
  void all_stop() override { bus_->all_stop(now_ns_); }

  std::unique_ptr<sim::zebro::Zebro> world_;
  std::unique_ptr<sim::Uart> line_;
  FrameBus* frame_bus_ = nullptr;  // with whole frames, else line_
  TimeNs plug_ns_ = kNever;        // when an unplugged port is there again
  std::unique_ptr<Bus> bus_;
};

}  // namespace lss::zebro
