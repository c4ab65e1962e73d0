#include <cmath>

#include "gnc/talaris/navigation_parameters.h"

namespace lss::gnc::talaris {

const char* check(const NavigationParameters& p) noexcept {
  const double positive[] = {p.range_sigma_m,
                             p.gate_sigma,
                             p.imu_period_s,
                             p.force_noise,
                             p.rate_noise,
                             p.max_rate_rad_s,
                             p.max_force_m_s2,
                             p.hold_s,
                             p.lost_attitude_rad,
                             p.calibration_s,
                             p.still_rate_rad_s,
                             p.still_force_m_s2,
                             p.rate_spread_rad_s,
                             p.force_spread_m_s2,
                             p.max_rate_bias_rad_s,
                             p.max_force_error_m_s2,
                             p.max_calibration_tilt_rad,
                             p.range_spread_m,
                             p.force_bias_sigma_m_s2,
                             p.start_position_sigma_m,
                             p.start_velocity_sigma_m_s,
                             p.start_heading_sigma_rad,
                             p.standing_sigma_m_s,
                             p.standing_sigma_rad_s,
                             p.standing_sigma_m_s2,
                             p.standing_sigma_rad,
                             p.stand.position_sigma_m,
                             p.stand.velocity_sigma_m_s,
                             p.stand.attitude_sigma_rad,
                             p.gravity_m_s2,
                             p.flow_period_s,
                             p.flow_sigma_rad_s,
                             p.flow_max_m,
                             p.corner_y_m,
                             p.corner_z_m};
  for (const double x : positive) {
    if (!(x > 0) || !std::isfinite(x)) {
      return "a time, limit, sigma or noise of navigation is not above 0";
    }
  }
  const double not_negative[] = {p.force_bias_walk,       p.rate_bias_walk,  p.gap_rotation_rad_s2,
                                 p.gap_acceleration_m_s2, p.range_latency_s, p.ground_slope_rad,
                                 p.flow_scale_sigma,      p.flow_min_m};
  for (const double x : not_negative) {
    if (!(x >= 0) || !std::isfinite(x)) {
      return "a random walk, gap, latency or slope of navigation is below 0";
    }
  }
  if (!p.altimeter_at_B_m.allFinite() || !std::isfinite(p.roll_rad) || !std::isfinite(p.height_m) ||
      !std::isfinite(p.corner_x_m)) {
    return "a place or heading of navigation is not a number";
  }
  if (!(p.range_min_m >= 0) || !(p.range_max_m > p.range_min_m)) {
    return "range_max_m must be above range_min_m";
  }
  if (p.camera && !(p.altimeter && p.pointing == Pointing::down)) {
    return "a camera needs an altimeter that looks down: it measures angles only";
  }
  if (p.corners && !(p.altimeter && p.pointing == Pointing::down)) {
    return "altimeters at the corners need the one in the middle, and that it looks down";
  }
  if (!(p.flow_max_m > p.flow_min_m)) return "farthest_m of the camera must be above nearest_m";
  if (p.range_latency_s > kLatestRange_s) return "range_latency_s must be at most 0.5";
  if (p.imu_period_s > 0.02) return "imu_period_s must be at most 0.02: 10 samples a frame";
  if (!(p.max_tilt_rad > 0) || p.max_tilt_rad > 75 * kDegree) {
    return "max_tilt_rad must be above 0 and at most 75 deg";
  }
  if (p.pointing == Pointing::sideways && std::abs(p.roll_rad) >= p.max_tilt_rad) {
    return "roll_rad turns the altimeter away from the wall; make it smaller than max_tilt_rad";
  }
  if (p.gate_reopens_after < 2) return "gate_reopens_after must be at least 2";
  if (p.calibration_restarts < 0) return "calibration_restarts must be 0 or more";
  if (p.calibration_s < 1) return "calibration_s must be at least 1";
  if (!(p.min_samples > 0) || p.min_samples > 1) return "min_samples must be in 0..1";
  if (p.min_ranges < 1) return "min_ranges must be at least 1";
  return nullptr;
}

}  // namespace lss::gnc::talaris
