// stop, land and estop in every phase of a flight: each has one defined effect, and none is without
// (docs/operators.md, "Fly TALARIS").

#include <gtest/gtest.h>

#include "daemon/vehicles/talaris/gate.h"
#include "tests/talaris/chain/flights.h"

namespace lss::talaris {
namespace {

struct At {
  Phase phase;
  const char* fault = nullptr;  // struck in the traverse, brings the phase about
  bool air = true;
};
std::ostream& operator<<(std::ostream& out, const At& at) {
  return out << kPhaseNames[static_cast<int>(at.phase)];
}
constexpr At kPhases[] = {
    {Phase::spin_up, nullptr, false},
    {Phase::ascend},
    {Phase::hover},
    {Phase::turn},
    {Phase::traverse},
    {Phase::brake},
    {Phase::descend},
    {Phase::escape, "altimeter-silent"},
    {Phase::parachute, "node-silent:0x20"},
    {Phase::touchdown, nullptr, false},
};

class TalarisCommands : public testing::TestWithParam<At> {
 protected:
  // In this phase, in its second frame.
  void reach() {
    const At at = GetParam();
    ASSERT_TRUE(chain.prepare());
    const double turn_rad = at.phase == Phase::turn ? 0.8 : 0;
    ASSERT_TRUE(chain.fly(Program::hop, {.height_m = 2, .distance_m = 12, .turn_rad = turn_rad}));
    if (at.fault != nullptr) {
      ASSERT_TRUE(chain.run_until(Phase::traverse, 40));
      chain.inject(at.fault);
    }
    ASSERT_TRUE(chain.run_until(at.phase, 60));
    chain.run(0.25);
    ASSERT_EQ(chain.phase(), at.phase);
  }
  bool upright() const { return (chain.body().attitude * Eigen::Vector3d::UnitX()).x() > 0.98; }
  void expect_landed() {
    EXPECT_TRUE(chain.run_until([&] { return chain.rests() && !active(chain.orders()); }, 5));
    EXPECT_EQ(chain.world().gas().open(), 0);
    EXPECT_TRUE(upright());
    EXPECT_LT(chain.world().plant().touchdown().down_m_s, 1.5);
    EXPECT_EQ(chain.rejected(), Reason::none);
  }

  // Hover and brake have a second frame.
  Chain chain{{.config = "hop", .seed = 3, .adjust = [](Parameters& p) {
                 p.flight.profile.hover_s = 0.4;
               }}};
};

TEST_P(TalarisCommands, StopBringsItToTheGroundAndToIdle) {
  reach();
  const bool fault = GetParam().fault != nullptr;
  chain.send(lss::CommandKind::stop);
  const State end = fault ? State::fatal_error : State::idle;
  ASSERT_TRUE(chain.run_until(end, 40));
  expect_landed();
}

TEST_P(TalarisCommands, LandBringsItToTheGround) {
  reach();
  const bool fault = GetParam().fault != nullptr;
  chain.send(CommandKind::land);
  ASSERT_TRUE(chain.run_until([&] { return chain.mode() != Mode::execute; }, 40));
  EXPECT_EQ(chain.state(), fault ? State::fatal_error : State::operational);
  expect_landed();
}

TEST_P(TalarisCommands, EmergencyStopShutsEverythingAtOnce) {
  reach();
  chain.send(lss::CommandKind::emergency_stop);
  chain.run(0.005);
  EXPECT_EQ(chain.world().valve_node().outputs(), 0);
  for (const std::uint16_t us : chain.world().fan_node().pulse_us()) EXPECT_LE(us, 1000);
  EXPECT_TRUE(chain.run_until(State::fatal_error, 0.5));
  EXPECT_FALSE(active(chain.orders()));
}

INSTANTIATE_TEST_SUITE_P(Phases, TalarisCommands, testing::ValuesIn(kPhases),
                         [](const auto& which) {
                           std::string name = kPhaseNames[static_cast<int>(which.param.phase)];
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace lss::talaris
