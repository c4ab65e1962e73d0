#pragma once

// Tests of the parameters of every vehicle: each is accepted at once, a value that makes no sense
// is refused, and a recording in which they change is executed again to the bit, also from the
// middle. World: the vehicle's in tests/NAME/daemon/world.h.

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <set>
#include <string>
#include <vector>

#include "daemon/parameters/start.h"
#include "daemon/replay/replay.h"
#include "tests/support/allocations.h"

namespace lss::parameters_test {

inline double number(std::size_t index) { return static_cast<double>(index + 1); }

// Another value that goes with the others; the present one when there is none.
template <class P>
double another(const Tuning<P>& tuning, const P& parameters, std::size_t index) {
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

template <class P>
void expect_a_sound_table(const Tuning<P>& tuning) {
  std::set<std::string> names;
  const P defaults;
  EXPECT_EQ(tuning.check(defaults), nullptr);
  ASSERT_EQ(tuning.tunables.size(), tuning.infos.size());
  for (std::size_t i = 0; i < tuning.infos.size(); ++i) {
    const TunableInfo& t = tuning.infos[i];
    EXPECT_TRUE(names.insert(t.name).second) << t.name;
    EXPECT_LT(std::string(t.name).size(), 48U) << t.name;
    EXPECT_LT(std::string(t.unit).size(), 12U) << t.name;
    EXPECT_NE(*t.help, '\0') << t.name;
    EXPECT_LT(t.min, t.max) << t.name;
    EXPECT_TRUE(in_range(t, get_tunable(tuning.tunables[i], defaults))) << t.name;
    EXPECT_FALSE(
        same_value(another(tuning, defaults, i), get_tunable(tuning.tunables[i], defaults)))
        << t.name;
    // A value that was set is read back.
    P changed = defaults;
    for (const double value : {t.min, t.max}) {
      set_tunable(tuning.tunables[i], changed, value);
      EXPECT_TRUE(same_value(get_tunable(tuning.tunables[i], changed), value)) << t.name;
    }
  }
}

// In Idle.
template <class World, class P>
void expect_each_is_taken_and_told(const Tuning<P>& tuning) {
  World w;
  w.run(0.5);
  for (std::size_t i = 0; i < tuning.infos.size(); ++i) {
    const double before = w.vehicle_.tunables().value[i];
    P now;
    for (std::size_t k = 0; k < tuning.infos.size(); ++k)
      set_tunable(tuning.tunables[k], now, w.vehicle_.tunables().value[k]);
    const double value = another(tuning, now, i);
    const std::uint32_t changes = w.vehicle_.tunables().changes;
    w.acks.clear();
    w.events.clear();
    w.send(CommandKind::set_parameter, {number(i), value});
    w.step();
    ASSERT_FALSE(w.acks.empty()) << tuning.infos[i].name;
    EXPECT_EQ(w.acks.back().phase, Phase::completed) << tuning.infos[i].name;
    EXPECT_EQ(w.vehicle_.tunables().value[i], value) << tuning.infos[i].name;
    EXPECT_EQ(w.vehicle_.tunables().changes, changes + 1);
    ASSERT_EQ(w.events.size(), 1U) << tuning.infos[i].name;
    EXPECT_EQ(w.events[0].id, static_cast<std::uint16_t>(EventId::parameter_changed));
    EXPECT_EQ(w.events[0].argument, (std::array<double, 4>{number(i), before, value, 0}));
  }
}

// On the frame thread nothing may.
template <class World, class P>
void expect_adjusting_allocates_nothing(const Tuning<P>& tuning) {
  World w;
  w.run(0.5);
  int taken = 0, refused = 0;
  const std::uint64_t before = testing_support::allocations();
  for (std::size_t i = 0; i < tuning.infos.size(); ++i) {
    const TunableInfo& t = tuning.infos[i];
    for (const double value : {t.min, t.max, w.vehicle_.tunables().value[i]}) {
      const Verdict verdict = w.vehicle_.adjust(i, value, true).verdict;
      ++(verdict.reason == Reason::none ? taken : refused);
    }
  }
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_GT(taken, 0);
  EXPECT_GT(refused, 0);
}

// For any input: active values are in range, consistent, and those that the world received.
template <class World, class P>
void expect_nonsense_is_refused(const Tuning<P>& tuning) {
  EXPECT_TRUE(rc::check([&](std::vector<std::pair<std::uint8_t, double>> wishes) {
    World w;
    w.step();
    std::vector<double> expected(tuning.infos.size());
    for (std::size_t i = 0; i < expected.size(); ++i) expected[i] = w.vehicle_.tunables().value[i];
    for (const auto& [n, wish] : wishes) {
      const std::size_t index = n % (tuning.infos.size() + 2);
      const bool known = index < tuning.infos.size();
      // Half of them near the limits.
      const TunableInfo& t = tuning.infos[known ? index : 0];
      const double value = n & 1 ? wish : t.min + std::fmod(std::abs(wish), t.max - t.min);
      w.acks.clear();
      w.send(CommandKind::set_parameter, {number(index), value});
      w.step();
      RC_ASSERT(!w.acks.empty());
      if (w.acks.back().phase != Phase::completed) {
        RC_ASSERT(w.acks.back().phase == Phase::rejected);
        continue;
      }
      RC_ASSERT(known);
      RC_ASSERT(in_range(t, value));
      expected[index] = value;
    }
    P in_force;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      RC_ASSERT(w.vehicle_.tunables().value[i] == expected[i]);
      set_tunable(tuning.tunables[i], in_force, expected[i]);
    }
    tuning.derive(in_force);
    RC_ASSERT(tuning.check(in_force) == nullptr);
  }));
}

using Bytes = std::vector<std::uint8_t>;

// Every frame of a world from now on, and its stored state at one of them.
template <class World, class Vehicle>
class Recording {
 public:
  explicit Recording(World& world) : world_(world) {}

