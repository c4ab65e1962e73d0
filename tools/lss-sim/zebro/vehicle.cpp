#include "tools/lss-sim/zebro/vehicle.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "tools/lss-sim/zebro/kinematic.h"
#include "tools/lss-sim/zebro/robot.h"
#include "tools/lss-sim/zebro/soil_robot.h"

namespace lss::sim {
namespace zebro {
namespace {

constexpr FaultArgument kUnit = {"N", "module, 1-6 legs LF RF LM RM LH RH, 7 panel", 1, kModules,
                                 true};
constexpr FaultArgument kModule[] = {kUnit};
constexpr FaultArgument kDrag[] = {
    kUnit, {"TORQUE_NM", "that drags at the shaft", 0, 5, false, true, 1.0}};
constexpr FaultArgument kTemperature[] = {kUnit, {"DEGC", "of the motor", -150, 200}};
constexpr FaultArgument kJump[] = {kUnit, {"DEG", "of a jump", -180, 180, false, true, 90.0}};
constexpr FaultArgument kDrift[] = {kUnit,
                                    {"DEG_S", "degrees a second", -90, 90, false, true, 5.0}};
constexpr FaultArgument kSlip[] = {kUnit, {"SHARE", "of the way", 0.05, 0.9, false, true, 0.3}};
constexpr FaultKind kFaultKinds[] = {
    {"module-dead", kModule, "neither receives nor answers, its motor is off", false, true},
    {"module-reset", kModule, "restarts once: position and calibration are lost", true, true},
    {"leg-stuck", kModule, "the shaft is blocked where it is", false, true},
    {"over-current", kDrag, "the shaft drags: the motor draws more, or stalls", false, true},
    {"driver-fault", kModule, "the motor driver fails whenever it is on, until a reset", false,
     true},
    {"hall-lost", kModule, "its calibration sensor sees nothing", false, true},
    {"temperature", kTemperature, "the motor has this temperature", false, true},
    {"encoder-frozen", kModule, "its encoder stands still", false, true},
    {"encoder-random", kModule, "it reports a random position in each status", false, true},
    {"encoder-jumps", kJump, "its encoder jumps by DEG each second", false, true},
    {"encoder-drifts", kDrift, "its encoder counts DEG_S too many", false, true},
    {"gear-slips", kSlip, "the leg turns by SHARE less than the motor", false, true},
    {"leg-limp", kModule, "the motor draws nothing and turns nothing", false, true},
};

constexpr double kBlocked_Nm = 5;  // holding torque of a blocked shaft
constexpr double kWanting_rad_s = 1e-3;
constexpr double kPatchEdge_m = 0.02;  // ours

std::size_t unit_of(const Fault& fault) {
  return static_cast<std::size_t>(fault.values.front()) - 1;
}

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

double to_seconds(TimeNs time) { return static_cast<double>(time) / 1e9; }

std::unique_ptr<Plant> make_plant(const ZebroOptions& options) {
  if (options.terrain.soil) {
    if (options.plant == PlantKind::kinematic)
      throw std::invalid_argument(
          "the kinematic plant is on hard ground: leave out --ground, or use --plant dart");
    return std::make_unique<SoilRobot>(options.terrain, to_seconds(options.step_ns));
  }
  if (!options.terrain.patches.empty())
    throw std::invalid_argument(
        "a patch is in a soil: leave out --patch or add one to --ground, for example regolith");
  if (options.plant == PlantKind::kinematic)
    return std::make_unique<KinematicRobot>(options.terrain, to_seconds(options.step_ns));
  if (options.step_ns != kStepNs) throw std::invalid_argument("rigid bodies take steps of 1 ms");
  return std::make_unique<Robot>(options.terrain);
}

}  // namespace

soil::Patch parse_patch(const std::string& text) {
  return soil::parse_patch(text, "leg", kPatchEdge_m);
}

const ShaftState& Panel::step(const ShaftDrive& drive) {
  constexpr double kTravel_rad = 110 * kDegree;
  constexpr double kStop_Nm_rad = 20;  // of the stops
  constexpr double kHinge_Nm = 0.02;   // friction
  const double angle_rad = shaft_.angle_rad + drive.velocity_rad_s * step_s_;
  const double past_rad = angle_rad - std::clamp(angle_rad, 0.0, kTravel_rad);
  const bool held = std::abs(past_rad) * kStop_Nm_rad > drive.torque_limit_Nm;
  shaft_.velocity_rad_s = held ? 0 : drive.velocity_rad_s;
  shaft_.angle_rad += shaft_.velocity_rad_s * step_s_;
  const double friction_Nm = std::abs(shaft_.velocity_rad_s) > kWanting_rad_s
                                 ? std::copysign(kHinge_Nm, shaft_.velocity_rad_s)
                                 : 0;
  shaft_.torque_Nm =
      held ? std::copysign(drive.torque_limit_Nm, past_rad) : past_rad * kStop_Nm_rad + friction_Nm;
  return shaft_;
}

Zebro::Zebro(const ZebroOptions& options)
    : options_(options),
      plant_(make_plant(options)),
      panel_(to_seconds(options.step_ns)),
      receiver_(options.check, options.stop) {
  const double step_s = to_seconds(options.step_ns);
  for (const ShaftState& shaft : plant_->shafts()) {
    modules_.emplace_back(std::numbers::pi, shaft.angle_rad, step_s);
  }
  modules_.emplace_back(0.0, panel_.shaft().angle_rad, step_s);
  std::ranges::copy(plant_->shafts(), felt_.begin());
  felt_.back() = panel_.shaft();
}

void Zebro::step() {
  std::array<ShaftDrive, kLegs> legs;
  ShaftDrive panel;
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < kModules; ++i) {
      const ShaftDrive drive = through_obstacle(i, modules_[i].step(felt_[i], slipped_rad_[i]));
      (i < kLegs ? legs[i] : panel) = drive;
    }
  }
  plant_->step(legs);
  panel_.step(panel);
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < kModules; ++i) {
    feel(i, i < kLegs ? plant_->shafts()[i] : panel_.shaft());
  }
}

