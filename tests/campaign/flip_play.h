#pragma once

// The flips of flips.h on a World of play.h: one run goes through the scenario; at each drawn
// moment a copy of it has one bit flipped, at once or in a thread's work that follows, and goes on
// to the end alone. Where soon nothing differs but that bit itself, it waits for somebody who reads
// it, mostly in vain: of such flips some go on to the end together, each from its own moment. When
// anything comes of that, each of them goes on alone.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
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
  static constexpr unsigned kOfAScenario = 2000;
  static constexpr int kGrid_ms = 10;  // shorter than every frame
  static constexpr double kDetection_s = 1, kAll_s = World::kFlips_s + World::kAfter_s;
  static constexpr double kNever_s = 1e9;
  static constexpr unsigned kCpu_s = 20, kCpuOfThreads_s = 60;
  static constexpr double kProgramShare = 0.2;
  static constexpr double kWaits_s = 0.25;  // after so long it counts as waiting
  static constexpr std::size_t kTogether = 16;
  // Of the buses so many follow a moment, which is some turns; of the frame all of one period do.
  static constexpr Instructions kMost = {20'000'000, 20'000};

  // The run ends a pass at each flip and at each step of a grid, the same with and without a flip:
  // a pass that ends elsewhere may shift a turn of a bus by a nanosecond. What came out by then:
  struct Slice {
    std::uint64_t sent = 0, alarms = 0, memory = 0, series = 0;
  };
  using Bytes = std::span<std::uint8_t>;
  struct Flip {
    double at_s = 0;
    const FlipPart* part = nullptr;
    std::uint64_t bit = 0;
    std::optional<Hit> hit{};  // of a thread: instead of `bit`
  };
  struct Waiting {
    Flip flip;
    std::size_t part;  // of parts_
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
    std::size_t at = 0;  // ends of passes, so far
    double now_s = 0;

    Slice pass(const std::vector<double>& ends_s) {
      const double end_s = ends_s[at++];
      world.chain.run(end_s - now_s);
      now_s = end_s;
      if (end_s == World::kFlips_s) world.end_flips();
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
    list_parts(live);
    const std::vector<Flip> flips = draw(live.dice);
    ends_s_.clear();
    for (const Flip& flip : flips) ends_s_.push_back(flip.at_s);
    for (int ms = kGrid_ms; ms <= kAll_s * 1000; ms += kGrid_ms) ends_s_.push_back(ms / 1000.0);
    std::ranges::sort(ends_s_);

    const std::vector<std::uint64_t> told = told_by_a_copy([&] {
      std::vector<std::uint64_t> all;
      while (live.at < ends_s_.size()) {
        const Slice slice = live.pass(ends_s_);
        all.insert(all.end(), {slice.sent, slice.alarms, memory(), series()});
      }
      return all;
    });
    reference_.clear();
    for (std::size_t i = 0; i < told.size(); i += 4)
      reference_.push_back({told[i], told[i + 1], told[i + 2], told[i + 3]});

    std::vector<Waiting> waiting;
    for (const Flip& flip : flips) {
      while (live.now_s < flip.at_s) live.pass(ends_s_);
      const FlipResult result = in_a_copy([&] { return play_on(live, flip, kWaits_s); },
                                          flip.hit ? kCpuOfThreads_s : kCpu_s);
      if (flip.hit && !struck().happened)
        throw std::runtime_error("a thread executed fewer instructions than before");
      if (result.waits) {
        waiting.push_back({flip, static_cast<std::size_t>(flip.part - parts_.data())});
      } else {
        count(flip, result, live);
      }
    }
    if (!waiting.empty()) go_on(seed, waiting);
  }

  // The same scenario again, for flips that wait.
  void go_on(unsigned seed, std::span<Waiting> waiting) {
    Live live(seed, plan_.protect);
    if (!live.world.begin_flips(live.dice))
      throw std::runtime_error("a scenario cannot be repeated");
    list_parts(live);
    for (Waiting& one : waiting) one.flip.part = &parts_.at(one.part);
    for (std::size_t first = 0; first < waiting.size(); first += kTogether) {
      const auto some = waiting.subspan(first, std::min(kTogether, waiting.size() - first));
      while (live.now_s < some.front().flip.at_s) live.pass(ends_s_);
      const bool none =
          in_a_copy([&] { return play_together(live, some); }, kCpu_s).outcome == FlipOutcome::none;
      for (const Waiting& one : some) {
        while (!none && live.now_s < one.flip.at_s) live.pass(ends_s_);
        const auto alone = [&] { return play_on(live, one.flip, kNever_s); };
        count(one.flip, none ? FlipResult{FlipOutcome::none} : in_a_copy(alone, kCpu_s), live);
      }
    }
  }

  // none: nothing on the bus differs and nothing is reported, to the end.
  FlipResult play_together(Live& live, std::span<const Waiting> some) {
    Rules<World> rules;
    bool broken = false;
    while (live.at < ends_s_.size()) {
      for (; !some.empty() && some.front().flip.at_s <= live.now_s; some = some.subspan(1))
        campaign::flip(some.front().flip.part->bytes, some.front().flip.bit);
      const Slice& expected = reference_[live.at];
      const Slice slice = live.pass(ends_s_);
      rules.look(live.world, [&](const std::string&) { broken = true; });
      if (broken || slice.sent != expected.sent || slice.alarms > expected.alarms)
        return {FlipOutcome::silent};
    }
    return {FlipOutcome::none};
  }

  // Of the running scenario: its parts, what is hit of them, and what is compared.
  void list_parts(Live& live) {
    auto& chain = live.world.chain;
    parts_.clear();
    all_parts_.clear();
    counts_.bytes.clear();
    const bool state = plan_.part.empty() || plan_.part == "state";
    const auto list = [&](const auto& given, FlipPart::Kind kind) {
      for (const auto& [name, bytes, what] : given) {
        all_parts_.push_back({name, bytes, kind});
        const bool asked = plan_.part == name || plan_.part == fmt::format("{}: {}", name, what);
        if (!asked && !(state && kind == FlipPart::state)) continue;
        parts_.push_back(all_parts_.back());
        counts_.bytes[name] += bytes.size();
      }
    };
    list(chain.memory(), FlipPart::state);
    list(chain.more_memory(), FlipPart::more);
    drawn_ = plan_.part == "registers" ? all_registers() : register_bits(plan_.part);
    const bool stack = plan_.part == "stack" && all_registers().count != 0;
    if (drawn_.count != 0 || stack) {
      for (const DaemonThread thread : kDaemonThreads)
        parts_.push_back({(stack ? "stack, " : "registers, ") + name_of(thread),
                          {},
                          FlipPart::of_thread,
                          thread});
      counts_.instructions = instructions_of_a_period(live);
    }
    if (parts_.empty()) throw std::invalid_argument(unknown_part());

    reports_ = chain.memory_of_reports();
    std::vector<Bytes> undecisive = reports_;
    if (plan_.protect) undecisive.push_back(chain.second_copies());
    decisive_.clear();
    const bool all = parts_.front().kind != FlipPart::state;
    for (const FlipPart& part : all_parts_)
      if (all || part.kind == FlipPart::state) add_decisive(part.bytes, undecisive);
  }

  static std::string name_of(DaemonThread thread) {
    return kDaemonThreadNames[static_cast<std::size_t>(thread)];
  }

  Instructions instructions_of_a_period(Live& live) {
    const std::vector<std::uint64_t> told = told_by_a_copy([&] {
      auto& chain = live.world.chain;
      // And a little more: a vehicle's own clock may begin its frames.
      const double period_s = 1.02e-9 * static_cast<double>(chain.config().period_ns);
      const Instructions all = count_instructions([&] { chain.run(period_s); }, kMost);
      return std::vector<std::uint64_t>(all.begin(), all.end());
    });
    Instructions all{};
    std::ranges::copy(told, all.begin());
    if (std::ranges::find(all, 0u) != all.end())
      throw std::runtime_error("this computer does not stop after each instruction");
    all[0] += all[0] / 10;  // later frames are a little longer
    return all;
  }

  std::string unknown_part() const {
    std::string names = "state";
    for (const FlipPart& part : all_parts_)
      if (names.find(part.name) == names.npos) names += ", " + part.name;
    if (all_registers().count != 0) names += ", stack, registers, or one of them (rip)";
    return "--part: no \"" + plan_.part + "\" here; there are: " + names;
  }

  // All of these bytes but those of `without`.
  void add_decisive(Bytes bytes, std::span<const Bytes> without) {
    for (const Bytes& hole : without) {
      if (!within(hole.data(), bytes)) continue;
      const auto at = static_cast<std::size_t>(hole.data() - bytes.data());
      add_decisive(bytes.first(at), without);
      add_decisive(bytes.subspan(at + hole.size()), without);
      return;
    }
    if (!bytes.empty()) decisive_.push_back(bytes);
  }
  static bool within(const std::uint8_t* byte, const Bytes& bytes) {
    return !std::less{}(byte, bytes.data()) && std::less{}(byte, bytes.data() + bytes.size());
  }

  // What the orders from now on depend on.
  std::uint64_t memory() const {
    std::uint64_t all = 0;
    for (const Bytes& bytes : decisive_) all = digest(all, bytes);
    return all;
  }

  // Of the supervisor's events: an alarm may wait there.
  std::uint64_t series() const { return digest(0, reports_.front()); }

  std::vector<Flip> draw(Dice& dice) {
    std::vector<Flip> flips(std::min(kOfAScenario, plan_.flips - done_));
    done_ += static_cast<unsigned>(flips.size());
    for (Flip& flip : flips) {
      flip.at_s = dice.between(0, World::kFlips_s);
      if (parts_.front().kind == FlipPart::of_thread) {
        flip.part = &dice.one_of(parts_);
        flip.hit = draw_hit(dice, flip.part->thread);
        continue;
      }
      if (plan_.bit) {
        flip.part = &parts_.front();
        flip.bit = *plan_.bit;
        continue;
      }
      const auto& parts =
          plan_.part.empty() && dice.chance(kProgramShare) ? program_parts() : parts_;
      std::uint64_t bytes = 0;
      for (const FlipPart& part : parts) bytes += part.bytes.size();
      auto byte = static_cast<std::uint64_t>(dice.between(0, static_cast<double>(bytes)));
      flip.part = &parts.front();
      while (byte >= flip.part->bytes.size()) byte -= (flip.part++)->bytes.size();
      flip.bit = 8 * byte + static_cast<std::uint64_t>(dice.whole(0, 7));
    }
    std::ranges::sort(flips, {}, &Flip::at_s);
    return flips;
  }

  Hit draw_hit(Dice& dice, DaemonThread thread) {
    const auto most = static_cast<double>(counts_.instructions[static_cast<std::size_t>(thread)]);
    Hit hit{.thread = thread, .stack = drawn_.count == 0};
    hit.instruction = static_cast<std::uint64_t>(dice.between(0, most));
    const auto bits = static_cast<int>(hit.stack ? 8 : drawn_.count);
    hit.bit = drawn_.first + static_cast<std::uint64_t>(dice.whole(0, bits - 1));
    hit.place = dice.between(0, 1);
    return hit;
  }

  // waits: nothing else has differed for `waits_s`, and only the bit itself does.
  FlipResult play_on(Live& live, const Flip& flip, double waits_s) {
    Rules<World> rules;
    bool broken = false;
    const auto look = [&] { rules.look(live.world, [&](const std::string&) { broken = true; }); };
    look();
    const std::uint64_t modes = processor_modes();
    if (flip.hit) {
      expect(*flip.hit);
    } else {
      campaign::flip(flip.part->bytes, flip.bit);
    }
    const auto in_reports = [&](const Bytes& bytes) {
      return !flip.hit && within(&flip.part->bytes[flip.bit / 8], bytes);
    };
    const bool compares = flip.part->kind != FlipPart::program && !plan_.to_the_end &&
                          std::ranges::none_of(reports_, in_reports);
    double other_s = kNever_s, alarm_s = kNever_s;
    for (unsigned passes = 1; live.at < ends_s_.size() && !broken; ++passes) {
      const Slice& expected = reference_[live.at];
      const Slice slice = live.pass(ends_s_);
      if (flip.hit && !struck().happened) {
        passes = 0;
        continue;
      }
      if (flip.hit) allow_cpu();
      look();
      if (slice.sent != expected.sent) other_s = std::min(other_s, live.now_s);
      if (slice.alarms > expected.alarms) alarm_s = std::min(alarm_s, live.now_s);
      // Nothing is left of it, and nothing can come any more.
      const bool now = std::has_single_bit(passes) || passes % 64 == 0;
      if (!compares || !now || slice.sent != expected.sent ||
          (alarm_s == kNever_s && series() != expected.series) ||
          !live.world.chain.second_copies_agree() || processor_modes() != modes)
        continue;
      if (memory() == expected.memory) break;
      const bool waits = !flip.hit && other_s == kNever_s && alarm_s == kNever_s &&
                         live.now_s - flip.at_s >= waits_s;
      if (waits && with_bit_restored(flip, [&] { return memory() == expected.memory; }))
        return {.outcome = FlipOutcome::none, .waits = true};
    }
    if (broken) return {FlipOutcome::unsafe};
    if (other_s == kNever_s)
      return {alarm_s == kNever_s ? FlipOutcome::none : FlipOutcome::corrected};
    const double detected_s = alarm_s - other_s;
    if (detected_s > kDetection_s) return {FlipOutcome::silent};
    return {FlipOutcome::safe, std::max(detected_s, 0.0)};
  }

  template <class Look>
  static bool with_bit_restored(const Flip& flip, Look&& look) {
    campaign::flip(flip.part->bytes, flip.bit);
    const bool seen = look();
    campaign::flip(flip.part->bytes, flip.bit);
    return seen;
  }

  void count(const Flip& flip, const FlipResult& result, Live& live) {
    const auto outcome = static_cast<std::size_t>(result.outcome);
    const FlipPart& part = *flip.part;
    const bool program = part.kind == FlipPart::program;
    ++counts_.parts[program ? "program" : part.name][outcome];
    if (program) ++counts_.program[outcome];
    if (part.kind == FlipPart::state) ++counts_.state[outcome];
    counts_.slowest_detection_s = std::max(counts_.slowest_detection_s, result.detected_s);
    counts_.simulated_s += kAll_s - live.now_s;
    if (result.hung) ++counts_.hung[program ? "program" : part.name];
    if (result.outcome == FlipOutcome::none) return;
    const auto at = [&](const std::string& place) { ++counts_.places[place][outcome]; };
    if (flip.hit) {
      at(part.name + " in " + function_at(struck().instruction));
      if (!flip.hit->stack) at(part.name + ": " + register_of(flip.hit->bit));
    } else {
      at(program ? part.name : live.world.chain.member_at(part.name, &part.bytes[flip.bit / 8]));
    }
  }

  FlipPlan plan_;
  unsigned done_ = 0;
  std::vector<FlipPart> parts_, all_parts_;  // of the running scenario: to be hit, and all bytes
  RegisterBits drawn_;                       // that are hit
  std::vector<Bytes> reports_, decisive_;    // of all
  std::vector<double> ends_s_;               // of its passes
  std::vector<Slice> reference_;
  FlipCounts counts_;
};

}  // namespace lss::campaign
