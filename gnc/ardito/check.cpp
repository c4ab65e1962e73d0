#include <cmath>

#include "gnc/ardito/parameters.h"
#include "gnc/ardito/vote.h"
#include "gnc/math.h"

namespace lss::gnc::ardito {
namespace {

template <class T>
bool finite(const T& value) noexcept {
  if constexpr (IsArray<T>::value) {
    for (const auto& one : value) {
      if (!finite(one)) return false;
    }
    return true;
  } else if constexpr (Tied<T>) {
    return std::apply([](const auto&... one) { return (finite(one) && ...); }, T::members(value));
  } else if constexpr (std::is_floating_point_v<T>) {
    return std::isfinite(value);
  } else {
    return true;
  }
}

bool rising(const std::array<double, kNoLoadPoints>& x) noexcept {
  for (std::size_t i = 1; i < kNoLoadPoints; ++i) {
    if (x[i] <= x[i - 1]) return false;
  }
  return x[0] >= 0;
}

}  // namespace

const char* check(const Parameters& p) noexcept {
  const Geometry& g = p.geometry;
  if (!finite(p)) return "a parameter is not a number";
  if (g.a_m <= 0 || g.b_m <= 0 || g.c_m <= 0 || g.d_m <= 0 || g.e_m <= 0 || g.f_m <= 0 ||
      g.wheel_radius_m <= 0 || g.gear_ratio <= 0 || g.l4_m <= 0) {
    return "lengths and the gear ratio must be greater than 0";
  }
  if (p.top_speed_m_s <= 0 || p.top_speed_m_s > 1) {
    return "top_speed_m_s must be above 0 and at most 1: above that the rover tips over";
  }
  if (p.deceleration_m_s2 < 0.05 || p.deceleration_m_s2 > 2) {
    return "deceleration_m_s2 must be in 0.05..2: wheels that brake harder slide";
  }
  // with the centre of rotation inside a middle wheel, that wheel would turn without rolling
  if (p.max_sigma_rad < 0 || g.f_m / math::tan(p.max_sigma_rad) <= g.b_m / 2) {
    return "max_sigma_rad puts the centre of rotation between the middle wheels; make it smaller";
  }
  if (5 * p.max_sigma_rad > kPi / 2) return "max_sigma_rad must not be above 18 deg";
  if (std::abs(p.correction_sign) != 1 && p.correction_sign != 0) {
    return "correction_sign must be 1, -1, or 0 for no correction";
  }
  if (p.max_correction < 0 || p.max_correction > 1) return "max_correction must be in 0..1";
  const double step = p.integral_1_s * kFrame_s;
  if (p.proportional < 0 || step <= 0 || std::abs(step - p.proportional) >= 1 ||
      2 * p.proportional >= 2 + step) {
    return "the PI controllers are unstable at 10 Hz; make proportional or integral_1_s smaller";
  }
  if (p.wheel_saturation_rad_s <= 0 || p.steering_saturation_rad <= 0) {
    return "saturations must be greater than 0";
  }
  // between two frames of a ramp a healthy drive lags by the controller's increment
  if (p.wheel_saturation_rad_s * step >= p.agree_rad_s) {
    return "agree_rad_s is smaller than one frame of a ramp: healthy wheels would be faults";
  }
  if (p.drive_age_s < kFrame_s || p.rocker_age_s < kFrame_s || p.imu_age_s < kFrame_s ||
      p.temperature_age_s < kFrame_s) {
    return "age limits must be at least one frame, 0.1 s";
  }
  if (p.agree_share <= 0 || p.agree_share >= 1 || p.still_rad_s <= 0 ||
      p.slow_rad_s <= p.still_rad_s) {
    return "thresholds must be agree_share in 0..1 and 0 < still_rad_s < slow_rad_s";
  }
  if (p.sensor_frames == 0 || p.motor_frames == 0 || p.reduction_frames == 0 ||
      p.clutch_frames == 0 || p.two_sensors_frames == 0 || p.all_sensors_frames == 0 ||
      p.steering_encoder_frames == 0 || p.steering_frames == 0 || p.quiet_frames == 0 ||
      p.imu_frozen_frames == 0 || p.stuck_frames == 0 || p.probe_frames < 2 ||
      p.all_sensors_error_frames < p.all_sensors_frames) {
    return "counters must be at least 1, probe_frames 2, all_sensors_error_frames the larger one";
  }
  if (p.slip_share <= 0 || p.slip_share >= 1 || p.slip_speed_m_s <= 0 ||
      p.yaw_filter_s < kFrame_s) {
    return "slip_share must be in 0..1, slip_speed_m_s above 0, yaw_filter_s at least one frame";
  }
  if (p.slow_share <= 0 || p.slow_share >= 1 || p.slow_hysteresis <= 0 ||
      p.slow_hysteresis >= p.slow_share || p.slow_factor <= 0 || p.slow_factor > 1) {
    return "slow_share must be in 0..1 and above slow_hysteresis, slow_factor in 0..1";
  }
  if (p.slow_least_m_s <= p.slip_speed_m_s || p.slow_rate_1_s <= 0 || p.slow_filter_s < kFrame_s ||
      p.slide_lost_share <= 0) {
    return "slow_least_m_s must be above slip_speed_m_s: at that slip is measured; slow_rate_1_s "
           "and slide_lost_share above 0, slow_filter_s at least one frame";
  }
  if (p.sink_m <= 0 || p.sink_strain_deep <= 1 || p.sink_strain < p.sink_strain_deep ||
      p.sink_deep <= 1 || p.sink_slip <= 0 || p.sink_filter_s < kFrame_s) {
    return "sink_m and sink_slip must be above 0, sink_strain_deep and sink_deep above 1, "
           "sink_strain not below sink_strain_deep, sink_filter_s at least one frame";
  }
  if (p.rocker_way_m <= 0 || p.rocker_mean_rad <= 0 || p.bogie_mean_rad <= 0) {
    return "rocker_way_m, rocker_mean_rad and bogie_mean_rad must be above 0";
  }
  if (p.warm_temperature_C > p.max_temperature_C) {
    return "motors are reported at motor_temperature_degC and taken out at motor_cutoff_degC, "
           "which "
           "must not be lower";
  }
  if (!rising(p.no_load_rad_s)) return "the speeds of no_load_rad_s must rise";
  if (p.probe_share <= 0 || p.probe_share >= 1 || p.clutch_min_rad_s <= p.probe_rad_s) {
    return "a probe must leave some speed: probe_share in 0..1, clutch_min_rad_s > probe_rad_s";
  }
  return nullptr;
}

}  // namespace lss::gnc::ardito
