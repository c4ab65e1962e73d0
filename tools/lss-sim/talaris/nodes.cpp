#include "tools/lss-sim/talaris/nodes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::talaris {
namespace {

using namespace nodes;

constexpr std::uint32_t kProduct = 0x7A1A0000;
constexpr std::uint16_t kNotRenewed = 0x8250;
constexpr auto rw = Access::read_write;

constexpr Object analogue_in(std::uint8_t sub) {
  return {.index = 0x6401, .sub = sub, .bytes = 2, .mappable = true, .is_signed = true};
}
constexpr Object count(std::uint16_t index, std::int64_t subs) {
  return {.index = index, .bytes = 1, .initial = subs};
}

constexpr Object kValveObjects[] = {
    {.index = 0x2200, .bytes = 1, .access = rw, .mappable = true},
    {.index = 0x2201, .bytes = 2, .access = rw},
    count(0x6200, 1),
    {.index = 0x6200, .sub = 1, .bytes = 1, .access = rw, .mappable = true},
    count(0x6206, 1),
    {.index = 0x6206, .sub = 1, .bytes = 1, .access = rw},
    count(0x6207, 1),
    {.index = 0x6207, .sub = 1, .bytes = 1, .access = rw},
    count(0x6401, 4),
    analogue_in(1),
    analogue_in(2),
    analogue_in(3),
    analogue_in(4),
};

constexpr Object pulse_out(std::uint8_t sub) {
  return {.index = 0x6411, .sub = sub, .bytes = 2, .access = rw, .initial = 1000, .mappable = true};
}
constexpr Object error_mode(std::uint8_t sub) {
  return {.index = 0x6443, .sub = sub, .bytes = 1, .access = rw};
}
constexpr Object error_value(std::uint8_t sub) {
  return {.index = 0x6444, .sub = sub, .bytes = 4, .access = rw, .initial = 1000};
}
constexpr Object kFanObjects[] = {
    {.index = 0x2201, .bytes = 2, .access = rw},
    {.index = 0x2202, .bytes = 2, .access = rw},
    count(0x6401, 4),
    analogue_in(1),
    analogue_in(2),
    analogue_in(3),
    analogue_in(4),
    count(0x6411, 4),
    pulse_out(1),
    pulse_out(2),
    pulse_out(3),
    pulse_out(4),
    count(0x6443, 4),
    error_mode(1),
    error_mode(2),
    error_mode(3),
    error_mode(4),
    count(0x6444, 4),
    error_value(1),
    error_value(2),
    error_value(3),
    error_value(4),
};

constexpr Object kLoadObjects[] = {
    count(0x6401, 6), analogue_in(1), analogue_in(2), analogue_in(3),
    analogue_in(4),   analogue_in(5), analogue_in(6),
};

constexpr double kSpeedSteps_rpm = 200;
constexpr double kRinging_rad_s = 2 * std::numbers::pi * 7, kDamping = 0.03;
constexpr double kForceNoise_N = 0.15, kMomentNoise_Nm = 0.02;
// Of the load cell at power-on, and its walk in a second: standard deviations, ours.
constexpr double kOffset_N = 2, kOffset_Nm = 0.2;
constexpr double kWalk_N_rts = 0.03, kWalk_Nm_rts = 0.003;

}  // namespace

bool Renewal::late(bool on, std::uint32_t limit_ms) {
  if (!on) {
    since_ms_ = 0;
    return false;
  }
  return ++since_ms_ == limit_ms;
}

// ---- valves

