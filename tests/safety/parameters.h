#pragma once

// Safety suite: parameters that change while the vehicle runs. See safety_suite.h.

#include <set>

#include "records.h"
#include "scene.h"

namespace lss::safety {

template <class T>
class SafetyParameters : public testing::Test {};
TYPED_TEST_SUITE_P(SafetyParameters);

template <class T>
const char* name_of(std::size_t index) {
  return T::tuning().infos[index].name;
}

template <class T>
Ack set_parameter(WorldOf<T>& w, const char* name, double value, const char* from = "test",
                  std::uint16_t flags = 0) {
  w.acks.clear();
  w.put({.source = source(from),
         .kind = static_cast<std::uint16_t>(CommandKind::set_parameter),
         .flags = flags,
         .parameter = {value},
         .name = parameter_name(name)});
  w.step();
  return w.acks.empty() ? Ack{} : w.acks.back();
}

// Parameters as they are in force.
template <class T>
auto in_force(const WorldOf<T>& w) {
  auto parameters = T::parameters();
  for (std::size_t i = 0; i < T::tuning().tunables.size(); ++i)
    set_tunable(T::tuning().tunables[i], parameters, w.vehicle_.tunables().value[i]);
  T::tuning().derive(parameters);
  return parameters;
}

// Another value that goes with the others; the present one when there is none.
template <class T, class P>
double another(const P& parameters, std::size_t index) {
  const auto& tuning = T::tuning();
  const TunableInfo& t = tuning.infos[index];
  const double now = get_tunable(tuning.tunables[index], parameters);
  for (const double wanted : {now * 1.1, now * 0.9, now + 1, now - 1, t.max, t.min}) {
    const double value = std::clamp(t.whole ? std::round(wanted) : wanted, t.min, t.max);
    if (same_value(value, now)) continue;
    P changed = parameters;
    set_tunable(tuning.tunables[index], changed, value);
    tuning.derive(changed);
    if (tuning.check(changed) == nullptr) return value;
  }
  return now;
}

TYPED_TEST_P(SafetyParameters, TheTableIsSound) {
  using T = TypeParam;
  const auto& tuning = T::tuning();
  std::set<std::string> names;
  const auto defaults = T::parameters();
  EXPECT_EQ(tuning.check(defaults), nullptr);
  ASSERT_EQ(tuning.tunables.size(), tuning.infos.size());
  ASSERT_FALSE(tuning.infos.empty());
  for (std::size_t i = 0; i < tuning.infos.size(); ++i) {
    const TunableInfo& t = tuning.infos[i];
    SCOPED_TRACE(t.name);
    EXPECT_TRUE(names.insert(t.name).second);
    EXPECT_LT(std::string(t.name).size(), 48U);
    EXPECT_LT(std::string(t.unit).size(), 12U);
    EXPECT_NE(*t.help, '\0');
    EXPECT_LT(t.min, t.max);
    EXPECT_TRUE(in_range(t, get_tunable(tuning.tunables[i], defaults)));
    EXPECT_FALSE(same_value(another<T>(defaults, i), get_tunable(tuning.tunables[i], defaults)));
    // A value that was set is read back.
    auto changed = defaults;
    for (const double value : {t.min, t.max}) {
      set_tunable(tuning.tunables[i], changed, value);
      EXPECT_TRUE(same_value(get_tunable(tuning.tunables[i], changed), value));
    }
  }
}

TYPED_TEST_P(SafetyParameters, EachIsTakenAndReportedInIdle) {
  using T = TypeParam;
  const auto w = rested<T>();
  for (std::size_t i = 0; i < T::tuning().infos.size(); ++i) {
    SCOPED_TRACE(T::tuning().infos[i].name);
    const double before = w->vehicle_.tunables().value[i];
    const double value = another<T>(in_force<T>(*w), i);
    const std::uint32_t changes = w->vehicle_.tunables().changes;
    w->events.clear();
    EXPECT_EQ(set_parameter<T>(*w, name_of<T>(i), value).phase, Phase::completed);
    EXPECT_EQ(w->vehicle_.tunables().value[i], value);
    EXPECT_EQ(w->vehicle_.tunables().changes, changes + 1);
    const EventRecord* told = w->heard(EventId::parameter_changed);
    ASSERT_NE(told, nullptr);
    EXPECT_EQ(told->argument,
              (std::array<double, 4>{static_cast<double>(i + 1), before, value, 0}));
  }
}

// Just inside is taken, or does not go with the others; just outside is refused with the limit.
TYPED_TEST_P(SafetyParameters, TheBoundsOfEachHoldAndARefusalNamesThem) {
  using T = TypeParam;
  int taken = 0;
  for (std::size_t i = 0; i < T::tuning().infos.size(); ++i) {
    const TunableInfo& t = T::tuning().infos[i];
    for (const double limit : {t.min, t.max}) {
      SCOPED_TRACE(std::string(t.name) + " " + std::to_string(limit));
      const auto w = fresh<T>();
      w->run(1);
      const double outside = t.whole ? limit + (limit == t.min ? -1 : 1)
                                     : std::nextafter(limit, limit == t.min ? -HUGE_VAL : HUGE_VAL);
      const Ack refused = set_parameter<T>(*w, name_of<T>(i), outside);
      EXPECT_EQ(refused.phase, Phase::rejected);
      EXPECT_EQ(refused.verdict.reason, Reason::parameter_range);
      EXPECT_EQ(refused.verdict.measured, outside);
      EXPECT_EQ(refused.verdict.limit, limit);
      EXPECT_EQ(refused.verdict.subject, i + 1);
      EXPECT_EQ(w->vehicle_.tunables().changes, 0u);
      const Ack inside = set_parameter<T>(*w, name_of<T>(i), limit);
      taken += inside.phase == Phase::completed ? 1 : 0;
      if (inside.phase != Phase::completed) {
        EXPECT_EQ(inside.verdict.reason, Reason::parameter_together);
      }
      EXPECT_EQ(w->vehicle_.tunables().changes, inside.phase == Phase::completed ? 1u : 0u);
      EXPECT_TRUE(stays_sound<T>(*w, 0.5));
    }
    if (!t.whole) continue;
    const auto w = fresh<T>();
    EXPECT_EQ(set_parameter<T>(*w, name_of<T>(i), t.min + 0.5).verdict.reason,
              Reason::parameter_whole);
  }
  EXPECT_GT(taken, 0);
}

TYPED_TEST_P(SafetyParameters, OneThatThereIsNotIsRefused) {
  using T = TypeParam;
  const auto w = rested<T>();
  const std::string longer = std::string(name_of<T>(0)) + "_";
  for (const char* name : {"", "nothing", longer.c_str(), longer.c_str() + 1}) {
    const Ack refused = set_parameter<T>(*w, name, 1);
    EXPECT_EQ(refused.phase, Phase::rejected) << name;
    EXPECT_EQ(refused.verdict.reason, *name == '\0' ? Reason::bad_name : Reason::no_such_parameter)
        << name;
  }
  EXPECT_EQ(w->vehicle_.tunables().changes, 0u);
  EXPECT_EQ(set_parameter<T>(*w, name_of<T>(0), kRequired).verdict.reason, Reason::not_finite);
}

TYPED_TEST_P(SafetyParameters, WhatMovesIsNotChangedUnderWay) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  for (std::size_t i = 0; i < T::tuning().infos.size(); ++i) {
    const TunableInfo& t = T::tuning().infos[i];
    SCOPED_TRACE(t.name);
    const double now = w->vehicle_.tunables().value[i];
    const Ack ack = set_parameter<T>(*w, name_of<T>(i), now);
    EXPECT_EQ(ack.phase, t.change == Change::at_rest ? Phase::rejected : Phase::completed);
    if (t.change == Change::at_rest) {
      EXPECT_EQ(ack.verdict.reason, Reason::not_in_state);
      EXPECT_EQ(ack.verdict.measured, static_cast<double>(State::operational));
    }
    EXPECT_EQ(w->vehicle_.tunables().value[i], now);
    EXPECT_TRUE(T::moves(*w)) << "it goes on";
    EXPECT_EQ(w->supervisor_.state().active.kind, T::kMotion.kind);
  }
}