void Zebro::rest(double seconds) {
  const std::lock_guard lock(mutex_);
  for (Module& module : modules_) module.rest(seconds);
}

double Zebro::current_A() const {
  const std::lock_guard lock(mutex_);
  double sum_A = 0;
  for (const Module& module : modules_) sum_A += module.current_A();
  return sum_A;
}

ShaftDrive Zebro::through_obstacle(std::size_t module, const ShaftDrive& drive) {
  wanted_[module] = drive;
  const Obstacle& obstacle = obstacles_[module];
  if (obstacle.limp) return {.velocity_rad_s = 0, .torque_limit_Nm = motor::kHold_Nm};
  if (obstacle.stuck || (obstacle.drag_Nm > 0 && obstacle.drag_Nm >= drive.torque_limit_Nm)) {
    return {.velocity_rad_s = 0, .torque_limit_Nm = kBlocked_Nm};
  }
  return {.velocity_rad_s = drive.velocity_rad_s * (1 - obstacle.slip),
          .torque_limit_Nm = drive.torque_limit_Nm - obstacle.drag_Nm};
}

// The motor's load is that of the leg plus drag; at a blocked shaft it gives its maximum torque.
void Zebro::feel(std::size_t module, const ShaftState& shaft) {
  ShaftState& felt = felt_[module];
  felt = shaft;
  const Obstacle& obstacle = obstacles_[module];
  const ShaftDrive& wanted = wanted_[module];
  if (obstacle.limp) felt.torque_Nm = 0;
  if (obstacle.slip > 0)
    slipped_rad_[module] +=
        shaft.velocity_rad_s * obstacle.slip / (1 - obstacle.slip) * to_seconds(options_.step_ns);
  if (!obstacle.stuck && obstacle.drag_Nm == 0) return;
  const bool wanting = std::abs(wanted.velocity_rad_s) > kWanting_rad_s;
  const double resistance_Nm =
      obstacle.stuck ? wanted.torque_limit_Nm : std::abs(shaft.torque_Nm) + obstacle.drag_Nm;
  felt.torque_Nm = wanting ? std::min(resistance_Nm, wanted.torque_limit_Nm) : 0;
}

