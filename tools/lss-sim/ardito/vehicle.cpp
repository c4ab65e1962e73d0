#include "tools/lss-sim/ardito/vehicle.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "idl/angles.h"
#include "tools/lss-sim/ardito/kinematic.h"

namespace lss::sim {
namespace ardito {
namespace {

constexpr double kBattery_V = 25.2, kInside_Ohm = 0.02;
constexpr double kCharge_s = 0.03, kDischarge_s = 0.08;  // of the drives' capacitors
constexpr double kPowerGood_V = 20;

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// The values of `Value get(i)` for each of N.
template <std::size_t N, typename Get>
auto collect(Get get) {
  std::array<decltype(get(std::size_t{0})), N> values;
  for (std::size_t i = 0; i < N; ++i) values[i] = get(i);
  return values;
}

std::unique_ptr<RoverPlant> make_plant(const RoverOptions& options) {
  if (options.plant == PlantKind::kinematic) {
    if (options.ground != Ground::flat || options.soil || !options.patches.empty() ||
        options.rocks > 0 || options.slope_rad != 0 || options.step_height_m > 0)
      throw std::invalid_argument(
          "the kinematic plant is on level ground: leave out --ground, --rocks, --slope and "
          "--step, or use --plant dart");
    return std::make_unique<KinematicRover>(options.gravity_m_s2);
  }
  return std::make_unique<Rover>(options);
}

}  // namespace

Ardito::Ardito(const RoverOptions& options)
    : NodeBus(options.seed + 34),
      rover_(make_plant(options)),
      io_(options.seed + 32),
      imu_(options.seed + 33) {
  for (std::size_t i = 0; i < kWheels; ++i) {
    const auto id = static_cast<std::uint8_t>(i + 1);
    wheels_[i] = std::make_unique<WheelDrive>(id, options.seed + id);
    add(*wheels_[i]);
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    steering_[i] = std::make_unique<SteeringDrive>(kSteeringIds[i], options.seed + kSteeringIds[i]);
    add(*steering_[i]);
  }
  add(io_);
  add(imu_);
}

void Ardito::step() {
  std::array<ShaftDrive, kWheels> wheels;
  std::array<ShaftDrive, kSteered> steering;
  {
    const std::lock_guard lock(mutex_);
    step_power();
    step_nodes();
    for (std::size_t i = 0; i < kWheels; ++i) {
      trains_[i].clutch_ordered = io_.clutch(i);
      if (held_degC_[i]) trains_[i].heat_to(*held_degC_[i]);
      wheels[i] = trains_[i].step(wheels_[i]->order(), rover_->wheels()[i], link_V_);
    }
    for (std::size_t i = 0; i < kSteered; ++i) {
      steering[i] = steering_trains_[i].step(steering_[i]->order(), steering_shaft(i), link_V_);
    }
    note_waiting();
  }
  rover_->step(wheels, steering);
  const std::lock_guard lock(mutex_);
  feel();
}

// The button and a failed supply disconnect the motors' battery; the nodes' electronics stay on.
void Ardito::step_power() {
  double current_A = 0;
  for (const WheelTrain& train : trains_) current_A += std::abs(train.current_A());
  const bool on = !button_ && !power_bad_;
  const double goal_V = on ? kBattery_V - kInside_Ohm * current_A : 0;
  link_V_ += (goal_V - link_V_) * kStep_s / (on ? kCharge_s : kDischarge_s);
  for (const auto& drive : wheels_) drive->set_link_V(link_V_);
  for (const auto& drive : steering_) drive->set_link_V(link_V_);
}

// Of the shaft, which gear and encoders know: the wheel stands at an angle to it in a bent bracket.
ShaftState Ardito::steering_shaft(std::size_t i) const {
  ShaftState shaft = rover_->steering()[i];
  shaft.angle_rad -= bent_rad_[i];
  return shaft;
}

void Ardito::feel() {
  for (std::size_t i = 0; i < kWheels; ++i) wheels_[i]->feel(trains_[i], rover_->wheels()[i]);
  for (std::size_t i = 0; i < kSteered; ++i) {
    steering_[i]->feel(steering_trains_[i], steering_shaft(i));
  }
  const bool power_good = !button_ && !power_bad_ && link_V_ > kPowerGood_V;
  io_.feel(rover_->suspension(), button_, power_good);
  imu_.feel(rover_->body());
}

nlohmann::ordered_json Ardito::truth() const {
  const BodyState body = rover_->body();
  const Suspension suspension = rover_->suspension();
  const Eigen::Quaterniond& q = body.attitude;
  const std::lock_guard lock(mutex_);
  return {
      {"position_m", to_array(body.position_m)},
      {"attitude_wxyz", {q.w(), q.x(), q.y(), q.z()}},
      {"velocity_m_s", to_array(body.velocity_m_s)},
      {"velocity_body_m_s", to_array(body.velocity_B_m_s)},
      {"yaw_rate_rad_s", body.yaw_rate_rad_s},
      {"wheel_rad_s", collect<kWheels>([&](auto i) { return rover_->wheels()[i].velocity_rad_s; })},
      {"wheel_slip_m_s", collect<kWheels>([&](auto i) { return rover_->slip_m_s(i); })},
      {"wheel_load_N", rover_->loads_N()},
      {"wheel_sinkage_m", collect<kWheels>([&](auto i) { return rover_->sinkage_m(i); })},
      {"steering_rad", collect<kSteered>([&](auto i) { return rover_->steering()[i].angle_rad; })},
      {"beta_rad", suspension.beta_rad},
      {"rho_rad", {suspension.rho1_rad, suspension.rho2_rad}},
      {"motor_rad_s", collect<kWheels>([&](auto i) { return trains_[i].motor_rad_s(); })},
      {"motor_current_A", collect<kWheels>([&](auto i) { return trains_[i].current_A(); })},
      {"coupled", collect<kWheels>([&](auto i) { return trains_[i].coupled(); })},
      {"beacon", io_.beacon()},
      {"link_V", link_V_},
  };
}

namespace {

// SHAPE, SOIL, or SHAPE,SOIL.
void set_ground(RoverOptions& options, const std::string& text) {
  const std::map<std::string, Ground> shapes = {
      {"flat", Ground::flat}, {"hills", Ground::hills}, {"rough", Ground::rough}};
  const std::size_t comma = text.find(',');
  const auto shape = shapes.find(text.substr(0, comma));
  if (shape != shapes.end()) options.ground = shape->second;
  if (shape != shapes.end() && comma == std::string::npos) return;
  if (shape == shapes.end() && comma != std::string::npos)
    throw std::invalid_argument("--ground " + text + ": before the comma flat, hills or rough");
  try {
    options.soil = soil::parse_soil(comma == std::string::npos ? text : text.substr(comma + 1));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("--ground: ") + error.what() +
                                "; on hard ground: flat, hills, rough");
  }
}

class ArditoKind final : public VehicleKind {
 public:
  std::string name() const override { return "ardito"; }
  std::string summary() const override {
    return "D.I.A.N.A. Ardito: twelve CANopen nodes on a bus, a rocker-bogie rover behind them";
  }
  std::span<const FaultKind> fault_kinds() const override { return ardito::fault_kinds(); }
  std::string can_address() const override { return "udp://127.0.0.1:20000"; }

