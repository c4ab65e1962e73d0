// Rocks under D.I.A.N.A. Ardito, and its wheels over one of them.

#include "tools/lss-sim/ardito/rocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/ardito/sim/driver.h"

namespace lss::sim::ardito {
namespace {

constexpr double kLeft_m = dimensions::kTrack_m / 2;

std::vector<Rock> all(const Rocks& rocks) {
  std::vector<Rock> found;
  for (int column = -20; column < 20; ++column) {
    for (int row = -20; row < 20; ++row) {
      if (const auto rock = rocks.at(column, row)) found.push_back(*rock);
    }
  }
  return found;
}

TEST(Rocks, LieWhereTheSeedSaysAsManyAndAsHighAsGiven) {
  const std::vector<Rock> half = all(Rocks(0.5, 7));
  EXPECT_NEAR(static_cast<double>(half.size()) / 1600, 0.5, 0.05);
  EXPECT_TRUE(all(Rocks(0, 7)).empty());
  int high = 0;
  for (const Rock& rock : half) {
    EXPECT_GE(rock.height_m, Rocks::kLeast_m);
    EXPECT_LE(rock.height_m, Rocks::kMost_m);
    EXPECT_GE(rock.radius_m, rock.height_m * 0.999) << "no rock overhangs";
    EXPECT_GE(std::hypot(rock.x_m, rock.y_m), Rocks::kClear_m) << "none at the start";
    high += rock.height_m > 0.04 ? 1 : 0;
  }
  EXPECT_GT(high, 100);
  EXPECT_LT(high, 400) << "most are low";
  const std::vector<Rock> again = all(Rocks(0.5, 7)), other = all(Rocks(0.5, 8));
  ASSERT_EQ(again.size(), half.size());
  for (std::size_t i = 0; i < half.size(); ++i) EXPECT_EQ(again[i].x_m, half[i].x_m);
  EXPECT_NE(other[0].x_m, half[0].x_m);
}

TEST(Rocks, TheNearestPointIsOnTheSphereTowardsTheWheel) {
  const Terrain flat(Ground::flat, 1);
  const Rocks rocks(1, 3);
  const Rock rock = *rocks.at(5, 5);
  const double z_m = 0.15;
  const auto point = rocks.nearest(rock.x_m + 0.05, rock.y_m, z_m, flat);
  ASSERT_TRUE(point);
  const double centre_m = rock.height_m - rock.radius_m;
  EXPECT_NEAR(std::hypot(point->x_m - rock.x_m, point->y_m - rock.y_m, point->z_m - centre_m),
              rock.radius_m, 1e-12);
  const double far_m = std::hypot(0.05, z_m - centre_m);
  EXPECT_NEAR(point->normal[0], 0.05 / far_m, 1e-12);
  EXPECT_NEAR(point->normal[2], (z_m - centre_m) / far_m, 1e-12);
  EXPECT_FALSE(Rocks(0, 3).nearest(rock.x_m, rock.y_m, z_m, flat));
}

// With a rock of 30 to 45 mm in the way of the left wheels, 2 to 4 m ahead, no other.
struct Found {
  unsigned seed = 0;
  Rock rock{};
};
Found rock_ahead() {
  for (unsigned seed = 1; seed < 100'000; ++seed) {
    const Rocks rocks(0.1, seed);
    Found found;
    int count = 0;
    for (int column = 0; column < 7; ++column) {
      for (int row = -1; row < 1; ++row) {
        const auto rock = rocks.at(column, row);
        if (!rock) continue;
        ++count;
        found = {seed, *rock};
      }
    }
    const Rock& rock = found.rock;
    if (count == 1 && std::abs(rock.y_m - kLeft_m) < 0.01 && rock.x_m > 2 && rock.x_m < 4 &&
        rock.height_m > 0.03 && rock.height_m < 0.045)
      return found;
  }
  return {};
}

TEST(RoverOnRocks, EachLeftWheelClimbsARockInItsWayAndTheRightOnesStayLevel) {
  const Found found = rock_ahead();
  ASSERT_NE(found.seed, 0u);
  for (const char* ground : {"hard", "regolith"}) {
    SCOPED_TRACE(ground);
    RoverOptions options{.rocks = 0.1, .seed = found.seed};
    const bool soft = ground == std::string("regolith");
    if (soft) options.soil = soil::parse_soil(ground);
    Driver driver(options);
    driver.drive(0.3);
    double left_rad = 0, right_rad = 0;
    while (driver.x_m() < found.rock.x_m + 1.2) {
      driver.run(0.02);
      const Suspension s = driver.rover.suspension();
      left_rad = std::max(left_rad, std::abs(s.rho1_rad));
      right_rad = std::max(right_rad, std::abs(s.rho2_rad));
    }
    // a bogie of 0.587 m with one wheel on the rock
    const double tilt_rad = found.rock.height_m / dimensions::kRear_m;
    EXPECT_GT(left_rad, 0.7 * tilt_rad);
    EXPECT_LT(left_rad, 2 * tilt_rad);
    EXPECT_LT(right_rad, 0.5 * left_rad);
    driver.run(1);
    for (std::size_t i = 0; i < kWheels; ++i) {
      EXPECT_GT(driver.rover.loads_N()[i], 40) << i;
      if (soft) {
        EXPECT_NEAR(driver.rover.sinkage_m(i), 0.009, 0.006) << i;
      }
    }
  }
}

}  // namespace
}  // namespace lss::sim::ardito
