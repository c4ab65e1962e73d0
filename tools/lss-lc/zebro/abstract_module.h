#pragma once

// A leg module of Lunar Zebro with its part of the bus, as docs/icd-zebro.md describes them,
// without bytes, physics and dynamics: an order takes effect at once, a movement is uniform, a
// re-send takes no time. And the ways in which it fails. Time is data; trivially copyable.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "drivers/zebro/leg_bus.h"
#include "drivers/zebro/leg_module.h"

namespace lss::zebro {

enum class Ill : std::uint8_t {
  well,
  silent,  // neither answers nor obeys
  deaf,    // answers, and obeys nothing
  jammed,  // trips by over-current as soon as it moves
  frozen,  // lies: its angle is that of the moment of the failure
  late,    // reports what was kLate ago
};

class AbstractModule {
 public:
  static constexpr TimeNs kLate = 300 * kMillisecond;
  static constexpr TimeNs kResends = 100 * kMillisecond;  // used up by then, by an answering module

  static constexpr TimeNs kRepeat = kSecond;

  Ill ill = Ill::well;

  void boot(double position_deg, double sensor_deg) {
    position_deg_ = position_deg;
    sensor_deg_ = sensor_deg;
    flags_ = kFlagCalibrated;
    past_.fill({flags_, position_deg_});
  }
  void begin(Ill failure) {
    ill = failure;
    frozen_deg_ = position_deg_;
    for (Report& report : past_) report = {flags_, position_deg_};
  }
  // A supply that drops for a moment.
  void reset_itself() {
    flags_ = kFlagReset;
    moving_ = false;
    sensor_deg_ = std::remainder(sensor_deg_ - position_deg_, 360);
    position_deg_ = 0;
  }
  void stop() {
    missed_ = ill == Ill::silent || ill == Ill::deaf;
    if (missed_) return;
    flags_ = static_cast<std::uint16_t>(flags_ & ~(kFlagMotionControl | kFlagMoving));
    moving_ = false;
  }

  // By the bus itself: what was ordered before is void.
  void bus_stops(TimeNs now) {
    order_ = {.kind = ModuleOrder::Kind::emergency_stop};
    ordered_ns_ = now;
    confirmed_ = disobeys_ = false;
    stop();
  }
  // The bus is another one, and has seen no order.
  void bus_begins(TimeNs now) {
    serial_ = 0;
    bus_stops(now);
  }

  void obey(const ModuleOrder& order, TimeNs now) {
    if (order.serial == serial_) return;
    missed_ = ill == Ill::silent || ill == Ill::deaf;
    if (ill == Ill::silent) return;
    serial_ = order.serial;
    order_ = order;
    ordered_ns_ = now;
    confirmed_ = order.kind == ModuleOrder::Kind::none;
    disobeys_ = false;
    if (!missed_) execute(now);
  }

  // From `now - dt` to `now`.
  void pass(TimeNs now, TimeNs dt) {
    if (moving_ && ill == Ill::jammed) {
      stop();
      flags_ |= kFlagOverCurrent;
    }
    if (moving_) move(now, dt);
    for (std::size_t i = past_.size() - 1; i > 0; --i) past_[i] = past_[i - 1];
    past_[0] = {flags_, position_deg_};
    if (answers()) follow(now);
  }

