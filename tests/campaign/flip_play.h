#pragma once

// The flips of flips.h on a World of play.h: one run goes through the scenario; at each drawn
// moment a copy of it has one bit flipped and goes on to the end alone.

#include <algorithm>
#include <vector>

#include "tests/campaign/dice.h"
#include "tests/campaign/flips.h"
#include "tests/campaign/rules.h"

namespace lss::campaign {

template <class World>
class Flips {
 public:
  explicit Flips(const FlipPlan& plan) : plan_(plan) {}

  FlipCounts play() {
    while (done_ < plan_.flips) scenario(plan_.seed * 10'000 + ++counts_.scenarios);
    return counts_;
  }

 private:
  static constexpr unsigned kOfAScenario = 500;
  static constexpr double kSlice_s = 0.01;  // shorter than every frame
  static constexpr std::size_t kFlipped = World::kFlips_s / kSlice_s;
  static constexpr std::size_t kSlices = (World::kFlips_s + World::kAfter_s) / kSlice_s;
  static constexpr double kDetection_s = 1;
  static constexpr unsigned kCpu_s = 20;
  static constexpr double kProgramShare = 0.2;

  // What came out by the end of a slice.
  struct Slice {
    std::uint64_t sent = 0, alarms = 0, memory = 0;
  };
  struct Flip {
    std::size_t slice = 0;
    double share = 0;  // of the slice
    const FlipPart* part = nullptr;
    std::uint64_t bit = 0;
  };
  struct Live {
    explicit Live(unsigned seed, bool protect) : dice(seed), world(seed, dice) {
      world.chain.protect(protect);
      world.chain.on_master = [this](const CanFrame& frame, TimeNs now) {
        world.sent_.add(now, frame.id, frame.remote, frame.size, frame.data);
      };
    }
    Dice dice;
    World world;
    std::size_t at = 0;  // slices passed

    void pass(double from_share, double to_share) {
      world.chain.run((to_share - from_share) * kSlice_s);
    }
    Slice end_slice() {
      if (++at == kFlipped) world.end_flips();
      return {world.sent(), alarms()};
    }
    std::uint64_t alarms() const {
      return static_cast<std::uint64_t>(std::ranges::count_if(
          world.chain.events,
          [](const EventRecord& event) { return event.severity != Severity::info; }));
    }
  };

  void scenario(unsigned seed) {
    Live live(seed, plan_.protect);
    if (!live.world.begin_flips(live.dice)) return;
    parts_.clear();
    all_parts_.clear();
    counts_.bytes.clear();
    for (const auto& [name, bytes] : live.world.chain.memory()) {
      all_parts_.push_back({name, bytes});
      if (!plan_.part.empty() && plan_.part != name) continue;
      parts_.push_back({name, bytes});
      counts_.bytes[name] += bytes.size();
    }
    const std::vector<std::uint64_t> told = told_by_a_copy([&] {
      std::vector<std::uint64_t> all;
      while (live.at < kSlices) {
        live.pass(0, 1);
        const Slice slice = live.end_slice();
        all.insert(all.end(), {slice.sent, slice.alarms, memory()});
      }
      return all;
    });
    reference_.clear();
    for (std::size_t i = 0; i < told.size(); i += 3)
      reference_.push_back({told[i], told[i + 1], told[i + 2]});

    std::vector<Flip> flips = draw(live.dice);
    std::size_t next = 0;
    while (live.at < kFlipped && next < flips.size()) {
      double share = 0;
      for (; next < flips.size() && flips[next].slice == live.at; ++next) {
        live.pass(share, flips[next].share);
        share = flips[next].share;
        count(flips[next], in_a_copy([&] { return hit(live, flips[next]); }, kCpu_s), live);
      }
      live.pass(share, 1);
      live.end_slice();
    }
  }

  std::uint64_t memory() const {
    std::uint64_t all = 0;
    for (const FlipPart& part : all_parts_) all = digest(all, part.bytes);
    return all;
  }

  std::vector<Flip> draw(Dice& dice) {
    std::vector<Flip> flips(std::min(kOfAScenario, plan_.flips - done_));
    done_ += static_cast<unsigned>(flips.size());
    for (Flip& flip : flips) {
      flip.slice = static_cast<std::size_t>(dice.whole(0, static_cast<int>(kFlipped) - 1));
      flip.share = dice.between(0, 1);
      const auto& parts =
          plan_.part.empty() && dice.chance(kProgramShare) ? program_parts() : parts_;
      std::uint64_t bytes = 0;
      for (const FlipPart& part : parts) bytes += part.bytes.size();
      auto byte = static_cast<std::uint64_t>(dice.between(0, static_cast<double>(bytes)));
      flip.part = &parts.front();
      while (byte >= flip.part->bytes.size()) byte -= (flip.part++)->bytes.size();
      flip.bit = 8 * byte + static_cast<std::uint64_t>(dice.whole(0, 7));
    }
    std::ranges::sort(flips, {},
                      [](const Flip& f) { return static_cast<double>(f.slice) + f.share; });
    return flips;
  }

  FlipResult hit(Live& live, const Flip& flip) {
    Rules<World> rules;
    bool broken = false;
    const auto look = [&] { rules.look(live.world, [&](const std::string&) { broken = true; }); };
    look();
    campaign::flip(flip.part->bytes, flip.bit);
    std::size_t other = kSlices, alarm = kSlices;
    std::size_t compare = live.at + 2;
    for (double share = flip.share; live.at < kSlices && !broken; share = 0) {
      live.pass(share, 1);
      const Slice slice = live.end_slice();
      look();
      const Slice& expected = reference_[live.at - 1];
      if (slice.sent != expected.sent) other = std::min(other, live.at);
      if (slice.alarms > expected.alarms) alarm = std::min(alarm, live.at);
      if (live.at < compare || flip.part->program) continue;
      // Nothing is left of it, and nothing can come any more.
      if (memory() == expected.memory && slice.sent == expected.sent) break;
      compare = live.at + 50;
    }
    if (broken) return {FlipOutcome::unsafe};
    if (other == kSlices) return {alarm == kSlices ? FlipOutcome::none : FlipOutcome::corrected};
    const double detected_s = (static_cast<double>(alarm) - static_cast<double>(other)) * kSlice_s;
    if (alarm == kSlices || detected_s > kDetection_s) return {FlipOutcome::silent};
    return {FlipOutcome::safe, std::max(detected_s, 0.0)};
  }

  void count(const Flip& flip, const FlipResult& result, Live& live) {
    const auto outcome = static_cast<std::size_t>(result.outcome);
    const FlipPart& part = *flip.part;
    const std::string where = part.program ? "program" : part.name;
    ++counts_.parts[where][outcome];
    ++(part.program ? counts_.program : counts_.state)[outcome];
    counts_.slowest_detection_s = std::max(counts_.slowest_detection_s, result.detected_s);
    counts_.simulated_s += static_cast<double>(kSlices - live.at) * kSlice_s;
    if (result.outcome == FlipOutcome::none) return;
    const std::uint64_t byte = flip.bit / 8;
    ++counts_
          .places[part.program ? part.name
                               : live.world.chain.member_at(part.name, &part.bytes[byte])][outcome];
  }

  FlipPlan plan_;
  unsigned done_ = 0;
  std::vector<FlipPart> parts_, all_parts_;  // of the running scenario: to be hit, and all
  std::vector<Slice> reference_;
  FlipCounts counts_;
};

}  // namespace lss::campaign