std::span<const std::uint8_t> Zebro::receive(std::uint8_t character, TimeNs now) {
  return receive({&character, 1}, now);
}

std::span<const std::uint8_t> Zebro::receive(std::span<const std::uint8_t> characters, TimeNs now) {
  const std::lock_guard lock(mutex_);
  receiver_.receive(characters, now);
  const lss::zebro::ReceiverCounters& c = receiver_.counters();
  const std::uint64_t dropped = c.bad_start + c.bad_length + c.bad_character + c.bad_check;
  for (; dropped_ < dropped; ++dropped_) {
    for (Module& module : modules_) module.count_dropped();
  }
  const auto received = receiver_.take();
  if (!received) return {};
  const lss::zebro::Frame& frame = received->frame;
  if (frame.address == 0) {
    for (Module& module : modules_) module.handle(frame.code, frame.data, false);
    return {};
  }
  if (frame.address > kModules) return {};
  const auto reply = modules_[frame.address - 1u].handle(frame.code, frame.data, true);
  if (!reply) return {};
  return lss::zebro::encode({.address = frame.address, .code = reply->code, .data = reply->data},
                            options_.check, options_.stop, reply_);
}

void Zebro::set_fault(const Fault& fault, bool attach) {
  const std::lock_guard lock(mutex_);
  const std::string_view name = fault.kind->name;
  const std::size_t unit = unit_of(fault);
  Module& module = modules_[unit];
  if (name == "module-dead") {
    module.set_dead(attach);
    if (!attach) module.reset(ResetCause::power_on);
  } else if (name == "module-reset") {
    module.reset(ResetCause::brown_out);
  } else if (name == "leg-stuck") {
    obstacles_[unit].stuck = attach;
  } else if (name == "over-current") {
    obstacles_[unit].drag_Nm = attach ? fault.values[1] : 0;
  } else if (name == "driver-fault") {
    module.set_driver_broken(attach);
  } else if (name == "hall-lost") {
    module.set_hall_broken(attach);
  } else if (name == "temperature") {
    module.set_temperature_degC(attach ? std::optional(fault.values[1]) : std::nullopt);
  } else if (name == "encoder-frozen") {
    encoder_[unit].frozen = attach;
  } else if (name == "encoder-random") {
    encoder_[unit].random = attach;
  } else if (name == "encoder-jumps") {
    encoder_[unit].jump_rad = attach ? fault.values[1] * kDegree : 0;
  } else if (name == "encoder-drifts") {
    encoder_[unit].drift_rad_s = attach ? fault.values[1] * kDegree : 0;
  } else if (name == "gear-slips") {
    obstacles_[unit].slip = attach ? fault.values[1] : 0;
  } else if (name == "leg-limp") {
    obstacles_[unit].limp = attach;
  }
  module.set_encoder(encoder_[unit]);
}

bool Zebro::in_force(const Fault& fault) const {
  if (fault.kind->name != std::string_view("driver-fault")) return true;
  const std::lock_guard lock(mutex_);
  return modules_[unit_of(fault)].driver_broken();
}

