#pragma once

// Remaining gas, by the commanded pulses and by the tank pressure. Thruster-seconds: one thruster
// open for one second (TALARIS thesis 2.3.3).

#include <array>

#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

class GasBudget {
 public:
  explicit GasBudget(const Gas& gas = {}) noexcept : gas_(gas) {}

  // The pulses of one frame.
  void count(const std::array<Pulse, kValves>& pulses) noexcept;
  void count(const std::array<double, kValves>& open_s) noexcept;
  // Filtered tank pressure, kPa; not a number: no sensor. The gas is taken as ideal and at constant
  // temperature, so the remaining gas is proportional to the pressure above empty.
  void pressure(double tank_kPa) noexcept;
  void refuel() noexcept { used_s_ = 0; }

  double used_s() const noexcept { return used_s_; }
  double left_s() const noexcept;                      // the lower of both; never below 0
  double mass_kg(double full_mass_kg) const noexcept;  // of the vehicle now, by the pulses

 private:
  Gas gas_;
  double used_s_ = 0;
  double used_by_pressure_s_ = kNaN;  // no sensor
};

}  // namespace lss::gnc::talaris
