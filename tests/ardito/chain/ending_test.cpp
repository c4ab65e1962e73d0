// The daemon ends at any moment of a start and of a drive, and leaves a rover that stands with its
// motors off, also when frames of nodes come late or orders are lost.

#include "daemon/cycle/ending.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/ardito/chain/chain.h"
#include "tests/support/everything.h"

namespace lss::ardito {
namespace {

using sim::nodes::Power;

constexpr TimeNs kBrakes = 3 * kSecond;  // to rest, a second at rest, motors off
constexpr int kEvery = 8;                // the sample: one of so many moments

struct Bus {
  const char* name;
  std::vector<const char*> late;  // one after the other, so that no heartbeat is missed
  bool loses = false;             // the orders of every third frame
};
void PrintTo(const Bus& bus, std::ostream* out) { *out << bus.name; }

class ArditoEnding : public testing::TestWithParam<Bus> {
 protected:
  // The moment is so many frames after the order.
  static constexpr int kStartFrames = 25, kDriveFrames = 40;

  static Chain::Options rolling(unsigned seed) {
    Chain::Options options{.seed = seed,
                           .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }};
    options.rover.plant = sim::ardito::PlantKind::kinematic;
    return options;
  }

  static void disturb(Chain& chain) {
    for (const char* fault : GetParam().late) {
      chain.inject(fault);
      chain.run(1);
    }
    chain.on_master = [&chain, releases = 0](const CanFrame& frame, TimeNs) mutable {
      if (frame.id == canopen::kSync) chain.inject("clear:drop");
      if (frame.id <= canopen::kRpdo1 || frame.id > canopen::kRpdo1 + kWheels) return;
      const std::size_t wheel = frame.id - canopen::kRpdo1 - 1;
      if (wheel == 0 && GetParam().loses && ++releases % 3 == 0) chain.inject("drop:1");
      // What brakes is switched off at rest only.
      if (frame.data[0] == 0 && chain.world().wheel(wheel).power() == Power::quick_stop) {
        EXPECT_LT(std::abs(chain.world().train(wheel).motor_rad_s()), 2);
      }
    };
  }

  static void expect_off(Chain& chain) {
    const auto off = [](const sim::nodes::Drive& drive) {
      return drive.power() == Power::switch_on_disabled || drive.power() == Power::ready;
    };
    for (std::size_t i = 0; i < kWheels; ++i)
      EXPECT_TRUE(off(chain.world().wheel(i))) << text(chain.world().wheel(i).power());
    for (std::size_t i = 0; i < kSteered; ++i)
      EXPECT_TRUE(off(chain.world().steering(i))) << text(chain.world().steering(i).power());
  }

  static void end(Chain& chain) {
    const TimeNs told_ns = chain.now();
    chain.shut_down();
    EXPECT_LT(chain.now() - told_ns, kBrakes);
    EXPECT_EQ(chain.state(), State::idle);
    expect_off(chain);
    chain.daemon = Chain::Daemon::killed;  // before its last orders are released
    chain.run(1);                          // nodes miss the master
    expect_off(chain);
    EXPECT_LT(chain.world().rover().body().velocity_m_s.norm(), 0.001);
  }
};

TEST_P(ArditoEnding, InAnyFrameOfAStartLeavesMotorsOff) {
  for (int frames = 0; frames <= kStartFrames; ++frames) {
    if (!testing_support::in_sample(static_cast<std::size_t>(frames), kEvery)) continue;
    SCOPED_TRACE(frames);
    Chain chain(rolling(static_cast<unsigned>(frames) + 1));
    ASSERT_TRUE(chain.run_until([&] { return chain.supervisor().controller.unheard == 0; }, 10));
    chain.run(1);
    disturb(chain);
    chain.send(lss::CommandKind::start, {0});
    chain.run(0.1 * frames);
    end(chain);
  }
}

TEST_P(ArditoEnding, InAnyFrameOfADriveLeavesMotorsOff) {
  for (int frames = 0; frames <= kDriveFrames; ++frames) {
    if (!testing_support::in_sample(static_cast<std::size_t>(frames), kEvery)) continue;
    SCOPED_TRACE(frames);
    Chain chain(rolling(static_cast<unsigned>(frames) + 1));
    ASSERT_TRUE(chain.start());
    disturb(chain);
    chain.send(CommandKind::drive, {0.3, 0.0, 1.0, 0.0});
    chain.run(0.1 * frames);
    end(chain);
  }
}

INSTANTIATE_TEST_SUITE_P(, ArditoEnding,
                         testing::Values(Bus{"as_it_should", {}}, Bus{"a_frame_late", {"late:100"}},
                                         Bus{"three_frames_late",
                                             {"late:100", "late:200", "late:300"}},
                                         Bus{"orders_lost", {}, true}),
                         [](const auto& of) { return std::string(of.param.name); });

// As icd-ardito.md says: after an emergency stop drives hold, also without the master.
TEST(ArditoEndingInFatalError, LeavesDrivesThatHold) {
  Chain::Options options{.seed = 1};
  options.rover.plant = sim::ardito::PlantKind::kinematic;
  Chain chain(options);
  ASSERT_TRUE(chain.start());
  ASSERT_TRUE(chain.drive(0.3));
  chain.run(2);
  chain.send(lss::CommandKind::emergency_stop);
  ASSERT_TRUE(chain.run_until(State::fatal_error, 1));
  const TimeNs told_ns = chain.now();
  chain.shut_down();
  EXPECT_LT(chain.now() - told_ns, 1500 * kMillisecond);
  chain.daemon = Chain::Daemon::killed;
  chain.run(1);
  for (std::size_t i = 0; i < kWheels; ++i)
    EXPECT_EQ(chain.world().wheel(i).power(), Power::quick_stop);
  EXPECT_LT(chain.world().rover().body().velocity_m_s.norm(), 0.001);
}

TEST(Ending, ComesASecondAfterTheLastFrame) {
  Ending without(100, 0);
  EXPECT_FALSE(without.over(100, kSecond - 1, true));
  EXPECT_TRUE(without.over(100, kSecond, true));
  Ending ending(100, 0);
  EXPECT_FALSE(ending.over(105, 500 * kMillisecond, false));
  EXPECT_FALSE(ending.over(105, 1400 * kMillisecond, false));
  EXPECT_TRUE(ending.over(105, 1600 * kMillisecond, false));
}

TEST(Ending, ComesAfterTenFramesWithMotorsOffOrTenSeconds) {
  Ending ending(100, 0);
  std::uint64_t frames = 100;
  for (TimeNs now = 0; now < 10 * kSecond; now += 200 * kMillisecond, ++frames) {
    EXPECT_FALSE(ending.over(frames, now, false));
    EXPECT_EQ(ending.over(frames, now, true), frames >= 110);
  }
  EXPECT_TRUE(ending.over(frames, 10 * kSecond, false));
}

}  // namespace
}  // namespace lss::ardito