nlohmann::ordered_json Zebro::truth() const {
  const BodyState body = plant_->body();
  const Eigen::Quaterniond& q = body.attitude;
  std::array<double, kLegs> legs{}, sinkage_m{}, slip_m_s{};
  std::ranges::transform(plant_->shafts(), legs.begin(), &ShaftState::angle_rad);
  std::ranges::transform(plant_->legs_in_soil(), sinkage_m.begin(), &LegInSoil::sinkage_m);
  std::ranges::transform(plant_->legs_in_soil(), slip_m_s.begin(), &LegInSoil::slip_m_s);
  return {{"position_m", to_array(body.position_m)},
          {"attitude_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"velocity_m_s", to_array(body.velocity_m_s)},
          {"leg_angle_rad", legs},
          {"panel_rad", panel_.shaft().angle_rad},
          {"leg_sinkage_m", sinkage_m},
          {"leg_slip_m_s", slip_m_s}};
}

namespace {

class ZebroKind final : public VehicleKind {
 public:
  std::string name() const override { return "zebro"; }
  std::string summary() const override {
    return "Lunar Zebro: seven modules on a serial line, a six-legged robot behind them";
  }
  std::span<const FaultKind> fault_kinds() const override { return kFaultKinds; }

  void add_options(CLI::App& command) override {
    TerrainOptions& terrain = options_.terrain;
    command
        .add_option(
            "--plant", plant_,
            "dart: rigid bodies; kinematic: legs that carry and roll, no falling or slipping")
        ->check(CLI::IsMember({"dart", "kinematic"}))
        ->capture_default_str();
    gravity_option(command, terrain.gravity_m_s2, "moon");
    number_option(command, "--slope", slope_deg_, "ground rises ahead by this angle, degrees",
                  -30.0, 30.0);
    command.add_flag("--rocks", terrain.rocks, "stones on the ground, placed by the seed");
    command
        .add_option(
            "--ground", ground_,
            "hard, or a soil: sand, loam, regolith, each with :FACTOR of its strength if wanted")
        ->capture_default_str();
    command.add_option("--patch", patches_,
                       "SOIL[:FACTOR]@LEGS[@FROM..TO], repeatable: another soil under these legs "
                       "(digits 1 to 6: LF RF LM RM LH RH), from and to these metres ahead of the "
                       "start");
    number_option(command, "--friction", terrain.friction, "of hard ground", 0.05, 2.0);
    number_option(command, "--scatter", scatter_deg_,
                  "legs boot at up to this from where they were stowed, degrees", 0.0, 80.0);
    command.add_option("--check", check_, "check of the frames")
        ->check(CLI::IsMember({"lrc", "crc8"}))
        ->capture_default_str();
    command.add_option("--stop", stop_, "stop of the frames")
        ->check(CLI::IsMember({"lf", "crlf"}))
        ->capture_default_str();
  }

  std::unique_ptr<Vehicle> make(unsigned seed) const override {
    ZebroOptions options = options_;
    options.check = check_ == "lrc" ? lss::zebro::Check::lrc : lss::zebro::Check::crc8;
    options.stop = stop_ == "lf" ? lss::zebro::Stop::lf : lss::zebro::Stop::crlf;
    options.plant = plant_ == "dart" ? PlantKind::dart : PlantKind::kinematic;
    if (ground_ != "hard") options.terrain.soil = soil::parse_soil(ground_);
    for (const std::string& patch : patches_) options.terrain.patches.push_back(parse_patch(patch));
    options.terrain.seed = seed;
    options.terrain.slope_rad = slope_deg_ * kDegree;
    options.terrain.scatter_rad = scatter_deg_ * kDegree;
    return std::make_unique<Zebro>(options);
  }

 private:
  ZebroOptions options_;
  double slope_deg_ = 0;
  double scatter_deg_ = 20;
  std::vector<std::string> patches_;
  std::string check_ = "lrc", stop_ = "lf", plant_ = "dart", ground_ = "hard";
};

}  // namespace
}  // namespace zebro

std::unique_ptr<VehicleKind> make_zebro_kind() { return std::make_unique<zebro::ZebroKind>(); }

}  // namespace lss::sim
