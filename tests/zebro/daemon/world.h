#pragma once

// A world for the cycle of Lunar Zebro without threads, bytes or physics: seven modules that
// execute their orders at once and exactly, in virtual time. Tests break them by hand.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/cycle/cycle.h"
#include "daemon/vehicles/zebro/vehicle.h"

namespace lss::zebro {

inline Name source(const std::string& text) {
  Name n{};
  text.copy(n.data(), n.size() - 1);
  return n;
}

struct IdealModule {
  bool alive = true;
  std::uint16_t flags = 0;
  double position_deg = 0;
  std::uint16_t current_mA = 100;
  std::int16_t temperature_cdegC = 2000;
  // the movement under way
  double rate_deg_s = 0;
  std::uint16_t target_cdeg = 0;
  TimeNs arrive_ns = 0;
  bool stuck = false;
  bool hall_broken = false;
  bool says_status = true;
  double hall_deg = 180;    // the position that it takes on at its sensor
  double sensor_deg = 180;  // where it passes the sensor, as it counts now
  std::uint32_t serial = 0;
  std::uint64_t resets = 0;  // that were ordered, and seen by the bus
  TimeNs boot_ns = 0;        // after a reset it is away for so long
  TimeNs back_ns = 0;        // 0: it is there

  // It counts from where it is, until it passes its sensor.
  void count_anew() {
    flags = kFlagReset;
    rate_deg_s = 0;
    sensor_deg -= position_deg;
    position_deg = 0;
  }
  // From the sensor, as it counts now.
  double from_sensor_deg() const { return std::remainder(position_deg - sensor_deg, 360); }
  double true_deg() const { return std::fmod(hall_deg + from_sensor_deg() + 360, 360); }

  void obey(const ModuleOrder& o, TimeNs now) {
    using Kind = ModuleOrder::Kind;
    if (!alive || o.serial == serial) return;
    serial = o.serial;
    switch (o.kind) {
      case Kind::none:
        return;
      case Kind::motion_on:
        flags = static_cast<std::uint16_t>((flags | kFlagMotionControl) &
                                           ~(kFlagOverCurrent | kFlagDriverFault | kFlagWatchdog));
        return;
      case Kind::reset:
        flags = kFlagReset;
        rate_deg_s = 0;
        alive = boot_ns == 0;
        back_ns = alive ? 0 : now + boot_ns;
        if (alive) ++resets;
        return;
      case Kind::motion_off:
      case Kind::emergency_stop:
        flags = static_cast<std::uint16_t>(flags & ~(kFlagMotionControl | kFlagMoving));
        rate_deg_s = 0;
        return;
      case Kind::rotate_forward:
      case Kind::rotate_backward:
        break;
    }
    if (!(flags & kFlagMotionControl)) return;
    target_cdeg = o.position_cdeg;
    arrive_ns = o.arrive_ns;
    flags |= kFlagMoving;
    go(o.kind == Kind::rotate_forward, now);
  }

  void boot(TimeNs now) {
    if (back_ns == 0 || now < back_ns) return;
    back_ns = 0;
    alive = true;
    ++resets;
  }

  void go(bool forward, TimeNs now) {
    const double ahead = std::fmod(target_cdeg / 100.0 - position_deg + 720, 360);
    double way = forward ? ahead : ahead - 360;
    if (std::abs(way) > 355) way += way > 0 ? -360 : 360;  // a little past: back, not once round
    rate_deg_s = way / std::max(static_cast<double>(arrive_ns - now) * 1e-9, 0.02);
  }

  void pass(TimeNs now, double dt_s) {
    if (!(flags & kFlagMoving) || stuck) return;
    const double before = from_sensor_deg();
    position_deg = now >= arrive_ns ? target_cdeg / 100.0
                                    : std::fmod(position_deg + rate_deg_s * dt_s + 720, 360);
    const double after = from_sensor_deg();
    if (!hall_broken && before * after <= 0 && std::abs(before - after) < 180) {
      flags |= kFlagCalibrated;
      position_deg = true_deg();
      const bool jumped = std::exchange(sensor_deg, hall_deg) != hall_deg;
      if (jumped && now < arrive_ns) go(rate_deg_s > 0, now);
    }
    if (now >= arrive_ns) flags = static_cast<std::uint16_t>(flags & ~kFlagMoving);
  }

