#include "gnc/talaris/gas.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {

void GasBudget::count(const std::array<Pulse, kValves>& pulses) noexcept {
  for (const Pulse& pulse : pulses) used_s_ += pulse.on_s;
}

void GasBudget::count(const std::array<double, kValves>& open_s) noexcept {
  for (const double s : open_s) {
    if (s > 0 && s <= kFrame_s) used_s_ += s;
  }
}

void GasBudget::pressure(double tank_kPa) noexcept {
  if (!std::isfinite(tank_kPa)) {
    used_by_pressure_s_ = kNaN;
    return;
  }
  const double share = (tank_kPa - gas_.empty_kPa) / (gas_.full_kPa - gas_.empty_kPa);
  used_by_pressure_s_ = gas_.budget_s * (1 - std::clamp(share, 0.0, 1.0));
}

double GasBudget::left_s() const noexcept {
  const double used =
      std::isfinite(used_by_pressure_s_) ? std::max(used_s_, used_by_pressure_s_) : used_s_;
  return std::max(gas_.budget_s - used, 0.0);
}

double GasBudget::mass_kg(double full_mass_kg) const noexcept {
  return full_mass_kg - gas_.mass_kg * std::min(used_s_ / gas_.budget_s, 1.0);
}

}  // namespace lss::gnc::talaris
