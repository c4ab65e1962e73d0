#include "gnc/talaris/parameters.h"

#include <cmath>

namespace lss::gnc::talaris {
namespace {

bool within(double x, double low, double high) noexcept { return x >= low && x <= high; }

const char* check(const Gains& g) noexcept {
  if (!within(g.attitude_wn_rad_s, 0.1, 4)) return "gains: attitude_wn must be 0.1 to 4 rad/s";
  if (!within(g.attitude_zeta, 0.3, 2)) return "gains: attitude_zeta must be 0.3 to 2";
  if (!within(g.attitude_ki_1_s3, 0.001, 5)) return "gains: attitude_ki must be 0.001 to 5 1/s3";
  // Routh: s^3 + 2 zeta wn s^2 + wn^2 s + ki
  const double wn_rad_s = g.attitude_wn_rad_s;
  if (g.attitude_ki_1_s3 >= 2 * g.attitude_zeta * wn_rad_s * wn_rad_s * wn_rad_s) {
    return "gains: attitude_ki is too large for wn and zeta: the loop would not be stable";
  }
  if (!within(g.attitude_max_integral_rad_s2, 0, 10)) {
    return "gains: attitude_max_integral must be 0 to 10 rad/s2";
  }
  if (!within(g.attitude_observer, 0, 0.8)) return "gains: attitude_observer must be 0 to 0.8";
  if (!within(g.roll_dead_band_rad, 0, 0.5)) return "gains: roll_dead_band must be 0 to 0.5 rad";
  if (!within(g.roll_rate_limit_rad_s, 0.02, 3)) {
    return "gains: roll_rate_limit must be 0.02 to 3 rad/s";
  }
  if (!within(g.roll_brake_share, 0.05, 1)) return "gains: roll_brake_share must be 0.05 to 1";
  if (!within(g.roll_slope_1_s, 0.2, 10)) return "gains: roll_slope must be 0.2 to 10 1/s";
  if (!within(g.roll_share, 0.2, 1)) return "gains: roll_share must be 0.2 to 1";
  if (!within(g.lateral_wn_rad_s, 0, 1)) return "gains: lateral_wn must be 0 to 1 rad/s";
  if (!within(g.lateral_zeta, 0.3, 2)) return "gains: lateral_zeta must be 0.3 to 2";
  if (!within(g.lateral_max_tilt_rad, 0, 0.2))
    return "gains: lateral_max_tilt must be 0 to 0.2 rad";
  if (!within(g.lateral_carry_N_s, 0, 50)) return "gains: lateral_carry must be 0 to 50 N s";
  if (!within(g.rpm_kp, 0, 2) || !within(g.rpm_ki_1_s, 0, 5)) {
    return "gains: rpm_kp must be 0 to 2 and rpm_ki 0 to 5 1/s";
  }
  if (!within(g.height_kp_1_s2, 0.05, 5) || !within(g.height_ki_1_s3, 0, 2) ||
      !within(g.height_kd_1_s, 0.1, 5)) {
    return "gains: height_kp must be 0.05 to 5, height_ki 0 to 2, height_kd 0.1 to 5";
  }
  if (!within(g.height_rate_m_s, 0.02, 1)) return "gains: height_rate must be 0.02 to 1 m/s";
  if (!within(g.fan_attitude_pole_rad_s, 0.3, 4)) {
    return "gains: fan_attitude_pole must be 0.3 to 4 rad/s";
  }
  if (!within(g.fan_max_tilt_rad, 0, 0.3)) return "gains: fan_max_tilt must be 0 to 0.3 rad";
  return nullptr;
}

const char* check(const Thrusters& t) noexcept {
  if (!within(t.force_N, 1, 1000)) return "thrusters: force must be 1 to 1000 N";
  if (!within(t.lift_y_m, 0.05, 5) || !within(t.lift_z_m, 0.05, 5) ||
      !within(t.side_y_m, 0.05, 5)) {
    return "thrusters: distances from the centre must be 0.05 to 5 m";
  }
  if (!(t.min_on_s > 0 && t.min_on_s < t.max_on_s && t.max_on_s <= t.long_on_s &&
        t.long_on_s <= kFrame_s)) {
    return "thrusters: 0 < min_on < max_on <= long_on <= 0.2 s does not hold";
  }
  if (!within(t.attitude_room_s, 0, 0.3 * (t.max_on_s - t.min_on_s))) {
    return "thrusters: attitude_room must be 0 to 0.3 of max_on - min_on";
  }
  if (!within(t.lag_s, 0, 0.03)) return "thrusters: lag must be 0 to 0.03 s";
  return nullptr;
}

const char* check(const Fans& f) noexcept {
  if (!(f.thrust_N_per_rpm2 > 0) || !within(f.max_rpm, 100, 100000)) {
    return "fans: thrust_N_per_rpm2 must be positive and max_rpm 100 to 100000";
  }
  if (!within(f.lag_s, 0.01, 2)) return "fans: lag must be 0.01 to 2 s";
  if (!within(f.y_m, 0.05, 5) || !within(f.z_m, 0.05, 5)) {
    return "fans: distances from the centre must be 0.05 to 5 m";
  }
  if (!within(f.weight_share, 0, 0.98)) return "fans: weight_share must be 0 to 0.98";
  if (!within(f.rpm_quantum, 0, 5000)) return "fans: rpm_quantum must be 0 to 5000 rpm";
  if (!(f.esc_min_us >= 500 && f.esc_min_us < f.esc_max_us && f.esc_max_us <= 2500)) {
    return "fans: 500 <= esc_min < esc_max <= 2500 us does not hold";
  }
  if (!within(f.ramp_rpm_s, 100, 100000)) return "fans: ramp must be 100 to 100000 rpm/s";
  if (!within(f.settled_rpm, 10, 5000)) return "fans: settled_rpm must be 10 to 5000 rpm";
  if (f.settled_rpm < f.rpm_quantum) return "fans: settled_rpm must not be below rpm_quantum";
  if (!within(f.settled_s, 0, 10)) return "fans: settled must be 0 to 10 s";
  if (!within(f.spin_up_timeout_s, 1, 60)) return "fans: spin_up_timeout must be 1 to 60 s";
  if (!within(f.max_run_s, 5, 3600)) return "fans: max_run must be 5 to 3600 s";
  return nullptr;
}

const char* check(const Gas& g) noexcept {
  if (!within(g.budget_s, 0.1, 10000)) return "gas: budget must be 0.1 to 10000 thruster-seconds";
  if (!within(g.reserve_s, 0, g.budget_s)) return "gas: reserve must be 0 to the budget";
  if (!within(g.attitude_N, 0, 1000)) return "gas: attitude must be 0 to 1000 N";
  if (!within(g.mass_kg, 0, 100)) return "gas: mass must be 0 to 100 kg";
  if (!(g.empty_kPa >= 0 && g.empty_kPa < g.full_kPa))
    return "gas: 0 <= empty < full kPa does not hold";
  if (!within(g.min_regulated_kPa, 0, 10000)) return "gas: min_regulated must be 0 to 10000 kPa";
  return nullptr;
}

const char* check(const Profile& p) noexcept {
  if (!within(p.climb_m_s2, 0.05, 5) || !within(p.descend_m_s2, 0.05, 5)) {
    return "profile: climb and descend must be 0.05 to 5 m/s2";
  }
  if (!within(p.hover_s, 0, 30)) return "profile: hover must be 0 to 30 s";
  if (!within(p.lateral_duty, 0.05, 0.79)) return "profile: lateral_duty must be 0.05 to 0.79";
  if (!within(p.min_leg_s, 1, 30)) return "profile: min_leg must be 1 to 30 s";
  if (!within(p.touchdown_height_m, 0.02, 1) || !within(p.touchdown_speed_m_s, 0.02, 0.5)) {
    return "profile: touchdown_height must be 0.02 to 1 m and touchdown_speed 0.02 to 0.5 m/s";
  }
  if (!within(p.clearance_m, 0, 5)) return "profile: clearance must be 0 to 5 m";
  if (!within(p.settle_angle_rad, 0.01, 0.5) || !within(p.settle_rate_rad_s, 0.01, 1) ||
      !within(p.settle_s, 0.2, 20)) {
    return "profile: settle_angle must be 0.01 to 0.5 rad, settle_rate 0.01 to 1 rad/s, settle 0.2 "
           "to 20 s";
  }
  if (!within(p.turn_rate_rad_s, 0.02, 3)) return "profile: turn_rate must be 0.02 to 3 rad/s";
  if (!within(p.turn_timeout_s, 0, 60)) return "profile: turn_timeout must be 0 to 60 s";
  if (!within(p.keep_s, 1, 120)) return "profile: keep must be 1 to 120 s";
  if (!within(p.stand_on_s, 0.04, 0.16)) return "profile: stand_on must be 0.04 to 0.16 s";
  return nullptr;
}

const char* check(const Limits& l) noexcept {
  if (!within(l.imu_hold_s, 0.05, 1)) return "limits: imu_hold must be 0.05 to 1 s";
  if (!within(l.range_age_s, 0.1, 5)) return "limits: range_age must be 0.1 to 5 s";
  if (!within(l.valve_age_s, 0.05, 5) || !within(l.fan_age_s, 0.05, 5)) {
    return "limits: valve_age and fan_age must be 0.05 to 5 s";
  }
  if (!within(l.tilt_rad, 0.1, 1.2)) return "limits: tilt must be 0.1 to 1.2 rad";
  if (!within(l.rate_rad_s, 0.5, 8)) return "limits: rate must be 0.5 to 8 rad/s";
  if (!(l.altimeter_min_m >= 0 && l.altimeter_min_m < l.altimeter_max_m) ||
      !within(l.altimeter_share, 0.1, 1)) {
    return "limits: 0 <= altimeter_min < altimeter_max, altimeter_share 0.1 to 1 do not hold";
  }
  if (!within(l.escape_m_s2, 0.1, 3)) return "limits: escape must be 0.1 to 3 m/s2";
  if (!within(l.blind_m_s, 0.05, 1)) return "limits: blind must be 0.05 to 1 m/s";
  if (!within(l.parachute_m_s, 0.1, 2)) return "limits: parachute must be 0.1 to 2 m/s";
  if (!within(l.level_m_s, 0.1, 2)) return "limits: level must be 0.1 to 2 m/s";
  if (!within(l.contact_height_m, 0.01, 0.5) || !within(l.contact_speed_m_s, 0.01, 1) ||
      !within(l.contact_m_s2, 0.1, 5)) {
    return "limits: contact_height must be 0.01 to 0.5 m, contact_speed 0.01 to 1 m/s, contact 0.1 "
           "to "
           "5 m/s2";
  }
  if (!within(l.run_down_s, 0.2, 20)) return "limits: run_down must be 0.2 to 20 s";
  if (!within(l.corridor_side_m, 0.5, 100) || !within(l.corridor_height_m, 0.2, 20) ||
      !within(l.corridor_m_s, 0.2, 10) || !within(l.corridor_tilt_rad, 0.05, 1.2) ||
      !within(l.corridor_late_s, 1, 60) || !within(l.wind_m_s2, 0.1, 3)) {
    return "limits: corridor_side must be 0.5 to 100 m, corridor_height 0.2 to 20 m, corridor "
           "0.2 to 10 m/s, corridor_tilt 3 to 68 deg, corridor_late 1 to 60 s, wind 0.1 to 3 m/s2";
  }
  if (!(l.waver_m > 0) || l.waver_m > l.corridor_side_m || !(l.waver_m_s > 0) ||
      l.waver_m_s > l.corridor_m_s) {
    return "limits: waver must be above 0 and inside the corridor";
  }
  if (!within(l.place_m, 0.2, 100) || !within(l.touchdown_m_s, 0.1, 3) ||
      !within(l.touchdown_side_m_s, 0.1, 3) || !within(l.upright_rad, 0.05, 1)) {
    return "limits: place must be 0.2 to 100 m, touchdown and touchdown_side 0.1 to 3 m/s, upright "
           "3 to 57 deg";
  }
  return nullptr;
}

}  // namespace

const char* check(const Parameters& p) noexcept {
  if (!within(p.offset_s, 0.0, 0.19)) return "offset must be 0 to 0.19 s";
  const Body& b = p.body;
  if (!within(b.mass_kg, 1, 1000)) return "body: mass must be 1 to 1000 kg";
  if (!within(b.inertia_x_kg_m2, 0.01, 1000) || !within(b.inertia_y_kg_m2, 0.01, 1000) ||
      !within(b.inertia_z_kg_m2, 0.01, 1000)) {
    return "body: moments of inertia must be 0.01 to 1000 kg m2";
  }
  if (p.gas.mass_kg >= b.mass_kg) return "gas: mass must be less than that of the vehicle";
  if (const char* wrong = check(p.thrusters)) return wrong;
  if (const char* wrong = check(p.fans)) return wrong;
  if (const char* wrong = check(p.gas)) return wrong;
  if (const char* wrong = check(p.profile)) return wrong;
  if (const char* wrong = check(p.limits)) return wrong;
  if (p.gain_sets < 1 || p.gain_sets > kGainSets) return "gains: there must be 1 to 8 sets";
  for (std::size_t i = 0; i < p.gain_sets; ++i) {
    if (const char* wrong = check(p.gains[i])) return wrong;
  }
  return nullptr;
}

}  // namespace lss::gnc::talaris
