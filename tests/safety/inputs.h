#pragma once

// Safety suite: numbers that make no sense, in commands and in samples, and anything at random. See
// safety_suite.h.

#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "scene.h"

namespace lss::safety {

template <class T>
class SafetyInputs : public testing::Test {};
TYPED_TEST_SUITE_P(SafetyInputs);

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Visitor of record::fields that changes a sample: all its numbers with a fraction, and bytes; or
// everything but time, choices and which alternative it is.
class Spoiler {
 public:
  Spoiler(double number, std::uint8_t byte) : number_(number), byte_(byte) {}
  explicit Spoiler(Dice& dice) : dice_(&dice) {}

  template <class X>
  void operator()(const char* name, X& x) {
    if (std::strcmp(name, "time_ns") != 0) spoil(x);
  }
  template <class X, std::size_t N>
  void list(const char*, std::array<X, N>& x, std::uint32_t& count) {
    for (std::uint32_t i = 0; i < count; ++i) spoil(x[i]);
  }

 private:
  template <class X>
  void spoil(X& x) {
    if constexpr (std::is_same_v<X, bool> || std::is_enum_v<X>) {
      return;  // a driver makes no others
    } else if constexpr (std::is_floating_point_v<X>) {
      x = static_cast<X>(dice_ != nullptr ? any(*dice_) : number_);
    } else if constexpr (record::Number<X>) {
      if (dice_ != nullptr) x = static_cast<X>(dice_->bits());
    } else {
      record::visit(*this, x);
    }
  }
  template <record::Array X>
  void spoil(X& x) {
    for (auto& element : x) spoil(element);
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(x[0])>, std::uint8_t>) {
      if (dice_ == nullptr) std::fill(std::begin(x), std::end(x), byte_);
    }
  }
  template <class... X>
  void spoil(std::variant<X...>& x) {
    std::visit([this](auto& alternative) { spoil(alternative); }, x);
  }

  static double any(Dice& dice) {
    constexpr double kAbsurd[] = {kNaN, kInfinite, -kInfinite, 1e300, -1e300,
                                  1e18, 0,         -0.0,       5e-324};
    const std::uint32_t n = dice.below(20);
    return n < std::size(kAbsurd) ? kAbsurd[n] : dice.between(-1e4, 1e4);
  }

  double number_ = 0;
  std::uint8_t byte_ = 0;
  Dice* dice_ = nullptr;
};

template <class T>
void spoil_samples(WorldOf<T>& w, Spoiler spoiler) {
  for (std::uint32_t i = 0; i < w.in_.sample_count; ++i) record::visit(spoiler, w.in_.samples[i]);
}

// ---- commands

TYPED_TEST_P(SafetyInputs, ACommandWithANumberThatMakesNoSenseIsRefusedWithTheReason) {
  using T = TypeParam;
  for (const bool in_motion : {false, true}) {
    const auto w = in_motion ? moving<T>() : fresh<T>();
    ASSERT_NE(w, nullptr);
    if (!in_motion) w->run(1);
    const auto expect_refused = [&](const CommandInfo& info, std::size_t i, double value,
                                    Reason reason, std::optional<double> limit) {
      SCOPED_TRACE(std::string(info.name) + ", parameter " + std::to_string(i + 1) + ": " +
                   std::to_string(value));
      Request r = request_of(info);
      r.parameter[i] = value;
      const auto before = w->supervisor_.state().active;
      const Ack ack = answer_to<T>(*w, r);
      EXPECT_EQ(ack.phase, Phase::rejected);
      EXPECT_EQ(ack.verdict.reason, reason);
      EXPECT_EQ(ack.verdict.subject, i + 1);
      if (limit) {
        EXPECT_EQ(ack.verdict.limit, *limit);
      }
      EXPECT_TRUE(std::isnan(value) || ack.verdict.measured == value);
      EXPECT_EQ(w->supervisor_.state().active.sequence, before.sequence) << "what runs goes on";
      EXPECT_TRUE(sound<T>(*w));
    };
    for (const CommandInfo& info : commands<T>()) {
      if (info.kind == static_cast<std::uint16_t>(CommandKind::emergency_stop)) continue;
      for (std::size_t i = 0; i < kMaxParameters; ++i) {
        for (const double value : {kNaN, kInfinite, -kInfinite})
          expect_refused(info, i, value, Reason::not_finite, {});
        if (i >= info.parameters.size()) {
          expect_refused(info, i, 1, Reason::unused_parameter, 0);
          continue;
        }
        const ParameterInfo& p = info.parameters[i];
        for (const double value : {std::nextafter(p.max, 1e308), p.max + 1, 1e300})
          expect_refused(info, i, value, Reason::out_of_range, p.max);
        for (const double value : {std::nextafter(p.min, -1e308), p.min - 1, -1e300})
          expect_refused(info, i, value, Reason::out_of_range, p.min);
        if (p.is_whole() && p.max - p.min >= 1)
          expect_refused(info, i, p.min + 0.5, Reason::not_a_choice, {});
      }
    }
    if (in_motion) {
      EXPECT_TRUE(T::moves(*w));
    }
  }
}

