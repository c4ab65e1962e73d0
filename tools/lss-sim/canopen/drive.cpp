#include "tools/lss-sim/canopen/drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::nodes {
namespace {

constexpr double kRpm_rad_s = 2 * std::numbers::pi / 60;
constexpr double kStanding_rpm = 6, kReached_rpm = 20;
constexpr double kUnder_V = 10, kAgain_V = 18, kOver_V = 32;
constexpr double kWarm_degC = 90, kHot_degC = 110;
constexpr int kBlocked_ms = 3000;
constexpr std::uint16_t kUnderVoltage = 0x3220, kOverVoltage = 0x3210, kTooHot = 0x4310;
constexpr std::uint16_t kMotorBlocked = 0x7121, kConnectionLost = 0x8130;

constexpr Object kDriveObjects[] = {
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
    {.index = 0x6075, .initial = 4000},
    {.index = 0x6078, .bytes = 2, .mappable = true, .is_signed = true},
};
constexpr Object kVelocityObjects[] = {
    {.index = 0x606C, .mappable = true, .is_signed = true},
    {.index = 0x6083, .access = rw, .initial = 3000, .min = 1, .max = kMost},
    {.index = 0x6084, .access = rw, .initial = 3000, .min = 1, .max = kMost},
    {.index = 0x6085, .access = rw, .initial = 3000, .min = 1, .max = kMost},
    {.index = 0x60FF, .access = rw, .mappable = true, .is_signed = true},
};

}  // namespace

const char* text(Power power) {
  constexpr const char* kTexts[] = {"not ready", "switch on disabled", "ready", "switched on",
                                    "enabled",   "quick stop",         "fault"};
  return kTexts[static_cast<std::size_t>(power)];
}

Drive::Drive(const Identity& identity, OperationMode mode, std::size_t tpdos,
             std::span<const Object> objects, unsigned seed)
    : Node(identity, 1, tpdos, objects, seed) {
  const auto number = static_cast<std::int64_t>(mode);
  objects_.add(kDriveObjects);
  objects_.add(
      {.index = 0x6060, .bytes = 1, .access = rw, .is_signed = true, .min = number, .max = number});
  objects_.add(
      {.index = 0x6061, .bytes = 1, .initial = number, .mappable = true, .is_signed = true});
  objects_.add({.index = 0x6502, .initial = 1 << (number - 1)});
}

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
  const std::int64_t option = communication_error ? objects_.get_signed(0x6007, 0) : 3;
  if (power_ != Power::enabled || option == 0) return;
  if (option == 1) return fail(kConnectionLost);
  if (option == 2) return void(power_ = Power::switch_on_disabled);
  begin_quick_stop();
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
    case Power::not_ready: break;
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

// ---- Profile velocity

VelocityDrive::VelocityDrive(const Identity& identity, unsigned seed, std::size_t tpdos,
                             std::span<const Object> own_objects)
    : Drive(identity, OperationMode::profile_velocity, tpdos, kVelocityObjects, seed),
      velocity_rpm_({.noise = 1.5, .share = 0.001, .quantum = 1, .lag_ms = 5}),
      current_({.noise = 5, .lag_ms = 4, .velocity = false}) {
  objects_.add(own_objects);
}

Signal* VelocityDrive::signal(int number) {
  return number == 1 ? &velocity_rpm_ : number == 2 ? &current_ : nullptr;
}

void VelocityDrive::feel(const MotorState& motor) {
  motor_ = motor;
  velocity_rpm_.step(motor.velocity_rad_s / kRpm_rad_s);
  current_.step(motor.current_per_mille);
}

void VelocityDrive::tick() {
  tick_power();
  warm_ = motor_.temperature_degC > kWarm_degC;
  if (motor_.temperature_degC > kHot_degC) fail(kTooHot);
  const bool blocked = moves() && motor_.at_limit && std::abs(motor_.velocity_rad_s) < 1;
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

std::uint16_t VelocityDrive::mode_bits() const {
  const double rpm = motor_.velocity_rad_s / kRpm_rad_s;
  unsigned bits = 0;
  const auto target_rpm = static_cast<double>(objects_.get_signed(0x60FF, 0));
  if (power_ == Power::enabled && std::abs(rpm - target_rpm) < kReached_rpm) bits |= 1u << 10;
  if (motor_.at_limit) bits |= 1u << 11;
  if (std::abs(rpm) < kStanding_rpm) bits |= 1u << 12;
  return static_cast<std::uint16_t>(bits);
}

void VelocityDrive::measure() {
  objects_.set(0x6041, 0, statusword());
  objects_.set(0x606C, 0, to_i32(velocity_rpm_.read(random_)));
  objects_.set(0x6078, 0, to_i16(current_.read(random_)));
}

}  // namespace lss::sim::nodes
