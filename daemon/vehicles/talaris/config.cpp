#include "daemon/vehicles/talaris/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "daemon/config/reading.h"
#include "daemon/vehicles/talaris/tunables.h"
#include "idl/angles.h"

namespace lss::talaris {
namespace {

namespace g = gnc::talaris;

// Replaces the default in the member; `unit`: of the key, in that of the member.
void read(config::Section& s, std::string_view key, double& member, double min, double max,
          double unit = 1) {
  const double was = member / unit;
  const double is = s.number(key, was, min, max);
  // A default stays bit-identical.
  if (std::abs(is - was) > 1e-5 * std::abs(was)) member = is * unit;
}
void read(config::Section& s, std::string_view key, int& member, int min, int max) {
  member = static_cast<int>(s.integer(key, member, min, max));
}
void read(config::Section& s, std::string_view key, std::uint8_t& member, int min, int max) {
  member = static_cast<std::uint8_t>(s.integer(key, member, min, max));
}
void read_ms(config::Section& s, std::string_view key, TimeNs& member, double min, double max) {
  member = config::milliseconds(s, key, member, min, max);
}

// `body`: the axes of the body along which those of the sensor look, as words.
template <std::size_t kCount>
void read_axes(config::Section& s, std::array<SensorAxis, kCount>& axes, const char* body) {
  std::vector<std::string> names{"x", "y", "z"};
  names.resize(kCount);
  const auto read = s.texts("axes", names);
  for (std::size_t i = 0; i < kCount; ++i) names.push_back("-" + names[i]);
  std::set<std::size_t> used;
  for (std::size_t i = 0; i < read.size() && i < axes.size(); ++i) {
    const auto found = std::find(names.begin(), names.end(), read[i]);
    if (found == names.end()) {
      s.error("axes",
              fmt::format("\"{}\" is no axis: use one of {}", read[i], fmt::join(names, ", ")));
      return;
    }
    const auto number = static_cast<std::size_t>(found - names.begin());
    used.insert(number % kCount);
    axes[i] = {static_cast<std::uint8_t>(number % kCount), number < kCount ? 1.0 : -1.0};
  }
  if (read.size() != kCount || used.size() != kCount)
    s.error("axes", fmt::format("name {} axes of the sensor, each once: along {} of the body",
                                kCount, body));
}

void read_imu(config::Section s, Parameters& p) {
  p.buses.imu =
      static_cast<ImuKind>(s.choice("kind", 0, {std::begin(kImuKinds), std::end(kImuKinds)}));
  read_axes(s, p.imu_axes, "x, y and z");
  p.buses.landmark.configure = s.flag("configure", p.buses.landmark.configure);
  read(s, "rate_range_deg_s", p.buses.crossbow.rate_range_deg_s, 10, 2000);
  read(s, "force_range_g", p.buses.crossbow.force_range_g, 1, 50);
  read(s, "stuck_s", p.imu_stuck_s, 0.02, 1);
  config::read_tunables(s, "imu", tuning().tunables, p);
  p.navigation.imu_period_s =
      static_cast<double>(p.buses.imu == ImuKind::landmark30 ? p.buses.landmark.period_ns
                                                             : p.buses.crossbow.period_ns) *
      1e-9;
}

// Its limits are those of the first.
void read_standby(config::Section s, Parameters& p) {
  p.buses.has_standby = s.flag("present", p.buses.has_standby);
  read_axes(s, p.standby_axes, "x, y and z");
  read(s, "rate_range_deg_s", p.buses.standby.rate_range_deg_s, 10, 2000);
  read(s, "force_range_g", p.buses.standby.force_range_g, 1, 50);
}

void read_altimeter(config::Section s, Parameters& p) {
  g::NavigationParameters& n = p.navigation;
  n.altimeter = s.flag("present", n.altimeter);
  n.pointing = static_cast<g::Pointing>(s.choice("pointing", 0, {"down", "sideways"}));
  const auto at = s.integers("at_mm", {0, 0, 0}, 3, -2000, 2000);
  for (std::size_t i = 0; i < at.size() && i < 3; ++i)
    n.altimeter_at_B_m[static_cast<Eigen::Index>(i)] = static_cast<double>(at[i]) * 1e-3;
  read(s, "sigma_m", n.range_sigma_m, 0.001, 1);
  read(s, "ground_slope_deg", n.ground_slope_rad, 0, 20, kDegree);
  read(s, "nearest_m", n.range_min_m, 0.01, 5);
  read(s, "farthest_m", n.range_max_m, 1, 200);
  read(s, "max_slant_deg", n.max_tilt_rad, 5, 75, kDegree);
  if (n.range_min_m >= n.range_max_m) s.error("nearest_m", "nearest_m must be below farthest_m");
  read_ms(s, "latency_ms", p.buses.altimeter.latency_ns, 0, 200);
  read(s, "repeats", p.altimeter_repeats, 3, 100);
  config::read_tunables(s, "altimeter", tuning().tunables, p);
  p.buses.altimeter.nearest_m = n.range_min_m;
  p.buses.altimeter.farthest_m = n.range_max_m;
  p.flight.limits.altimeter_min_m = n.range_min_m;
  p.flight.limits.altimeter_max_m = n.range_max_m;
}

// Besides that they are like the one in the middle.
void read_corners(config::Section s, Parameters& p) {
  g::NavigationParameters& n = p.navigation;
  n.corners = p.buses.has_corners = s.flag("present", n.corners);
  read(s, "x_m", n.corner_x_m, -1, 1);
  read(s, "y_m", n.corner_y_m, 0.05, 2);
  read(s, "z_m", n.corner_z_m, 0.05, 2);
}

void read_camera(config::Section s, Parameters& p) {
  g::NavigationParameters& n = p.navigation;
  FlowCameraParameters& c = p.buses.camera;
  n.camera = p.buses.has_camera = s.flag("present", n.camera);
  read_axes(s, p.camera_axes, "y and z");
  read(s, "counts_per_rad", c.counts_per_rad, 1, 1e6);
  read_ms(s, "period_ms", c.period_ns, 10, 200);
  read_ms(s, "latency_ms", c.latency_ns, 0, 200);
  read(s, "least_quality", c.least_quality, 0, 255);
  read_ms(s, "silent_ms", p.camera_silent_ns, 100, 10'000);
  read(s, "sigma_deg_s", n.flow_sigma_rad_s, 0.01, 60, kDegree);
  read(s, "scale_sigma", n.flow_scale_sigma, 0, 0.2);
  read(s, "nearest_m", n.flow_min_m, 0, 5);
  read(s, "farthest_m", n.flow_max_m, 0.5, 200);
  n.flow_period_s = static_cast<double>(c.period_ns) * 1e-9;
  // Of a number that is rounded to whole counts: a step by the root of 12.
  const double least = 1 / (n.flow_period_s * n.flow_sigma_rad_s * std::sqrt(12.0));
  if (c.counts_per_rad < least)
    s.error("counts_per_rad", fmt::format("with so coarse counts a frame is less exact than "
                                          "sigma_deg_s says: at least {:.0f}, or a larger sigma",
                                          std::ceil(least)));
}

void read_bus(config::Section s, Parameters& p) {
  HopperBusParameters& b = p.buses.can;
  read(s, "valve_node", b.node[kValveNode], 1, 126);
  read(s, "fan_node", b.node[kFanNode], 1, 126);
  read(s, "load_cell_node", b.node[kLoadCellNode], 1, 126);
  b.load_cell = s.flag("load_cell", b.load_cell);
  read(s, "master_node", b.master_node, 1, 127);
  const std::set<int> numbers = {b.node[0], b.node[1], b.node[2], b.master_node};
  if (numbers.size() != 4) s.error("", "two nodes have one number: give each its own");
  read_ms(s, "node_timeout_ms", b.node_timeout_ns, 100, 5000);
  read_ms(s, "heartbeat_timeout_ms", b.heartbeat_timeout_ns, 50, 1000);
  read_ms(s, "stale_ms", b.stale_after_ns, 250, 5000);
  read_ms(s, "renew_ms", p.buses.valves.renew_ns, 5, 100);
  read_ms(s, "fan_ramp_ms", b.fan_ramp_ns, 0, 10'000);
  config::read_tunables(s, "bus", tuning().tunables, p);
  p.buses.valves.node = b.node[kValveNode];
  p.buses.valves.fan_node = b.node[kFanNode];
  p.buses.valves.stale_after_ns = b.stale_after_ns;
}

void read_navigation(config::Section s, g::NavigationParameters& n) {
  read(s, "calibration_s", n.calibration_s, 1, 300);
  read(s, "calibration_restarts", n.calibration_restarts, 0, 20);
  read(s, "still_deg_s", n.still_rate_rad_s, 0.01, 10, kDegree);
  read(s, "still_m_s2", n.still_force_m_s2, 0.01, 5);
  read(s, "spread_deg_s", n.rate_spread_rad_s, 0.01, 20, kDegree);
  read(s, "spread_m_s2", n.force_spread_m_s2, 0.01, 10);
  read(s, "max_bias_deg_s", n.max_rate_bias_rad_s, 0.01, 20, kDegree);
  read(s, "max_force_error_m_s2", n.max_force_error_m_s2, 0.01, 5);
  read(s, "max_tilt_deg", n.max_calibration_tilt_rad, 1, 60, kDegree);
  read(s, "force_noise", n.force_noise, 1e-5, 1);
  read(s, "rate_noise_deg_s", n.rate_noise, 1e-5, 1, kDegree);
  read(s, "force_bias_walk", n.force_bias_walk, 0, 0.1);
  read(s, "rate_bias_walk", n.rate_bias_walk, 0, 0.01);
  read(s, "gate_sigma", n.gate_sigma, 2, 20);
  read(s, "gate_reopens_after", n.gate_reopens_after, 2, 100);
  read(s, "hold_s", n.hold_s, 0, 5);
  read(s, "lost_deg", n.lost_attitude_rad, 0.1, 45, kDegree);
  read(s, "min_samples", n.min_samples, 0.1, 1);
  read(s, "min_ranges", n.min_ranges, 1, 1000);
  read(s, "range_spread_m", n.range_spread_m, 0.001, 1);
  read(s, "heading_deg", n.roll_rad, -180, 180, kDegree);
  read(s, "height_m", n.height_m, 0, 100);
  read(s, "force_bias_sigma_m_s2", n.force_bias_sigma_m_s2, 1e-4, 1);
  read(s, "start_sigma_m", n.start_position_sigma_m, 1e-5, 1);
  read(s, "start_sigma_m_s", n.start_velocity_sigma_m_s, 1e-5, 1);
  read(s, "start_heading_sigma_deg", n.start_heading_sigma_rad, 1e-4, 10, kDegree);
  read(s, "standing_sigma_m_s", n.standing_sigma_m_s, 1e-5, 1);
  read(s, "standing_sigma_deg_s", n.standing_sigma_rad_s, 1e-4, 1, kDegree);
  read(s, "standing_sigma_m_s2", n.standing_sigma_m_s2, 1e-4, 1);
  read(s, "standing_sigma_deg", n.standing_sigma_rad, 1e-3, 5, kDegree);
  // The flight computes weight and thrust with kGravity_m_s2: anywhere else it would not hover.
  read(s, "gravity_m_s2", n.gravity_m_s2, 9.7, 9.9);
}

void read_stand(config::Section s, g::Stand& stand) {
  for (const std::string& axis : s.texts("fixed", {})) {
    bool* fixed = axis == "x"   ? &stand.fixed_x
                  : axis == "y" ? &stand.fixed_y
                  : axis == "z" ? &stand.fixed_z
                                : nullptr;
    if (fixed != nullptr) {
      *fixed = true;
    } else {
      s.error("fixed", fmt::format("\"{}\" is no axis: use x, y or z", axis));
    }
  }
  stand.rotation = static_cast<g::FreeRotation>(
      s.choice("rotation", 0, {"all", "none", "about-x", "about-y", "about-z"}));
  read(s, "play_m", stand.position_sigma_m, 0.001, 1);
  read(s, "play_m_s", stand.velocity_sigma_m_s, 0.001, 1);
  read(s, "play_deg", stand.attitude_sigma_rad, 0.01, 10, kDegree);
}

void read_body(config::Section s, g::Body& b) {
  read(s, "mass_kg", b.mass_kg, 1, 1000);
  read(s, "inertia_x_kg_m2", b.inertia_x_kg_m2, 0.01, 1000);
  read(s, "inertia_y_kg_m2", b.inertia_y_kg_m2, 0.01, 1000);
  read(s, "inertia_z_kg_m2", b.inertia_z_kg_m2, 0.01, 1000);
}

void read_thrusters(config::Section s, g::Thrusters& t) {
  read(s, "force_N", t.force_N, 1, 1000);
  read(s, "lift_y_m", t.lift_y_m, 0.01, 5);
  read(s, "lift_z_m", t.lift_z_m, 0.01, 5);
  read(s, "side_y_m", t.side_y_m, 0.01, 5);
  read(s, "min_on_ms", t.min_on_s, kMinPulse_s * 1e3, 100, 1e-3);
  read(s, "max_on_ms", t.max_on_s, 100, 200, 1e-3);
  read(s, "attitude_room_ms", t.attitude_room_s, 0, 50, 1e-3);
  read(s, "lag_ms", t.lag_s, 0, 30, 1e-3);
}

void read_fans(config::Section s, Parameters& p) {
  g::Fans& f = p.flight.fans;
  double thrust_N = f.thrust_N_per_rpm2 * f.max_rpm * f.max_rpm;
  const double was_N = thrust_N, was_rpm = f.max_rpm;
  read(s, "thrust_N", thrust_N, 1, 10000);
  read(s, "max_rpm", f.max_rpm, 1000, 100'000);
  if (thrust_N != was_N || f.max_rpm != was_rpm)
    f.thrust_N_per_rpm2 = thrust_N / (f.max_rpm * f.max_rpm);
  read(s, "lag_s", f.lag_s, 0.01, 2);
  read(s, "y_m", f.y_m, 0.01, 5);
  read(s, "z_m", f.z_m, 0.01, 5);
  read(s, "weight_share", f.weight_share, 0, 0.98);
  read(s, "rpm_quantum", f.rpm_quantum, 0, 2000);
  read(s, "ramp_rpm_s", f.ramp_rpm_s, 100, 100'000);
  read(s, "settled_rpm", f.settled_rpm, 10, 5000);
  read(s, "settled_s", f.settled_s, 0, 10);
  read(s, "slew_us_s", p.fan_slew_us_s, 100, 50000);
  config::read_tunables(s, "fans", tuning().tunables, p);
}

void read_gas(config::Section s, Parameters& p) {
  g::Gas& gas = p.flight.gas;
  read(s, "budget_s", gas.budget_s, 1, 1000);
  read(s, "attitude_N", gas.attitude_N, 0, 200);
  read(s, "mass_kg", gas.mass_kg, 0, 100);
  read(s, "full_kPa", gas.full_kPa, 100, 60000);
  read(s, "empty_kPa", gas.empty_kPa, 0, 30000);
  read(s, "refuelled", p.refuelled, 0.5, 1);
  read(s, "pressure_corner_Hz", p.pressure_corner_Hz, 0.05, 2.4);
  config::read_tunables(s, "gas", tuning().tunables, p);
}

void read_profile(config::Section s, Parameters& p) {
  g::Profile& f = p.flight.profile;
  config::read_tunables(s, "profile", tuning().tunables, p);
  read(s, "lateral_duty", f.lateral_duty, 0.05, 1);
  read(s, "min_leg_s", f.min_leg_s, 0.6, 30);
  read(s, "clearance_m", f.clearance_m, 0, 10);
  read(s, "settle_deg", f.settle_angle_rad, 0.1, 30, kDegree);
  read(s, "settle_deg_s", f.settle_rate_rad_s, 0.1, 90, kDegree);
  read(s, "settle_s", f.settle_s, 0, 30);
  read(s, "turn_deg_s", f.turn_rate_rad_s, 1, 180, kDegree);
  read(s, "turn_timeout_s", f.turn_timeout_s, 1, 120);
  read(s, "keep_s", f.keep_s, 1, 120);
  read(s, "stand_on_ms", f.stand_on_s, kMinPulse_s * 1e3, 160, 1e-3);
}

void read_limits(config::Section s, Parameters& p) {
  config::read_tunables(s, "limits", tuning().tunables, p);
  g::Limits& l = p.flight.limits;
  read(s, "altimeter_share", l.altimeter_share, 0.1, 1);
  read(s, "corridor_side_m", l.corridor_side_m, 0.5, 100);
  read(s, "corridor_height_m", l.corridor_height_m, 0.2, 20);
  read(s, "corridor_m_s", l.corridor_m_s, 0.2, 10);
  read(s, "corridor_tilt_deg", l.corridor_tilt_rad, 3, 68, kDegree);
  read(s, "corridor_late_s", l.corridor_late_s, 1, 60);
  read(s, "wind_m_s2", l.wind_m_s2, 0.1, 3);
  read(s, "waver_m", l.waver_m, 0.1, 100);
  read(s, "waver_m_s", l.waver_m_s, 0.1, 10);
  read(s, "place_m", l.place_m, 0.2, 100);
  read(s, "touchdown_m_s", l.touchdown_m_s, 0.1, 3);
  read(s, "touchdown_side_m_s", l.touchdown_side_m_s, 0.1, 3);
  read(s, "upright_deg", l.upright_rad, 3, 57, kDegree);
}

void read_gains(config::Section& s, g::Gains& k) {
  Parameters first;  // the ranges are those of the first set
  config::read_tunables(s, "gains.1", tuning().tunables, first);
  k = first.flight.gains[0];
  read(s, "attitude_max_integral_rad_s2", k.attitude_max_integral_rad_s2, 0, 10);
  read(s, "attitude_observer", k.attitude_observer, 0, 0.8);
  read(s, "roll_dead_band_deg", k.roll_dead_band_rad, 0.1, 20, kDegree);
  read(s, "roll_rate_limit_deg_s", k.roll_rate_limit_rad_s, 1, 180, kDegree);
  read(s, "roll_brake_share", k.roll_brake_share, 0.05, 1);
  read(s, "roll_slope_1_s", k.roll_slope_1_s, 0.2, 10);
  read(s, "roll_share", k.roll_share, 0.2, 1);
  read(s, "lateral_max_tilt_deg", k.lateral_max_tilt_rad, 0, 20, kDegree);
  read(s, "lateral_carry_N_s", k.lateral_carry_N_s, 0, 100);
  read(s, "rpm_kp", k.rpm_kp, 0, 20);
  read(s, "rpm_ki_1_s", k.rpm_ki_1_s, 0, 20);
  read(s, "height_m_s", k.height_rate_m_s, 0.01, 5);
  read(s, "fan_max_tilt_deg", k.fan_max_tilt_rad, 0, 30, kDegree);
}

void read_gain_sets(config::Section& root, g::Parameters& p) {
  std::set<std::string> names;
  std::vector<config::Section> sets = root.sections("gains");
  if (sets.size() > g::kGainSets)
    root.error("gains", fmt::format("{} sets of gains: at most {}", sets.size(), g::kGainSets));
  std::size_t count = 0;
  for (config::Section& s : sets) {
    g::Gains gains;
    const std::string name = s.required_text("name");
    if (!name.empty() && !names.insert(name).second)
      s.error("name", fmt::format("the name \"{}\" is there twice: give each set its own", name));
    read_gains(s, gains);
    if (count < g::kGainSets) p.gains[count++] = gains;
  }
  p.gain_sets = std::max<std::size_t>(count, 1);
}

}  // namespace

Parameters read_parameters(config::Section& root) {
  Parameters p;
  read_imu(root.section("imu"), p);
  read_standby(root.section("standby_imu"), p);
  read_altimeter(root.section("altimeter"), p);
  read_corners(root.section("corner_altimeters"), p);
  read_camera(root.section("camera"), p);
  read_bus(root.section("bus"), p);
  read_navigation(root.section("navigation"), p.navigation);
  read_stand(root.section("stand"), p.navigation.stand);
  read_body(root.section("body"), p.flight.body);
  read_thrusters(root.section("thrusters"), p.flight.thrusters);
  read_fans(root.section("fans"), p);
  read_gas(root.section("gas"), p);
  read_profile(root.section("profile"), p);
  read_limits(root.section("limits"), p);
  read_gain_sets(root, p.flight);
  {
    config::Section s = root.section("load_cell");
    read(s, "notch_Hz", p.notch_Hz, 1, 125);
    read(s, "notch_quality", p.notch_quality, 0.3, 50);
  }
  config::Section solve = root.section("solve");
  for (std::size_t c = 0; c < kFaultClasses; ++c)
    config::read_strategies(solve, kFaultClassNames[c], kStrategyNames, p.solver.order[c]);
  config::read_tunables(solve, "solve", tuning().tunables, p);
  tuning().derive(p);

  if (const char* wrong = g::check(p.navigation)) root.error("navigation", wrong);
  if (const char* wrong = g::check(p.flight)) root.error("", wrong);
  return p;
}

Parameters with_frame(Parameters parameters, const config::Config& config) noexcept {
  parameters.offset_ns = config.offset_ns;
  parameters.flight.offset_s = static_cast<double>(config.offset_ns) * 1e-9;
  return parameters;
}

}  // namespace lss::talaris
