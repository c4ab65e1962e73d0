#pragma once

// Navigation that is calibrated, on a flight whose truth is known.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gnc/talaris/navigation.h"
#include "tests/talaris/gnc/flown.h"

namespace lss::gnc::talaris::test {

inline double degrees(double rad) { return rad / kDegree; }

// Calibrated, and in the air when `flying`.
struct Fixture {
  explicit Fixture(const NavigationParameters& p = {}, bool flying = true, unsigned seed = 1)
      : flown(p, seed), navigation(p) {
    EXPECT_TRUE(flown.calibrate(navigation)) << describe(navigation.calibration().fault);
    flown.flying = flying;
  }
  const NavState& run(int frames) {
    for (int i = 0; i < frames; ++i) navigation.step(flown.frame());
    return navigation.state();
  }
  double height_error() const { return navigation.state().position_N_m.x() - flown.truth.p.x(); }
  double tilt_error() const {
    const Vector3 ours = navigation.state().q_NB * Vector3::UnitX();
    return degrees(std::acos(std::min(1.0, ours.dot(flown.truth.q * Vector3::UnitX()))));
  }

  Flown flown;
  Navigation navigation;
};

}  // namespace lss::gnc::talaris::test
