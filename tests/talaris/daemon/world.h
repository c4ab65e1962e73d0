#pragma once

// A world for the cycle of TALARIS without threads and without turning: it stands level, goes up
// and down and along z according to the orders of valves and fans, in virtual time. Sensors are as
// good as their quantisation; tests break them by hand.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/cycle/cycle.h"
#include "daemon/vehicles/talaris/vehicle.h"

namespace lss::talaris {

inline Name source(const std::string& text) {
  Name n{};
  text.copy(n.data(), n.size() - 1);
  return n;
}

// As by default, but calibrated in 4 s.
Parameters quick();

class World {
 public:
  explicit World(const Parameters& parameters = quick(), const Supervisor::Parameters& links = {});

  static Logic logic();

  canopen::NodeStatus& node(std::size_t i) { return in_.bus.can.status.link[i].node; }

  void step();  // one frame
  void run(double seconds);
  template <class Condition>
  bool run_until(Condition condition, double seconds) {
    for (TimeNs end = time_ns_ + static_cast<TimeNs>(seconds * 1e9); time_ns_ < end;) {
      step();
      if (condition()) return true;
    }
    return false;
  }
  bool run_until(Mode mode, double seconds) {
    return run_until([&] { return this->mode() == mode; }, seconds);
  }
  bool run_until(State state, double seconds) {
    return run_until([&] { return this->state() == state; }, seconds);
  }
  bool run_until(Phase phase, double seconds) {
    return run_until([&] { return this->phase() == phase; }, seconds);
  }

  template <class Kind>
  void send(Kind kind, std::initializer_list<double> parameters = {}, const char* from = "test",
            std::uint16_t flags = 0) {
    Request r{.source = source(from),
              .sequence = ++sequence_,
              .kind = static_cast<std::uint16_t>(kind),
              .flags = flags,
              .lease_ms = 1000};
    std::copy(parameters.begin(), parameters.end(), r.parameter.begin());
    requests_.push_back(r);
  }
  // Sends and steps; the verdict of its reject, reason none when it was accepted.
  template <class Kind>
  Verdict ask(Kind kind, std::initializer_list<double> parameters = {}, const char* from = "test",
              std::uint16_t flags = 0) {
    acks.clear();
    send(kind, parameters, from, flags);
    step();
    const Ack* refused = last(Phase_::rejected);
    return refused != nullptr ? refused->verdict : Verdict{};
  }
  template <class Kind>
  Reason why(Kind kind, std::initializer_list<double> parameters = {}) {
    return ask(kind, parameters).reason;
  }

  bool start();      // to Manual
  bool calibrate();  // from Manual to Standby, calibrated
  bool arm();        // in Manual
  bool fly(Program program, double height = 2, double distance = 5);  // until it is in the air

  using Phase_ = lss::Phase;  // of an acknowledgement
  State state() const { return supervisor_.controller().state; }
  Mode mode() const { return static_cast<Mode>(supervisor_.controller().mode); }
  Phase phase() const { return Phase{out_.telemetry.phase}; }
  bool airborne() const { return supervisor_.airborne(); }
  bool has(FaultId id, std::uint16_t subject = 0) const;
  const EventRecord* heard(EventId id) const;  // the last one
  const Ack* last(Phase_ phase) const;
  bool shut() const { return !active(out_.command); }
  const TalarisOrders& orders() const { return out_.command; }

  // The measurements of a frame, before they are sent.
  std::function<void(std::vector<TalarisSample>&)> distort;

  std::vector<Ack> acks;
  std::vector<EventRecord> events;
  lss::Inputs<Vehicle> in_{};
  Outputs<Vehicle> out_{};
  Parameters parameters_;
  Vehicle vehicle_;
  Supervisor supervisor_;
  bool heartbeat_ = true;
  TimeNs time_ns_ = 1000 * kSecond;
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
  void measure();
  void move(double into_s, double& up_m_s2, double& along_m_s2);
  double noise();

  std::vector<Request> requests_;
  std::uint64_t sequence_ = 0;
  std::uint32_t seed_ = 1;
};

}  // namespace lss::talaris
