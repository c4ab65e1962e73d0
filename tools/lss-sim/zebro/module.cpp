#include "tools/lss-sim/zebro/module.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lss::sim::zebro {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

// ICD section 5.
enum Code : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kRotateForward = 0x03,
  kRotateBackward = 0x04,
  kRequest = 0x05,
  kEmergencyStop = 0x06,
  kReset = 0x07,
  kStatus = 0x40,
  kHealth = 0x41,
  kIdentity = 0x42,
};
enum Flag : std::uint16_t {
  kMotionControl = 1 << 0,
  kCalibrated = 1 << 1,
  kMoving = 1 << 2,
  kOverCurrent = 1 << 3,
  kDriverFault = 1 << 4,
  kWatchdog = 1 << 5,
  kHallLevel = 1 << 6,
  kWasReset = 1 << 7,
  kHot = 1 << 8,
};
constexpr std::uint8_t kFirmware[2] = {1, 0};

// The three Hall sensors inside the motor: six states a turn, before the gear.
constexpr double kCount_rad = kTurn_rad / (6 * motor::kGear);
constexpr double kHallWindow_rad = 3 * kDegree;

constexpr double kAcceleration_rad_s2 = 15;
constexpr double kPositionGain_1_s = 8;
constexpr double kFollowing_rad = 10 * kDegree;  // the reference waits for a leg that cannot follow
constexpr double kGoBack_rad = 5 * kDegree;
constexpr double kMoving_rad = 1 * kDegree;

constexpr double kWatchdog_s = 8;
constexpr double kOverCurrent_s = 0.020;
constexpr double kHot_degC = 85, kCool_degC = 80;

double wrap(double angle_rad) {  // into [0, 2 pi)
  const double wrapped = std::fmod(angle_rad, kTurn_rad);
  return wrapped < 0 ? wrapped + kTurn_rad : wrapped;
}

double wrap_half(double angle_rad) { return std::remainder(angle_rad, kTurn_rad); }

double low_pass(double old, double now, double step_s, double time_constant_s) {
  return step_s >= time_constant_s ? now : old + (now - old) * step_s / time_constant_s;
}

std::uint16_t get_u16(const Payload& data, std::size_t at) {
  return static_cast<std::uint16_t>(data[at] << 8 | data[at + 1]);
}

void put(Payload& data, std::size_t at, std::size_t bytes, std::uint32_t value) {
  for (std::size_t i = 0; i < bytes; ++i) {
    data[at + i] = static_cast<std::uint8_t>(value >> (8 * (bytes - 1 - i)));
  }
}

std::uint16_t to_u16(double value) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, 65535.0)));
}

std::uint16_t to_i16(double value) {
  const auto rounded = static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0, 32767.0)));
  return static_cast<std::uint16_t>(rounded);
}

std::uint16_t to_cdeg(double angle_rad) {
  return static_cast<std::uint16_t>(std::lround(wrap(angle_rad) / kDegree * 100) % 36000);
}

}  // namespace

Module::Module(double hall_rad, double shaft_rad, double step_s)
    : step_s_(step_s),
      hall_{.at_rad = hall_rad},
      motor_rad_(shaft_rad),
      encoder_rad_(shaft_rad),
      shaft_rad_(shaft_rad),
      from_hall_rad_(wrap_half(shaft_rad - hall_rad)) {
  reset(ResetCause::power_on);
  boot_left_s_ = 0;
}

void Module::reset(ResetCause cause) {
  motion_control_ = rotating_ = calibrated_ = hot_ = false;
  stops_ = 0;
  was_reset_ = true;
  cause_ = cause;
  dropped_ = 0;
  boot_left_s_ = kBoot_s;
  uptime_s_ = unheard_s_ = over_current_s_ = time_left_s_ = 0;
  velocity_rad_s_ = current_A_ = reference_rad_s_ = 0;
  driver_broken_ = false;  // the driver chip restarts too
  offset_rad_ = 0;
  sense(shaft_rad_);
  if (!calibrated_) {
    offset_rad_ -= measured_rad_;
    measured_rad_ = 0;
  }
}

