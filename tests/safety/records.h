#pragma once

// Safety suite: frames that were recorded are executed again to the bit, and the cycle allocates
// nothing. See safety_suite.h.

#include <span>

#include "daemon/replay/replay.h"
#include "scene.h"

namespace lss::safety {

template <class T>
class SafetyRecords : public testing::Test {};
TYPED_TEST_SUITE_P(SafetyRecords);

using Bytes = std::vector<std::uint8_t>;

// Every frame of a world from now on, as the daemon writes it, and its stored state between two of
// them.
template <class World>
class Recording {
 public:
  using Vehicle = typename World::Vehicle;
  using Replay = record::VehicleReplay<Vehicle>;

  explicit Recording(World& world) : world_(world) {
    world_.executed = [this] { keep_frame(); };
  }
  ~Recording() { world_.executed = nullptr; }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  const std::vector<Bytes>& frames() const { return frames_; }
  std::size_t middle() const { return middle_; }

  // The state of now.
  void remember() {
    state_.resize(sizeof(Vehicle) + sizeof(Supervisor) + sizeof(typename Vehicle::Telemetry));
    record::StateWriter writer(state_);
    record::keep(writer, world_.vehicle_, world_.supervisor_, world_.out_.telemetry);
    ASSERT_TRUE(writer.fits());
    state_.resize(writer.size());
    middle_ = frames_.size();
  }

  template <class P>
  void expect_replayed(const P& parameters, const Logic& logic) const {
    Replay from_start(parameters, logic, 30 * kSecond);
    expect_equal(from_start, frames_);
    ASSERT_FALSE(state_.empty());
    ASSERT_LT(middle_, frames_.size());
    Replay from_middle(parameters, logic, 30 * kSecond);
    ASSERT_TRUE(from_middle.restore(state_));
    expect_equal(from_middle, std::span(frames_).subspan(middle_));
  }
  // Whether something comes out differently, with other parameters or other frames.
  template <class P>
  static bool differs(const P& parameters, const Logic& logic, std::span<const Bytes> frames) {
    Replay replay(parameters, logic, 30 * kSecond);
    return std::ranges::any_of(
        frames, [&](const Bytes& frame) { return replay.step(frame).difference.has_value(); });
  }
  template <class P>
  bool differs_with(const P& parameters, const Logic& logic) const {
    return differs(parameters, logic, frames_);
  }

 private:
  void keep_frame() {
    Bytes bytes(sizeof(record::FrameRecord<Vehicle>));
    record::Writer writer(bytes);
    const TimingPoints timing{};
    fields(writer,
           record::FrameView<Vehicle>{world_.in_, world_.out_.command, world_.supervisor_.outbox(),
                                      world_.supervisor_.state(), world_.out_.telemetry,
                                      world_.out_.data_requested, timing});
    ASSERT_TRUE(writer.fits());
    bytes.resize(writer.size());
    frames_.push_back(std::move(bytes));
  }
  static void expect_equal(Replay& replay, std::span<const Bytes> frames) {
    for (const Bytes& frame : frames) {
      const record::Replay::Frame result = replay.step(frame);
      ASSERT_FALSE(result.difference)
          << "frame " << result.frame << ": " << result.difference->field << " was "
          << result.difference->recorded << ", is " << result.difference->computed;
    }
  }

