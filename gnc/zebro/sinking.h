#pragma once

// Whether the belly lies in the soil, by the currents of the motors while the legs fly. A leg meets
// soil earlier on its way down, or leaves it later on its way up, the deeper the robot has sunk;
// how its current grows on that way follows from the depth alone, not from gravity or the soil's
// strength. A robot that walks on its legs tilts, so that some of them are always higher: only
// on its belly are all of them deep, and all of a side only where the belly's edge lies in the soil
// there. Frame thread; nothing allocates; no clock.

#include <array>
#include <cstdint>

#include "gnc/zebro/gait.h"

namespace lss::gnc::zebro {

class Sinking {
 public:
  struct Leg {
    double theta_rad = 0;
    double current_A = 0;
    bool known = false;  // theta is
    bool flies = false;
  };

  // `belly_rad`: lowered_rad() of the belly's height.
  explicit Sinking(double belly_rad) noexcept : belly_rad_(belly_rad) {}
  void reset() noexcept { *this = Sinking(belly_rad_); }

  // Once per frame. True when all legs have ended another flight: shares() are new.
  bool update(const PerLeg<Leg>& legs) noexcept;

  // Current with the hip where the belly would touch the ground, as a share of that further down;
  // each above that of the same leg in the air. Left and right, the smallest of a side's three
  // legs; 0: no soil, negative: not felt yet.
  const std::array<double, 2>& shares() const noexcept { return shares_; }

 private:
  struct Mean {
    double sum = 0;
    std::int64_t count = 0;
    void add(double value) noexcept;
    double value() const noexcept { return sum / static_cast<double>(count); }
  };
  struct Flight {
    Mean low, high, air;
    bool whole() const noexcept;
    double share() const noexcept;
  };

  double belly_rad_;
  PerLeg<Flight> under_way_{};
  PerLeg<double> of_leg_{};
  PerLeg<std::int64_t> ended_{};  // whole flights since the last time that shares() were new
  std::array<double, 2> shares_{-1, -1};
};

}  // namespace lss::gnc::zebro