void Module::rest(double seconds) {
  constexpr double kPiece_s = 10;  // short against the time constant of the heat
  for (double left_s = seconds; left_s > 0; left_s -= kPiece_s)
    heat_.step(0, 0, std::min(left_s, kPiece_s));
  uptime_s_ += seconds;
  unheard_s_ += seconds;
  velocity_rad_s_ = current_A_ = time_left_s_ = 0;
  boot_left_s_ = std::max(0.0, boot_left_s_ - seconds);
}

std::optional<Reply> Module::handle(std::uint8_t code, const Payload& data, bool own) {
  if (dead_ || boot_left_s_ > 0) return std::nullopt;
  if (!own) {
    if (code == kEmergencyStop) stop(0);
    return std::nullopt;
  }
  unheard_s_ = 0;
  switch (code) {
    case kStart:
      stops_ = 0;
      if (motion_control_) break;
      motion_control_ = true;
      rotating_ = false;
      reference_rad_ = goal_rad_ = measured_rad_;
      set_point_rad_ = wrap(measured_rad_);
      reference_rad_s_ = time_left_s_ = over_current_s_ = 0;
      break;
    case kStop:
    case kEmergencyStop: stop(0); break;
    case kRotateForward: rotate(data, +1); break;
    case kRotateBackward: rotate(data, -1); break;
    case kRequest: return request(data[0]);
    case kReset: reset(ResetCause::command); break;
    default:
      if (code < kStatus || code > kIdentity) count_dropped();
  }
  return std::nullopt;
}

std::optional<Reply> Module::request(std::uint8_t page) {
  if (page == 0) return status();
  if (page == 1) return health();
  if (page == 2) return identity();
  count_dropped();
  return std::nullopt;
}

void Module::rotate(const Payload& data, int sense) {
  const std::uint16_t position_cdeg = get_u16(data, 0);
  if (position_cdeg >= 36000) {
    count_dropped();
    return;
  }
  if (!motion_control_) return;
  set_point_rad_ = position_cdeg * 0.01 * kDegree;
  sense_ = sense;
  time_left_s_ = get_u16(data, 2) * 1e-3;
  rotating_ = true;
  plan();
}

// From the leg's position to the set-point in the commanded direction; after a small overshoot it
// goes back.
void Module::plan() {
  double way = wrap(sense_ * (set_point_rad_ - measured_rad_));
  if (way > kTurn_rad - kGoBack_rad) way -= kTurn_rad;
  goal_rad_ = measured_rad_ + sense_ * way;
  reference_rad_ = measured_rad_;
}

void Module::stop(std::uint16_t because) {
  stops_ |= because;
  motion_control_ = rotating_ = false;
  reference_rad_s_ = time_left_s_ = over_current_s_ = 0;
}

ShaftDrive Module::step(const ShaftState& shaft, double slipped_rad) {
  heat_.step(shaft.torque_Nm, shaft.velocity_rad_s, step_s_);
  if (held_degC_) heat_.set_motor_degC(*held_degC_);
  const double before_rad = measured_rad_;
  const double before_offset_rad = offset_rad_;
  turn_encoder(shaft.angle_rad + slipped_rad);
  sense(shaft.angle_rad);
  const double moved_rad = (measured_rad_ - before_rad) - (offset_rad_ - before_offset_rad);
  velocity_rad_s_ = low_pass(velocity_rad_s_, moved_rad / step_s_, step_s_, 0.1);

  uptime_s_ += step_s_;
  unheard_s_ += step_s_;
  time_left_s_ = std::max(0.0, time_left_s_ - step_s_);
  boot_left_s_ = std::max(0.0, boot_left_s_ - step_s_);
  protect(shaft.torque_Nm, shaft.velocity_rad_s);

  // Without power or firmware the driver is off: the gear holds by its friction.
  if (dead_ || !motion_control_) return {.velocity_rad_s = 0, .torque_limit_Nm = motor::kHold_Nm};
  const double reference_rad_s = advance_reference();
  // The reference is that of the end of this step; its advance within a long step is not an error.
  const double ahead_rad = reference_rad_s * (step_s_ - kStep_s);
  const double error_rad = reference_rad_ - ahead_rad - measured_rad_;
  const double felt_rad = error_rad - std::clamp(error_rad, -kCount_rad, kCount_rad);
  const double speed_rad_s =
      std::clamp(reference_rad_s + kPositionGain_1_s * felt_rad, -1.1 * motor::kMaxSpeed_rad_s,
                 1.1 * motor::kMaxSpeed_rad_s);
  return {.velocity_rad_s = speed_rad_s,
          .torque_limit_Nm = motor::torque_limit_Nm(shaft.velocity_rad_s)};
}