TYPED_TEST_P(SafetyParameters, OnlyTheHolderOfAuthorityChangesThem) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  const double now = w->vehicle_.tunables().value[0];
  EXPECT_EQ(set_parameter<T>(*w, name_of<T>(0), now, "another").verdict.reason,
            Reason::not_authorised);
  EXPECT_EQ(w->vehicle_.tunables().changes, 0u);
}

TYPED_TEST_P(SafetyParameters, ADryRunAsksOnly) {
  using T = TypeParam;
  const auto w = rested<T>();
  const double value = another<T>(T::parameters(), 0);
  EXPECT_EQ(set_parameter<T>(*w, name_of<T>(0), value, "test", kFlagDryRun).phase, Phase::accepted);
  const double outside = T::tuning().infos[0].max + 1;
  EXPECT_EQ(set_parameter<T>(*w, name_of<T>(0), outside, "test", kFlagDryRun).verdict.reason,
            Reason::parameter_range);
  EXPECT_EQ(w->vehicle_.tunables().changes, 0u);
}

// The saver's thread answers.
TYPED_TEST_P(SafetyParameters, ASaveIsAskedForOnceAFrame) {
  using T = TypeParam;
  const auto w = rested<T>();
  w->send(CommandKind::save_parameters);
  w->send(CommandKind::save_parameters, {}, "another");
  w->step();
  ASSERT_NE(w->supervisor_.save_asked(), nullptr);
  EXPECT_EQ(w->supervisor_.save_asked()->source, source("test"));
  EXPECT_NE(w->answer(CommandKind::save_parameters, Phase::executing), nullptr);
  EXPECT_EQ(w->answer(CommandKind::save_parameters, Phase::completed), nullptr);
  ASSERT_NE(w->last(Phase::rejected), nullptr);
  EXPECT_EQ(w->last(Phase::rejected)->verdict.reason, Reason::busy);
  w->step();
  EXPECT_EQ(w->supervisor_.save_asked(), nullptr);
}

