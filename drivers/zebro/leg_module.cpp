#include "drivers/zebro/leg_module.h"

#include <cmath>
#include <numbers>

#include "idl/angles.h"

namespace lss::zebro {
namespace {

constexpr double kPosition_rad = 0.01 * kDegree;
constexpr double kVelocity_rad_s = 0.1 * kDegree;
constexpr double kCurrent_A = 0.001;
constexpr double kTemperature_degC = 0.01;
constexpr double kSupply_V = 0.001;
constexpr double kTime_s = 0.001;

// Ranges of what a working module can report.
constexpr double kTurn_rad = (kTurn_cdeg - 0.5) * kPosition_rad;  // the last position, and rounding
constexpr double kMostVelocity_rad_s = 360 * kDegree;             // three times its limit
constexpr double kMostCurrent_A = 10;                             // far above a stalled motor
constexpr double kLeast_degC = -150, kMost_degC = 200;
constexpr double kLeastSupply_V = 3, kMostSupply_V = 24;  // of 12 V; below it there is no reply

std::uint16_t u16(const Payload& data, std::size_t at) {
  return static_cast<std::uint16_t>((data[at] << 8) | data[at + 1]);
}

std::int16_t i16(const Payload& data, std::size_t at) {
  return static_cast<std::int16_t>(u16(data, at));
}

void put_u16(Payload& data, std::size_t at, std::uint16_t value) {
  data[at] = static_cast<std::uint8_t>(value >> 8);
  data[at + 1] = static_cast<std::uint8_t>(value & 0xFF);
}

}  // namespace

Status decode_status(const Payload& data) noexcept {
  return {u16(data, 0), u16(data, 2) * kPosition_rad, i16(data, 4) * kVelocity_rad_s,
          u16(data, 6) * kCurrent_A};
}

Health decode_health(const Payload& data) noexcept {
  return {i16(data, 0) * kTemperature_degC, u16(data, 2) * kSupply_V, u16(data, 4) * kPosition_rad,
          u16(data, 6) * kTime_s};
}

Identity decode_identity(const Payload& data) noexcept {
  const std::uint32_t uptime_ms = (std::uint32_t{u16(data, 4)} << 16) | u16(data, 6);
  return {data[0], data[1], data[2], data[3], uptime_ms * kTime_s};
}

bool possible(const Status& s) noexcept {
  return (s.flags & kFlagsReserved) == 0 && s.position_rad < kTurn_rad &&
         std::abs(s.velocity_rad_s) <= kMostVelocity_rad_s && s.current_A <= kMostCurrent_A;
}

bool possible(const Health& h) noexcept {
  return h.temperature_degC >= kLeast_degC && h.temperature_degC <= kMost_degC &&
         h.supply_V >= kLeastSupply_V && h.supply_V <= kMostSupply_V && h.set_point_rad < kTurn_rad;
}

std::uint16_t position_cdeg(double angle_rad) noexcept {
  const double turns = angle_rad / (2 * std::numbers::pi);
  const auto cdeg =
      static_cast<std::uint32_t>(std::lround((turns - std::floor(turns)) * kTurn_cdeg));
  return static_cast<std::uint16_t>(cdeg % kTurn_cdeg);  // just below a turn rounds up to it
}

Frame command(std::uint8_t address, Code code) noexcept {
  return {address, static_cast<std::uint8_t>(code), {}};
}

Frame rotate(std::uint8_t address, Code code, std::uint16_t position_cdeg,
             std::uint16_t delta_ms) noexcept {
  Frame frame = command(address, code);
  put_u16(frame.data, 0, position_cdeg);
  put_u16(frame.data, 2, delta_ms);
  return frame;
}

Frame request(std::uint8_t address, Page page) noexcept {
  Frame frame = command(address, Code::request_data);
  frame.data[0] = static_cast<std::uint8_t>(page);
  return frame;
}

}  // namespace lss::zebro
