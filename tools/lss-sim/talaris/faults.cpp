// The faults of TALARIS: sensors, their lines, nodes, valves, fans, gas.

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <string_view>

#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::sim::talaris {
namespace {

constexpr double kNodes[] = {0x20, 0x21, 0x22};
constexpr FaultArgument kNode = {.name = "NODE",
                                 .meaning = "number on the bus",
                                 .min = 0x20,
                                 .max = 0x22,
                                 .whole = true,
                                 .hexadecimal = true,
                                 .choices = kNodes};
constexpr FaultArgument kNode1[] = {kNode};
constexpr FaultArgument kBabble[] = {kNode,
                                     {"RATE", "frames a second", 1, 10'000, false, true, 3'000}};
constexpr FaultArgument kEmcy[] = {kNode, {"CODE", "of CiA 301", 1, 0xFFFF, true, false, 0, true}};
constexpr FaultArgument kLength[] = {kNode, {"BYTES", "too many", -8, 8, true, true, -1}};
constexpr FaultArgument kAbort[] = {
    kNode, {"CODE", "abort code", 1, 0xFFFFFFFF, true, true, 0x08000000, true}};
constexpr FaultArgument kType[] = {
    kNode, {"TYPE", "that it claims", 1, 0xFFFFFFFF, true, true, 0x000F0191, true}};

constexpr FaultArgument kPackets[] = {{"PACKETS", "so many are left out", 1, 255, true, true, 5}};
constexpr FaultArgument kPacketShare[] = {{"P", "probability", 0, 1, false, true, 0.1}};
constexpr FaultArgument kByteShare[] = {{"P", "probability", 0, 1, false, true, 0.005}};
constexpr FaultArgument kScale[] = {
    {"CODE", "bits of the scale status: 0x31 rate, 0x0E force", 0, 0x3F, true, false, 0, true}};
constexpr FaultArgument kBias[] = {
    {"AXIS", "1-3 rate about x, y, z; 4-6 force along x, y, z", 1, 6, true},
    {"VALUE", "rad/s or m/s2", -100, 100}};
constexpr FaultArgument kNoise[] = {{"FACTOR", "on its noise", 0, 10'000}};

constexpr FaultArgument kError[] = {{"NUMBER", "after the E", 1, 99, true, true, 15}};
constexpr FaultArgument kOffset[] = {{"M", "metres too far", -30, 30}};

constexpr FaultArgument kCorner = {"CORNER", "1-4", 1, 4, true};
constexpr FaultArgument kCorner1[] = {kCorner};
constexpr FaultArgument kCornerOffset[] = {kCorner, {"M", "metres too far", -30, 30}};

constexpr FaultArgument kFlow[] = {{"RAD_S", "rad/s along both axes", -10, 10}};

constexpr FaultArgument kValve[] = {{"VALVE", "1-8", 1, 8, true}};
constexpr FaultArgument kFan[] = {{"FAN", "1-4", 1, 4, true}};
constexpr FaultArgument kAnyFan[] = {{"FAN", "1-4; 0: all", 0, 4, true, true, 0}};
constexpr FaultArgument kPressure[] = {
    {"SHARE", "of the regulated pressure that is left", 0, 1, false, true, 0.3}};
constexpr FaultArgument kLeak[] = {{"RATE", "thruster-seconds lost each second", 0, 100}};
constexpr FaultArgument kGas[] = {{"SECONDS", "thruster-seconds that are left", 0, 1'000}};
constexpr FaultArgument kPush[] = {
    {"N", "force on the centre of mass", 0, 1'000},
    {"DEG", "direction from +z towards +y", -360, 360, false, true, 0}};

constexpr FaultKind kFaultKinds[] = {
    {"imu-silent", {}, "the IMU says nothing"},
    {"imu-stuck", {}, "the IMU's values stand, its counter goes on"},
    {"imu-counter-jump", kPackets, "the IMU's counter jumps once", true},
    {"imu-checksum", kPacketShare, "packets of the IMU have a wrong sum"},
    {"imu-parity", kByteShare, "bytes of the IMU come with a wrong bit"},
    {"imu-scale", kScale, "the IMU changes its scales and says so"},
    {"imu-bias", kBias, "the IMU is off by so much", false, 1},
    {"imu-noise", kNoise, "the IMU is noisier"},
    {"standby-imu-silent", {}, "the second IMU says nothing"},
    {"standby-imu-stuck", {}, "the second IMU's values stand"},
    {"altimeter-silent", {}, "the altimeter says nothing"},
    {"altimeter-error", kError, "the altimeter says errors only"},
    {"altimeter-garbage", {}, "the altimeter says what is no number"},
    {"altimeter-offset", kOffset, "the altimeter is off by so much"},
    {"altimeter-range", {}, "the altimeter has no target"},
    {"altimeter-stuck", {}, "the altimeter repeats its last reading"},
    {"corner-silent", kCorner1, "an altimeter at a corner says nothing", false, 1},
    {"corner-offset", kCornerOffset, "an altimeter at a corner is off by so much", false, 1},
    {"camera-silent", {}, "the camera says nothing"},
    {"camera-blind", {}, "the camera sees nothing: dust, darkness, even ground"},
    {"camera-off", kFlow, "the camera is off by so much"},
    {"node-silent", kNode1, "a node neither sends nor receives, and continues by itself", false, 1},
    {"node-reset", kNode1, "a node restarts once", true, 1},
    {"node-babble", kBabble, "a node sends frames that nobody asked for", false, 1},
    {"emcy", kEmcy, "a node reports this error until it is cleared", false, 2},
    {"wrong-pdo-length", kLength, "a node's PDOs are too long or too short", false, 1},
    {"sdo-abort", kAbort, "a node refuses every SDO", false, 1},
    {"wrong-device-type", kType, "a node is another device", false, 1},
    {"valve-stuck-open", kValve, "a valve is open, ignores commands", false, 1},
    {"valve-stuck-shut", kValve, "a valve does not open", false, 1},
    {"fan-dead", kFan, "a fan's motor has no torque", false, 1},
    {"fan-broken", kFan, "a fan turns and gives no thrust", false, 1},
    {"esc-unarmed", kAnyFan, "speed controllers were off and on: they want their start-up", true},
    {"pressure-drop", kPressure, "the pressure regulator fails"},
    {"gas-leak", kLeak, "gas is lost"},
    {"gas", kGas, "the tanks contain this much from now on", true},
    {"push", kPush, "wind: a steady force"},
};

}  // namespace

std::span<const FaultKind> fault_kinds() { return kFaultKinds; }

void Talaris::set_fault(const Fault& fault, bool attach) {
  if (set_imu_fault(fault, attach) || set_altimeter_fault(fault, attach) ||
      set_corner_fault(fault, attach) || set_camera_fault(fault, attach))
    return;
  const std::lock_guard lock(mutex_);
  set_actuator_fault(fault, attach) || set_named_node_fault(fault, attach);
  note_waiting();
}

bool Talaris::set_imu_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  const double value = attach && !fault.values.empty() ? fault.values.back() : 0;
  if (name == "imu-counter-jump") {
    imu_->jump(static_cast<int>(value));
    return true;
  }
  if (name.starts_with("standby-imu-")) {
    if (!standby_imu_) {
      fmt::print(stderr, "lss-sim: {} does nothing: there is no second IMU, see --standby-imu\n",
                 to_text(fault));
      return true;
    }
    ImuFaults faults = standby_imu_->faults();
    (name.ends_with("silent") ? faults.silent : faults.stuck) = attach;
    standby_imu_->set_faults(faults);
    return true;
  }
  ImuFaults faults = imu_->faults();
  if (name == "imu-silent") {
    faults.silent = attach;
  } else if (name == "imu-stuck") {
    faults.stuck = attach;
  } else if (name == "imu-checksum") {
    faults.checksum = value;
  } else if (name == "imu-parity") {
    faults.parity = value;
  } else if (name == "imu-scale") {
    faults.scale = attach ? std::optional(static_cast<std::uint8_t>(value)) : std::nullopt;
  } else if (name == "imu-bias") {
    faults.bias[static_cast<std::size_t>(fault.values.front() - 1)] = value;
  } else if (name == "imu-noise") {
    faults.noise = attach ? value : 1;
  } else {
    return false;
  }
  imu_->set_faults(faults);
  return true;
}

bool Talaris::set_altimeter_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  AltimeterFaults faults = altimeter_.faults();
  if (name == "altimeter-silent") {
    faults.silent = attach;
  } else if (name == "altimeter-error") {
    faults.error = attach ? std::optional(static_cast<int>(fault.values.front())) : std::nullopt;
  } else if (name == "altimeter-garbage") {
    faults.garbage = attach;
  } else if (name == "altimeter-offset") {
    faults.offset_m = attach ? fault.values.front() : 0;
  } else if (name == "altimeter-range") {
    faults.out_of_range = attach;
  } else if (name == "altimeter-stuck") {
    faults.stuck = attach;
  } else {
    return false;
  }
  altimeter_.set_faults(faults);
  return true;
}

bool Talaris::set_corner_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  if (!name.starts_with("corner-")) return false;
  if (corners_.empty()) {
    fmt::print(stderr,
               "lss-sim: {} does nothing: there are no altimeters at the corners, see "
               "--corner-altimeters\n",
               to_text(fault));
    return true;
  }
  Altimeter& corner = *corners_[static_cast<std::size_t>(fault.values.front()) - 1];
  AltimeterFaults faults = corner.faults();
  if (name == "corner-silent") {
    faults.silent = attach;
  } else {
    faults.offset_m = attach ? fault.values.back() : 0;
  }
  corner.set_faults(faults);
  return true;
}

bool Talaris::set_camera_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  FlowCameraFaults faults = camera_.faults();
  if (name == "camera-silent") {
    faults.silent = attach;
  } else if (name == "camera-blind") {
    faults.blind = attach;
  } else if (name == "camera-off") {
    faults.off_rad_s = attach ? fault.values.front() : 0;
  } else {
    return false;
  }
  camera_.set_faults(faults);
  return true;
}

bool Talaris::set_actuator_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  const double first = fault.values.empty() ? 0 : fault.values.front();
  const auto unit = static_cast<std::size_t>(first) - 1;
  if (name == "valve-stuck-open") {
    gas_.stuck_open[unit] = attach;
  } else if (name == "valve-stuck-shut") {
    gas_.stuck_shut[unit] = attach;
  } else if (name == "fan-dead") {
    fans_.dead[unit] = attach;
  } else if (name == "fan-broken") {
    fans_.broken[unit] = attach;
  } else if (name == "esc-unarmed") {
    for (std::size_t i = 0; i < kFans; ++i) {
      if (first == 0 || i == unit) fans_.unarm(i);
    }
  } else if (name == "pressure-drop") {
    gas_.regulator = attach ? first : 1;
  } else if (name == "gas-leak") {
    gas_.leak_s_per_s = attach ? first : 0;
  } else if (name == "gas") {
    gas_.set_left_s(std::min(first, options_.gas.budget_s));
  } else if (name == "push") {
    const double angle = fault.values.back() * kDegree;
    push_N_ = (attach ? first : 0) * Vector3(0, std::sin(angle), std::cos(angle));
  } else {
    return false;
  }
  return true;
}

bool Talaris::set_named_node_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  Node* found = node(static_cast<std::uint8_t>(fault.values.front()));
  if (found == nullptr) {
    fmt::print(stderr, "lss-sim: {} does nothing: there is no such node on this stand\n",
               to_text(fault));
  } else if (name == "node-reset") {
    found->power_on();
  } else if (name == "node-babble") {
    found->faults.babble_1_s = attach ? fault.values[1] : 0;
  } else {
    return set_node_fault(fault, attach);
  }
  return true;
}

}  // namespace lss::sim::talaris
