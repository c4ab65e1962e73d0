#pragma once

// The interface of a simulated vehicle to lss-sim: serial lines and CAN buses with devices on them,
// physics in steps of one millisecond, faults, and the true motion. Threads: the physics thread
// calls step() and truth(), the thread of a line or bus calls its device, and any thread calls the
// functions for faults. The vehicle locks data that threads share.

#include <CLI/CLI.hpp>
#include <map>
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
  std::string name;  // of the link in the folder --dir
  LineDevice* device = nullptr;
  int baud = 0;                                      // 0: that of the program's option
  int bits = 10;                                     // of a character on the line
  std::uint8_t frame_begin = ':', frame_end = '\n';  // of messages from the master
};

struct CanLine {
  std::string name;  // for messages
  CanDevice* device = nullptr;
};

class Vehicle {
 public:
  virtual ~Vehicle() = default;
  virtual std::vector<SerialLine> lines() { return {}; }
  virtual std::vector<CanLine> can_buses() { return {}; }
  virtual void step() = 0;  // simulates kStepNs, then wakes the threads of the buses
  // position_m, attitude_wxyz, velocity_m_s, and fields of this vehicle.
  virtual nlohmann::ordered_json truth() const = 0;
  // Attaches or clears a fault of a type that only this vehicle has.
  virtual void set_fault(const Fault& fault, bool attach) = 0;
  // False when an attached fault of its own has ended by itself.
  virtual bool in_force(const Fault&) const { return true; }
};

// The entry of a vehicle in lss-sim's roster.
class VehicleKind {
 public:
  virtual ~VehicleKind() = default;
  virtual std::string name() const = 0;
  virtual std::string summary() const = 0;
  virtual std::span<const FaultKind> fault_kinds() const = 0;
  // Default address of the CAN bus; empty for a vehicle on serial lines.
  virtual std::string can_address() const { return {}; }
  virtual bool has_lines() const { return can_address().empty(); }
  virtual void add_options(CLI::App& command) = 0;
  virtual std::unique_ptr<Vehicle> make(unsigned seed) const = 0;

 protected:
  // Adds an option with a range; --help shows its default.
  template <class T>
  static void number_option(CLI::App& command, const std::string& name, T& value,
                            const std::string& help, std::type_identity_t<T> least,
                            std::type_identity_t<T> most) {
    command.add_option(name, value, help)->check(CLI::Range(least, most))->capture_default_str();
  }
  // Adds an option with named values; an error lists the names.
  template <class T>
  static void choice_option(CLI::App& command, const std::string& name, T& value,
                            const std::string& help, const std::map<std::string, T>& choices,
                            const char* fallback) {
    command.add_option(name, value, help)
        ->transform(CLI::CheckedTransformer(choices).description(""))
        ->transform(CLI::IsMember(choices).description(""))  // the last one comes first
        ->default_str(fallback);
  }
  static void gravity_option(CLI::App& command, double& value, const char* where) {
    const std::map<std::string, double> gravities = {
        {"moon", 1.625}, {"mars", 3.72}, {"earth", 9.81}};
    command.add_option("--gravity", value, "moon, mars, earth, or m/s2")
        ->transform((CLI::CheckedTransformer(gravities) | CLI::Range(0.1, 30.0)).description(""))
        ->default_str(where);
  }
};

// All vehicles of this build, made by their make_NAME_kind().
std::vector<std::unique_ptr<VehicleKind>> all_vehicles();

}  // namespace lss::sim
