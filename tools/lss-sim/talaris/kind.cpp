// The entry of TALARIS in lss-sim's roster: its options, and the tolerances of vehicles.

#include <map>
#include <stdexcept>

#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::sim {
namespace talaris {
namespace {

constexpr double kBalanced = 0.05;  // of the offset of the centre of mass
constexpr double kSeaLevel_kg_m3 = 1.2;

}  // namespace

TalarisOptions dispersed(const TalarisOptions& nominal, unsigned seed, const Spread& spread) {
  TalarisOptions drawn = nominal;
  std::mt19937 random(seed * 7'919u + 17u);
  const auto share = [&](double most) {
    return 1 + std::uniform_real_distribution(-most, most)(random);
  };
  const auto off = [&](double most) { return std::uniform_real_distribution(-most, most)(random); };
  drawn.plant.mass_kg *= share(spread.mass);
  for (Eigen::Index i = 0; i < 3; ++i) drawn.plant.inertia_kg_m2[i] *= share(spread.inertia);
  const Vector3 cg_m(off(spread.cg_x_m), off(spread.cg_m), off(spread.cg_m));
  // On the pivot it is balanced first: the remaining offset is within the pivot's friction.
  drawn.plant.cg_m += drawn.plant.stand == Stand::pivot ? kBalanced * cg_m : cg_m;
  drawn.plant.friction_m_s2 *= share(spread.friction);
  for (double& each : drawn.gas.thrust_scale) each *= share(spread.valve_thrust);
  for (double& each : drawn.fans.thrust_scale) each *= share(spread.fan_thrust);
  drawn.fans.lag_s *= share(spread.fan_lag);
  drawn.gas.open_lag_ms =
      std::max(0, drawn.gas.open_lag_ms + static_cast<int>(std::lround(off(spread.valve_lag_ms))));
  drawn.gas.close_lag_ms =
      std::max(0, drawn.gas.close_lag_ms + static_cast<int>(std::lround(off(spread.valve_lag_ms))));
  if (drawn.plant.stand != Stand::free) drawn.plant.heading_rad += off(spread.heading_rad);

  const auto any = [&](double most) {
    return most > 0 ? std::uniform_real_distribution(0.0, most)(random) : 0;
  };
  const auto sigma = [&](double& value, double each) { value = std::max(value, each); };
  drawn.gas.fill -= any(spread.tank_fill);
  drawn.gas.droop += any(spread.droop);
  drawn.gas.fade += any(spread.fade);
  sigma(drawn.fans.torque_m, spread.fan_torque_m);
  if (spread.fan_torque > 0)
    for (double& each : drawn.fans.torque_scale) each *= share(spread.fan_torque);
  sigma(drawn.fans.rotor_kg_m2, spread.rotor_kg_m2);
  sigma(drawn.imu.gyro_scale, spread.imu_scale_sigma);
  sigma(drawn.imu.accel_scale, spread.imu_scale_sigma);
  sigma(drawn.imu.misaligned_rad, spread.imu_misaligned_sigma_rad);
  sigma(drawn.imu.skewed_rad, spread.imu_skewed_sigma_rad);
  drawn.imu.vibration_m_s2 += any(spread.vibration_m_s2);
  drawn.imu.vibration_rad_s += any(spread.vibration_rad_s);
  if (spread.altimeter_bias_m > 0) drawn.altimeter.bias_m += off(spread.altimeter_bias_m);
  drawn.altimeter.latency_s += any(spread.altimeter_latency_s);
  if (drawn.plant.stand != Stand::free) return drawn;
  if (spread.slope_rad > 0) {
    drawn.plant.slope_rad += any(spread.slope_rad);
    drawn.plant.uphill_rad = off(180 * kDegree);
  }
  sigma(drawn.air.density_kg_m3, spread.density_kg_m3);
  drawn.air.wind_m_s += any(spread.wind_m_s);
  drawn.air.gust_m_s += any(spread.gust_m_s);
  if (spread.wind_m_s + spread.gust_m_s > 0) drawn.air.to_rad = off(180 * kDegree);
  if (drawn.camera.present && spread.camera_scale_sigma > 0)
    drawn.camera.scale += std::normal_distribution(0.0, spread.camera_scale_sigma)(random);
  return drawn;
}

namespace {

class TalarisKind final : public VehicleKind {
 public:
  std::string name() const override { return "talaris"; }
  std::string summary() const override {
    return "TALARIS: IMU and altimeter on serial lines, CANopen nodes for valves and fans, a "
           "hopper "
           "behind them";
  }
  std::span<const FaultKind> fault_kinds() const override { return talaris::fault_kinds(); }
  std::string can_address() const override { return "udp://127.0.0.1:20000"; }
  bool has_lines() const override { return true; }

  void add_options(CLI::App& command) override {
    add_stand_options(command);
    add_body_options(command);
    add_actuator_options(command);
    add_sensor_options(command);
    add_field_options(command);
  }

  std::unique_ptr<Vehicle> make(unsigned seed) const override {
    TalarisOptions options = options_;
    options.seed = seed;
    options.plant.tilt_rad = tilt_deg_ * kDegree;
    options.plant.heading_rad = heading_deg_ * kDegree;
    options.plant.slope_rad = slope_deg_ * kDegree;
    options.plant.uphill_rad = uphill_deg_ * kDegree;
    if (ground_ != "hard") options.plant.soil = soil::parse_soil(ground_);
    options.air.to_rad = to_deg_ * kDegree;
    if (options.air.wind_m_s + options.air.gust_m_s > 0 && options.air.density_kg_m3 == 0)
      options.air.density_kg_m3 = kSeaLevel_kg_m3;
    fill(options.plant.cg_m, cg_m_);
    fill(options.altimeter_at_m, altimeter_at_m_);
    options.plant.inertia_kg_m2 =
        options.plant.inertia_kg_m2.cwiseProduct(Vector3(scale_[0], scale_[1], scale_[2]));
    options.gas.thrust_scale.fill(thrust_scale_);
    options.fans.thrust_scale.fill(fan_scale_);
    for (double* each : {&options.imu.gyro_noise_rad_s, &options.imu.accel_noise_m_s2,
                         &options.imu.gyro_bias_rad_s, &options.imu.accel_bias_m_s2,
                         &options.imu.gyro_walk_rad_s_rts, &options.imu.accel_walk_m_s2_rts}) {
      *each *= imu_errors_;
    }
    if (!altimeter_points_.empty()) {
      options.pointing = altimeter_points_ == "down" ? Pointing::down : Pointing::sideways;
    }
    if (load_cell_) options.load_cell = true;
    const Stand stand = options.plant.stand;
    if (heading_deg_ != 0 && stand != Stand::free && stand != Stand::sled) {
      throw std::invalid_argument("--heading is for the stands free and sled only");
    }
    if (options.plant.weight_kg > 0 && stand != Stand::pivot) {
      throw std::invalid_argument("--weight is for the stand pivot only");
    }
    if (!disperse_) return std::make_unique<Talaris>(options);
    return std::make_unique<Talaris>(dispersed(options, seed, wide_ ? kWide : kNarrow));
  }

 private:
  static void fill(Vector3& to, const std::vector<double>& from) {
    to = Vector3(from[0], from[1], from[2]);
  }

  void add_stand_options(CLI::App& command) {
    const std::map<std::string, Stand> stands = {{"free", Stand::free}, {"rail", Stand::rail},
                                                 {"sled", Stand::sled}, {"pivot", Stand::pivot},
                                                 {"lift", Stand::lift}, {"fans", Stand::fans},
                                                 {"load", Stand::load}};
    const std::map<std::string, Axis> axes = {{"pitch", Axis::pitch}, {"yaw", Axis::yaw}};
    choice_option(command, "--stand", options_.plant.stand,
                  "free, rail, sled, pivot, lift, fans or load: what may move", stands, "free");
    choice_option(command, "--axis", options_.plant.axis, "pitch or yaw: of tilt, pivot and lift",
                  axes, "pitch");
    number_option(command, "--tilt", tilt_deg_, "at the start, degrees", -30.0, 30.0);
    number_option(command, "--heading", heading_deg_,
                  "at the start, about x, degrees; free and sled", -180.0, 180.0);
    number_option(command, "--height", options_.plant.height_m,
                  "at the start, m above where it stands", 0.0, 20.0);
    number_option(command, "--wall", options_.plant.wall_m, "rail, sled: from the start along z, m",
                  0.7, 100.0);
    number_option(command, "--weight", options_.plant.weight_kg,
                  "pivot: at the end of the frame, kg", 0.0, 10.0);
    number_option(command, "--stand-friction", options_.plant.friction_m_s2,
                  "rail, sled, lift, fans: what slows it down, m/s2", 0.0, 5.0);
  }

  void add_body_options(CLI::App& command) {
    number_option(command, "--mass", options_.plant.mass_kg, "with full tanks, kg", 20.0, 80.0);
    command.add_option("--inertia-scale", scale_, "factors about x, y, z")
        ->expected(3)
        ->check(CLI::Range(0.2, 5.0));
    command.add_option("--cg", cg_m_, "centre of mass from the IMU: x y z, m")
        ->expected(3)
        ->check(CLI::Range(-0.2, 0.2));
    auto* disperse =
        command.add_flag("--disperse", disperse_, "draw masses, thrusts and lags from the seed");
    command
        .add_flag("--wide", wide_, "and what a day in the field brings: wind, slope, sensor errors")
        ->needs(disperse);
  }

  void add_actuator_options(CLI::App& command) {
    number_option(command, "--thrust", options_.gas.thrust_N, "of a valve, N", 1.0, 200.0);
    number_option(command, "--thrust-scale", thrust_scale_, "factor on it", 0.1, 3.0);
    number_option(command, "--fade", options_.gas.fade,
                  "share of it that is gone with the last gas", 0.0, 1.0);
    number_option(command, "--droop", options_.gas.droop,
                  "share of the pressure that each further open valve takes", 0.0, 0.1);
    number_option(command, "--gas", options_.gas.budget_s, "in full tanks, thruster-seconds", 1.0,
                  1'000.0);
    number_option(command, "--open-lag", options_.gas.open_lag_ms, "of the valves, ms", 0, 100);
    number_option(command, "--close-lag", options_.gas.close_lag_ms, "of the valves, ms", 0, 100);
    number_option(command, "--fan-scale", fan_scale_, "factor on the fans' thrust", 0.1, 3.0);
    number_option(command, "--fan-bend", options_.fans.bend,
                  "their speed at throttle t goes with t + BEND t (1 - t)", -0.5, 0.5);
    command.add_flag("--fans-started", options_.fans.started,
                     "the speed controllers had their start-up procedure already");
  }

  void add_sensor_options(CLI::App& command) {
    const std::map<std::string, ImuKind> kinds = {{"landmark", ImuKind::landmark},
                                                  {"crossbow", ImuKind::crossbow}};
    choice_option(command, "--imu", options_.imu.kind, "landmark or crossbow", kinds, "landmark");
    command.add_flag("--standby-imu", options_.standby_imu,
                     "a second IMU, a Crossbow, on the line \"standby_imu\"");
    number_option(command, "--imu-errors", imu_errors_, "factor on its noise and biases", 0.0,
                  100.0);
    command
        .add_option("--altimeter", altimeter_points_,
                    "down or sideways; default: as the stand needs it")
        ->check(CLI::IsMember({"down", "sideways"}).description(""));
    command.add_option("--altimeter-at", altimeter_at_m_, "its place from the IMU: x y z, m")
        ->expected(3)
        ->check(CLI::Range(-1.0, 1.0));
    number_option(command, "--altimeter-noise", options_.altimeter.noise_m, "standard deviation, m",
                  0.0, 1.0);
    command.add_flag("--corner-altimeters", options_.corner_altimeters,
                     "four more altimeters, on the lines \"corner_1\" to \"corner_4\"");
    command.add_flag("--camera", options_.camera.present,
                     "a camera on the line \"camera\", beside the altimeter");
    command.add_flag("--load-cell", load_cell_, "node 0x22 also where the stand has none");
  }

  void add_field_options(CLI::App& command) {
    number_option(command, "--air", options_.air.density_kg_m3,
                  "its density, kg/m3; with wind: 1.2", 0.0, 2.0);
    number_option(command, "--wind", options_.air.wind_m_s, "steady, m/s", 0.0, 30.0);
    number_option(command, "--gust", options_.air.gust_m_s, "most that a gust adds, m/s", 0.0,
                  30.0);
    number_option(command, "--wind-to", to_deg_, "where it blows, degrees from +z towards +y",
                  -360.0, 360.0);
    number_option(command, "--slope", slope_deg_, "of the ground, degrees; stand free only", 0.0,
                  20.0);
    number_option(command, "--uphill", uphill_deg_, "where it rises, degrees from +z towards +y",
                  -360.0, 360.0);
    command
        .add_option("--ground", ground_,
                    "hard, or a soil: sand, loam, regolith, each with :FACTOR of its strength if "
                    "wanted; stand free only")
        ->capture_default_str();
    number_option(command, "--tank-fill", options_.gas.fill, "share of the full tanks", 0.1, 1.0);
  }

  TalarisOptions options_;
  double slope_deg_ = 0, uphill_deg_ = 0, to_deg_ = 0;
  double tilt_deg_ = 0, heading_deg_ = 0, thrust_scale_ = 1, fan_scale_ = 1, imu_errors_ = 1;
  std::vector<double> scale_ = {1, 1, 1}, cg_m_ = {0, 0, 0}, altimeter_at_m_ = {0, 0, 0};
  std::string altimeter_points_, ground_ = "hard";
  bool disperse_ = false, wide_ = false, load_cell_ = false;
};

}  // namespace
}  // namespace talaris

std::unique_ptr<VehicleKind> make_talaris_kind() {
  return std::make_unique<talaris::TalarisKind>();
}

}  // namespace lss::sim