// With any requests values in force are in range, consistent, and those that were taken.
TYPED_TEST_P(SafetyParameters, AnyNonsenseIsRefused) {
  using T = TypeParam;
  const auto& tuning = T::tuning();
  int completed = 0, refused = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Dice dice(seed);
    const auto w = fresh<T>();
    w->run(1);
    std::vector<double> expected(w->vehicle_.tunables().value.begin(),
                                 w->vehicle_.tunables().value.begin() + tuning.infos.size());
    for (int i = 0; i < 400; ++i) {
      const std::size_t index = dice.below(tuning.infos.size() + 2);
      const bool known = index < tuning.infos.size();
      const TunableInfo& t = tuning.infos[known ? index : 0];
      double value = dice.between(t.min, t.max);
      if (t.whole) value = std::floor(value);
      if (dice.below(3) == 0) value = dice.between(-1e9, 1e9);
      const Ack ack = set_parameter<T>(*w, known ? t.name : "nothing", value);
      if (ack.phase != Phase::completed) {
        ASSERT_EQ(ack.phase, Phase::rejected);
        ++refused;
        continue;
      }
      ++completed;
      ASSERT_TRUE(known);
      ASSERT_TRUE(in_range(t, value)) << t.name << " " << value;
      expected[index] = value;
      ASSERT_EQ(tuning.check(in_force<T>(*w)), nullptr);
    }
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(w->vehicle_.tunables().value[i], expected[i]) << tuning.infos[i].name;
    EXPECT_TRUE(stays_sound<T>(*w, 1));
  }
  EXPECT_GT(completed, 100);
  EXPECT_GT(refused, 100);
}

// On the frame thread nothing may.
TYPED_TEST_P(SafetyParameters, AdjustingAllocatesNothing) {
  using T = TypeParam;
  const auto w = rested<T>();
  int taken = 0, refused = 0;
  const std::uint64_t before = T::allocations();
  for (std::size_t i = 0; i < T::tuning().infos.size(); ++i) {
    const TunableInfo& t = T::tuning().infos[i];
    for (const double value : {t.min, t.max, w->vehicle_.tunables().value[i]}) {
      const Verdict verdict = w->vehicle_.adjust(i, value, true).verdict;
      ++(verdict.reason == Reason::none ? taken : refused);
    }
  }
  EXPECT_EQ(T::allocations(), before);
  EXPECT_GT(taken, 0);
}

TYPED_TEST_P(SafetyParameters, ARunInWhichTheyChangeIsExecutedAgainToTheBit) {
  using T = TypeParam;
  const auto w = fresh<T>();
  Recording recording(*w);
  w->run(1);
  for (std::size_t i = 0; i < T::tuning().infos.size(); ++i)
    set_parameter<T>(*w, name_of<T>(i), another<T>(in_force<T>(*w), i));
  recording.remember();
  ASSERT_TRUE(comes_to_motion<T>(*w));
  w->run(2);
  recording.expect_replayed(T::parameters(), T::logic());
  // With other values before the first change something comes out differently.
  for (std::size_t i = 0; i < T::tuning().infos.size(); ++i) {
    auto other = T::parameters();
    set_tunable(T::tuning().tunables[i], other, another<T>(other, i));
    T::tuning().derive(other);
    EXPECT_TRUE(recording.differs_with(other, T::logic())) << T::tuning().infos[i].name;
  }
}

REGISTER_TYPED_TEST_SUITE_P(SafetyParameters, TheTableIsSound, EachIsTakenAndReportedInIdle,
                            TheBoundsOfEachHoldAndARefusalNamesThem, OneThatThereIsNotIsRefused,
                            WhatMovesIsNotChangedUnderWay, OnlyTheHolderOfAuthorityChangesThem,
                            ADryRunAsksOnly, ASaveIsAskedForOnceAFrame, AnyNonsenseIsRefused,
                            AdjustingAllocatesNothing,
                            ARunInWhichTheyChangeIsExecutedAgainToTheBit);

}  // namespace lss::safety