  World& world_;
  std::vector<Bytes> frames_;
  Bytes state_;
  std::size_t middle_ = 0;
};

// Motion, a fault, a rescue, and motion again.
template <class T>
testing::AssertionResult eventful_run(WorldOf<T>& w, Recording<WorldOf<T>>* recording = nullptr) {
  if (const auto result = comes_to_motion<T>(w); !result) return result;
  if (recording != nullptr) recording->remember();
  w.run(2);
  const auto fault = T::faults().front();
  fault.cause(w);
  w.run(3);
  w.alter = nullptr;
  if (fault.heal) fault.heal(w);
  if (const auto result = is_solved<T>(w); !result) return result;
  return comes_to_motion<T>(w);
}

TYPED_TEST_P(SafetyRecords, ARunIsExecutedAgainToTheBitAlsoFromTheMiddle) {
  using T = TypeParam;
  const auto w = fresh<T>();
  Recording recording(*w);
  ASSERT_TRUE(eventful_run<T>(*w, &recording));
  recording.expect_replayed(T::parameters(), T::logic());
}

// [Prod-1]
TYPED_TEST_P(SafetyRecords, TheSameInputsGiveTheSameBitsEverywhere) {
  using T = TypeParam;
  for (const auto& place : places<T>()) {
    SCOPED_TRACE(place.name);
    const auto a = fresh<T>(), b = fresh<T>();
    Recording first(*a), second(*b);
    ASSERT_TRUE(go_to<T>(*a, place));
    ASSERT_TRUE(go_to<T>(*b, place));
    a->run(10);
    b->run(10);
    EXPECT_TRUE(first.frames() == second.frames());
  }
}

// A bit of the inputs that changed later: the replay notices it, or it has no effect; and always
// the same.
TYPED_TEST_P(SafetyRecords, AChangedBitIsNoticedOrHasNoEffectAlwaysTheSame) {
  using T = TypeParam;
  using World = WorldOf<T>;
  const auto w = fresh<T>();
  Recording recording(*w);
  ASSERT_TRUE(comes_to_motion<T>(*w));
  w->run(1);
  Dice dice(3);
  int noticed = 0;
  constexpr int kTries = 200;
  for (int i = 0; i < kTries; ++i) {
    std::vector<Bytes> frames = recording.frames();
    Bytes& frame = frames[frames.size() - 1 - dice.below(frames.size() / 4)];
    frame[dice.below(frame.size() / 4)] ^= static_cast<std::uint8_t>(1u << dice.below(8));
    const bool differs = Recording<World>::differs(T::parameters(), T::logic(), frames);
    EXPECT_EQ(Recording<World>::differs(T::parameters(), T::logic(), frames), differs);
    noticed += differs ? 1 : 0;
  }
  EXPECT_GT(noticed, 0);
}

// A changed output cannot be explained by its inputs.
TYPED_TEST_P(SafetyRecords, AChangedBitOfAnOutputIsAlwaysNoticed) {
  using T = TypeParam;
  using World = WorldOf<T>;
  const auto w = fresh<T>();
  Recording recording(*w);
  w->run(1);
  const TimingPoints none;
  record::Writer timing(std::span<std::uint8_t>{});
  record::visit(timing, none);
  const auto outputs = [&](const Bytes& frame) {
    auto read = std::make_unique<record::FrameRecord<typename World::Vehicle>>();
    record::Reader reader(frame);
    fields(reader, read->in);
    return reader.at();
  };
  Dice dice(4);
  for (int i = 0; i < 100; ++i) {
    std::vector<Bytes> frames = recording.frames();
    Bytes& frame = frames.back();
    const std::size_t begin = outputs(frame), end = frame.size() - timing.size();
    frame[begin + dice.below(end - begin)] ^= static_cast<std::uint8_t>(1u << dice.below(8));
    EXPECT_TRUE(Recording<World>::differs(T::parameters(), T::logic(), frames));
  }
}

TYPED_TEST_P(SafetyRecords, WhatIsWrittenIsReadBack) {
  using T = TypeParam;
  using Frame = record::FrameRecord<typename WorldOf<T>::Vehicle>;
  const auto w = fresh<T>();
  Recording recording(*w);
  ASSERT_TRUE(comes_to_motion<T>(*w));
  for (const Bytes& bytes : recording.frames()) {
    auto read = std::make_unique<Frame>();
    record::Reader reader(bytes);
    fields(reader, *read);
    ASSERT_TRUE(reader.good() && reader.at_end());
    Bytes again(sizeof(Frame));
    record::Writer writer(again);
    fields(writer, *read);
    ASSERT_TRUE(writer.fits());
    again.resize(writer.size());
    ASSERT_EQ(again, bytes);
  }
}

TYPED_TEST_P(SafetyRecords, BrokenBytesAreNoRecordAndNothingWorse) {
  using T = TypeParam;
  using Frame = record::FrameRecord<typename WorldOf<T>::Vehicle>;
  const auto w = fresh<T>();
  Recording recording(*w);
  w->run(1);
  Dice dice(5);
  auto read = std::make_unique<Frame>();
  int broken = 0;
  for (int i = 0; i < 300; ++i) {
    Bytes bytes = recording.frames().back();
    bytes.resize(dice.below(bytes.size()));
    for (int k = 0; k < 10 && !bytes.empty(); ++k)
      bytes[dice.below(bytes.size())] = static_cast<std::uint8_t>(dice.bits());
    record::Reader reader(bytes);
    fields(reader, *read);
    ASSERT_TRUE(!reader.good() || reader.at_end());
    ASSERT_LE(read->in.sample_count, read->in.samples.size());
    broken += reader.good() ? 0 : 1;
  }
  EXPECT_GT(broken, 250) << "it is too short";
}

TYPED_TEST_P(SafetyRecords, TheCycleAllocatesNothing) {
  using T = TypeParam;
  using Vehicle = typename WorldOf<T>::Vehicle;
  for (const auto& place : places<T>()) {
    SCOPED_TRACE(place.name);
    const auto w = fresh<T>();
    std::vector<Inputs<Vehicle>> inputs;
    w->executed = [&] { inputs.push_back(w->in_); };
    ASSERT_TRUE(go_to<T>(*w, place));
    w->run(20);
    auto vehicle = std::make_unique<Vehicle>(T::parameters());
    Supervisor supervisor(T::logic(), {});
    auto out = std::make_unique<Outputs<Vehicle>>();
    const std::uint64_t before = T::allocations();
    for (const auto& in : inputs) cycle(*vehicle, supervisor, in, *out, [](Stage) {});
    EXPECT_EQ(T::allocations(), before);
    EXPECT_EQ(supervisor.controller(), w->supervisor_.controller()) << "it is the same run";
  }
}

REGISTER_TYPED_TEST_SUITE_P(SafetyRecords, ARunIsExecutedAgainToTheBitAlsoFromTheMiddle,
                            TheSameInputsGiveTheSameBitsEverywhere,
                            AChangedBitIsNoticedOrHasNoEffectAlwaysTheSame,
                            AChangedBitOfAnOutputIsAlwaysNoticed, WhatIsWrittenIsReadBack,
                            BrokenBytesAreNoRecordAndNothingWorse, TheCycleAllocatesNothing);

}  // namespace lss::safety
