#pragma once

// A scenario of tests/campaign/campaign.h, played with a vehicle. World has:
//
//   using Chain, Vehicle;                     of tests/NAME/chain and of the daemon
//   static constexpr double kRest_s, kCutRest_s;  from leaving Operational to standstill; when its
//   bus is
//                                             cut, so that the vehicle's own watchdogs stop it
//   static constexpr kNotHere                 types of faults that the chain lacks
//   bool cut()                                it is
//   World(unsigned seed, Dice&)               with the member `chain`
//   bool begin(Dice&)                         from Idle to where the faults hit
//   bool start()                              from Idle to Operational
//   bool moves() const                        an order moves the vehicle
//   bool may_move() const                     one may be moved outside Operational: by error
//                                             solving, or by a command of Idle
//   bool sound() const                        orders are numbers in their ranges
//   bool rests() const                        the vehicle does nothing
//   std::string motion() const                its motion, for a person
//   std::string outcome() const               how it stands, when a vehicle can end otherwise
//   bool can_start() const                    as it stands; a hopper on its side cannot
//   static std::span<const CommandInfo> commands()
//
// and for flip_play.h:
//
//   static constexpr double kFlips_s, kAfter_s  flips hit in the first; the second is for the stop
//   bool begin_flips(Dice&)                   from Idle into motion
//   void end_flips()                          commands the stop, when it does not stop by itself
//   Sent sent_                                what came on the bus
//   std::uint64_t sent()                      its digest

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <map>
#include <string_view>

#include "tests/campaign/campaign.h"
#include "tests/campaign/dice.h"
#include "tests/campaign/flip_play.h"
#include "tests/campaign/rules.h"
#include "tests/support/tape.h"

namespace lss::campaign {

template <class World>
class Scenario {
 public:
  explicit Scenario(unsigned number) : Scenario(number, Dice(number)) {}
  Scenario(unsigned number, Dice dice) : dice_(std::move(dice)), world_(number, dice_) {
    run_.number = number;
    for (const sim::FaultKind& kind : chain().fault_kinds())
      if (!std::ranges::count(World::kNotHere, std::string_view(kind.name))) kinds_.push_back(kind);
  }

  Scenario& record_to(const std::filesystem::path& folder) {
    chain().tape = testing_support::tape<typename World::Vehicle>(folder, chain().config());
    return *this;
  }

  Scenario& tell(const std::function<void(std::uint64_t)>& seen) {
    seen_ = seen;
    return *this;
  }

  Run play() {
    try {
      if (!world_.begin(dice_)) {
        broke("without any fault it does not begin");
      } else {
        hit();
        repair();
      }
      look_at_acks();
    } catch (const std::exception& error) {
      broke(fmt::format("threw: {}", error.what()));
    }
    run_.stops = rules_.stops;
    run_.slowest_rest_s = rules_.slowest_rest_s;
    run_.slowest_cut_rest_s = rules_.slowest_cut_rest_s;
    run_.simulated_s = chain().seconds();
    run_.frames = chain().frames();
    run_.cycles = chain().cycles();
    return run_;
  }

 private:
  static constexpr double kRepaired_s = 300;  // motors cool, fans stop, a hopper comes down
  static constexpr int kSolves = 8;
  static constexpr double kOnTheWay_s = 11;  // delayed messages, by 10 s at most, arrive until then

  struct Deed {
    double at_s;
    enum { attach, clear, command, leave, come_back } what;
    std::string fault{};
  };

  auto& chain() { return world_.chain; }
  double seconds() { return chain().seconds() - begin_s_; }
  bool operational() { return chain().state() == State::operational; }

  void say(const std::string& what) {
    run_.story.push_back(fmt::format("{:.3f} s: {}", chain().seconds(), what));
  }
  void broke(const std::string& what) {
    if (!run_.broken.empty() && run_.broken.size() >= 5) return;
    run_.broken.push_back(fmt::format("{:.3f} s: {}", chain().seconds(), what));
  }