TYPED_TEST_P(SafetyInputs, ACommandThatIsNoneIsRefusedWithTheReason) {
  using T = TypeParam;
  const auto w = rested<T>();
  const Request good = request_of(*T::logic().command(1));
  const auto expect_refused = [&](const Request& r, Reason reason) {
    EXPECT_EQ(answer_to<T>(*w, r).verdict.reason, reason);
    EXPECT_TRUE(safe<T>(*w));
    EXPECT_EQ(w->state(), State::idle);
  };
  for (const std::uint16_t kind : std::to_array<std::uint16_t>({11, 99, 1000, 32768, 65535})) {
    Request r = good;
    r.kind = kind;
    expect_refused(r, Reason::unknown_command);
  }
  for (const std::uint32_t lease_ms :
       {0u, WorldOf<T>::kShortestLease_ms - 1, WorldOf<T>::kLongestLease_ms + 1, ~0u}) {
    Request r = good;
    r.lease_ms = lease_ms;
    expect_refused(r, Reason::bad_lease);
  }
  for (const char first : {'\0', '\n', '\x7f', '\xff'}) {
    Request r = good;
    r.source[0] = first;
    expect_refused(r, Reason::bad_source);
  }
  Request endless = good;
  endless.source.fill('a');
  expect_refused(endless, Reason::bad_source);
}

// ---- samples

TYPED_TEST_P(SafetyInputs, SamplesThatAreNoNumbersNeverGiveACommandThatIsNone) {
  using T = TypeParam;
  const std::pair<double, std::uint8_t> numbers[] = {
      {kNaN, 0xFF},   {kInfinite, 0x7F}, {-kInfinite, 0x80}, {1e300, 0x00},
      {-1e300, 0xAA}, {1e9, 0x55},       {-1e9, 0x01},       {0, 0x10}};
  for (const auto& place : places<T>()) {
    for (const auto& [number, byte] : numbers) {
      SCOPED_TRACE(place.name + ", " + std::to_string(number));
      const auto w = at<T>(place);
      ASSERT_NE(w, nullptr);
      w->alter = [number, byte](WorldOf<T>& world) {
        spoil_samples<T>(world, Spoiler(number, byte));
      };
      EXPECT_TRUE(stays_sound<T>(*w, 3));
      w->alter = nullptr;
      EXPECT_TRUE(stays_sound<T>(*w, 3)) << "afterwards";
      w->send(CommandKind::emergency_stop);
      w->step();
      EXPECT_TRUE(stopped<T>(*w)) << "it can still be stopped";
    }
  }
}

TYPED_TEST_P(SafetyInputs, RandomSamplesNeverGiveACommandThatIsNone) {
  using T = TypeParam;
  Dice dice(1);
  for (const auto& place : places<T>()) {
    SCOPED_TRACE(place.name);
    const auto w = at<T>(place);
    ASSERT_NE(w, nullptr);
    w->alter = [&dice](WorldOf<T>& world) {
      for (std::uint32_t i = 0; i < world.in_.sample_count; ++i) {
        Spoiler any(dice);
        if (dice.below(3) == 0) record::visit(any, world.in_.samples[i]);
        // Also old ones and ones of the future.
        if (dice.below(20) == 0) world.in_.samples[i].time_ns += dice.bits() - 2'000'000'000LL;
      }
    };
    EXPECT_TRUE(stays_sound<T>(*w, 10));
    w->send(CommandKind::emergency_stop);
    w->step();
    EXPECT_TRUE(stopped<T>(*w)) << "it can still be stopped";
  }
}

// ---- everything at random

// One long day of a vehicle: commands of several sources, good and bad, heartbeats that stop,
// failures that come and go. In every frame the command is sound.
template <class T>
class RandomDay {
 public:
  explicit RandomDay(std::uint64_t seed) : dice_(seed), w_(fresh<T>()), faults_(faults<T>()) {}

  void frame() {
    const TimeNs dt = w_->period_ns_;
    if (dice_.every(4, dt)) go_on();
    if (dice_.every(2, dt)) put(any_request());
    if (dice_.every(60, dt)) put(stop());
    if (dice_.every(10, dt)) w_->heartbeat_ = dice_.below(4) != 0;
    if (dice_.every(25, dt)) faults_[dice_.below(faults_.size())].cause(*w_);
    if (dice_.every(15, dt)) heal();
    step();
    moved_ += T::moves(*w_) ? 1 : 0;
  }
  // Until the last command has ended.
  void finish() {
    put(stop());
    step();
    heal();
    for (int i = 0; i < 30 * kSecond / w_->period_ns_; ++i) step();
    for (const auto& [sequence, final_answers] : final_)
      EXPECT_EQ(final_answers, 1) << "of request " << sequence;
  }
  int moved() const { return moved_; }
  int answered() const { return static_cast<int>(final_.size()); }

