#pragma once

// Safety suite: each limit of the supervision, just below and just above. See safety_suite.h.

#include <algorithm>

#include "parameters.h"
#include "scene.h"

namespace lss::safety {

// What the supervision measures, brought just below its limit and just above it. P: the vehicle's
// parameters, as they are in force.
template <class World, class P>
struct Limit {
  std::string name;
  std::vector<std::string> parameters;  // that set it; none: it is a constant
  double within_s;                      // above, it is noticed within it; below, not at all
  std::function<void(World&, const P&, bool above)> cause;
  std::function<bool(const World&)> noticed;
  std::function<void(World&)> begin{};  // from Idle; none: into motion
};

// The same for a limit that is a fault.
template <class World>
auto fault_noticed(FaultId id, std::uint16_t subject = 0) {
  return [=](const World& w) { return w.has(id, subject); };
}

// Applies `now` before each frame for so long, `then` in the frame after it.
template <class World, class Now, class Then>
void for_so_long(World& w, TimeNs duration, Now now, Then then) {
  w.alter = [end = w.time_ns_ + duration, now, then, over = false](World& world) mutable {
    if (world.time_ns_ <= end) {
      now(world);
    } else if (!std::exchange(over, true)) {
      then(world);
    }
  };
}

template <class T>
class SafetyLimits : public testing::Test {};
TYPED_TEST_SUITE_P(SafetyLimits);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(SafetyLimits);

template <class T, class L>
void expect_noticed(const L& limit, const std::vector<std::pair<std::string, double>>& values) {
  for (const bool above : {false, true}) {
    SCOPED_TRACE(above ? "above" : "below");
    const auto w = fresh<T>();
    w->run(1);
    for (const auto& [name, value] : values) {
      SCOPED_TRACE(name + " = " + std::to_string(value));
      ASSERT_EQ(w->set(name.c_str(), value).phase, Phase::completed);
    }
    if (limit.begin) {
      limit.begin(*w);
    } else {
      ASSERT_TRUE(comes_to_motion<T>(*w));
    }
    ASSERT_FALSE(limit.noticed(*w)) << "before its cause";
    limit.cause(*w, in_force<T>(*w), above);
    EXPECT_EQ(w->run_until([&] { return limit.noticed(*w); }, limit.within_s), above)
        << where<T>(*w);
  }
}

TYPED_TEST_P(SafetyLimits, JustBelowNothingIsNoticedJustAboveItIs) {
  using T = TypeParam;
  for (const auto& limit : T::limits()) {
    SCOPED_TRACE(limit.name);
    expect_noticed<T>(limit, {});
  }
}

// The parameter decides, no number in the code.
TYPED_TEST_P(SafetyLimits, TheyFollowTheirParameters) {
  using T = TypeParam;
  const auto& tuning = T::tuning();
  for (const auto& limit : T::limits()) {
    for (const std::string& parameter : limit.parameters) {
      SCOPED_TRACE(limit.name + " by " + parameter);
      const auto i = static_cast<std::size_t>(find_tunable(tuning.infos, parameter.c_str()));
      ASSERT_LT(i, tuning.infos.size()) << "there is such a parameter";
      const double other = another<T>(in_force<T>(*fresh<T>()), i);
      expect_noticed<T>(limit, {{parameter, other}});
    }
  }
}

// Each parameter belongs to a limit here, or to those of which the vehicle says that they limit
// nothing that is watched (how it moves), or where their limit is tested.
TYPED_TEST_P(SafetyLimits, EveryParameterHasALimitOrIsNone) {
  using T = TypeParam;
  std::set<std::string> known = T::no_limits();
  for (const auto& limit : T::limits()) {
    for (const std::string& parameter : limit.parameters) {
      EXPECT_FALSE(T::no_limits().contains(parameter)) << parameter;
      known.insert(parameter);
    }
  }
  for (const TunableInfo& info : T::tuning().infos) {
    EXPECT_EQ(known.erase(info.name), 1u) << info.name;
  }
  EXPECT_TRUE(known.empty()) << *known.begin();
}

REGISTER_TYPED_TEST_SUITE_P(SafetyLimits, JustBelowNothingIsNoticedJustAboveItIs,
                            TheyFollowTheirParameters, EveryParameterHasALimitOrIsNone);

}  // namespace lss::safety
