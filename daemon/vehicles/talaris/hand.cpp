#include "daemon/vehicles/talaris/hand.h"

#include <algorithm>
#include <cmath>

namespace lss::talaris {
namespace {

TimeNs whole_milliseconds(double s) noexcept { return std::llround(s * 1e3) * kMillisecond; }
bool in(std::uint8_t set, std::size_t i) noexcept { return (set & 1u << i) != 0; }

}  // namespace

std::uint16_t fan_us(double throttle) noexcept {
  if (!(throttle > 0)) return kFanOff_us;
  constexpr int kRange = kFanFull_us - kFanOff_us;
  return static_cast<std::uint16_t>(kFanOff_us + std::lround(std::min(throttle, 1.0) * kRange));
}

void Hand::shut() noexcept {
  wanted_ns_.fill(0);
  until_ns_.fill(0);
  timed_out_ = pulsed_ = 0;
  frames_ = 0;
  throttle_.fill(0);
  rpm_.fill(0);
  by_rpm_.fill(false);
  arming_ = 0;
  armed_ = false;
  speed_.reset();
}

void Hand::valve(std::uint8_t valves, bool open, double time_s) noexcept {
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (!in(valves, i)) continue;
    wanted_ns_[i] = open ? whole_milliseconds(time_s) : 0;
    if (!open) until_ns_[i] = 0;
  }
}

void Hand::pulse(std::uint8_t valves, double on_s, double delay_s, int frames) noexcept {
  pulsed_ = valves;
  // Rounding must not make it longer than the frame.
  const TimeNs delay_ns = whole_milliseconds(delay_s);
  pulse_ = {delay_ns, std::min(whole_milliseconds(on_s), kFrame - delay_ns)};
  frames_ = frames;
}

void Hand::throttle(std::uint8_t fans, double throttle) noexcept {
  for (std::size_t i = 0; i < kHopperFans; ++i) {
    if (!in(fans, i)) continue;
    by_rpm_[i] = false;
    throttle_[i] = throttle;
    rpm_[i] = 0;
  }
}

void Hand::rpm(std::uint8_t fans, double rpm, double ramp_rpm_s) noexcept {
  for (std::size_t i = 0; i < kHopperFans; ++i) {
    if (!in(fans, i)) continue;
    by_rpm_[i] = true;
    throttle_[i] = 0;
    rpm_[i] = rpm;
  }
  ramp_rpm_s_ = ramp_rpm_s;
}

void Hand::arm() noexcept {
  shut();
  arming_ = kFullFrames + kQuietFrames;
}

void Hand::limit(std::uint8_t valves) noexcept {
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (!in(valves, i)) wanted_ns_[i] = until_ns_[i] = 0;
  }
  pulsed_ = static_cast<std::uint8_t>(pulsed_ & valves);
  if (pulsed_ == 0) frames_ = 0;
}

void Hand::step(TalarisOrders& orders, const gnc::talaris::PerFan* measured_rpm) noexcept {
  timed_out_ = 0;
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (wanted_ns_[i] != 0) until_ns_[i] = orders.release_ns + wanted_ns_[i];
    wanted_ns_[i] = 0;
    if (until_ns_[i] == 0) continue;
    if (until_ns_[i] <= orders.release_ns) {
      until_ns_[i] = 0;
      timed_out_ = static_cast<std::uint8_t>(timed_out_ | 1u << i);
      continue;
    }
    orders.hold[i] = {true, until_ns_[i]};
  }
  if (frames_ > 0) {
    --frames_;
    for (std::size_t i = 0; i < kHopperValves; ++i) {
      if (in(pulsed_, i)) orders.pulse[i] = pulse_;
    }
  }
  armed_ = false;
  if (arming_ != 0) {
    const bool full = arming_ > kQuietFrames;
    orders.fan_us.fill(full ? kFanFull_us : kFanOff_us);
    armed_ = --arming_ == 0;
    return;
  }
  const gnc::talaris::PerFan by_speed =
      measured_rpm != nullptr ? speed_.ramp(rpm_, ramp_rpm_s_, *measured_rpm) : speed_.blind(rpm_);
  for (std::size_t i = 0; i < kHopperFans; ++i)
    orders.fan_us[i] = fan_us(by_rpm_[i] ? by_speed[i] : throttle_[i]);
}

bool Hand::idle() const noexcept {
  const auto none = [](double x) { return x == 0; };
  return arming_ == 0 && std::ranges::all_of(throttle_, none) && std::ranges::all_of(rpm_, none);
}

std::uint8_t Hand::open() const noexcept {
  unsigned open = 0;
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (until_ns_[i] != 0 || wanted_ns_[i] != 0) open |= 1u << i;
  }
  return static_cast<std::uint8_t>(open);
}

}  // namespace lss::talaris