// The encoder is at the motor, before the gear.
void Module::turn_encoder(double motor_rad) {
  constexpr double kJumpEvery_s = 1;
  const double turned_rad = motor_rad - motor_rad_;
  motor_rad_ = motor_rad;
  if (encoder_.frozen) return;
  encoder_rad_ += turned_rad + encoder_.drift_rad_s * step_s_;
  jump_due_s_ -= step_s_;
  if (jump_due_s_ > 0) return;
  jump_due_s_ += kJumpEvery_s;
  encoder_rad_ += encoder_.jump_rad;
}

// Counts the encoder and watches the Hall sensor: at its middle the position is set to the true
// one.
void Module::sense(double shaft_rad) {
  const double before_rad = from_hall_rad_;
  const double after_rad = wrap_half(shaft_rad - hall_.at_rad);
  shaft_rad_ = shaft_rad;
  from_hall_rad_ = after_rad;
  const double counted_rad = (std::floor(encoder_rad_ / kCount_rad) + 0.5) * kCount_rad;
  measured_rad_ = counted_rad + offset_rad_;

  const bool crossed = before_rad * after_rad <= 0 && std::abs(after_rad) < kHallWindow_rad &&
                       std::abs(before_rad) < kHallWindow_rad;
  const bool still = calibrated_ && before_rad == after_rad;
  if (hall_.broken || !crossed || still) return;
  // In a long step the shaft has moved on since then.
  const double since_rad = after_rad * (1 - kStep_s / step_s_);
  const double jump_rad = wrap_half(hall_.at_rad + since_rad - measured_rad_);
  offset_rad_ += jump_rad;
  measured_rad_ += jump_rad;
  const bool corrected = calibrated_ && std::abs(jump_rad) < kMoving_rad;
  calibrated_ = true;
  if (corrected || !motion_control_) return;
  if (rotating_) {
    plan();
  } else {
    reference_rad_ = goal_rad_ = measured_rad_;
    set_point_rad_ = wrap(measured_rad_);
  }
}

void Module::protect(double shaft_torque_Nm, double shaft_speed_rad_s) {
  const double current_A =
      motion_control_ ? motor::current_A(shaft_torque_Nm, shaft_speed_rad_s) : 0.0;
  current_A_ = low_pass(current_A_, current_A, step_s_, 0.010);
  over_current_s_ = current_A > motor::kCurrentLimit_A ? over_current_s_ + step_s_ : 0;
  const double temperature_degC = heat_.motor_degC();
  hot_ = temperature_degC > kHot_degC || (hot_ && temperature_degC > kCool_degC);
  if (!motion_control_) return;
  if (over_current_s_ >= kOverCurrent_s) stop(kOverCurrent);
  if (driver_broken_) stop(kDriverFault);
  if (unheard_s_ >= kWatchdog_s) stop(kWatchdog);
}

