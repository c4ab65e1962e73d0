// The faults of D.I.A.N.A. Ardito: the failures of the Ardito thesis' sections 17 and 19 under its
// names, and those of nodes, bus, supply and sensors in its FMEA (its part IV).

#include <algorithm>
#include <string_view>

#include "idl/angles.h"
#include "tools/lss-sim/ardito/vehicle.h"
#include "tools/lss-sim/canopen/node_faults.h"

namespace lss::sim::ardito {
namespace {

constexpr double kSteeredNumbers[] = {1, 2, 5, 6};

constexpr FaultArgument mode_of(const char* meaning, double most) {
  return {"MODE", meaning, 0, most, true, true, 0};
}

constexpr FaultArgument kWheel = {"WHEEL", "1-6: LF RF LM RM LR RR", 1, 6, true};
constexpr FaultArgument kSteeredWheel = {
    "WHEEL", "steered wheel: LF RF LR RR", 1, 6, true, false, 0, false, kSteeredNumbers};
constexpr FaultArgument kMotorRpm[] = {
    kWheel, {"RPM", "of the motor, that it gives", -5000, 5000, false, true, 0}};
constexpr FaultArgument kWheelRpm[] = {
    kWheel, {"RPM", "of the wheel, that it gives", -100, 100, false, true, 0}};
constexpr FaultArgument kMotor[] = {kWheel, mode_of("0 stuck, 1 without torque but free", 1)};
constexpr FaultArgument kGearOf[] = {kWheel, mode_of("0 jammed, 1 lost its coupling", 1)};
constexpr FaultArgument kClutch[] = {kWheel, mode_of("0 does not close, 1 does not open", 1)};
constexpr FaultArgument kSteered1[] = {kSteeredWheel};
constexpr FaultArgument kSteeringGear[] = {kSteeredWheel,
                                           mode_of("0 jammed, 1 lost its coupling", 1)};
constexpr FaultArgument kHot[] = {kWheel, {"DEGC", "of the motor", -100, 200}};

constexpr FaultArgument kImuJump[] = {
    {"MM_S", "by which its speed is wrong", -10'000, 10'000, false, true, 800}};
constexpr FaultArgument kRocker[] = {{"SENSOR", "1 beta, 2 rho1, 3 rho2", 1, 3, true},
                                     {"RAD", "that it gives", -3.2, 3.2, false, true, 0.8}};

constexpr double kDriveNodes[] = {1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16};
constexpr FaultArgument kDrive[] = {
    {"NODE", "number on the bus", 1, 0x16, true, false, 0, true, kDriveNodes}};
constexpr double kNodes[] = {1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16, IoNode::kId, ImuNode::kId};
constexpr FaultArgument kLacks[] = {
    {"NODE", "number on the bus", 1, 0x21, true, false, 0, true, kNodes},
    {"INDEX", "of the object", 0x1000, 0x9FFF, true, false, 0, true}};
constexpr FaultArgument kBent[] = {
    kSteeredWheel, {"DEG", "to the left, that no encoder shows", -30, 30, false, true, 10}};

constexpr FaultKind kMechanics[] = {
    {"H-TM", kMotorRpm, "Hall sensors of a traction motor: dead, or give a constant", false, 1},
    {"E-TM", kMotorRpm, "encoder of a traction motor: dead, or gives a constant", false, 1},
    {"E-TRG", kWheelRpm, "encoder of a traction gear: dead, or gives a constant", false, 1},
    {"TM", kMotor, "traction motor", false, 1},
    {"TRG", kGearOf, "traction reduction gear", false, 1},
    {"TC", kClutch, "traction clutch", false, 1},
    {"SM", kSteered1, "steering motor: no torque, the gear locks", false, 1},
    {"SRG", kSteeringGear, "steering reduction gear", false, 1},
    {"E-SM", kSteered1, "encoder of a steering motor stays where it is", false, 1},
    {"E-SRG", kSteered1, "encoder of a steering gear stays where it is", false, 1},
    {"motor-hot", kHot, "a traction motor has this temperature", false, 1},
    {"bracket-bent", kBent, "a wheel stands at an angle to its steering shaft", false, 1},
};

constexpr FaultKind kDevices[] = {
    {"rocker-encoder", kRocker, "an encoder of the suspension gives a constant", false, 1},
    {"imu-silent", {}, "the IMU neither sends nor receives"},
    {"imu-stuck", {}, "the IMU's values and counter stand, its node goes on"},
    {"imu-jump", kImuJump, "the IMU's speed is wrong"},
    {"e-stop-button", {}, "the emergency-stop button is pressed"},
    {"power-bad", {}, "the motors' battery is gone"},
    {"drive-drop", kDrive, "a drive leaves operation enabled once, without a fault", true, 1},
    {"no-object", kLacks, "a node does not have this object", false, 2},
};

constexpr const char* kSignals =
    "wheel: 1 motor encoder, 2 Hall, 3 reduction encoder, 4 current, 5 temperature, 6 link "
    "voltage; steering: 1 motor encoder, 2 reduction encoder, 3 current; I/O: 1 beta, 2 rho1, 3 "
    "rho2; IMU: 1 speed, 2 direction, 3 yaw rate";

}  // namespace

std::span<const FaultKind> fault_kinds() {
  static const NodeFaultKinds kinds(
      {.all = {1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16, IoNode::kId, ImuNode::kId},
       .drives = {1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16},
       .signals = kSignals,
       .last_signal = 6},
      kMechanics, kDevices);
  return kinds.all();
}

void Ardito::set_fault(const Fault& fault, bool attach) {
  const std::lock_guard lock(mutex_);
  const std::string_view name = fault.kind->name;
  if (name == "e-stop-button") {
    button_ = attach;
  } else if (name == "power-bad") {
    power_bad_ = attach;
  } else if (name == "drive-drop") {
    drive(fault.values.front()).drop();
  } else if (name == "no-object") {
    node(static_cast<std::uint8_t>(fault.values.front()))->faults.no_object =
        attach ? static_cast<std::uint16_t>(fault.values[1]) : std::uint16_t{0};
  } else if (name == "bracket-bent") {
    const auto wheel = static_cast<std::size_t>(fault.values[0] - 1);
    bent_rad_[wheel < 2 ? wheel : wheel - 2] = attach ? fault.values[1] * kDegree : 0;
  } else {
    set_train_fault(fault, attach) || set_steering_fault(fault, attach) ||
        set_sensor_fault(fault, attach) || set_node_fault(fault, attach);
  }
  note_waiting();
}

Drive& Ardito::drive(double number) {
  for (const auto& each : wheels_) {
    if (each->id() == number) return *each;
  }
  return **std::ranges::find_if(steering_, [&](const auto& each) { return each->id() == number; });
}

bool Ardito::set_train_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  if (fault.values.size() < 2) return false;
  const auto wheel = static_cast<std::size_t>(fault.values[0] - 1);
  const double second = fault.values[1];
  if (name == "TM") {
    trains_[wheel].motor_fault = !attach       ? MotorFault::none
                                 : second == 0 ? MotorFault::blocked
                                               : MotorFault::open;
  } else if (name == "TRG") {
    trains_[wheel].gear_fault = !attach       ? GearFault::none
                                : second == 0 ? GearFault::jammed
                                              : GearFault::loose;
  } else if (name == "TC") {
    trains_[wheel].clutch_fault = !attach       ? ClutchFault::none
                                  : second == 0 ? ClutchFault::open
                                                : ClutchFault::closed;
  } else if (name == "motor-hot") {
    held_degC_[wheel] = attach ? std::optional(second) : std::nullopt;
  } else if (name == "H-TM" || name == "E-TM" || name == "E-TRG") {
    const int number = name == "E-TM" ? 1 : name == "H-TM" ? 2 : 3;
    const double units = name == "E-TRG" ? second * 100 : second;
    wheels_[wheel]->signal(number)->hold(attach ? std::optional(units) : std::nullopt);
  } else {
    return false;
  }
  return true;
}

