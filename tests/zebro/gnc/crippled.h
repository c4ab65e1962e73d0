#pragma once

// A robot with legs out of service, for tests.

#include <gtest/gtest.h>

#include "gnc/zebro/stability.h"
#include "tests/zebro/gnc/fewer_legs.h"

namespace lss::gnc::zebro::test {

inline constexpr double kRest_rad = 105.7 * kDegree;
inline constexpr LegSet kLF = 0b000001, kMiddle = 0b001100;

// A robot whose isolated legs are dead, with checks of forbidden conditions.
struct Crippled : Robot {
  explicit Crippled(LegSet without, double hangs_rad = kRest_rad) : isolated(without) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (!contains(isolated, i)) continue;
      legs[i].theta_rad = hangs_rad;
      legs[i].stuck_until_s = 1e9;
      legs[i].calibrated = legs[i].answers = false;
    }
    EXPECT_TRUE(locomotion.isolate(isolated));
    on_order = [this](std::size_t i, const LegTarget&, double) {
      ordered |= contains(isolated, i);
    };
  }

  bool dead(std::size_t i) const { return contains(isolated, i); }

  void put_legs_at(double theta_rad) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (!dead(i)) legs[i].theta_rad = theta_rad;
    }
  }

  // Of the feet that are down, by the true angles.
  double margin_m() const {
    PerLeg<bool> down{};
    PerLeg<double> theta{};
    for (std::size_t i = 0; i < kLegs; ++i) {
      down[i] = !dead(i) && !locomotion.targets()[i].swing;
      theta[i] = theta_rad(i);
    }
    return static_margin_m(down, theta, parameters.leg_diameter_m);
  }

  void expect_legs_at(double theta_wanted_rad) const {
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (dead(i)) continue;
      EXPECT_NEAR(wrap_rad(theta_rad(i) - theta_wanted_rad), 0, 0.06) << i;
    }
  }

  LegSet isolated;
  bool ordered = false;  // a leg out of service was asked to move
};

}  // namespace lss::gnc::zebro::test
