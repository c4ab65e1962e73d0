// Steering drives: profile position.

#include <algorithm>
#include <cmath>

#include "tools/lss-sim/ardito/drive.h"
#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::ardito {
namespace {

constexpr double kCount_rad = 1e-4;
constexpr double kReached_rad = 0.1, kFollowing_rad = 3.0;
constexpr int kBehind_ms = 500;
constexpr double kFollowGain_1_s = 30;
constexpr std::uint16_t kFollowingError = 0x8611;

constexpr Object kSteeringObjects[] = {
    {.index = 0x6064, .mappable = true, .is_signed = true},
    {.index = 0x607A, .access = rw, .mappable = true, .is_signed = true},
    {.index = 0x6081, .access = rw, .initial = 100'000, .min = 1, .max = kMost},
    {.index = 0x6083, .access = rw, .initial = 500'000, .min = 1, .max = kMost},
    {.index = 0x6084, .access = rw, .initial = 500'000, .min = 1, .max = kMost},
    {.index = 0x6085, .access = rw, .initial = 500'000, .min = 1, .max = kMost},
    {.index = 0x2100, .sub = 3, .mappable = true, .is_signed = true},
};

}  // namespace

SteeringDrive::SteeringDrive(std::uint8_t id, unsigned seed)
    : Drive({.id = id, .device_type = kStepper, .product = kProduct},
            OperationMode::profile_position, 2, kSteeringObjects, seed),
      encoder_({.noise = 30, .quantum = 31, .lag_ms = 1, .velocity = false}),
      reduction_({.noise = 3, .quantum = 4, .lag_ms = 2, .velocity = false}),
      current_({.noise = 8, .lag_ms = 4, .velocity = false}) {}

Signal* SteeringDrive::signal(int number) {
  Signal* all[] = {&encoder_, &reduction_, &current_};
  return number >= 1 && number <= 3 ? all[number - 1] : nullptr;
}

// The absolute encoder behind the gear initialises the motor's count.
void SteeringDrive::reset() {
  Drive::reset();
  zero_rad_ = motor_rad_ - reduction_.read(random_) * kCount_rad * kGear;
  acknowledged_ = last_bit4_ = false;
  next_rad_.reset();
  behind_ms_ = 0;
}

void SteeringDrive::feel(const SteeringTrain& train, const ShaftState& shaft) {
  motor_rad_ = train.motor_rad();
  encoder_.step((motor_rad_ - zero_rad_) / kCount_rad);
  reduction_.step(shaft.angle_rad / kCount_rad);
  current_.step(train.current_A() / motor::kRated_A * 1000);
}

void SteeringDrive::begin_motion() {
  reference_rad_ = goal_rad_ = motor_rad_ - zero_rad_;
  velocity_rad_s_ = 0;
  next_rad_.reset();
}

// Bit 4 rises: a set-point is accepted, at once or after the current one (bit 5).
void SteeringDrive::new_control() {
  const bool bit4 = (controlword() & 1u << 4) != 0;
  const bool rises = bit4 && !last_bit4_;
  last_bit4_ = bit4;
  if (!bit4 || power_ != Power::enabled) acknowledged_ = false;
  if (!rises || next_rad_ || power_ != Power::enabled) return;
  const double set_point_rad = static_cast<double>(objects_.get_signed(0x607A, 0)) * kCount_rad;
  const bool at_once = (controlword() & 1u << 5) != 0 || arrived();
  (at_once ? goal_rad_ : next_rad_.emplace()) = set_point_rad;
  acknowledged_ = true;
}

bool SteeringDrive::arrived() const { return velocity_rad_s_ == 0 && reference_rad_ == goal_rad_; }

void SteeringDrive::tick() {
  tick_power();
  if (!moves()) {
    velocity_rad_s_ = 0;
    behind_ms_ = 0;
    return;
  }
  if (next_rad_ && arrived()) {
    goal_rad_ = *next_rad_;
    next_rad_.reset();
  }
  advance();
  const double error_rad = reference_rad_ - (motor_rad_ - zero_rad_);
  const bool behind = std::abs(error_rad) > kFollowing_rad;
  behind_ms_ = behind ? behind_ms_ + 1 : 0;
  if (behind_ms_ > kBehind_ms) raise(kFollowingError);
  if (!behind) settle(kFollowingError);
}

// A trapezoidal velocity profile, recomputed in every step.
void SteeringDrive::advance() {
  const bool stopping = power_ == Power::quick_stop;
  const double slower_rad_s2 = objects_.get(stopping ? 0x6085 : 0x6084, 0) * kCount_rad;
  const double faster_rad_s2 = objects_.get(0x6083, 0) * kCount_rad;
  const double most_rad_s = objects_.get(0x6081, 0) * kCount_rad;
  const double way_rad = goal_rad_ - reference_rad_;
  const double reach_rad_s = std::sqrt(2 * slower_rad_s2 * std::abs(way_rad));
  const double wanted_rad_s =
      stopping ? 0 : std::copysign(std::min(most_rad_s, reach_rad_s), way_rad);
  const bool faster =
      wanted_rad_s * velocity_rad_s_ >= 0 && std::abs(wanted_rad_s) > std::abs(velocity_rad_s_);
  const double change_rad_s = (faster ? faster_rad_s2 : slower_rad_s2) * kStep_s;
  velocity_rad_s_ += std::clamp(wanted_rad_s - velocity_rad_s_, -change_rad_s, change_rad_s);
  reference_rad_ += velocity_rad_s_ * kStep_s;
  if (stopping) {
    if (velocity_rad_s_ == 0) goal_rad_ = reference_rad_;
  } else if (std::abs(way_rad) <= std::abs(velocity_rad_s_) * kStep_s + slower_rad_s2 * 1e-6) {
    reference_rad_ = goal_rad_;
    velocity_rad_s_ = 0;
  }
}

MotorOrder SteeringDrive::order() const {
  const double error_rad = reference_rad_ - (motor_rad_ - zero_rad_);
  const double follow_rad_s = std::clamp(kFollowGain_1_s * error_rad, -50.0, 50.0);
  return {moves(), velocity_rad_s_ + follow_rad_s};
}

std::uint16_t SteeringDrive::mode_bits() const {
  const double actual_rad = motor_rad_ - zero_rad_;
  unsigned bits = 0;
  const bool there = std::abs(actual_rad - goal_rad_) < kReached_rad && !next_rad_;
  if (power_ == Power::enabled && there) bits |= 1u << 10;
  if (power_ == Power::enabled && acknowledged_) bits |= 1u << 12;
  if (moves() && std::abs(reference_rad_ - actual_rad) > kFollowing_rad) bits |= 1u << 13;
  return static_cast<std::uint16_t>(bits);
}

void SteeringDrive::measure() {
  objects_.set(0x6041, 0, statusword());
  objects_.set(0x6064, 0, to_i32(encoder_.read(random_)));
  objects_.set(0x6078, 0, to_i16(current_.read(random_)));
  objects_.set(0x2100, 3, to_i32(reduction_.read(random_)));
}

}  // namespace lss::sim::ardito