  void add_options(CLI::App& command) override {
    const std::map<std::string, StepSide> sides = {
        {"both", StepSide::both}, {"left", StepSide::left}, {"right", StepSide::right}};
    command
        .add_option("--plant", plant_,
                    "dart: rigid bodies; kinematic: wheels that roll on level ground")
        ->check(CLI::IsMember({"dart", "kinematic"}))
        ->capture_default_str();
    command
        .add_option("--ground", ground_,
                    "flat, hills or rough, placed by the seed; a soil: sand, loam, regolith, each "
                    "with :FACTOR of its strength if wanted; or both: hills,regolith")
        ->default_str("flat");
    command.add_option(
        "--patch", patches_,
        "SOIL[:FACTOR]@WHEELS[@FROM..TO], repeatable: another soil under these wheels "
        "(digits 1 to 6), from and to these metres ahead of the start");
    command
        .add_option(
            "--rocks", options_.rocks,
            "share of the square metres that have a rock of 10 to 60 mm, placed by the seed")
        ->check(CLI::Range(0.0, 1.0))
        ->default_str("0");
    gravity_option(command, options_.gravity_m_s2, "earth");
    number_option(command, "--friction", options_.friction, "of hard ground", 0.05, 2.0);
    number_option(command, "--slope", slope_deg_, "ground rises ahead by this angle, degrees",
                  -30.0, 30.0);
    number_option(command, "--step", step_mm_, "height of a step across the way, mm; 0: none", 0.0,
                  400.0);
    number_option(command, "--step-at", options_.step_at_m, "where it begins, m ahead of the start",
                  1.0, 1000.0);
    number_option(command, "--step-length", options_.step_length_m, "how long it stays up, m", 0.1,
                  1000.0);
    choice_option(command, "--step-side", options_.step_side, "both, left or right wheels meet it",
                  sides, "both");
  }

  std::unique_ptr<Vehicle> make(unsigned seed) const override {
    RoverOptions options = options_;
    options.seed = seed;
    options.plant = plant_ == "dart" ? PlantKind::dart : PlantKind::kinematic;
    set_ground(options, ground_);
    for (const std::string& patch : patches_) options.patches.push_back(parse_patch(patch));
    options.slope_rad = slope_deg_ * kDegree;
    options.step_height_m = step_mm_ * 1e-3;
    return std::make_unique<Ardito>(options);
  }

 private:
  RoverOptions options_;
  std::string plant_ = "dart", ground_ = "flat";
  std::vector<std::string> patches_;
  double slope_deg_ = 0, step_mm_ = 0;
};

}  // namespace
}  // namespace ardito

std::unique_ptr<VehicleKind> make_ardito_kind() { return std::make_unique<ardito::ArditoKind>(); }

}  // namespace lss::sim
