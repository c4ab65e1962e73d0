#include "vehicle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/config/reading.h"
#include "daemon/kit/declare.h"

namespace lss::scout {
namespace {

constexpr double kRadPerSecondPerRpm = std::numbers::pi / 30;
constexpr double kMostAcceleration_m_s2 = 1;
constexpr double kBlockedCurrent_permille = 1200, kStanding_rpm = 20;
constexpr TimeNs kBlockedAfter = kSecond;

constexpr std::array kTunables{
    tunable<&Parameters::speed_m_s>("limits.speed_m_s", "m/s", 0.05, kMostSpeed_m_s, Change::always,
                                    "commands that are faster are limited to it"),
    tunable<&Parameters::acceleration_m_s2>("limits.acceleration_m_s2", "m/s²", 0.05,
                                            kMostAcceleration_m_s2, Change::always, "of the body"),
};
constexpr Tuning<Parameters> kTuning{kTunables, kInfosOf<kTunables>};

constexpr Presentation::Parts kParts[] = {
    {.field = "drives", .unheard = "does not answer, last heartbeat"}};
constexpr Presentation::Hold kHold[] = {
    {"forward", kDriveCommand, {0.3, 0}},        {"backward", kDriveCommand, {-0.3, 0}},
    {"left", kDriveCommand, {0, 0.5}},           {"right", kDriveCommand, {0, -0.5}},
    {"forward left", kDriveCommand, {0.3, 0.5}}, {"forward right", kDriveCommand, {0.3, -0.5}}};
const Vocabulary kVocabulary{
    .modes = kModeNames,
    .modules = kDriveNames,
    .strategies = kit::kDriveStrategyNames,
    .presentation = {.at_rest = "motors off", .parts = kParts, .hold = kHold}};

// Towards `wanted`, at most `step` a frame.
double towards(double wanted, double is, double step) {
  return is + std::clamp(wanted - is, -step, step);
}

}  // namespace

const Tuning<Parameters>& tuning() noexcept { return kTuning; }

Parameters read_parameters(config::Section& root) {
  Parameters p;
  kit::read_drive_bus(root.section("bus"), p);
  config::Section body = root.section("body");
  p.wheel_radius_m = body.number("wheel_radius_m", p.wheel_radius_m, 0.01, 1);
  p.track_m = body.number("track_m", p.track_m, 0.05, 3);
  p.gear = body.number("gear", p.gear, 1, 1000);
  config::Section limits = root.section("limits");
  config::read_tunables(limits, "limits", tuning().tunables, p);
  const double rim_m_s = kMostSpeed_m_s + kMostTurn_rad_s * p.track_m / 2;
  const double rpm = p.gear / p.wheel_radius_m / kRadPerSecondPerRpm;
  p.max_motor_rpm = rim_m_s * rpm;
  p.slew_rpm_s = 2 * kMostAcceleration_m_s2 * rpm;  // a rim's, in a turn that begins
  return p;
}

Vehicle::Vehicle(const Parameters& parameters) noexcept
    : DriveVehicle(parameters, kDrives),
      parameters_(parameters),
      tunables_(values_of(tuning().tunables, parameters)) {}

double Vehicle::dt_s() const noexcept {
  return static_cast<double>(parameters_.bus.period_ns) * 1e-9;
}

Adjusted Vehicle::adjust(std::size_t index, double value, bool really) noexcept {
  return lss::adjust(tuning(), parameters_, tunables_, index, value, really, [] {});
}

void Vehicle::act(lc::ActionSet actions, const Request* request) noexcept {
  DriveVehicle::act(actions, request);
  if (actions & (lc::kEmergencyStop | lc::kMotorsOff))
    wanted_m_s_ = wanted_rad_s_ = speed_m_s_ = turn_rad_s_ = 0;
  if (actions & kMotorsOn) {
    motors_on();
    distance_m_ = x_m_ = y_m_ = yaw_rad_ = 0;
  }
  if (actions & kHalt) wanted_m_s_ = wanted_rad_s_ = 0;
  if (actions & kDrive) {
    const auto drive = arguments<Drive>(*request);
    wanted_m_s_ = drive.speed_m_s;
    wanted_rad_s_ = drive.turn_rad_s;
  }
}

void Vehicle::watch_own(Supervisor& s) noexcept {
  const auto mode = static_cast<Mode>(s.controller().mode);
  if (mode == Mode::enabling && enabled()) s.happen(event::motors_confirmed);
  for (std::size_t i = 0; i < kDrives; ++i) {
    const bool blocked = motion(i).current_permille > kBlockedCurrent_permille &&
                         std::abs(motion(i).motor_rpm) < kStanding_rpm && mode != Mode::none;
    if (!blocked) free_ns_[i] = now();
    if (now() - free_ns_[i] > kBlockedAfter) s.raise(kWheelBlocked, kit::module_of(i));
  }
  if (mode == Mode::stopping && speed_m_s_ == 0 && turn_rad_s_ == 0 && standing(kStanding_rpm))
    s.happen(event::stands);
}

void Vehicle::navigate(TimeNs) noexcept {
  const double rim_m = kRadPerSecondPerRpm / parameters_.gear * parameters_.wheel_radius_m;
  const double left_m_s = motion(0).motor_rpm * rim_m, right_m_s = motion(1).motor_rpm * rim_m;
  measured_m_s_ = (left_m_s + right_m_s) / 2;
  measured_rad_s_ = (right_m_s - left_m_s) / parameters_.track_m;
  distance_m_ += measured_m_s_ * dt_s();
  x_m_ += measured_m_s_ * dt_s() * std::cos(yaw_rad_);
  y_m_ += measured_m_s_ * dt_s() * std::sin(yaw_rad_);
  yaw_rad_ += measured_rad_s_ * dt_s();
}

void Vehicle::guide(TimeNs) noexcept {
  const double step = parameters_.acceleration_m_s2 * dt_s();
  const double limit = parameters_.speed_m_s;
  speed_m_s_ = towards(std::clamp(wanted_m_s_, -limit, limit), speed_m_s_, step);
  turn_rad_s_ = towards(wanted_rad_s_, turn_rad_s_, 2 * step / parameters_.track_m);
}

Vehicle::Command Vehicle::control(TimeNs now) noexcept {
  const double rpm = parameters_.gear / parameters_.wheel_radius_m / kRadPerSecondPerRpm;
  const double side_m_s = turn_rad_s_ * parameters_.track_m / 2;
  return order(std::array{(speed_m_s_ - side_m_s) * rpm, (speed_m_s_ + side_m_s) * rpm}, now);
}

bool Vehicle::describe(const Inputs<Vehicle>& in, const SupervisorState& state,
                       Telemetry& out) noexcept {
  describe_common(in, state, out);
  out.speed_m_s = speed_m_s_;
  out.turn_rad_s = turn_rad_s_;
  out.measured_m_s = measured_m_s_;
  out.measured_rad_s = measured_rad_s_;
  out.distance_m = distance_m_;
  out.x_m = x_m_;
  out.y_m = y_m_;
  out.yaw_rad = yaw_rad_;
  return data_requested();
}

}  // namespace lss::scout

namespace lss {

record::VehicleRecords scout_records() {
  return record::records_of<scout::Vehicle>(scout::logic(), scout::tuning(), scout::read_parameters,
                                            kit::with_frame<scout::Parameters>);
}

Port scout_port() {
  return kit::port<scout::Vehicle, kit::DrivePort<scout::Vehicle, scout::Parameters>>(
      scout::read_parameters, scout::tuning(), scout::logic(), scout::kVocabulary, scout_records,
      kit::with_frame<scout::Parameters>);
}

}  // namespace lss