  // Frame by frame.
  template <class Condition>
  bool pass_until(Condition condition, double limit_s) {
    return chain().run_until(
        [&] {
          look();
          return condition();
        },
        limit_s);
  }
  void pass(double time_s) {
    if (time_s > 0) pass_until([] { return false; }, time_s);
  }

  // What a search distinguishes.
  std::uint64_t situation() {
    std::uint64_t hash = 0;
    const auto mix = [&hash](std::uint64_t part) {
      hash = (hash ^ part) * 0x9E37'79B9'7F4A'7C15u;
      hash ^= hash >> 29;
    };
    const SupervisorState& s = chain().supervisor();
    mix(static_cast<std::uint64_t>(s.controller.state));
    mix(static_cast<std::uint64_t>(s.controller.mode));
    for (const auto modules : {s.controller.silent, s.controller.unheard, s.controller.isolated})
      mix(modules);
    mix(s.active.kind);
    for (const FaultRecord& fault : s.faults) {
      mix(static_cast<std::uint64_t>(fault.id));
      mix(fault.subject);
    }
    return hash;
  }

  void look() {
    if (seen_) seen_(situation());
    rules_.look(world_, [this](const std::string& what) { broke(what); });
  }

  std::vector<Deed> plan() {
    std::vector<Deed> deeds;
    const double length_s = dice_.between(8, 25);
    for (int faults = dice_.whole(1, 3); faults > 0; --faults) {
      const double at_s = dice_.between(0, length_s);
      const std::string fault = draw_fault(dice_, kinds_);
      deeds.push_back({at_s, Deed::attach, fault});
      if (dice_.chance(0.5)) deeds.push_back({at_s + dice_.between(0.05, 8), Deed::clear, fault});
    }
    for (int commands = dice_.whole(0, 6); commands > 0; --commands)
      deeds.push_back({dice_.between(0, length_s), Deed::command});
    if (dice_.chance(0.2)) {
      const double at_s = dice_.between(0, length_s);
      deeds.push_back({at_s, Deed::leave});
      deeds.push_back({at_s + dice_.between(0.5, 15), Deed::come_back});
    }
    std::ranges::stable_sort(deeds, {}, &Deed::at_s);
    return deeds;
  }

  void send(std::uint16_t kind, std::span<const double> parameters) {
    last_sequence_ = chain().send(kind, parameters);
    ++run_.commands;
  }

  void hit() {
    begin_s_ = chain().seconds();
    for (const Deed& deed : plan()) {
      pass(deed.at_s - seconds());
      switch (deed.what) {
        case Deed::attach:
          say(deed.fault);
          chain().inject(deed.fault);
          ++run_.faults;
          break;
        case Deed::clear:
          say("clear:" + deed.fault.substr(0, deed.fault.find(':')));
          chain().inject("clear:" + deed.fault.substr(0, deed.fault.find(':')));
          break;
        case Deed::command: any_command(); break;
        case Deed::leave:
        case Deed::come_back:
          say(deed.what == Deed::leave ? "the operator is gone" : "the operator is back");
          chain().heartbeat(deed.what == Deed::come_back);
          break;
      }
    }
    pass(dice_.between(0, 5));
  }

  void any_command() {
    const bool common = dice_.chance(0.3);
    // Not those of parameters: with limits of any size a vehicle need not come back to Idle.
    const auto of_state = std::span(kCommonCommands).first(std::size(kCommonCommands) - 2);
    const CommandInfo& command = common ? dice_.one_of(of_state) : dice_.one_of(World::commands());
    const std::vector<double> parameters = draw_parameters(dice_, command);
    say(fmt::format("{} {:.4g}", command.name, fmt::join(parameters, " ")));
    send(command.kind, parameters);
  }