  void reply(std::uint8_t module, TimeNs now, std::vector<ModuleReply>& out) {
    if (!answers()) return;
    const Report& seen = report();
    const double shown_deg = ill == Ill::frozen ? frozen_deg_ : seen.position_deg;
    const auto cdeg = [](double deg) {
      return static_cast<std::uint16_t>(std::lround(std::fmod(deg + 720, 360) * 100) % kTurn_cdeg);
    };
    const bool level = std::abs(from_sensor_deg()) < 3;
    ModuleReply status{now, module, static_cast<std::uint8_t>(Code::status), {}};
    put(status, 0, static_cast<std::uint16_t>(seen.flags | (level ? kFlagHallSensor : 0)));
    put(status, 2, cdeg(shown_deg));
    const double rate_deg_s = moving_ && ill != Ill::frozen ? rate_deg_s_ : 0;
    put(status, 4, static_cast<std::uint16_t>(static_cast<std::int16_t>(rate_deg_s * 10)));
    put(status, 6, 100);
    out.push_back(status);
    flags_ = static_cast<std::uint16_t>(flags_ & ~kFlagReset);
    ModuleReply health{now, module, static_cast<std::uint8_t>(Code::health), {}};
    put(health, 0, 2000);
    put(health, 2, 12'000);
    put(health, 4, cdeg(moving_ ? to_deg_ : position_deg_));
    const TimeNs left = moving_ ? std::max<TimeNs>(arrive_ns_ - now, 0) / kMillisecond : 0;
    put(health, 6, static_cast<std::uint16_t>(std::min<TimeNs>(left, 65'535)));
    out.push_back(health);
  }

  bool answers() const { return ill != Ill::silent; }
  bool contradicts() const { return answers() && !confirmed_; }
  bool disobeys() const { return disobeys_; }
  bool motor_on() const { return (flags_ & kFlagMotionControl) != 0; }
  bool tripped() const {
    return (flags_ & (kFlagOverCurrent | kFlagDriverFault | kFlagWatchdog)) != 0;
  }
  std::uint64_t resets() const { return resets_; }

  // Times in steps; angles to `step_deg`, 0: not at all.
  template <class Hash>
  void hash(Hash& h, TimeNs now, TimeNs dt, double step_deg, const ModuleOrder& order) const {
    h(static_cast<std::uint64_t>(ill), flags_, order_.kind, confirmed_, disobeys_, missed_, moving_,
      order.serial == serial_);
    const auto angle = [&](double deg) {
      h(step_deg > 0 ? static_cast<std::int64_t>(std::lround(deg / step_deg)) : 0);
    };
    if (!confirmed_) h((now - ordered_ns_) % kRepeat / dt, now - ordered_ns_ > 3 * dt);
    if (moving_) h((arrive_ns_ - now) / dt);
    if (step_deg > 0) angle(position_deg_);
    if (ill == Ill::late) {
      for (const Report& r : past_) h(r.flags);
    }
  }

 private:
  struct Report {
    std::uint16_t flags;
    double position_deg;
  };

  static void put(ModuleReply& reply, std::size_t at, std::uint16_t value) {
    reply.data[at] = static_cast<std::uint8_t>(value >> 8);
    reply.data[at + 1] = static_cast<std::uint8_t>(value & 0xFF);
  }
  const Report& report() const { return past_[ill == Ill::late ? past_.size() - 1 : 0]; }
  double from_sensor_deg() const { return std::remainder(position_deg_ - sensor_deg_, 360); }

  void execute(TimeNs now) {
    using Kind = ModuleOrder::Kind;
    switch (order_.kind) {
      case Kind::none: break;
      case Kind::motion_on:
        flags_ = static_cast<std::uint16_t>((flags_ | kFlagMotionControl) &
                                            ~(kFlagOverCurrent | kFlagDriverFault | kFlagWatchdog));
        break;
      case Kind::motion_off:
      case Kind::emergency_stop: stop(); break;
      case Kind::reset:
        reset_itself();
        ++resets_;
        break;
      case Kind::rotate_forward:
      case Kind::rotate_backward:
        if ((flags_ & kFlagMotionControl) == 0) break;
        to_deg_ = order_.position_cdeg * 0.01;
        arrive_ns_ = order_.arrive_ns;
        moving_ = true;
        flags_ |= kFlagMoving;
        go(order_.kind == Kind::rotate_forward, now);
        break;
    }
  }

  void go(bool forward, TimeNs now) {
    double way = std::fmod(to_deg_ - position_deg_ + 720, 360);
    if (!forward) way -= 360;
    if (std::abs(way) > 355) way += way > 0 ? -360 : 360;  // a little past: back, not once round
    const double left_s = std::max(
        {static_cast<double>(arrive_ns_ - now) * 1e-9, std::abs(way) / kFastest_deg_s, 0.02});
    arrive_ns_ = now + std::llround(left_s * 1e9);
    rate_deg_s_ = way / left_s;
  }

  // At its sensor its position becomes the true one, and it goes on to where it was ordered.
  void move(TimeNs now, TimeNs dt) {
    const double before = from_sensor_deg();
    const bool there = now >= arrive_ns_;
    const double true_sensor_deg = kSensor;
    position_deg_ =
        there ? to_deg_
              : std::fmod(position_deg_ + rate_deg_s_ * static_cast<double>(dt) * 1e-9 + 720, 360);
    const double after = from_sensor_deg();
    if ((flags_ & kFlagCalibrated) == 0 && before * after <= 0 && std::abs(before - after) < 180) {
      flags_ |= kFlagCalibrated;
      position_deg_ = std::fmod(true_sensor_deg + after + 360, 360);
      sensor_deg_ = true_sensor_deg;
      if (!there) go(rate_deg_s_ > 0, now);
    }
    if (!there) return;
    moving_ = false;
    flags_ = static_cast<std::uint16_t>(flags_ & ~kFlagMoving);
  }

  // The bus compares reports with the order, and sends it again until the limit.
  void follow(TimeNs now) {
    using Kind = ModuleOrder::Kind;
    if (confirmed_) return;
    const TimeNs since = now - ordered_ns_;
    const bool obeys = ill != Ill::deaf;
    if (missed_ && obeys && since < kResends) {
      missed_ = false;
      execute(now);
    }
    // A stop is repeated as long as it is not confirmed.
    if (order_.kind == Kind::emergency_stop && since % kRepeat == 0) stop();
    const bool on = (report().flags & kFlagMotionControl) != 0;
    const bool in_time = ill != Ill::late || since >= kLate;
    bool executed = in_time && obeys && !missed_;
    if (order_.kind == Kind::motion_on) executed = on;
    if (order_.kind == Kind::motion_off || order_.kind == Kind::emergency_stop) executed = !on;
    confirmed_ = executed;
    if (!executed && since >= kResends) disobeys_ = true;
  }

  static constexpr double kSensor = 180;
  static constexpr double kFastest_deg_s = 117;  // docs/icd-zebro.md section 6

  std::uint16_t flags_ = 0;
  double position_deg_ = 0, sensor_deg_ = kSensor, frozen_deg_ = 0;
  double to_deg_ = 0, rate_deg_s_ = 0;
  bool moving_ = false;
  TimeNs arrive_ns_ = 0;
  std::uint32_t serial_ = 0;
  ModuleOrder order_{};  // the last one
  bool confirmed_ = true, disobeys_ = false, missed_ = false;
  TimeNs ordered_ns_ = 0;
  std::uint64_t resets_ = 0;
  std::array<Report, 4> past_{};  // one for each 100 ms
};

}  // namespace lss::zebro