 private:
  void put(Request r) {
    // Another thread answers a save.
    if (r.kind == static_cast<std::uint16_t>(CommandKind::save_parameters)) return;
    w_->acks.clear();
    const std::uint64_t sequence = w_->put(r);
    final_[sequence] = 0;
    dry_[sequence] = (r.flags & kFlagDryRun) != 0;
    count();
  }
  void step() {
    w_->acks.clear();
    w_->step();
    count();
    ASSERT_TRUE(sound<T>(*w_));
    ASSERT_EQ(w_->supervisor_.state().safe_commands, 0u) << "the gate had something to do";
    ASSERT_EQ(w_->supervisor_.outbox().dropped, 0u);
  }
  void count() {
    for (const Ack& ack : w_->acks) {
      const bool ended = ack.phase == Phase::rejected || ack.phase == Phase::completed ||
                         ack.phase == Phase::failed || ack.phase == Phase::superseded;
      if (ended || (dry_[ack.sequence] && ack.phase == Phase::accepted)) ++final_[ack.sequence];
    }
    w_->acks.clear();
  }
  // What brings it on its way from here.
  void go_on() {
    if (w_->state() == State::fatal_error) {
      if (dice_.below(3) != 0) heal();
      Request solve{.source = source("test"),
                    .kind = static_cast<std::uint16_t>(CommandKind::solve)};
      put(solve);
    } else if (w_->state() == State::idle) {
      w_->heartbeat_ = true;
      put(request_of(*T::logic().command(1)));
    } else {
      put({.source = source("test"),
           .kind = T::kMotion.kind,
           .lease_ms = 1000,
           .parameter = T::kMotion.parameter});
    }
  }
  Request any_request() {
    constexpr const char* kSources[] = {"test", "test", "other", "third"};
    const CommandInfo& info = commands_[dice_.below(commands_.size())];
    Request r = request_of(info, kSources[dice_.below(4)]);
    if (info.kind == static_cast<std::uint16_t>(CommandKind::emergency_stop)) r.kind = 6;
    for (std::size_t i = 0; i < info.parameters.size(); ++i) {
      const ParameterInfo& p = info.parameters[i];
      const double value = dice_.between(p.min, p.max);
      r.parameter[i] = p.is_whole() ? std::floor(value) : value;
    }
    if (dice_.below(10) == 0) r.parameter[dice_.below(kMaxParameters)] = kNaN;
    if (dice_.below(10) == 0) r.kind = static_cast<std::uint16_t>(dice_.below(400) + 7);
    if (dice_.below(5) == 0) r.flags = static_cast<std::uint16_t>(dice_.below(4));
    r.lease_ms = 100 + dice_.below(3000);
    return r;
  }
  Request stop() const {
    return {.source = source("anyone"),
            .kind = static_cast<std::uint16_t>(CommandKind::emergency_stop)};
  }
  void heal() {
    w_->alter = nullptr;
    for (const auto& fault : faults_) {
      if (fault.heal) fault.heal(*w_);
    }
  }

  Dice dice_;
  WorldPtr<T> w_;
  std::vector<Fault<WorldOf<T>>> faults_;
  std::vector<CommandInfo> commands_ = commands<T>();
  std::map<std::uint64_t, int> final_;
  std::map<std::uint64_t, bool> dry_;
  int moved_ = 0;
};

// [Oper-1] [Env-2]
TYPED_TEST_P(SafetyInputs, OnAnyDayEveryCommandIsSoundAndEveryRequestAnsweredOnce) {
  using T = TypeParam;
  int moved = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomDay<T> day(seed);
    for (int i = 0; i < 6000; ++i) {
      day.frame();
      if (this->HasFatalFailure()) return;
    }
    day.finish();
    moved += day.moved();
    EXPECT_GT(day.answered(), 50);
  }
  EXPECT_GT(moved, 100) << "frames in which it moved";
}

REGISTER_TYPED_TEST_SUITE_P(SafetyInputs, ACommandWithANumberThatMakesNoSenseIsRefusedWithTheReason,
                            ACommandThatIsNoneIsRefusedWithTheReason,
                            SamplesThatAreNoNumbersNeverGiveACommandThatIsNone,
                            RandomSamplesNeverGiveACommandThatIsNone,
                            OnAnyDayEveryCommandIsSoundAndEveryRequestAnsweredOnce);

}  // namespace lss::safety
