#include "tools/lss-sim/talaris/vehicle.h"

#include <fmt/format.h>

#include <cmath>
#include <random>

namespace lss::sim::talaris {
namespace {

// Five sets of lithium polymer packs (TALARIS thesis 2.3.4): 51.8 V, 45 s at full throttle.
constexpr double kBattery_V = 51.8, kInside_Ohm = 0.005, kEmpty_V = 4, kCharge_J = 1.44e6;
constexpr unsigned kCorners = 4;
constexpr double kFull_W = 8'000;  // of a fan at 33,000 rpm
constexpr double kRated_rpm = 33'000;
constexpr double kShaking_rpm = 29'400;  // of ImuOptions::vibration
constexpr double kTemperature_degC = 21.5,
                 kWarming_degC = 6;  // of the node; its rise over the whole charge

std::array<double, 3> to_array(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

Pointing pointing_of(const TalarisOptions& options) {
  const bool wall = options.plant.stand == Stand::rail || options.plant.stand == Stand::sled;
  return options.pointing.value_or(wall ? Pointing::sideways : Pointing::down);
}

}  // namespace

Talaris::Talaris(const TalarisOptions& options)
    : NodeBus(options.seed + 3),
      options_(options),
      plant_(options.plant),
      air_(options.air, options.seed + 4),
      imu_(make_imu(options.imu, options.seed + 1)),
      altimeter_(options.altimeter, options.seed + 2),
      camera_(options.camera, options.seed + 6),
      gas_(options.gas),
      fans_(options.fans),
      valve_node_(options.seed + ValveNode::kId),
      fan_node_(options.seed + FanNode::kId) {
  if (options.standby_imu) {
    ImuOptions second = options.imu;
    second.kind = ImuKind::crossbow;
    standby_imu_ = make_imu(second, options.seed + 7);
  }
  for (unsigned i = 0; options.corner_altimeters && i < kCorners; ++i) {
    AltimeterOptions own = options.altimeter;
    std::mt19937 random(options.seed * kCorners + i);
    own.bias_m *= std::uniform_real_distribution(-1.0, 1.0)(random);
    corners_.push_back(std::make_unique<Altimeter>(own, options.seed + 8 + i));
  }
  if (options.load_cell.value_or(options.plant.stand == Stand::load)) {
    load_cell_.emplace(options.seed + LoadCellNode::kId);
  }
  add(valve_node_);
  add(fan_node_);
  if (load_cell_) add(*load_cell_);
}

std::vector<SerialLine> Talaris::lines() {
  const bool polled = options_.imu.kind == ImuKind::crossbow;
  // Each command of the Crossbow is a letter; commands of the altimeter end with CR.
  std::vector<SerialLine> all = {
      {.name = "imu",
       .device = imu_.get(),
       .baud = polled ? 38'400 : 115'200,
       .bits = polled ? 10 : 12,
       .frame_begin = 'G'},
      {.name = "altimeter", .device = &altimeter_, .baud = 9'600, .frame_begin = 'D'}};
  if (options_.camera.present)
    all.push_back({.name = "camera", .device = &camera_, .baud = 115'200});
  if (standby_imu_)
    all.push_back(
        {.name = "standby_imu", .device = standby_imu_.get(), .baud = 38'400, .frame_begin = 'G'});
  for (std::size_t i = 0; i < corners_.size(); ++i)
    all.push_back({.name = fmt::format("corner_{}", i + 1),
                   .device = corners_[i].get(),
                   .baud = 9'600,
                   .frame_begin = 'D'});
  return all;
}

// Steps the nodes for a millisecond and applies their outputs. Locked.
Wrench Talaris::act() {
  step_nodes();
  gas_.step(valve_node_.outputs());
  fans_.step(fan_node_.pulse_us());
  std::array<double, kFans> rpm{};
  power_W_ = 0;
  for (std::size_t i = 0; i < kFans; ++i) {
    rpm[i] = fans_.rpm(i);
    power_W_ += kFull_W * std::pow(rpm[i] / kRated_rpm, 3);
  }
  drained_J_ += power_W_ * kStep_s;
  Wrench wrench = gas_.wrench();
  const Wrench lift = fans_.wrench(plant_.body().rate_B_rad_s);
  wrench.force_N += lift.force_N;
  wrench.torque_Nm += lift.torque_Nm;
  valve_node_.feel(gas_.tank_kPa(), gas_.regulated_kPa(), voltage_V(),
                   kTemperature_degC + kWarming_degC * drained_J_ / kCharge_J);
  fan_node_.feel(rpm);
  if (load_cell_) load_cell_->feel(wrench);
  note_waiting();
  return wrench;
}

void Talaris::step() {
  Wrench wrench;
  Vector3 push_N;
  double gas_used_kg = 0, rpm = 0;
  {
    const std::lock_guard lock(mutex_);
    wrench = act();
    push_N = push_N_;
    gas_used_kg = gas_.used_kg();
    for (std::size_t i = 0; i < kFans; ++i) rpm += fans_.rpm(i);
  }
  const Wrench blown = air_.step(plant_.body(), rpm);
  wrench.force_N += blown.force_N;
  wrench.torque_Nm += blown.torque_Nm;
  plant_.step(wrench, gas_used_kg, push_N + air_.push_N());
  const Inertial felt = {plant_.body().rate_B_rad_s, plant_.body().force_B_m_s2,
                         rpm / (kFans * kShaking_rpm)};
  imu_->step(felt);
  if (standby_imu_) standby_imu_->step(felt);
  altimeter_.step(range_m());
  for (std::size_t i = 0; i < corners_.size(); ++i) corners_[i]->step(corner_range_m(i));
  camera_.step(ground_passes_rad_s());
}

// By the velocity of the camera and its distance from the ground straight below it.
std::optional<std::array<double, 2>> Talaris::ground_passes_rad_s() const {
  const FlowCameraOptions& c = options_.camera;
  if (!c.present) return {};
  const auto depth_m = plant_.distance_m(options_.altimeter_at_m, Vector3(-1, 0, 0), c.most_rad);
  if (!depth_m || *depth_m < c.min_m || *depth_m > c.max_m) return {};
  const BodyState& body = plant_.body();
  const Vector3 v = body.attitude.conjugate() * body.velocity_m_s +
                    body.rate_B_rad_s.cross(options_.altimeter_at_m);
  return {{-v.y() / *depth_m + body.rate_B_rad_s.z(), -v.z() / *depth_m - body.rate_B_rad_s.y()}};
}

double Talaris::voltage_V() const {
  return kBattery_V - kInside_Ohm * power_W_ / kBattery_V - kEmpty_V * drained_J_ / kCharge_J;
}

std::optional<double> Talaris::range_m() const {
  const Vector3 along =
      pointing_of(options_) == Pointing::down ? Vector3(-1, 0, 0) : Vector3(0, 0, 1);
  return plant_.distance_m(options_.altimeter_at_m, along, options_.altimeter.most_rad);
}

std::optional<double> Talaris::corner_range_m(std::size_t corner) const {
  const Vector3 at_m(0, corner < 2 ? options_.corner_y_m : -options_.corner_y_m,
                     corner % 3 == 0 ? options_.corner_z_m : -options_.corner_z_m);
  return plant_.distance_m(at_m, Vector3(-1, 0, 0), options_.altimeter.most_rad);
}

nlohmann::ordered_json Talaris::truth() const {
  const BodyState& body = plant_.body();
  const Quaternion& q = body.attitude;
  const std::lock_guard lock(mutex_);
  std::array<double, kFans> rpm{};
  std::array<bool, kFans> armed{};
  for (std::size_t i = 0; i < kFans; ++i) {
    rpm[i] = fans_.rpm(i);
    armed[i] = fans_.armed(i);
  }
  const auto range = range_m();
  nlohmann::ordered_json state = {
      {"position_m", to_array(body.position_m)},
      {"attitude_wxyz", {q.w(), q.x(), q.y(), q.z()}},
      {"velocity_m_s", to_array(body.velocity_m_s)},
      {"rate_rad_s", to_array(body.rate_B_rad_s)},
      {"clearance_m", plant_.clearance_m()},
      {"range_m", range ? nlohmann::ordered_json(*range) : nlohmann::ordered_json()},
      {"valves", gas_.open()},
      {"rpm", rpm},
      {"armed", armed},
      {"mass_kg", plant_.mass_kg()},
      {"gas_kg", options_.gas.gas_kg - gas_.used_kg()},
      {"thruster_s", gas_.used_s()},
      {"tank_kPa", gas_.tank_kPa()},
      {"voltage_V", voltage_V()},
      {"contact", plant_.contact()},
      {"touchdown_down_m_s", plant_.touchdown().down_m_s},
      {"touchdown_horizontal_m_s", plant_.touchdown().horizontal_m_s},
  };
  if (options_.plant.soil) {
    std::array<double, Plant::kFeet> sinkage_m{};
    for (std::size_t i = 0; i < sinkage_m.size(); ++i) sinkage_m[i] = plant_.sinkage_m(i);
    state["foot_sinkage_m"] = sinkage_m;
  }
  return state;
}

}  // namespace lss::sim::talaris