  void step() {
    world_.step();
    Bytes bytes(sizeof(record::FrameRecord<Vehicle>));
    record::Writer writer(bytes);
    const bool asked = world_.out_.data_requested;
    const TimingPoints timing{};
    const Inputs<Vehicle>* in = &world_.in_;
    if constexpr (requires { world_.taken_; }) in = &world_.taken_;
    fields(writer, record::FrameView<Vehicle>{*in, world_.out_.command, world_.supervisor_.outbox(),
                                              world_.supervisor_.state(), world_.out_.telemetry,
                                              asked, timing});
    ASSERT_TRUE(writer.fits());
    bytes.resize(writer.size());
    frames_.push_back(std::move(bytes));
  }
  void run(double seconds) {
    for (const TimeNs end = world_.time_ns_ + static_cast<TimeNs>(seconds * 1e9);
         world_.time_ns_ < end;)
      step();
  }
  void remember() {
    Bytes bytes(sizeof(Vehicle) + sizeof(Supervisor) + sizeof(typename Vehicle::Telemetry));
    record::StateWriter writer(bytes);
    record::keep(writer, world_.vehicle_, world_.supervisor_, world_.out_.telemetry);
    ASSERT_TRUE(writer.fits());
    bytes.resize(writer.size());
    state_ = std::move(bytes);
    at_ = frames_.size();
  }

  template <class P>
  void expect_replayed(const P& parameters, const Logic& logic) const {
    record::VehicleReplay<Vehicle> from_start(parameters, logic, 30 * kSecond);
    for (const Bytes& frame : frames_) expect_equal(from_start, frame);
    ASSERT_FALSE(state_.empty());
    ASSERT_LT(at_, frames_.size());
    record::VehicleReplay<Vehicle> from_middle(parameters, logic, 30 * kSecond);
    ASSERT_TRUE(from_middle.restore(state_));
    for (std::size_t i = at_; i < frames_.size(); ++i) expect_equal(from_middle, frames_[i]);
  }
  // With other parameters something comes out differently: the replay is not blind to them.
  template <class P>
  bool differs_with(const P& parameters, const Logic& logic) const {
    record::VehicleReplay<Vehicle> replay(parameters, logic, 30 * kSecond);
    for (const Bytes& frame : frames_) {
      if (replay.step(frame).difference) return true;
    }
    return false;
  }

 private:
  static void expect_equal(record::VehicleReplay<Vehicle>& replay, const Bytes& frame) {
    const record::Replay::Frame result = replay.step(frame);
    ASSERT_FALSE(result.difference)
        << "frame " << result.frame << ": " << result.difference->field << " was "
        << result.difference->recorded << ", is " << result.difference->computed;
  }

  World& world_;
  std::vector<Bytes> frames_;
  Bytes state_;
  std::size_t at_ = 0;
};

}  // namespace lss::parameters_test
