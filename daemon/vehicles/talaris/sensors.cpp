#include "daemon/vehicles/talaris/sensors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace lss::talaris {
namespace {

constexpr double kPressureRate_Hz = 5, kLoadRate_Hz = 500;
constexpr double kNever_s = 1e9;
constexpr double kFrames_s = 5;  // a second
// Identical packets of the IMU in a row: more of them are no measurement, nor are these, if the
// frame is the same. Noise moves its last bits.
constexpr int kSameUsed = 3;

}  // namespace

Sensors::Sensors(const Parameters& p) noexcept
    : axes_(p.imu_axes),
      camera_axes_(p.camera_axes),
      imu_silent_ns_(p.imu_silent_ns),
      altimeter_silent_ns_(p.altimeter_silent_ns),
      camera_silent_ns_(p.camera_silent_ns),
      camera_period_ns_(p.buses.camera.period_ns),
      same_limit_(static_cast<int>(std::lround(p.imu_stuck_s / p.navigation.imu_period_s))),
      lossy_limit_(p.imu_lost_per_s),
      standby_(p),
      tank_(gnc::talaris::butterworth(p.pressure_corner_Hz, kPressureRate_Hz)),
      regulated_(gnc::talaris::butterworth(p.pressure_corner_Hz, kPressureRate_Hz)) {
  load_.fill(gnc::talaris::Filter(gnc::talaris::notch(p.notch_Hz, kLoadRate_Hz, p.notch_quality)));
}

void Sensors::configure(const Parameters& p) noexcept {
  imu_silent_ns_ = p.imu_silent_ns;
  altimeter_silent_ns_ = p.altimeter_silent_ns;
  lossy_limit_ = p.imu_lost_per_s;
}

void Sensors::begin(TimeNs now, bool stands) noexcept {
  now_ns_ = now;
  standby_.begin(now, std::span(imu_).first(imu_count_), stands);
  imu_count_ = range_count_ = flow_count_ = corner_count_ = 0;
  lossy_ -= lossy_ / kFrames_s;
  lost_in_frame_ = 0;
  errors_in_frame_ = 0;
  scale_changed_ = false;
}

void Sensors::take(const TalarisSample& sample) noexcept {
  std::visit([&](const auto& heard) { take(heard, sample.time_ns); }, sample.reading);
}

gnc::talaris::Vector3 Sensors::body(const std::array<double, 3>& sensor) const noexcept {
  const auto along = [&](std::size_t i) { return axes_[i].sign * sensor[axes_[i].axis]; };
  return {along(0), along(1), along(2)};
}

void Sensors::take(const ImuPacket& packet, TimeNs time) noexcept {
  const bool goes_on = imu_ns_ != 0 && packet.count > packet_.count;
  if (goes_on) {
    const std::uint64_t missing = packet.count - packet_.count - 1;
    lost_ += missing;
    lost_in_frame_ += missing;
    lossy_ += static_cast<double>(missing);
  }
  const bool same = imu_ns_ != 0 && packet.rate_rad_s == packet_.rate_rad_s &&
                    packet.force_m_s2 == packet_.force_m_s2;
  same_ = same ? same_ + 1 : 0;
  packet_ = packet;
  imu_ns_ = time;
  if (same_ == kSameUsed) imu_count_ -= std::min<std::size_t>(imu_count_, kSameUsed);
  if (same_ < kSameUsed && imu_count_ < kMaxImu)
    imu_[imu_count_++] = {.time_ns = time,
                          .rate_B_rad_s = body(packet.rate_rad_s),
                          .force_B_m_s2 = body(packet.force_m_s2)};
}

void Sensors::take(const ImuStatus& status, TimeNs) noexcept {
  if (status.kind == ImuStatus::Kind::test_flags) test_flags_ = status.value;
  if (status.kind != ImuStatus::Kind::scale) return;
  scale_before_ = scale_;
  scale_ = status.value;
  scale_changed_ = scale_before_ >= 0 && scale_before_ != scale_;
}

