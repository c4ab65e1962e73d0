#pragma once

// The interface of a simulated vehicle to lss-sim: serial lines and CAN buses with devices on them,
// physics in steps of one millisecond, faults, and the truth. Threads: step() and truth() from the
// physics thread, a line's or bus's device from that line's or bus's thread, faults from any; the
// vehicle locks the shared data.

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "drivers/time.h"
#include "tools/lss-sim/frame/can_bus.h"
#include "tools/lss-sim/frame/faults.h"
#include "tools/lss-sim/frame/uart.h"

namespace lss::sim {

inline constexpr TimeNs kStepNs = kMillisecond;

struct SerialLine {
  std::string name;  // of the link in DIR
  LineDevice* device = nullptr;
  int baud = 0;                                      // 0: the program's option
  int bits = 10;                                     // of a character
  std::uint8_t frame_begin = ':', frame_end = '\n';  // of messages from the master
};

struct CanLine {
  std::string name;  // for people
  CanDevice* device = nullptr;
};

class Vehicle {
 public:
  virtual ~Vehicle() = default;
  virtual std::vector<SerialLine> lines() { return {}; }
  virtual std::vector<CanLine> can_buses() { return {}; }
  virtual void step() = 0;  // kStepNs of simulated time; wakes the buses' threads after it
  // position_m, attitude_wxyz, velocity_m_s and the vehicle's own.
  virtual nlohmann::ordered_json truth() const = 0;
  // One of the vehicle's own fault types: attach or clear it.
  virtual void set_fault(const Fault& fault, bool attach) = 0;
  // False when an attached fault of its own has ended by itself.
  virtual bool in_force(const Fault& fault) const = 0;
};

// The entry of a vehicle in lss-sim's roster.
class VehicleKind {
 public:
  virtual ~VehicleKind() = default;
  virtual std::string name() const = 0;
  virtual std::string summary() const = 0;
  virtual std::span<const FaultKind> fault_kinds() const = 0;
  // The default place of its CAN bus; empty for a vehicle on serial lines.
  virtual std::string can_address() const { return {}; }
  virtual bool has_lines() const { return can_address().empty(); }
  virtual void add_options(CLI::App& command) = 0;
  virtual std::unique_ptr<Vehicle> make(unsigned seed) const = 0;

 protected:
  // An option within a range; help shows its default.
  template <class T>
  static void number_option(CLI::App& command, const std::string& name, T& value,
                            const std::string& help, std::type_identity_t<T> least,
                            std::type_identity_t<T> most) {
    command.add_option(name, value, help)->check(CLI::Range(least, most))->capture_default_str();
  }
};

// Every vehicle in the build, by its make_NAME_kind().
std::vector<std::unique_ptr<VehicleKind>> all_vehicles();

}  // namespace lss::sim
