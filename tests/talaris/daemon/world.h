#pragma once

// A world for the cycle of TALARIS without threads and without turning: it stands level, goes up
// and down and along z according to the orders of valves and fans, in virtual time. Sensors are as
// good as their quantisation; tests break them by hand.

#include <functional>
#include <vector>

#include "daemon/vehicles/talaris/vehicle.h"
#include "tests/safety/cycle_world.h"

namespace lss::talaris {

using Kind = CommandKind;
using safety::source;

// As by default, but calibrated in 4 s.
Parameters quick();

class World : public safety::CycleWorld<World, Vehicle, Mode> {
 public:
  explicit World(const Parameters& parameters = quick(), const Supervisor::Parameters& links = {});

  canopen::NodeStatus& node(std::size_t i) { return in_.bus.can.status.link[i].node; }

  void sense();
  void obey() {}  // it moves in sense()
  using CycleWorld::run_until;
  bool run_until(Phase phase, double seconds) {
    return run_until([&] { return this->phase() == phase; }, seconds);
  }

  bool start();      // to Manual
  bool calibrate();  // from Manual to Standby, calibrated
  bool arm();        // in Manual
  bool fly(Program program, double height = 2, double distance = 5);  // until it is in the air

  Phase phase() const { return Phase{out_.telemetry.phase}; }
  bool airborne() const { return supervisor_.airborne(); }
  bool shut() const { return !active(out_.command); }
  const TalarisOrders& orders() const { return out_.command; }

  // The measurements of a frame, before they are sent.
  std::function<void(std::vector<TalarisSample>&)> distort;

  Parameters parameters_;
  bool imu_alive = true, altimeter_alive = true, valves_alive = true, fans_alive = true;
  double tank_kPa = 31026, regulated_kPa = 2000, voltage_V = 24;
  double shake = 0;  // of the IMU, rad/s and m/s2
  bool gas_works = true;
  double height_m = 0, speed_m_s = 0;  // up
  double along_m = 0, along_m_s = 0;   // z
  double landing_m_s = 0;              // of the last touch
  double gas_s = 0;                    // thruster-seconds spent
  std::array<double, kHopperFans> rpm{};
  std::uint64_t imu_count = 0;

 private:
  void move(double into_s, double& up_m_s2, double& along_m_s2);
  double noise();

  std::uint32_t seed_ = 1;
};

}  // namespace lss::talaris
