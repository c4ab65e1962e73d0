// A module may be reset at any moment: of a walk, of gaits and headings that differ, and of the way
// from Idle to Idle. Each time all modules are stopped, nothing moves, `solve` leads to Idle, and
// Lunar Zebro stands up and walks on.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/zebro/chain/chain.h"
#include "tests/zebro/chain/wire_check.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

using gnc::zebro::Speed;
using sim::zebro::PlantKind;

// From the reset to FatalError: the restart time of the module (docs/icd-zebro.md section 6: 300 ms
// at most), then its status in the next bus cycle, and the frame after it.
constexpr double kNoticed_s = 0.300 + 4 * 0.020;
constexpr double kStill_rad = 0.01;

struct Walks {
  unsigned seed;
  PlantKind plant;
  int resets;
};

class ZebroResets : public testing::TestWithParam<Walks> {
 protected:
  double draw(double from, double to) { return std::uniform_real_distribution(from, to)(random_); }
  int draw_int(int from, int to) { return std::uniform_int_distribution(from, to)(random_); }

  void walk() {
    ASSERT_TRUE(chain_.stand());
    ASSERT_NO_FATAL_FAILURE(walk_some_way());
    chain_.run(draw(0.5, 8));
    ASSERT_EQ(chain_.mode(), Mode::walking);
    ASSERT_FALSE(chain_.has_fatal());
  }

  void walk_some_way() {
    const bool forward = draw_int(0, 1) == 1;
    const double heading_rad = draw_int(0, 1) == 0 ? 0 : draw(-kHalfPi, kHalfPi);
    const auto speed = static_cast<Speed>(draw_int(1, 3));
    ASSERT_TRUE(chain_.walk(forward, heading_rad, speed));
  }

  void reset(std::uint16_t module) {
    const TimeNs reset_ns = chain_.now();
    chain_.inject("module-reset:" + std::to_string(module));
    ASSERT_TRUE(chain_.run_until(State::fatal_error, kNoticed_s));
    const TimeNs order_ns = chain_.now() + chain_.config().offset_ns;
    EXPECT_TRUE(chain_.has(FaultId::module_reset, module));
    latest_ns_ = std::max(latest_ns_, chain_.now() - reset_ns);

    chain_.run(0.1);
    const auto shafts = chain_.world().robot().shafts();
    chain_.run(0.9);
    EXPECT_EQ(emergency_on_wire(chain_.wire(), chain_.parameters().bus, order_ns, chain_.now()),
              "");
    for (std::size_t i = 0; i < shafts.size(); ++i) {
      EXPECT_NEAR(chain_.world().robot().shafts()[i].angle_rad, shafts[i].angle_rad, kStill_rad)
          << "leg " << i + 1;
    }
    EXPECT_EQ(chain_.state(), State::fatal_error);
    EXPECT_EQ(chain_.supervisor().fault_count, 1u);
  }

  void solve() {
    const TimeNs begin_ns = chain_.now();
    ASSERT_TRUE(chain_.solve(3));
    EXPECT_EQ(harmless(chain_.wire(), begin_ns, chain_.now()), "");
    EXPECT_EQ(chain_.supervisor().fault_count, 0u);
    EXPECT_EQ(chain_.supervisor().controller.isolated, 0);
  }

  std::mt19937 random_{GetParam().seed};
  // More often than error solving accepts without a minute of walking.
  Chain chain_{{.seed = GetParam().seed, .plant = GetParam().plant, .adjust = [](Parameters& p) {
                  p.solver.rounds = 1000;
                }}};
  TimeNs latest_ns_ = 0;
  int noticed_ = 0;
};

// [P-Int-2]
TEST_P(ZebroResets, AtAnyMomentOfAWalkEndSafeAndCanGoOn) {
  for (int i = 0; i < GetParam().resets && !HasFailure(); ++i) {
    const auto module = static_cast<std::uint16_t>(draw_int(1, kModules));
    SCOPED_TRACE(testing::Message() << "reset " << i + 1 << ", of module " << module << " at "
                                    << chain_.seconds() << " s");
    ASSERT_NO_FATAL_FAILURE(walk());
    ASSERT_NO_FATAL_FAILURE(reset(module));
    ASSERT_NO_FATAL_FAILURE(solve());
    chain_.forget();
  }
  RecordProperty("noticed_after_ms", static_cast<int>(latest_ns_ / kMillisecond));
  ASSERT_NO_FATAL_FAILURE(walk());
  chain_.send(lss::CommandKind::stop, {1});
  EXPECT_TRUE(chain_.run_until(State::idle, 60));
}

// From Idle to Idle: standing up, standing, walking, the last step, lying down.
// [P-Int-2]
TEST_P(ZebroResets, AtAnyMomentBetweenIdleAndIdleEndSafe) {
  for (int i = 0; i < GetParam().resets && !HasFailure(); ++i) {
    const auto module = static_cast<std::uint16_t>(draw_int(1, kModules));
    SCOPED_TRACE(testing::Message() << "reset " << i + 1 << ", of module " << module << " at "
                                    << chain_.seconds() << " s");
    const int phase = draw_int(0, 2);
    if (phase > 0) {
      ASSERT_TRUE(chain_.stand());
    }
    if (phase > 1) {
      ASSERT_NO_FATAL_FAILURE(walk_some_way());
      chain_.run(draw(0, 4));
    }
    if (phase == 0) chain_.send(lss::CommandKind::start, {1});
    if (phase > 0) chain_.send(lss::CommandKind::stop, {1});
    chain_.run(draw(0.1, 8));
    if (chain_.state() == State::idle) continue;  // the stop has ended
    ASSERT_EQ(chain_.state(), State::operational);
    const TimeNs before_ns = chain_.now();
    chain_.inject("module-reset:" + std::to_string(module));
    chain_.run_until([&] { return chain_.state() != State::operational; }, kNoticed_s);
    if (chain_.state() == State::idle) {  // the stop ended before the module answered
      chain_.run(1);
      continue;
    }
    ASSERT_EQ(chain_.state(), State::fatal_error);
    EXPECT_TRUE(chain_.has(FaultId::module_reset, module));
    EXPECT_LE(chain_.now() - before_ns, static_cast<TimeNs>(kNoticed_s * 1e9));
    const TimeNs order_ns = chain_.now() + chain_.config().offset_ns;
    chain_.run(1);
    EXPECT_EQ(emergency_on_wire(chain_.wire(), chain_.parameters().bus, order_ns, chain_.now()),
              "");
    ASSERT_NO_FATAL_FAILURE(solve());
    chain_.forget();
    ++noticed_;
  }
  EXPECT_GT(noticed_, GetParam().resets / 3);
}

INSTANTIATE_TEST_SUITE_P(Zebro, ZebroResets,
                         testing::Values(Walks{101, PlantKind::dart, 5},
                                         Walks{102, PlantKind::kinematic, 50},
                                         Walks{103, PlantKind::kinematic, 50}),
                         [](const auto& walks) {
                           return (walks.param.plant == PlantKind::dart ? "rigid_bodies_"
                                                                        : "kinematic_") +
                                  std::to_string(walks.param.seed);
                         });

}  // namespace
}  // namespace lss::zebro