  void reply(std::uint8_t index, TimeNs now, std::vector<ModuleReply>& out) {
    if (!alive) return;
    ModuleReply r{.time_ns = now,
                  .module = index,
                  .code = static_cast<std::uint8_t>(Code::status),
                  .data = {}};
    const auto put = [&](std::size_t i, std::uint16_t v) {
      r.data[i] = static_cast<std::uint8_t>(v >> 8);
      r.data[i + 1] = static_cast<std::uint8_t>(v & 0xFF);
    };
    const bool level = !hall_broken && std::abs(from_sensor_deg()) < 3;
    put(0, static_cast<std::uint16_t>(flags | (level ? kFlagHallSensor : 0)));
    put(2, static_cast<std::uint16_t>(std::lround(position_deg * 100) % 36000));
    put(6, current_mA);
    if (says_status) out.push_back(r);
    if (says_status) flags = static_cast<std::uint16_t>(flags & ~kFlagReset);
    r = {.time_ns = now,
         .module = index,
         .code = static_cast<std::uint8_t>(Code::health),
         .data = {}};
    put(0, static_cast<std::uint16_t>(temperature_cdegC));
    out.push_back(r);
  }
};

class World {
 public:
  static constexpr TimeNs kPeriod = 20 * kMillisecond;

  explicit World(const Parameters& parameters = {}, const Supervisor::Parameters& links = {})
      : vehicle_(parameters), supervisor_(logic(), links) {
    for (std::size_t i = 0; i < modules.size(); ++i)
      modules[i].position_deg = 30.0 * static_cast<double>(i);
    IdealModule& panel = modules.back();
    panel.position_deg = panel.hall_deg = panel.sensor_deg = 0;
    in_.bus.was_open = in_.bus.open = true;
  }

  static Logic logic() { return zebro::logic(); }

  // One frame.
  void step() {
    time_ns_ += kPeriod;
    in_.frame += 1;
    in_.time_ns = time_ns_;
    in_.bus.time_ns = time_ns_ - kMillisecond;
    std::vector<ModuleReply> replies;
    for (std::size_t i = 0; i < modules.size(); ++i) {
      modules[i].boot(time_ns_);
      in_.bus.counters.module[i].resets = modules[i].resets;
      modules[i].pass(time_ns_, 0.02);
      for (int replied = 0; in_.bus.open && replied < (twice ? 2 : 1); ++replied)
        modules[i].reply(static_cast<std::uint8_t>(i), time_ns_ - 1, replies);
    }
    in_.sample_count = static_cast<std::uint32_t>(replies.size());
    for (std::size_t i = 0; i < replies.size(); ++i) in_.samples[i] = replies[i];
    in_.request_count = 0;
    for (const Request& r : requests_) in_.requests[in_.request_count++] = r;
    requests_.clear();
    if (heartbeat_ && in_.request_count < kMaxRequests)
      in_.requests[in_.request_count++] = {.source = source("test")};
    cycle(vehicle_, supervisor_, in_, out_, [](Stage) {});
    for (std::size_t i = 0; i < modules.size(); ++i)
      modules[i].obey(out_.command.module[i], time_ns_ + 5 * kMillisecond);
    const auto& box = supervisor_.outbox();
    acks.insert(acks.end(), box.acks.begin(), box.acks.begin() + box.ack_count);
    events.insert(events.end(), box.events.begin(), box.events.begin() + box.event_count);
  }
  void run(double seconds) {
    for (TimeNs end = time_ns_ + static_cast<TimeNs>(seconds * 1e9); time_ns_ < end;) step();
  }
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
  // From Idle to Standing.
  bool stand() {
    run(0.2);
    send(lss::CommandKind::start, {1});
    return run_until(Mode::standing, 40);
  }

  State state() const { return supervisor_.controller().state; }
  Mode mode() const { return static_cast<Mode>(supervisor_.controller().mode); }
  bool has(FaultId id, std::uint16_t subject = 0) const {
    for (const FaultRecord& f : supervisor_.state().faults) {
      if (f.id == id && f.subject == subject) return true;
    }
    return false;
  }
  const Ack* last(Phase phase) const {
    for (auto i = acks.rbegin(); i != acks.rend(); ++i) {
      if (i->phase == phase) return &*i;
    }
    return nullptr;
  }
  bool all_stopped() const {
    for (const ModuleOrder& o : out_.command.module) {
      if (o.kind != ModuleOrder::Kind::emergency_stop) return false;
    }
    return true;
  }

  std::array<IdealModule, kModules> modules;
  std::vector<Ack> acks;
  std::vector<EventRecord> events;
  Inputs<Vehicle> in_{};
  Outputs<Vehicle> out_{};
  Vehicle vehicle_;
  Supervisor supervisor_;
  bool heartbeat_ = true;
  bool twice = false;  // modules answer twice a frame
  TimeNs time_ns_ = 1000 * kSecond;

 private:
  std::vector<Request> requests_;
  std::uint64_t sequence_ = 0;
};

}  // namespace lss::zebro
