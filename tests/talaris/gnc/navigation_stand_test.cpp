// Navigation at standstill or on a stand: at a wall, on test stands, on the ground.

#include <tuple>

#include "tests/talaris/gnc/navigation_fixture.h"

namespace lss::gnc::talaris::test {
namespace {

TEST(Navigation, PointsSidewaysAtAWall) {
  NavigationParameters p;
  p.pointing = Pointing::sideways;
  p.height_m = 0.7;
  p.roll_rad = 45 * kDegree;  // sled: 45 deg away from the wall
  p.altimeter_at_B_m = {0, 0.1, 0.3};
  Fixture f(p, true, 2);
  f.run(100);
  EXPECT_GT(f.navigation.counters().ranges_used, 150u);
  EXPECT_LT(std::abs(f.navigation.state().position_N_m.z() - f.flown.truth.p.z()), 0.04);
  EXPECT_LT(f.navigation.state().position_sigma_m.z(), 0.02);
  EXPECT_GT(f.navigation.state().position_sigma_m.x(), 0.08);
}

// The sled cannot leave the floor nor tilt: with this constraint the axes without altimeter are
// known, too.
TEST(Navigation, AStandBoundsTheErrorsOfTheAxesThatItFixes) {
  NavigationParameters p;
  p.pointing = Pointing::sideways;
  p.height_m = 1.2;
  p.stand.fixed_x = true;
  p.stand.rotation = FreeRotation::x;
  Fixture f(p, false, 4);
  f.run(300);
  const NavState& s = f.navigation.state();
  EXPECT_NEAR(s.position_N_m.x(), 1.2, 0.03);
  EXPECT_LT(s.position_sigma_m.x(), 0.02);
  EXPECT_LT(degrees(s.attitude_sigma_rad.tail<2>().maxCoeff()), 0.15);
  EXPECT_GT(s.position_sigma_m.y(), 0.3);
  p.stand = {};
  Fixture free(p, false, 4);
  free.run(300);
  EXPECT_GT(free.navigation.state().position_sigma_m.x(), 1);
  EXPECT_GT(degrees(free.navigation.state().attitude_sigma_rad.tail<2>().maxCoeff()), 0.2);
}

// Turned by 90 deg about its free axis, the axes that a stand blocks are still constrained, the
// turn is not.
TEST(Navigation, AStandLeavesItsFreeAxisAlone) {
  for (const FreeRotation axis : {FreeRotation::x, FreeRotation::y, FreeRotation::z}) {
    NavigationParameters p;
    p.altimeter = false;
    p.force_bias_sigma_m_s2 = 1e-6;
    p.stand.rotation = axis;
    Fixture f(p, false, 5);
    const int i = static_cast<int>(axis) - static_cast<int>(FreeRotation::x);
    const Quaternion start = f.navigation.state().q_NB;
    const Vector3 bias = f.navigation.state().gyro_bias_rad_s;
    std::int64_t t = f.flown.now_ns;
    for (int frame = 0; frame < 10; ++frame) {
      ImuSample samples[40];
      for (ImuSample& s : samples) {
        t += 5'000'000;
        // about an axis of N, as the stand does
        s = {t,
             bias + start.conjugate() * Vector3(Vector3::Unit(i) * (1.5707963267948966 / 2)),
             {9.8, 0, 0}};
      }
      f.navigation.step({samples, {}, t});
    }
    const Quaternion turned = f.navigation.state().q_NB * start.conjugate();
    const Vector3 along = turned * Vector3::Unit(i);
    EXPECT_NEAR(degrees(turned.angularDistance(Quaternion::Identity())), 90, 0.2);
    EXPECT_LT(degrees(std::acos(std::min(1.0, along(i)))), 0.1);
    // pushed off the axis by 2 deg in one frame, it is brought back in the next ones
    Vector3 off = Vector3::Unit((i + 1) % 3) * (2 * kDegree / 0.2);
    for (int frame = 0; frame < 100; ++frame) {
      ImuSample samples[40];
      for (ImuSample& s : samples) {
        t += 5'000'000;
        s = {t, bias + f.navigation.state().q_NB.conjugate() * off, {9.8, 0, 0}};
      }
      f.navigation.step({samples, {}, t});
      off.setZero();
    }
    const Vector3 after = (f.navigation.state().q_NB * start.conjugate()) * Vector3::Unit(i);
    EXPECT_LT(degrees(std::acos(std::min(1.0, after(i)))), 1.9);
  }
}

TEST(Navigation, StandingDoesNotDrift) {
  Fixture f({}, false), left({}, false);
  for (int i = 0; i < 600; ++i) {
    f.navigation.step(f.flown.frame(), true);
    left.run(1);
  }
  EXPECT_LT((f.navigation.state().position_N_m - f.flown.truth.p).norm(), 0.1);
  EXPECT_LT(f.navigation.state().velocity_N_m_s.norm(), 0.02);
  EXPECT_LT(f.tilt_error(), 0.4);
  EXPECT_GT(left.navigation.state().position_sigma_m.z(), 10);
  // all three biases of the gyroscopes are followed
  const auto bias_error = [](const Fixture& of) {
    return degrees((of.navigation.state().gyro_bias_rad_s - of.flown.truth.bg).norm());
  };
  EXPECT_LT(bias_error(f), 0.01);
  EXPECT_GT(bias_error(left), 0.01);
}

// While the fans take its weight it may slide, but does not turn: neither noise nor what is left of
// the gyroscopes' bias may turn it, or it flies with that tilt. The accelerometers' bias looks like
// tilt, and remains.
TEST(Navigation, LightOnItsLegsItDoesNotTurn) {
  constexpr int kFlights = 30;
  double squares = 0, predicted = 0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    Fixture f({}, false, seed);
    for (int i = 0; i < 10; ++i) f.navigation.step(f.flown.frame(), true);
    for (int i = 0; i < 25; ++i) f.navigation.step(f.flown.frame(), true, true);
    const auto e = f.flown.error(f.navigation);
    const Matrix15 c = f.navigation.filter().covariance();
    const double g = f.flown.parameters.gravity_m_s2;
    for (const auto& [turn, bias, sign] : {std::tuple(7, 11, 1.0), std::tuple(8, 10, -1.0)}) {
      const double tilt = e(turn) + sign * e(bias) / g;
      squares += tilt * tilt;
      predicted += c(turn, turn) + c(bias, bias) / (g * g) + 2 * sign * c(turn, bias) / g;
    }
  }
  EXPECT_LT(degrees(std::sqrt(squares / (2 * kFlights))), 0.006);
  EXPECT_LT(squares, 1.5 * predicted);
}

}  // namespace
}  // namespace lss::gnc::talaris::test
