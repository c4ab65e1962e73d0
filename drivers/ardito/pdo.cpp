#include "drivers/ardito/pdo.h"

#include <limits>

#include "drivers/canopen/drive_pdo.h"

namespace lss::ardito {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Fields of a PDO, in their order.
class Fields {
 public:
  Fields(const Profile& profile, Bytes data) : profile_(profile), data_(data) {}

  template <class Signal>
  std::int64_t raw(Signal signal) {
    const Field& f = profile_.of(signal);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < f.bytes; ++i) value |= std::uint32_t{data_[at_ + i]} << (8 * i);
    at_ += f.bytes;
    if (!f.is_signed) return value;
    if (f.bytes == 1) return static_cast<std::int8_t>(value);
    return f.bytes == 2 ? static_cast<std::int16_t>(value) : static_cast<std::int32_t>(value);
  }
  // NaN when the node has no such signal.
  template <class Signal>
  double value(Signal signal) {
    if (profile_.of(signal).bytes == 0) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(raw(signal)) * profile_.of(signal).unit;
  }

 private:
  const Profile& profile_;
  Bytes data_;
  std::size_t at_ = 0;
};

template <class... Signal>
std::size_t bytes(const Profile& p, Signal... signal) {
  return (std::size_t{p.of(signal).bytes} + ...);
}

// Of TPDO `number`; 0: there is none.
std::size_t length(const Profiles& profiles, std::size_t node, int number) {
  const auto of = [&](Kind kind) -> const Profile& {
    return profiles[static_cast<std::size_t>(kind)];
  };
  if (node < kFirstSteering) {
    using S = WheelSignal;
    const Profile& p = of(Kind::wheel);
    if (number == 1) return bytes(p, S::statusword, S::velocity, S::current);
    return number == 2 ? bytes(p, S::hall_velocity, S::wheel_velocity)
                       : bytes(p, S::temperature, S::link_voltage);
  }
  if (node < kIo) {
    using S = SteeringSignal;
    const Profile& p = of(Kind::steering);
    if (number == 1) return bytes(p, S::statusword, S::position, S::current);
    return number == 2 ? bytes(p, S::wheel_position) : 0;
  }
  if (node == kIo) {
    using S = IoSignal;
    const Profile& p = of(Kind::io);
    if (number == 1) return bytes(p, S::inputs);
    return number == 2 ? bytes(p, S::beta, S::rho1, S::rho2) : 0;
  }
  using S = ImuSignal;
  return number == 1 ? bytes(of(Kind::imu), S::speed, S::direction, S::yaw_rate, S::counter) : 0;
}

// The fields are read in the order in which they are written here.
Reading wheel(std::uint8_t index, int number, Fields f) {
  using S = WheelSignal;
  if (number == 1) {
    WheelMotion m{.wheel = index};
    m.statusword = static_cast<std::uint16_t>(f.raw(S::statusword));
    m.motor_rpm = f.value(S::velocity);
    m.current_permille = f.value(S::current);
    return m;
  }
  if (number == 2) {
    WheelSpeeds m{.wheel = index};
    m.hall_rpm = f.value(S::hall_velocity);
    m.reduction_rpm = f.value(S::wheel_velocity);
    return m;
  }
  WheelHealth m{.wheel = index};
  m.temperature_degC = f.value(S::temperature);
  m.link_V = f.value(S::link_voltage);
  return m;
}

Reading steering(std::uint8_t index, int number, Fields f) {
  using S = SteeringSignal;
  if (number == 2) return SteeringAngle{index, f.value(S::wheel_position)};
  SteeringMotion m{.wheel = index};
  m.statusword = static_cast<std::uint16_t>(f.raw(S::statusword));
  m.motor_rad = f.value(S::position);
  m.current_permille = f.value(S::current);
  return m;
}

Reading io(int number, Fields f) {
  using S = IoSignal;
  if (number == 1) {
    const std::int64_t bits = f.raw(S::inputs);
    return Inputs{(bits & 1) != 0, (bits & 2) != 0};
  }
  Rocker m;
  m.beta_rad = f.value(S::beta);
  m.rho1_rad = f.value(S::rho1);
  m.rho2_rad = f.value(S::rho2);
  return m;
}

Reading imu(Fields f) {
  using S = ImuSignal;
  Imu m;
  m.Vtan_mm_s = f.value(S::speed);
  m.sigma_rad = f.value(S::direction);
  m.yaw_rate_rad_s = f.value(S::yaw_rate);
  m.counter = static_cast<std::uint16_t>(f.raw(S::counter));
  return m;
}

}  // namespace

std::optional<Reading> decode(const Profiles& profiles, std::size_t node, int number,
                              Bytes data) noexcept {
  if (node >= kNodes || number < 1 || number > 3) return std::nullopt;
  const std::size_t size = length(profiles, node, number);
  if (size == 0 || data.size() != size) return std::nullopt;
  const auto fields = [&](Kind kind) {
    return Fields(profiles[static_cast<std::size_t>(kind)], data);
  };
  if (node < kFirstSteering)
    return wheel(static_cast<std::uint8_t>(node), number, fields(Kind::wheel));
  if (node < kIo) {
    const auto index = static_cast<std::uint8_t>(kSteeredWheel[node - kFirstSteering]);
    return steering(index, number, fields(Kind::steering));
  }
  return node == kIo ? io(number, fields(Kind::io)) : imu(fields(Kind::imu));
}

RpdoBytes drive_rpdo(std::uint16_t controlword, std::int32_t target) noexcept {
  return canopen::drive_rpdo(controlword, target);
}

std::int32_t counts(const Field& field, double value) noexcept {
  return canopen::field_i32(value / field.unit);
}

std::uint8_t io_rpdo(std::uint8_t clutches, bool beacon) noexcept {
  return static_cast<std::uint8_t>((clutches & 0x3F) | (beacon ? 0x40 : 0));
}

}  // namespace lss::ardito
