// scout from the view of the daemon: two drives of CiA 402 in profile velocity on one CAN bus, and
// behind them two wheels that roll without slip on level ground. World: x forward at the start, y
// left, z up. The body's origin is the middle of the axle.

#include <array>
#include <cmath>

#include "tools/lss-sim/canopen/drive.h"
#include "tools/lss-sim/canopen/node_faults.h"
#include "tools/lss-sim/canopen/vehicle.h"

namespace lss::sim {
namespace {

using namespace nodes;

constexpr double kWheelRadius_m = 0.10, kGear = 50, kTrack_m = 0.40;
constexpr double kFollow_s = 0.05;                        // of a shaft behind its reference
constexpr double kRolling = 120, kPerAcceleration = 0.3;  // per mille; per mille / (rad/s2)
constexpr double kBlocked = 1500;                         // per mille
constexpr double kStill_rad_s = 1;                        // of a motor

constexpr const char* kSides[] = {"left", "right"};
constexpr FaultArgument kWheelArgument[] = {
    {.name = "WHEEL", .meaning = "side", .min = 0, .max = 1, .whole = true, .words = kSides}};
constexpr FaultKind kOwnFaults[] = {
    {"wheel-blocked", kWheelArgument, "a wheel does not turn, its motor pulls", false, 1}};

struct Wheel {
  VelocityDrive drive;
  double motor_rad_s = 0, current_per_mille = 0;
  bool blocked = false;

  double rad_s() const { return motor_rad_s / kGear; }
  void step() {
    const double wanted_rad_s = drive.reference_rad_s();
    const double before_rad_s = motor_rad_s;
    motor_rad_s = blocked ? 0 : motor_rad_s + (wanted_rad_s - motor_rad_s) * kStep_s / kFollow_s;
    const double way = std::tanh(motor_rad_s / kStill_rad_s);
    const double load = kRolling * way + kPerAcceleration * (motor_rad_s - before_rad_s) / kStep_s;
    const double pull = blocked ? kBlocked * std::tanh(wanted_rad_s / kStill_rad_s) : load;
    current_per_mille += ((drive.on() ? pull : 0) - current_per_mille) * kStep_s / kFollow_s;
    drive.feel({.velocity_rad_s = motor_rad_s, .current_per_mille = current_per_mille});
  }
};

class Scout final : public NodeVehicle {
 public:
  explicit Scout(unsigned seed)
      : NodeVehicle("rover", seed),
        wheels_{{{.drive = VelocityDrive({.id = 1, .device_type = kServo}, seed + 1)},
                 {.drive = VelocityDrive({.id = 2, .device_type = kServo}, seed + 2)}}} {
    for (Wheel& wheel : wheels_) add(wheel.drive);
  }

 private:
  void move() override {
    for (Wheel& wheel : wheels_) wheel.step();
    const double left_m_s = wheels_[0].rad_s() * kWheelRadius_m;
    const double right_m_s = wheels_[1].rad_s() * kWheelRadius_m;
    speed_m_s_ = (left_m_s + right_m_s) / 2;
    yaw_rad_ += (right_m_s - left_m_s) / kTrack_m * kStep_s;
    x_m_ += speed_m_s_ * std::cos(yaw_rad_) * kStep_s;
    y_m_ += speed_m_s_ * std::sin(yaw_rad_) * kStep_s;
  }

  nlohmann::ordered_json state() const override {
    const auto& [left, right] = wheels_;
    const double vx_m_s = speed_m_s_ * std::cos(yaw_rad_), vy_m_s = speed_m_s_ * std::sin(yaw_rad_);
    return {
        {"position_m", {x_m_, y_m_, kWheelRadius_m}},
        {"attitude_wxyz", {std::cos(yaw_rad_ / 2), 0.0, 0.0, std::sin(yaw_rad_ / 2)}},
        {"velocity_m_s", {vx_m_s, vy_m_s, 0.0}},
        {"wheel_rad_s", {left.rad_s(), right.rad_s()}},
        {"current_per_mille", {left.current_per_mille, right.current_per_mille}},
        {"power", {text(left.drive.power()), text(right.drive.power())}},
    };
  }

  void set_own_fault(const Fault& fault, bool attach) override {
    wheels_[static_cast<std::size_t>(fault.values.front())].blocked = attach;
  }

  std::array<Wheel, 2> wheels_;  // left, right
  double x_m_ = 0, y_m_ = 0, yaw_rad_ = 0, speed_m_s_ = 0;
};

class ScoutKind final : public VehicleKind {
 public:
  std::string name() const override { return "scout"; }
  std::string summary() const override { return "a small rover: two driven wheels on a CAN bus"; }
  std::string can_address() const override { return "udp://127.0.0.1:20000"; }
  std::span<const FaultKind> fault_kinds() const override {
    static const NodeFaultKinds kinds(
        {.all = {1, 2}, .drives = {1, 2}, .signals = "1 velocity, 2 current", .last_signal = 2},
        kOwnFaults);
    return kinds.all();
  }
  void add_options(CLI::App&) override {}
  std::unique_ptr<Vehicle> make(unsigned seed) const override {
    return std::make_unique<Scout>(seed);
  }
};

}  // namespace

std::unique_ptr<VehicleKind> make_scout_kind() { return std::make_unique<ScoutKind>(); }

}  // namespace lss::sim