// A ramp of constant speed that arrives at the end of the time, with limited acceleration at both
// ends: way = speed * time - speed^2 / (2 acceleration), solved for the speed again at every step.
double Module::advance_reference() {
  const double way_rad = goal_rad_ - reference_rad_;
  const double left_rad = std::abs(way_rad);
  const double reach_rad_s = kAcceleration_rad_s2 * time_left_s_;
  const double square = reach_rad_s * reach_rad_s - 2 * kAcceleration_rad_s2 * left_rad;
  double speed_rad_s = square >= 0 ? reach_rad_s - std::sqrt(square) : motor::kMaxSpeed_rad_s;
  speed_rad_s = std::min(
      {speed_rad_s, motor::kMaxSpeed_rad_s, std::sqrt(2 * kAcceleration_rad_s2 * left_rad)});
  const double wanted_rad_s = std::copysign(speed_rad_s, way_rad);
  const double change_rad_s = kAcceleration_rad_s2 * step_s_;
  reference_rad_s_ += std::clamp(wanted_rad_s - reference_rad_s_, -change_rad_s, change_rad_s);
  if (left_rad <= std::abs(reference_rad_s_) * step_s_ + 1e-6) {
    reference_rad_ = goal_rad_;
    reference_rad_s_ = 0;
  } else {
    reference_rad_ += reference_rad_s_ * step_s_;
  }
  reference_rad_ =
      std::clamp(reference_rad_, measured_rad_ - kFollowing_rad, measured_rad_ + kFollowing_rad);
  return reference_rad_s_;
}

bool Module::hall_level() const {
  return !hall_.broken && std::abs(from_hall_rad_) < kHallWindow_rad;
}

std::uint16_t Module::flags() const {
  const bool off_goal = std::abs(goal_rad_ - measured_rad_) > kMoving_rad;
  const bool moving = motion_control_ && rotating_ && (time_left_s_ > 0 || off_goal);
  unsigned flags = stops_;
  if (motion_control_) flags |= kMotionControl;
  if (calibrated_) flags |= kCalibrated;
  if (moving) flags |= kMoving;
  if (hall_level()) flags |= kHallLevel;
  if (was_reset_) flags |= kWasReset;
  if (hot_) flags |= kHot;
  return static_cast<std::uint16_t>(flags);
}

// Uniform; the same ones in every run (Numerical Recipes' quick generator).
std::uint16_t Module::random_cdeg() {
  random_ = random_ * 1664525u + 1013904223u;
  return static_cast<std::uint16_t>((random_ >> 8) % 36000u);
}

Reply Module::status() {
  Reply reply{.code = kStatus};
  put(reply.data, 0, 2, flags());
  put(reply.data, 2, 2, encoder_.random ? random_cdeg() : to_cdeg(measured_rad_));
  put(reply.data, 4, 2, to_i16(velocity_rad_s_ / kDegree * 10));
  put(reply.data, 6, 2, to_u16(current_A_ * 1000));
  was_reset_ = false;
  return reply;
}

Reply Module::health() const {
  constexpr double kCable_Ohm = 0.2;
  Reply reply{.code = kHealth};
  put(reply.data, 0, 2, to_i16(heat_.motor_degC() * 100));
  put(reply.data, 2, 2, to_u16((motor::kSupply_V - kCable_Ohm * current_A_) * 1000));
  put(reply.data, 4, 2, to_cdeg(motion_control_ ? set_point_rad_ : measured_rad_));
  put(reply.data, 6, 2, to_u16(time_left_s_ * 1000));
  return reply;
}

Reply Module::identity() const {
  Reply reply{.code = kIdentity};
  put(reply.data, 0, 1, kFirmware[0]);
  put(reply.data, 1, 1, kFirmware[1]);
  put(reply.data, 2, 1, static_cast<std::uint32_t>(cause_));
  put(reply.data, 3, 1, dropped_);
  put(reply.data, 4, 4, static_cast<std::uint32_t>(std::lround(uptime_s_ * 1000)));
  return reply;
}

}  // namespace lss::sim::zebro