bool Ardito::set_steering_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  if (name != "SM" && name != "SRG" && name != "E-SM" && name != "E-SRG") return false;
  const auto wheel = static_cast<std::size_t>(fault.values[0] - 1);
  const std::size_t i = wheel < 2 ? wheel : wheel - 2;  // wheels 1, 2, 5, 6
  if (name == "SM") {
    steering_trains_[i].motor_fault = attach ? MotorFault::blocked : MotorFault::none;
  } else if (name == "SRG") {
    steering_trains_[i].gear_fault = !attach                ? GearFault::none
                                     : fault.values[1] == 0 ? GearFault::jammed
                                                            : GearFault::loose;
  } else {
    steering_[i]->signal(name == "E-SM" ? 1 : 2)->stick(attach);
  }
  return true;
}

bool Ardito::set_sensor_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  if (name == "imu-silent") {
    imu_.faults.silent = attach;
  } else if (name == "imu-stuck") {
    imu_.set_stuck(attach);
  } else if (name == "imu-jump") {
    imu_.signal(1)->jump(attach ? fault.values.front() : 0);
  } else if (name == "rocker-encoder") {
    const double units = fault.values[1] * 1e4;
    io_.signal(static_cast<int>(fault.values[0]))
        ->hold(attach ? std::optional(units) : std::nullopt);
  } else {
    return false;
  }
  return true;
}

}  // namespace lss::sim::ardito
