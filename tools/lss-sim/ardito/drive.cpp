#include "tools/lss-sim/ardito/drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::ardito {
namespace {

constexpr double kRpm_rad_s = 2 * std::numbers::pi / 60;
constexpr double kStanding_rpm = 6, kReached_rpm = 20;
constexpr double kUnder_V = 10, kAgain_V = 18, kOver_V = 32;
constexpr double kWarm_degC = 90, kHot_degC = 110;
constexpr int kBlocked_ms = 3000;
constexpr std::uint16_t kUnderVoltage = 0x3220, kOverVoltage = 0x3210, kTooHot = 0x4310;
constexpr std::uint16_t kMotorBlocked = 0x7121;

constexpr Object kWheelObjects[] = {
    {.index = 0x6007, .bytes = 2, .access = rw, .is_signed = true, .min = 0, .max = 3},
    {.index = 0x603F, .bytes = 2, .mappable = true},
    {.index = 0x6040, .bytes = 2, .access = rw, .mappable = true},
    {.index = 0x6041, .bytes = 2, .mappable = true},
    {.index = 0x605A,
     .bytes = 2,
     .access = rw,
     .initial = 2,
     .is_signed = true,
     .min = 0,
     .max = 6},
    {.index = 0x6060, .bytes = 1, .access = rw, .is_signed = true, .min = 3, .max = 3},
    {.index = 0x6061, .bytes = 1, .initial = 3, .mappable = true, .is_signed = true},
    {.index = 0x606C, .mappable = true, .is_signed = true},
    {.index = 0x6075, .initial = 4000},
    {.index = 0x6078, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x6083, .access = rw, .initial = 3000, .min = 1, .max = kMost},
    {.index = 0x6084, .access = rw, .initial = 3000, .min = 1, .max = kMost},
    {.index = 0x6085, .access = rw, .initial = 3000, .min = 1, .max = kMost},
    {.index = 0x60FF, .access = rw, .mappable = true, .is_signed = true},
    {.index = 0x6502, .initial = 1 << 2},
    {.index = 0x2100, .sub = 1, .mappable = true, .is_signed = true},
    {.index = 0x2100, .sub = 2, .mappable = true, .is_signed = true},
    {.index = 0x2101, .sub = 1, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x2101, .sub = 2, .bytes = 2, .mappable = true},
};

}  // namespace

// ---- CiA 402

void Drive::written(std::uint16_t index, std::uint8_t) {
  if (index == 0x6040) obey(controlword());
}

void Drive::reset() {
  power_ = Power::not_ready;
  last_control_ = cause_ = 0;
}

void Drive::fail(std::uint16_t code) {
  if (power_ == Power::fault || power_ == Power::not_ready) return;
  power_ = Power::fault;
  cause_ = code;
  objects_.set(0x603F, 0, code);
  raise(code);
}

void Drive::left_operational(bool communication_error) {
  if (communication_error && objects_.get_signed(0x6007, 0) != 3) return;
  if (power_ == Power::enabled) begin_quick_stop();
}

void Drive::begin_quick_stop() {
  power_ = objects_.get_signed(0x605A, 0) == 0 ? Power::switch_on_disabled : Power::quick_stop;
}

void Drive::obey(std::uint16_t control) {
  const bool reset_edge = (control & 0x80) != 0 && (last_control_ & 0x80) == 0;
  last_control_ = control;
  const bool shutdown = (control & 0x87) == 0x06;
  const bool switch_on = (control & 0x87) == 0x07;  // with bit 3: also enable
  const bool enable = (control & 0x8F) == 0x0F;
  const bool no_voltage = (control & 0x82) == 0x00;
  const bool quick_stop = (control & 0x86) == 0x02;
  switch (power_) {
    case Power::not_ready:
      break;
    case Power::switch_on_disabled:
      if (shutdown) power_ = Power::ready;
      break;
    case Power::ready:
      if (no_voltage || quick_stop) power_ = Power::switch_on_disabled;
      if (switch_on) power_ = Power::switched_on;
      break;
    case Power::switched_on:
      if (no_voltage || quick_stop) power_ = Power::switch_on_disabled;
      if (shutdown) power_ = Power::ready;
      if (enable) {
        power_ = Power::enabled;
        begin_motion();
      }
      break;
    case Power::enabled:
      if (no_voltage) power_ = Power::switch_on_disabled;
      if (shutdown) power_ = Power::ready;
      if (switch_on && !enable) power_ = Power::switched_on;
      if (quick_stop) begin_quick_stop();
      break;
    case Power::quick_stop:
      if (no_voltage) power_ = Power::switch_on_disabled;
      break;
    case Power::fault: {
      const bool gone = cause_ == kUnderVoltage ? link_V_ > kAgain_V
                        : cause_ == kTooHot     ? !warm_
                                                : true;
      if (!reset_edge || !gone) break;
      power_ = Power::switch_on_disabled;
      objects_.set(0x603F, 0, 0);
      settle(cause_);
      break;
    }
  }
  new_control();
}

