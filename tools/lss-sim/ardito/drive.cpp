#include "tools/lss-sim/ardito/drive.h"

#include <numbers>

#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::ardito {
namespace {

constexpr double kRpm_rad_s = 2 * std::numbers::pi / 60;

constexpr Object kWheelObjects[] = {
    {.index = 0x2100, .sub = 1, .mappable = true, .is_signed = true},
    {.index = 0x2100, .sub = 2, .mappable = true, .is_signed = true},
    {.index = 0x2101, .sub = 1, .bytes = 2, .mappable = true, .is_signed = true},
    {.index = 0x2101, .sub = 2, .bytes = 2, .mappable = true},
};

}  // namespace

WheelDrive::WheelDrive(std::uint8_t id, unsigned seed)
    : VelocityDrive({.id = id, .device_type = kServo, .product = kProduct}, seed, 3, kWheelObjects),
      hall_rpm_({.noise = 6, .share = 0.004, .quantum = 3, .lag_ms = 15}),
      reduction_crpm_({.noise = 6, .share = 0.002, .quantum = 3, .lag_ms = 20}),
      temperature_({.noise = 1, .lag_ms = 500, .velocity = false}),
      link_({.noise = 2, .lag_ms = 5, .velocity = false}) {}

Signal* WheelDrive::signal(int number) {
  Signal* all[] = {&velocity_rpm_, &hall_rpm_, &reduction_crpm_, &current_, &temperature_, &link_};
  return number >= 1 && number <= 6 ? all[number - 1] : nullptr;
}

void WheelDrive::feel(const WheelTrain& train, const ShaftState& wheel) {
  VelocityDrive::feel({.velocity_rad_s = train.motor_rad_s(),
                       .current_per_mille = train.current_A() / motor::kRated_A * 1000,
                       .at_limit = train.at_limit(),
                       .temperature_degC = train.temperature_degC()});
  hall_rpm_.step(train.motor_rad_s() / kRpm_rad_s);
  reduction_crpm_.step(wheel.velocity_rad_s / kRpm_rad_s * 100);
  temperature_.step(train.temperature_degC() * 10);
  link_.step(link_V_ * 100);
}

void WheelDrive::measure() {
  VelocityDrive::measure();
  objects_.set(0x2100, 1, to_i32(hall_rpm_.read(random_)));
  objects_.set(0x2100, 2, to_i32(reduction_crpm_.read(random_)));
  objects_.set(0x2101, 1, to_i16(temperature_.read(random_)));
  objects_.set(0x2101, 2, to_u16(link_.read(random_)));
}

}  // namespace lss::sim::ardito
