// The scout passes the safety suite of every vehicle, and reckons where it drives.

#include "tests/safety/drive_world.h"
#include "tests/safety/safety_suite.h"
#include "vehicle.h"

namespace lss::scout {
namespace {

struct World : safety::DriveWorld<World, Vehicle, Mode> {
  explicit World(const Parameters& p = {}, const Supervisor::Parameters& links = {})
      : DriveWorld(p, scout::logic(), links, kDrives) {}
};

struct ScoutSafety : safety::DriveTraits<World, kDrives>,
                     safety::Shipped<read_parameters, logic, tuning> {
  static constexpr double kRest_s = 3;
  static constexpr safety::Motion kMotion{kDriveCommand, {0.3, 0.2}};
  static constexpr std::array<std::uint16_t, kDrives> kResettable = {1, 2};

  static bool ready(World& w) {
    w.run(0.5);
    w.send(kStartCommand);
    return w.run_until(Mode::ready, 5);
  }
  static bool moves(const World& w) { return w.mode() == Mode::driving && w.rpm[1] != 0; }
};

TEST(Scout, ReckonsTheArcThatItDrives) {
  World w(ScoutSafety::parameters());
  ASSERT_TRUE(ScoutSafety::ready(w));
  w.send(kDriveCommand, {0.4, 0.2});
  w.run(10);
  EXPECT_NEAR(w.out_.telemetry.measured_m_s, 0.4, 1e-6);
  EXPECT_NEAR(w.out_.telemetry.yaw_rad, 0.2 * 10, 0.1);
}

}  // namespace
}  // namespace lss::scout

LSS_SAFETY_SUITE(Scout, lss::scout::ScoutSafety);
LSS_SAFETY_RESETS(Scout, lss::scout::ScoutSafety);
