// A leg whose sensor lies, sleeps, jumps or drifts, whose gear slips or whose motor is limp: it is
// named within its time, `solve` takes it out of service while the fault lasts, and the others walk
// on. All legs, all these faults.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <random>

#include "idl/zebro/codes.h"
#include "tests/zebro/chain/chain.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

struct Doubt {
  const char* fault;
  double within_s;  // docs/faults-zebro.md
  std::vector<FaultId> said;
};

const std::vector<Doubt> kDoubts = {
    {"encoder-random", 0.3, {faults::position_jumps, faults::gear_slips}},
    // The module turns the leg on and on, over its sensor or until something is in its way.
    {"encoder-frozen",
     5,
     {faults::leg_still, faults::gear_slips, faults::position_jumps, FaultId::module_over_current}},
    {"encoder-jumps", 1.1, {faults::report_impossible, faults::position_jumps, faults::gear_slips}},
    {"encoder-drifts", 20, {faults::gear_slips, faults::leg_still}},
    {"gear-slips", 20, {faults::gear_slips, faults::leg_still}},
    {"leg-limp", 5, {faults::leg_still, faults::motion_timeout}},
};

class DoubtfulLeg : public testing::TestWithParam<std::tuple<std::size_t, unsigned>> {};

// [Env-2] [Conf-3] [Oper-6]
TEST_P(DoubtfulLeg, IsNamedIsolatedBySolveAndTheOthersWalkOn) {
  const Doubt& doubt = kDoubts[std::get<0>(GetParam())];
  const unsigned leg = std::get<1>(GetParam());
  const auto subject = static_cast<std::uint16_t>(leg);
  const unsigned seed = 100 + static_cast<unsigned>(std::get<0>(GetParam())) * 6 + leg;
  Chain chain({.seed = seed, .plant = sim::zebro::PlantKind::kinematic});
  ASSERT_TRUE(chain.stand());
  ASSERT_TRUE(chain.walk());
  std::mt19937 random(seed);
  chain.run(std::uniform_real_distribution(0.5, 8.0)(random));
  ASSERT_EQ(chain.mode(), Mode::walking);
  const double begun_s = chain.seconds();
  chain.inject(fmt::format("{}:{}", doubt.fault, leg));
  ASSERT_TRUE(chain.run_until(State::fatal_error, doubt.within_s)) << "nothing is said";
  RecordProperty("after_ms", static_cast<int>((chain.seconds() - begun_s) * 1e3));
  EXPECT_TRUE(std::ranges::any_of(doubt.said, [&](FaultId id) { return chain.has(id, subject); }))
      << "another fault";
  for (const FaultRecord& fault : chain.supervisor().faults) {
    if (fault.id == FaultId::none) continue;
    EXPECT_EQ(fault.subject, subject) << info(fault.id)->name;
    RecordProperty("said", info(fault.id)->name);
  }

  chain.run(1);
  ASSERT_TRUE(chain.solve());
  EXPECT_EQ(chain.supervisor().controller.isolated, 1u << (leg - 1));
  ASSERT_TRUE(chain.stand());
  ASSERT_TRUE(chain.walk());
  const auto from = chain.body().position_m;
  const std::uint32_t steps = chain.telemetry().steps;
  chain.run(60);
  EXPECT_EQ(chain.mode(), Mode::walking);
  EXPECT_FALSE(chain.has_fatal());
  EXPECT_GE(chain.telemetry().steps, steps + 3);
  EXPECT_GT((chain.body().position_m - from).norm(), 0.001 * 60);
  chain.send(lss::CommandKind::stop, {1});
  EXPECT_TRUE(chain.run_until(State::idle, 60));
}

INSTANTIATE_TEST_SUITE_P(Zebro, DoubtfulLeg,
                         testing::Combine(testing::Range(std::size_t{0}, kDoubts.size()),
                                          testing::Range(1u, 7u)),
                         [](const auto& drawn) {
                           std::string name = kDoubts[std::get<0>(drawn.param)].fault;
                           std::ranges::replace_if(
                               name, [](char c) { return std::isalnum(c) == 0; }, '_');
                           return name + "_" + kModuleNames[std::get<1>(drawn.param) - 1];
                         });

}  // namespace
}  // namespace lss::zebro
