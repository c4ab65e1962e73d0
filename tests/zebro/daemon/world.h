#pragma once

// A world for the cycle of Lunar Zebro without threads, bytes or physics: seven modules that
// execute their orders at once and exactly, in virtual time. Tests break them by hand.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "daemon/vehicles/zebro/vehicle.h"
#include "tests/safety/cycle_world.h"

namespace lss::zebro {

using safety::source;

struct IdealModule {
  bool alive = true;
  std::uint16_t flags = 0;
  double position_deg = 0;
  std::uint16_t current_mA = 100;
  std::int16_t temperature_cdegC = 2000;
  std::uint16_t supply_mV = 12'000;
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
  void restart_count() {
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
      case Kind::none: return;
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
      case Kind::rotate_backward: break;
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
    put(2, supply_mV);
    out.push_back(r);
  }
};

class World : public safety::CycleWorld<World, Vehicle, Mode> {
 public:
  static constexpr TimeNs kPeriod = 20 * kMillisecond;

  explicit World(const Parameters& parameters = {}, const Supervisor::Parameters& links = {})
      : CycleWorld(parameters, zebro::logic(), links, kPeriod) {
    for (std::size_t i = 0; i < modules.size(); ++i)
      modules[i].position_deg = 30.0 * static_cast<double>(i);
    IdealModule& panel = modules.back();
    panel.position_deg = panel.hall_deg = panel.sensor_deg = 0;
    in_.bus.was_open = in_.bus.open = true;
  }

  void sense() {
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
  }
  void obey() {
    for (std::size_t i = 0; i < modules.size(); ++i)
      modules[i].obey(out_.command.module[i], time_ns_ + 5 * kMillisecond);
  }

  // From Idle to Standing.
  bool stand() {
    run(0.2);
    send(lss::CommandKind::start, {1});
    return run_until(Mode::standing, 40);
  }
  // False: not within the time, or not to Idle.
  bool solve(double seconds) {
    send(lss::CommandKind::solve);
    step();
    return run_until([&] { return state() != State::solve_errors; }, seconds) &&
           state() == State::idle;
  }
  bool all_stopped() const {
    for (const ModuleOrder& o : out_.command.module) {
      if (o.kind != ModuleOrder::Kind::emergency_stop) return false;
    }
    return true;
  }

  std::array<IdealModule, kModules> modules;
  bool twice = false;  // modules answer twice a frame
};

}  // namespace lss::zebro