void Sensors::take(const Range& range, TimeNs time) noexcept {
  if (range.corner != 0) return take_corner(range, time);
  altimeter_ns_ = time;
  if (range.error != 0) {
    error_ = range.error;
    ++errors_;
    ++errors_in_frame_;
    return;
  }
  repeats_ = range.range_m == range_m_ ? repeats_ + 1 : 0;
  range_m_ = range.range_m;
  range_ns_ = time;
  if (range_count_ < kMaxRanges)
    range_[range_count_++] = {.time_ns = time, .range_m = range.range_m};
}

void Sensors::take_corner(const Range& range, TimeNs time) noexcept {
  if (range.error != 0 || range.corner > kCornerAltimeters) return;
  corner_ns_[range.corner - 1u] = time;
  const auto heard = std::span(corner_).first(corner_count_);
  if (std::ranges::count(heard, range.corner, &gnc::talaris::RangeSample::corner) == kMostOfCorner)
    return;
  std::size_t at = corner_count_++;
  for (; at > 0 && corner_[at - 1].time_ns > time; --at) corner_[at] = corner_[at - 1];
  corner_[at] = {.time_ns = time, .range_m = range.range_m, .corner = range.corner};
}

void Sensors::take(const Flow& flow, TimeNs time) noexcept {
  // Navigation uses no frames out of their rhythm: of such a camera nothing is heard.
  const TimeNs off_ns =
      std::abs(time - std::exchange(frame_of_camera_ns_, time) - camera_period_ns_);
  if (static_cast<double>(off_ns) <
      gnc::talaris::kFlowPeriod * static_cast<double>(camera_period_ns_))
    camera_ns_ = time;
  const auto along = [&](const SensorAxis& axis) { return axis.sign * flow.angle_rad[axis.axis]; };
  if (flow.usable && flow_count_ < kMaxFlows)
    flow_[flow_count_++] = {
        .time_ns = time, .y_rad = along(camera_axes_[0]), .z_rad = along(camera_axes_[1])};
}

void Sensors::take(const GasState& gas, TimeNs time) noexcept {
  gas_ = gas;
  gas_ns_ = time;
  tank_.step(gas.tank_Pa);
  regulated_.step(gas.regulated_Pa);
}

void Sensors::take(const FanSpeeds& fans, TimeNs time) noexcept {
  rpm_ = fans.rpm;
  fans_ns_ = time;
}

void Sensors::take(const Load& load, TimeNs) noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    load_[i].step(load.force_N[i]);
    load_[i + 3].step(load.moment_Nm[i]);
  }
}

gnc::talaris::Batch Sensors::batch() noexcept {
  return {.imu = standby_.with(std::span(imu_).first(imu_count_)),
          .ranges = std::span(range_).first(range_count_),
          .end_ns = now_ns_,
          .flows = std::span(flow_).first(flow_count_),
          .corners = std::span(corner_).first(corner_count_)};
}

double Sensors::age_s(TimeNs since) const noexcept {
  return since == 0 ? kNever_s : static_cast<double>(now_ns_ - since) * 1e-9;
}

bool Sensors::imu_silent() const noexcept {
  return imu_ns_ == 0 || now_ns_ - imu_ns_ > imu_silent_ns_;
}

bool Sensors::altimeter_lost() const noexcept {
  return range_ns_ == 0 || now_ns_ - range_ns_ > altimeter_silent_ns_;
}

bool Sensors::corner_lost(std::size_t corner) const noexcept {
  return corner_ns_[corner] == 0 || now_ns_ - corner_ns_[corner] > altimeter_silent_ns_;
}

bool Sensors::camera_lost() const noexcept {
  return camera_ns_ == 0 || now_ns_ - camera_ns_ > camera_silent_ns_;
}

void Sensors::forget_imu() noexcept {
  imu_ns_ = 0;
  same_ = 0;
  lossy_ = 0;
}

double Sensors::tank_kPa() const noexcept {
  return gas_ns_ == 0 ? gnc::talaris::kNaN : tank_.value() * 1e-3;
}
double Sensors::regulated_kPa() const noexcept {
  return gas_ns_ == 0 ? gnc::talaris::kNaN : regulated_.value() * 1e-3;
}
std::array<double, 3> Sensors::load_N() const noexcept {
  return {load_[0].value(), load_[1].value(), load_[2].value()};
}
std::array<double, 3> Sensors::load_Nm() const noexcept {
  return {load_[3].value(), load_[4].value(), load_[5].value()};
}

}  // namespace lss::talaris
