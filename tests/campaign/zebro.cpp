// Lunar Zebro in a fault campaign: stands up and walks, on kinematics.

#include <array>
#include <cmath>
#include <string_view>

#include "daemon/vehicles/zebro/modes.h"
#include "daemon/vehicles/zebro/vehicle.h"
#include "tests/campaign/play.h"
#include "tests/zebro/chain/chain.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::campaign {
namespace {

using zebro::ModuleOrder;

struct World {
  using Chain = zebro::Chain;
  using Vehicle = zebro::Vehicle;
  static constexpr std::array<std::string_view, 0> kNotHere{};
  static constexpr double kRest_s = 1;
  static constexpr double kCutRest_s = 8.5;  // a module's watchdog: 8 s (docs/icd-zebro.md)
  static constexpr double kStill_rad_s = 0.05;

  World(unsigned seed, Dice&) : chain({.seed = seed, .plant = sim::zebro::PlantKind::kinematic}) {}

  bool start() {
    // Like an operator: resets tripped modules; a deployed panel forbids to start.
    chain.run_until([this] { return !may_move(); }, 60);
    chain.send(lss::CommandKind::reset, {0});
    chain.run(2);
    chain.send(zebro::CommandKind::panel, {0});
    chain.run_until([this] { return may_move(); }, 2);
    chain.run_until([this] { return !may_move(); }, 60);
    return chain.stand();
  }
  bool begin(Dice& dice) {
    return chain.stand() && sets_out(dice, chain, 10, [this](Dice& d) { return walk(d); });
  }
  bool walk(Dice& dice) {
    const auto speed = static_cast<gnc::zebro::Speed>(dice.whole(1, 3));
    const double heading = dice.chance(0.5) ? 0 : dice.between(-zebro::kHalfPi, zebro::kHalfPi);
    return chain.walk(dice.chance(0.7), heading, speed);
  }

  bool moves() const {
    return std::ranges::any_of(chain.due().module, [](const ModuleOrder& order) {
      return order.kind == ModuleOrder::Kind::rotate_forward ||
             order.kind == ModuleOrder::Kind::rotate_backward;
    });
  }
  bool may_move() const {
    const auto& s = chain.supervisor().controller;
    return (s.state == State::solve_errors && (s.flags & zebro::kFreeing) != 0) ||
           (s.state == State::idle && (s.flags & zebro::kPanelMoving) != 0);
  }
  bool cut() {
    return std::ranges::any_of(chain.attached(), [](const std::string& fault) {
      return fault.starts_with("bus-cut") || fault.starts_with("unplug") ||
             fault.starts_with("drop") || fault.starts_with("noise") || fault.starts_with("late");
    });
  }
  bool sound() const {
    return std::ranges::all_of(
        chain.due().module, [](const ModuleOrder& order) { return order.position_cdeg < 36'000; });
  }
  bool rests() const {
    return std::ranges::all_of(world().robot().shafts(), [](const auto& shaft) {
      return std::abs(shaft.velocity_rad_s) < kStill_rad_s;
    });
  }
  std::string motion() const {
    std::string text = "rad/s";
    for (const auto& shaft : world().robot().shafts())
      text += fmt::format(" {:.2f}", shaft.velocity_rad_s);
    return text;
  }
  static std::span<const CommandInfo> commands() { return zebro::kCommands; }

  sim::zebro::Zebro& world() const { return const_cast<Chain&>(chain).world(); }

  // ---- flips
  static constexpr double kFlips_s = 2, kAfter_s = 1.5;
  bool begin_flips(Dice& dice) { return chain.stand() && walk(dice); }
  void end_flips() { chain.send(lss::CommandKind::stop); }
  // Everything on the wire but requests of data.
  std::uint64_t sent() {
    for (const auto& wire = chain.wire(); looked_ < wire.size(); ++looked_) {
      const zebro::WireFrame& f = wire[looked_];
      if (f.code() == zebro::Code::request_data) continue;
      sent_.add(f.begin_ns, f.frame.address, f.frame.code, f.frame.data);
    }
    return sent_.digest;
  }

  Chain chain;
  Sent sent_;
  std::size_t looked_ = 0;
};

}  // namespace

Subject zebro() {
  return subject_of<World>("zebro", "standing and walking, at any speed and heading",
                           "all legs below 0.05 rad/s");
}

}  // namespace lss::campaign
