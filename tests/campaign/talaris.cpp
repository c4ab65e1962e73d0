// TALARIS in a fault campaign: any moment of a hop.

#include <array>
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

  bool start() { return chain.start(); }
  // Where it fell over the altimeter sees no ground.
  bool can_start() const { return upright(); }
  std::string outcome() const {
    if (!lifted_) return "never left the ground";
    const double down_m_s = chain.world().plant().touchdown().down_m_s;
    if (!upright()) return "fell over";
    return down_m_s <= 2 ? "upright, landed below 2 m/s" : "upright, landed harder";
  }
  bool upright() const {
    constexpr double kUpright = 0.9;  // cosine of the tilt
    return (chain.body().attitude * Eigen::Vector3d::UnitX()).x() > kUpright;
  }
  bool begin(Dice& dice) {
    if (!fly()) return false;
    chain.run(dice.between(0, 12));
    return true;
  }
  bool fly() {
    if (!chain.prepare()) return false;
    if (!chain.fly(talaris::Program::hop, {.height_m = 2, .distance_m = 30})) return false;
    chain.after_step = [this] {
      lifted_ = lifted_ || chain.world().plant().clearance_m() > 0.05;
      for (std::size_t i = 0; i < sim::talaris::kValves; ++i) {
        if (chain.world().gas().stuck_open[i]) stuck_s_[i] = chain.seconds();
      }
    };
    return true;
  }

  bool moves() const { return talaris::active(chain.due()); }
  bool may_move() const { return false; }
  bool cut() {
    return std::ranges::any_of(chain.attached(), [](const std::string& fault) {
      return fault.starts_with("bus-cut") || fault.starts_with("noise") ||
             fault.starts_with("drop") || fault.starts_with("late") || fault.starts_with("node-");
    });
  }
  bool sound() const {
    const talaris::TalarisOrders& o = chain.due();
    return std::ranges::all_of(o.fan_us,
                               [](std::uint16_t us) { return us >= 1000 && us <= 2000; }) &&
           std::ranges::all_of(
               o.pulse,
               [](const talaris::ValvePulse& p) {
                 constexpr TimeNs kLeast = 40 * kMillisecond, kFrame = 200 * kMillisecond;
                 const bool whole =
                     p.delay_ns >= 0 && p.on_ns >= 0 && p.delay_ns + p.on_ns <= kFrame;
                 return whole &&
                        (p.on_ns == 0 || p.on_ns >= kLeast || p.delay_ns + p.on_ns == kFrame);
               }) &&
           std::ranges::all_of(o.hold, [&](const talaris::ValveHold& h) {
             constexpr TimeNs kLongest = 30 * kSecond;
             return !h.open || (h.until_ns > o.release_ns && h.until_ns <= o.release_ns + kLongest);
           });
  }
  bool rests() const {
    const auto& gas = chain.world().gas();
    for (std::size_t i = 0; i < sim::talaris::kValves; ++i) {
      constexpr double kShuts_s = 0.05;  // a valve that stuck until now
      if ((gas.open() >> i & 1u) != 0 && chain.seconds() - stuck_s_[i] > kShuts_s) return false;
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

  // ---- flips
  static constexpr double kFlips_s = 14, kAfter_s = 6;
  bool begin_flips(Dice&) { return fly(); }
  void end_flips() {}
  std::uint64_t sent() const { return sent_.digest; }

  Chain chain;
  Sent sent_;
  bool lifted_ = false;
  std::array<double, sim::talaris::kValves> stuck_s_{};  // when each last stuck
};

}  // namespace

Subject talaris() {
  return subject_of<World>("talaris", "a hop, from the fans' spinning up to the landing",
                           "valves that are not stuck shut, fans below 2000 rpm");
}

}  // namespace lss::campaign
