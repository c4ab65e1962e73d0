#pragma once

// What the master of D.I.A.N.A. Ardito knows of its four kinds of nodes: device type, objects that
// it writes, and the object, size and unit of each signal. Made from device descriptions
// (drivers/canopen/description.h) at start-up; plain data from then on.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/canopen/description.h"
#include "drivers/canopen/sdo.h"

namespace lss::ardito {

// Signals of each kind, by their names in the description's section [LssSignals], and the units
// that the master counts in.
enum class WheelSignal : std::uint8_t {
  controlword,
  target_velocity,  // rpm of the motor
  statusword,
  velocity,        // rpm of the motor
  current,         // per mille of the rated one
  hall_velocity,   // rpm of the motor
  wheel_velocity,  // rpm of the wheel
  temperature,     // degC
  link_voltage,    // V; may be missing
  acceleration,    // rpm/s of the motor
  deceleration,
  quick_stop_deceleration,
};
enum class SteeringSignal : std::uint8_t {
  controlword,
  target_position,  // rad of the motor
  statusword,
  position,          // rad of the motor
  current,           // per mille of the rated one
  wheel_position,    // rad of the wheel
  profile_velocity,  // rad/s of the motor
  acceleration,      // rad/s2
  deceleration,
  quick_stop_deceleration,
};
enum class IoSignal : std::uint8_t { outputs, inputs, beta, rho1, rho2 };     // bits; rad
enum class ImuSignal : std::uint8_t { speed, direction, yaw_rate, counter };  // mm/s, rad, rad/s

inline constexpr std::size_t kMostSignals = 12, kMostWritten = 8;

// The object of a signal; bytes 0: the node has none.
struct Field {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 0;
  bool is_signed = false;
  double unit = 1;  // of one count

  // As mapped into a PDO.
  constexpr std::uint32_t mapping() const {
    return bytes == 0
               ? 0
               : std::uint32_t{index} << 16 | std::uint32_t{sub} << 8 | std::uint32_t{bytes} * 8;
  }
};

struct Profile {
  std::uint32_t device_type = 0;
  std::array<canopen::Entry, kMostWritten> entries{};  // size 0: end
  std::array<Field, kMostSignals> field{};

  template <class Signal>
  constexpr const Field& of(Signal signal) const {
    return field[static_cast<std::size_t>(signal)];
  }
};

enum class Kind : std::uint8_t { wheel, steering, io, imu };
inline constexpr std::size_t kKinds = 4;
inline constexpr const char* kKindNames[kKinds] = {"wheel", "steering", "io", "imu"};
using Profiles = std::array<Profile, kKinds>;

// Sentences go to `errors`; without any the profile can be used. An object of the communication
// profile (0x1000 to 0x1FFF) that the description writes is optional: a node without it is as good.
Profile make_profile(Kind kind, const canopen::Description& description,
                     std::vector<std::string>& errors);
// Of the text of a description.
Profile make_profile(Kind kind, std::string_view text, std::vector<std::string>& errors);

// Of the descriptions shipped in config/devices, which are part of the program.
const Profiles& default_profiles();

}  // namespace lss::ardito