  void repair() {
    say(fmt::format("repaired, in {}", kStateNames[static_cast<std::size_t>(chain().state())]));
    chain().inject("clear");
    chain().heartbeat(true);
    pass(kOnTheWay_s);
    const double repaired_s = chain().seconds();
    const double give_up_s = repaired_s + kRepaired_s;
    const auto left_s = [&] { return give_up_s - chain().seconds(); };
    const auto comes_to_idle = [&] {
      for (int solves = 0; left_s() > 0; ++solves) {
        if (operational()) send(static_cast<std::uint16_t>(CommandKind::stop), {});
        pass_until([&] { return !operational() && chain().state() != State::solve_errors; },
                   left_s());
        if (chain().state() == State::idle || solves == kSolves) break;
        send(static_cast<std::uint16_t>(CommandKind::solve), {});
        pass(2);
      }
      return chain().state() == State::idle;
    };
    const bool idle = comes_to_idle();
    run_.slowest_idle_s = chain().seconds() - repaired_s;
    if (!idle) return broke("repaired, it does not come back to Idle: " + faults());
    send(static_cast<std::uint16_t>(CommandKind::restore), {});
    pass(World::kRest_s + 1);
    // What is not well yet, as a motor that is still hot, says so and is taken out of service
    // again.
    if (!comes_to_idle()) return broke("restored, it does not come back to Idle: " + faults());
    if constexpr (requires { world_.outcome(); }) {
      run_.outcome = world_.outcome();
      say(run_.outcome);
      if (!world_.can_start()) return;
    }
    say("starts again");
    if (!world_.start()) return broke("repaired and in Idle, it does not start again: " + faults());
    send(static_cast<std::uint16_t>(CommandKind::stop), {});
    if (!pass_until([&] { return chain().state() == State::idle; }, 60))
      broke("started again, it does not stop");
    pass(2);
  }

  std::string faults() {
    std::string text = kStateNames[static_cast<std::size_t>(chain().state())];
    const auto& s = chain().supervisor();
    const auto& modules = s.controller;
    if (modules.silent != 0) text += fmt::format(", silent {:#x}", modules.silent);
    if (modules.unheard != 0) text += fmt::format(", unheard {:#x}", modules.unheard);
    if (modules.isolated != 0) text += fmt::format(", isolated {:#x}", modules.isolated);
    for (const FaultRecord& fault : s.faults) {
      if (fault.id != FaultId::none)
        text += fmt::format(", {} {}", info(fault.id)->name, fault.subject);
    }
    if (!chain().acks.empty() && chain().acks.back().phase == Phase::rejected)
      text += fmt::format(", rejected: {}", info(chain().acks.back().verdict.reason)->name);
    return text;
  }

  // Each command that was sent has an end, one.
  void look_at_acks() {
    std::map<std::uint64_t, int> ends;
    for (const Ack& ack : chain().acks) {
      if (ack.phase == Phase::accepted || ack.phase == Phase::executing) continue;
      ++ends[ack.sequence];
      run_.rejected += ack.phase == Phase::rejected ? 1u : 0u;
    }
    for (std::uint64_t i = 1; i <= last_sequence_; ++i) {
      if (ends[i] != 1) broke(fmt::format("command {} was ended {} times", i, ends[i]));
    }
  }

  Dice dice_;
  World world_;
  Rules<World> rules_;
  std::vector<sim::FaultKind> kinds_;
  Run run_;
  double begin_s_ = 0;
  std::uint64_t last_sequence_ = 0;
  std::function<void(std::uint64_t)> seen_;
};

template <class World>
Subject subject_of(const char* vehicle, const char* begin, const char* at_rest) {
  return {vehicle,
          begin,
          World::kRest_s,
          World::kCutRest_s,
          at_rest,
          [](unsigned number) { return Scenario<World>(number).play(); },
          [](std::span<const std::uint8_t> script, const std::function<void(std::uint64_t)>& seen) {
            return Scenario<World>(1, Dice(script)).tell(seen).play();
          },
          [](unsigned number, const std::filesystem::path& folder) {
            return Scenario<World>(number).record_to(folder).play();
          },
          [](const FlipPlan& plan) { return Flips<World>(plan).play(); }};
}

}  // namespace lss::campaign