void Drive::tick_power() {
  if (power_ == Power::not_ready && ready()) power_ = Power::switch_on_disabled;
  if (link_V_ < kUnder_V) fail(kUnderVoltage);
  if (link_V_ > kOver_V) fail(kOverVoltage);
  const bool ends = objects_.get_signed(0x605A, 0) < 5;
  if (power_ == Power::quick_stop && ends && standing()) power_ = Power::switch_on_disabled;
}

std::uint16_t Drive::statusword() const {
  constexpr std::uint16_t kStates[] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x08};
  unsigned word = kStates[static_cast<std::size_t>(power_)] | 1u << 9;
  if (link_V_ > kUnder_V) word |= 1u << 4;
  if (warm_) word |= 1u << 7;
  return static_cast<std::uint16_t>(word | mode_bits());
}

// ---- Wheel: profile velocity

WheelDrive::WheelDrive(std::uint8_t id, unsigned seed)
    : Drive(id, 0x0002'0192, 3, kWheelObjects, seed),
      encoder_rpm_({.noise = 1.5, .share = 0.001, .quantum = 1, .lag_ms = 5}),
      hall_rpm_({.noise = 6, .share = 0.004, .quantum = 3, .lag_ms = 15}),
      reduction_crpm_({.noise = 6, .share = 0.002, .quantum = 3, .lag_ms = 20}),
      current_({.noise = 5, .lag_ms = 4, .velocity = false}),
      temperature_({.noise = 1, .lag_ms = 500, .velocity = false}),
      link_({.noise = 2, .lag_ms = 5, .velocity = false}) {}

Signal* WheelDrive::signal(int number) {
  Signal* all[] = {&encoder_rpm_, &hall_rpm_, &reduction_crpm_, &current_, &temperature_, &link_};
  return number >= 1 && number <= 6 ? all[number - 1] : nullptr;
}

void WheelDrive::feel(const WheelTrain& train, const ShaftState& wheel) {
  motor_rad_s_ = train.motor_rad_s();
  at_limit_ = train.at_limit();
  temperature_degC_ = train.temperature_degC();
  const double motor_rpm = motor_rad_s_ / kRpm_rad_s;
  encoder_rpm_.step(motor_rpm);
  hall_rpm_.step(motor_rpm);
  reduction_crpm_.step(wheel.velocity_rad_s / kRpm_rad_s * 100);
  current_.step(train.current_A() / motor::kRated_A * 1000);
  temperature_.step(temperature_degC_ * 10);
  link_.step(link_V_ * 100);
}

void WheelDrive::tick() {
  tick_power();
  warm_ = temperature_degC_ > kWarm_degC;
  if (temperature_degC_ > kHot_degC) fail(kTooHot);
  const bool blocked = moves() && at_limit_ && std::abs(motor_rad_s_) < 1;
  blocked_ms_ = blocked ? blocked_ms_ + 1 : 0;
  if (blocked_ms_ > kBlocked_ms) fail(kMotorBlocked);
  if (!moves()) {
    reference_rad_s_ = 0;
    return;
  }
  const bool stopping = power_ == Power::quick_stop;
  const double target_rad_s =
      stopping ? 0 : static_cast<double>(objects_.get_signed(0x60FF, 0)) * kRpm_rad_s;
  const bool faster =
      target_rad_s * reference_rad_s_ >= 0 && std::abs(target_rad_s) > std::abs(reference_rad_s_);
  const std::uint16_t ramp = stopping ? 0x6085 : faster ? 0x6083 : 0x6084;
  const double change_rad_s = objects_.get(ramp, 0) * kRpm_rad_s * kStep_s;
  reference_rad_s_ += std::clamp(target_rad_s - reference_rad_s_, -change_rad_s, change_rad_s);
}

std::uint16_t WheelDrive::mode_bits() const {
  const double rpm = motor_rad_s_ / kRpm_rad_s;
  unsigned bits = 0;
  const auto target_rpm = static_cast<double>(objects_.get_signed(0x60FF, 0));
  if (power_ == Power::enabled && std::abs(rpm - target_rpm) < kReached_rpm) bits |= 1u << 10;
  if (at_limit_) bits |= 1u << 11;
  if (std::abs(rpm) < kStanding_rpm) bits |= 1u << 12;
  return static_cast<std::uint16_t>(bits);
}

void WheelDrive::measure() {
  objects_.set(0x6041, 0, statusword());
  objects_.set(0x606C, 0, to_i32(encoder_rpm_.read(random_)));
  objects_.set(0x6078, 0, to_i16(current_.read(random_)));
  objects_.set(0x2100, 1, to_i32(hall_rpm_.read(random_)));
  objects_.set(0x2100, 2, to_i32(reduction_crpm_.read(random_)));
  objects_.set(0x2101, 1, to_i16(temperature_.read(random_)));
  objects_.set(0x2101, 2, to_u16(link_.read(random_)));
}

}  // namespace lss::sim::ardito
