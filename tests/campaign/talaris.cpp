// TALARIS in a fault campaign: any moment of a hop.

#include <array>
#include <cmath>
#include <string_view>

#include "daemon/vehicles/talaris/gate.h"
#include "daemon/vehicles/talaris/vehicle.h"
#include "tests/campaign/play.h"
#include "tests/talaris/chain/chain.h"

namespace lss::campaign {
namespace {

struct World {
  using Chain = talaris::Chain;
  using Vehicle = talaris::Vehicle;
  static constexpr std::array<std::string_view, 3> kNotHere = {"unplug", "line-unplug", "bus-off"};
  static constexpr double kRest_s = 8;
  static constexpr double kCutRest_s = 15;    // orders come through now and then
  static constexpr double kStill_rpm = 2000;  // fan speed without thrust

  World(unsigned seed, Dice&)
      : chain({.config = "hop", .world = sim::talaris::dispersed({}, seed), .seed = seed}) {}

  // Where it fell over the altimeter sees no ground: then there is nothing to start.
  bool start() { return !upright() || chain.start(); }
  bool upright() const {
    constexpr double kUpright = 0.9;  // cosine of the tilt
    return (chain.body().attitude * Eigen::Vector3d::UnitX()).x() > kUpright;
  }
  bool begin(Dice& dice) {
    if (!chain.prepare()) return false;
    if (!chain.fly(talaris::Program::hop, {.height_m = 2, .distance_m = 30})) return false;
    chain.run(dice.between(0, 12));
    return true;
  }

  bool moves() const { return talaris::active(chain.orders()); }
  bool may_move() const { return false; }
  bool cut() {
    return std::ranges::any_of(chain.attached(), [](const std::string& fault) {
      return fault.starts_with("bus-cut") || fault.starts_with("noise") ||
             fault.starts_with("drop") || fault.starts_with("late") || fault.starts_with("node-");
    });
  }
  bool sound() const {
    return std::ranges::all_of(chain.orders().fan_us,
                               [](std::uint16_t us) { return us >= 1000 && us <= 2000; });
  }
  bool rests() const {
    const auto& gas = chain.world().gas();
    for (std::size_t i = 0; i < sim::talaris::kValves; ++i) {
      if ((gas.open() >> i & 1u) != 0 && !gas.stuck_open[i]) return false;
    }
    for (std::size_t i = 0; i < sim::talaris::kFans; ++i) {
      if (chain.world().fans().rpm(i) > kStill_rpm) return false;
    }
    return true;
  }
  std::string motion() const {
    const auto& fans = chain.world().fans();
    return fmt::format("valves {:#04x}, fans {:.0f} {:.0f} {:.0f} {:.0f} rpm",
                       chain.world().gas().open(), fans.rpm(0), fans.rpm(1), fans.rpm(2),
                       fans.rpm(3));
  }
  static std::span<const CommandInfo> commands() { return talaris::kCommands; }

  Chain chain;
};

}  // namespace

Subject talaris() {
  return subject_of<World>("talaris", "a hop, from the fans' spinning up to the landing",
                           "valves that are not stuck shut, fans below 2000 rpm");
}

}  // namespace lss::campaign