ValveNode::ValveNode(unsigned seed)
    : Node({.id = kId, .device_type = 0x0006'0191, .product = kProduct + kId}, 1, 2, kValveObjects,
           seed),
      tank_kPa_({.noise = 10, .lag_ms = 5, .velocity = false}),
      regulated_kPa_({.noise = 5, .lag_ms = 5, .velocity = false}),
      voltage_10mV_({.noise = 2, .lag_ms = 5, .velocity = false}),
      temperature_0_1degC_({.noise = 1, .velocity = false}) {}

Signal* ValveNode::signal(int number) {
  Signal* all[] = {&tank_kPa_, &regulated_kPa_, &voltage_10mV_, &temperature_0_1degC_};
  return number >= 1 && number <= 4 ? all[number - 1] : nullptr;
}

void ValveNode::feel(double tank_kPa, double regulated_kPa, double voltage_V,
                     double temperature_degC) {
  tank_kPa_.step(tank_kPa);
  regulated_kPa_.step(regulated_kPa);
  voltage_10mV_.step(voltage_V * 100);
  temperature_0_1degC_.step(temperature_degC * 10);
}

void ValveNode::measure() {
  objects_.set(0x6401, 1, to_u16(tank_kPa_.read(random_)));
  objects_.set(0x6401, 2, to_u16(regulated_kPa_.read(random_)));
  objects_.set(0x6401, 3, to_u16(voltage_10mV_.read(random_)));
  objects_.set(0x6401, 4, to_i16(temperature_0_1degC_.read(random_)));
}

// The sequence is last in the PDO, so the valves are already stored when it is written.
void ValveNode::written(std::uint16_t index, std::uint8_t) {
  if (index != 0x2200) return;
  const std::uint32_t sequence = objects_.get(0x2200, 0);
  if (sequence == 0) return shut();
  if (sequence == last_sequence_) return;
  if (last_sequence_ != 0) gaps_ += (sequence + 254 - last_sequence_) % 255;
  last_sequence_ = sequence;
  outputs_ = static_cast<std::uint8_t>(objects_.get(0x6200, 1));
  renewal_.renewed();
  settle(kNotRenewed);
}

// Valves close in any case, regardless of 0x6206 and 0x6207.
void ValveNode::left_operational(bool) {
  shut();
  last_sequence_ = 0;
}

void ValveNode::tick() {
  if (!renewal_.late(outputs_ != 0, objects_.get(0x2201, 0))) return;
  shut();
  raise(kNotRenewed);
}

// ---- fans

FanNode::FanNode(unsigned seed)
    : Node({.id = kId, .device_type = 0x000C'0191, .product = kProduct + kId}, 1, 1, kFanObjects,
           seed) {}

void FanNode::feel(const std::array<double, kFans>& rpm) {
  for (std::size_t i = 0; i < kFans; ++i) sum_rpm_[i] += rpm[i];
  ++summed_;
}

void FanNode::measure() {
  if (summed_ == 0) return;
  for (std::size_t i = 0; i < kFans; ++i) {
    const double steps = std::round(sum_rpm_[i] / summed_ / kSpeedSteps_rpm);
    objects_.set(0x6401, static_cast<std::uint8_t>(i + 1), to_u16(steps * kSpeedSteps_rpm));
    sum_rpm_[i] = 0;
  }
  summed_ = 0;
}

void FanNode::written(std::uint16_t index, std::uint8_t sub) {
  if (index != 0x6411) return;
  const std::uint32_t wanted = objects_.get(0x6411, sub);
  ramps_ = false;
  pulse_us_[sub - 1u] =
      static_cast<std::uint16_t>(std::clamp<std::uint32_t>(wanted, kOff_us, kFull_us));
  renewal_.renewed();
  settle(kNotRenewed);
}

// By command: off. Without the master, or its orders: even slowing down.
void FanNode::left_operational(bool communication_error) { communication_error ? drop() : off(); }

void FanNode::drop() {
  if (objects_.get(0x2202, 0) == 0) return off();
  ramps_ = true;
  std::ranges::copy(pulse_us_, ramp_us_.begin());
}

void FanNode::tick() {
  if (ramps_) {
    const double step_us =
        static_cast<double>(kFull_us - kOff_us) / std::max(objects_.get(0x2202, 0), 1u);
    for (std::size_t i = 0; i < kFans; ++i) {
      ramp_us_[i] = std::max<double>(ramp_us_[i] - step_us, kOff_us);
      pulse_us_[i] = static_cast<std::uint16_t>(ramp_us_[i]);
    }
    return;
  }
  const bool on = std::ranges::any_of(pulse_us_, [](auto pulse) { return pulse > kOff_us; });
  if (!renewal_.late(on, objects_.get(0x2201, 0))) return;
  drop();
  raise(kNotRenewed);
}

// ---- load cell

LoadCellNode::LoadCellNode(unsigned seed)
    : Node({.id = kId, .device_type = 0x0004'0191, .product = kProduct + kId}, 0, 2, kLoadObjects,
           seed) {
  for (std::size_t i = 0; i < offset_.size(); ++i) offset_[i] = drawn(i, kOffset_N, kOffset_Nm);
}

double LoadCellNode::drawn(std::size_t component, double force_N, double moment_Nm) {
  return std::normal_distribution(0.0, component < 3 ? force_N : moment_Nm)(random_);
}

void LoadCellNode::feel(const Wrench& wrench) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    load_[i] = wrench.force_N[axis];
    load_[i + 3] = wrench.torque_Nm[axis];
  }
}

// One moment for both PDOs.
void LoadCellNode::tick() {
  for (std::size_t i = 0; i < felt_.size(); ++i) {
    Ringing& felt = felt_[i];
    const double pull = kRinging_rad_s * kRinging_rad_s * (load_[i] - felt.value) -
                        2 * kDamping * kRinging_rad_s * felt.rate_1_s;
    felt.rate_1_s += pull * kStep_s;
    felt.value += felt.rate_1_s * kStep_s;
    offset_[i] += std::sqrt(kStep_s) * drawn(i, kWalk_N_rts, kWalk_Nm_rts);
    const double steps =
        (felt.value + offset_[i] + drawn(i, kForceNoise_N, kMomentNoise_Nm)) / (i < 3 ? 0.1 : 0.01);
    objects_.set(0x6401, static_cast<std::uint8_t>(i + 1), to_i16(steps));
  }
}

}  // namespace lss::sim::talaris
