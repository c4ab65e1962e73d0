#include "tools/lss-sim/ardito/devices.h"

#include <cmath>

#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::ardito {
namespace {

constexpr Object kIoObjects[] = {
    {.index = 0x6000, .bytes = 1, .initial = 1},
    {.index = 0x6000, .sub = 1, .bytes = 1, .mappable = true},
    {.index = 0x6200, .bytes = 1, .initial = 1},
    {.index = 0x6200, .sub = 1, .bytes = 1, .access = rw, .mappable = true},
    {.index = 0x6206, .bytes = 1, .initial = 1},
    {.index = 0x6206, .sub = 1, .bytes = 1, .access = rw},
    {.index = 0x6207, .bytes = 1, .initial = 1},
    {.index = 0x6207, .sub = 1, .bytes = 1, .access = rw},
    {.index = 0x6401, .bytes = 1, .initial = 3},
    {.index = 0x6401, .sub = 1, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x6401, .sub = 2, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x6401, .sub = 3, .bytes = 2, .mappable = true, .is_signed = true},
};
constexpr Object kImuObjects[] = {
    {.index = 0x2110, .bytes = 1, .initial = 4},
    {.index = 0x2110, .sub = 1, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x2110, .sub = 2, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x2110, .sub = 3, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x2110, .sub = 4, .bytes = 2, .mappable = true},
};

constexpr Signal::Quality kAngle = {.noise = 8, .quantum = 4, .lag_ms = 2, .velocity = false};
constexpr double kStanding_mm_s = 5;  // below it a velocity has no direction

}  // namespace

IoNode::IoNode(unsigned seed)
    : Node({.id = kId, .device_type = 0x0007'0191, .product = kProduct}, 1, 2, kIoObjects, seed),
      beta_(kAngle),
      rho1_(kAngle),
      rho2_(kAngle) {}

Signal* IoNode::signal(int number) {
  Signal* all[] = {&beta_, &rho1_, &rho2_};
  return number >= 1 && number <= 3 ? all[number - 1] : nullptr;
}

void IoNode::feel(const Suspension& suspension, bool button, bool power_good) {
  beta_.step(suspension.beta_rad * 1e4);
  rho1_.step(suspension.rho1_rad * 1e4);
  rho2_.step(suspension.rho2_rad * 1e4);
  const auto inputs = static_cast<std::uint8_t>((button ? 1 : 0) | (power_good ? 2 : 0));
  if (inputs != inputs_) changed(0);
  inputs_ = inputs;
}

void IoNode::measure() {
  objects_.set(0x6000, 1, inputs_);
  for (const int sub : {1, 2, 3}) {
    objects_.set(0x6401, static_cast<std::uint8_t>(sub), to_i16(signal(sub)->read(random_)));
  }
}

void IoNode::written(std::uint16_t index, std::uint8_t) {
  if (index == 0x6200) outputs_ = objects_.get(0x6200, 1);
}

// On a communication error the outputs of 0x6206 take the values of 0x6207; otherwise they stay.
void IoNode::left_operational(bool communication_error) {
  if (!communication_error) return;
  const std::uint32_t which = objects_.get(0x6206, 1);
  outputs_ = (outputs_ & ~which) | (objects_.get(0x6207, 1) & which);
  objects_.set(0x6200, 1, outputs_);
}

ImuNode::ImuNode(unsigned seed)
    : Node({.id = kId, .device_type = 0x0001'0000, .product = kProduct}, 0, 1, kImuObjects, seed),
      forward_mm_s_({.noise = 4, .quantum = 0.1, .lag_ms = 10}),
      right_mm_s_({.noise = 1.5, .quantum = 0.1, .lag_ms = 10, .velocity = false}),
      speed_({.quantum = 1}),
      direction_({.quantum = 1}),
      yaw_rate_({.noise = 2, .quantum = 1, .lag_ms = 10}) {}

Signal* ImuNode::signal(int number) {
  Signal* all[] = {&speed_, &direction_, &yaw_rate_};
  return number >= 1 && number <= 3 ? all[number - 1] : nullptr;
}

void ImuNode::feel(const BodyState& body) {
  forward_mm_s_.step(body.velocity_B_m_s.x() * 1e3);
  right_mm_s_.step(-body.velocity_B_m_s.y() * 1e3);
  yaw_rate_.step(-body.yaw_rate_rad_s * 1e3);
  for (Signal* each : {&speed_, &direction_}) each->step(0);  // drift passes
}

void ImuNode::measure() {
  if (stuck_) return;
  const double forward = forward_mm_s_.read(random_), right = right_mm_s_.read(random_);
  const double sign = forward < 0 ? -1 : 1;
  const double speed = std::hypot(forward, right);
  const double direction =
      speed < kStanding_mm_s ? 0 : std::atan2(sign * right, std::abs(forward)) * 1e4;
  speed_.set(sign * speed);
  direction_.set(direction);
  objects_.set(0x2110, 1, to_i16(speed_.read(random_)));
  objects_.set(0x2110, 2, to_i16(direction_.read(random_)));
  objects_.set(0x2110, 3, to_i16(yaw_rate_.read(random_)));
  objects_.set(0x2110, 4, counter_);
}

}  // namespace lss::sim::ardito
