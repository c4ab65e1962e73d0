#pragma once

// Orders of the frame thread to the actuators of TALARIS. Value-initialised it is the safe command:
// everything shut, fans off. The actuate thread executes the valves' part (valves.h), the bus
// thread all others (hopper_bus.h).

#include <array>
#include <cstdint>

#include "drivers/talaris/samples.h"
#include "drivers/time.h"

namespace lss::talaris {

inline constexpr std::uint16_t kFanOff_us = 1000, kFanFull_us = 2000;  // pulse width

// Opens `delay_ns` after the release and stays open for `on_ns`; on_ns 0: shut.
struct ValvePulse {
  TimeNs delay_ns = 0;
  TimeNs on_ns = 0;
  bool operator==(const ValvePulse&) const = default;
};

// By hand: open until a time, regardless of the pulses.
struct ValveHold {
  bool open = false;
  TimeNs until_ns = 0;
  bool operator==(const ValveHold&) const = default;
};

struct TalarisOrders {
  TimeNs issued_ns = 0;    // when the frame computed them, to check freshness; 0: never
  TimeNs boundary_ns = 0;  // T_k
  TimeNs release_ns = 0;   // T_k + offset: the pulses count from here
  // Everything shut and off, overrides the orders below. Also the frame's answer to an all-stop
  // that the actuate thread obeyed before the frame knew of it.
  bool all_stop = false;
  std::uint8_t enabled = 0;  // bit i: valve i + 1 may open at all
  std::array<ValvePulse, kHopperValves> pulse{};
  std::array<ValveHold, kHopperValves> hold{};
  std::array<std::uint16_t, kHopperFans> fan_us = {kFanOff_us, kFanOff_us, kFanOff_us, kFanOff_us};
  // nodes that were lost, rebooted or failed may be reset, configured and started
  bool boot_allowed = false;
  std::uint32_t node_reset_serial = 0;  // a new number: `reset_nodes` are booted again
  std::uint8_t reset_nodes = 0;         // bit i: node i in the order of samples.h
  bool operator==(const TalarisOrders&) const = default;
};

}  // namespace lss::talaris
