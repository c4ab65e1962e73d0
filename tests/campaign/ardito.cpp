// Ardito in a fault campaign: drives on flat ground.

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "daemon/vehicles/ardito/vehicle.h"
#include "idl/angles.h"
#include "tests/ardito/chain/chain.h"
#include "tests/campaign/play.h"

namespace lss::campaign {
namespace {

struct World {
  using Chain = ardito::Chain;
  using Vehicle = ardito::Vehicle;
  static constexpr std::array<std::string_view, 2> kNotHere = {"unplug", "bus-off"};
  static constexpr double kRest_s = 3;
  static constexpr double kCutRest_s = kRest_s;
  static constexpr double kStill_m_s = 0.02;
  static sim::ardito::PlantKind plant(unsigned seed) {
    return seed % 10 == 0 ? sim::ardito::PlantKind::dart : sim::ardito::PlantKind::kinematic;
  }

  World(unsigned seed, Dice&) : chain({.rover = {.plant = plant(seed)}, .seed = seed}) {}

  // The drive of a motor that was too hot stays in fault until it is below its warning at 90 degC.
  bool start() {
    const auto cool = [](const lss_ArditoWheel& wheel) { return wheel.temperature_degC < 88; };
    return chain.run_until([&] { return std::ranges::all_of(chain.telemetry().wheels, cool); },
                           500) &&
           chain.start();
  }
  bool begin(Dice& dice) {
    return chain.start() && sets_out(dice, chain, 6, [this](Dice& d) { return drive(d); });
  }
  bool drive(Dice& dice) {
    const double heading = dice.chance(0.5) ? 0 : dice.between(-0.08, 0.08);
    return chain.drive(dice.between(0.1, 0.5), heading);
  }

  bool moves() const {
    const auto on = [](const auto& drive) { return drive.enabled; };
    const ardito::RoverOrders& o = chain.due();
    return !o.quick_stop &&
           (std::ranges::any_of(o.wheel, on) || std::ranges::any_of(o.steering, on));
  }
  bool may_move() const { return false; }
  bool cut() const { return false; }
  // A wheel outside of a curve is faster than the rover, which slows down there: by a fifth, as in
  // the gate. Wheels steer by 65 deg at most (Ardito thesis 11.2).
  bool sound() const {
    constexpr double kMostSteering_rad = 65 * kDegree;
    const gnc::ardito::Parameters& p = chain.parameters().mobility;
    const double most_rad_s = 1.2 * p.top_speed_m_s / p.geometry.wheel_radius_m;
    const double most_rpm = (most_rad_s + 2 * p.wheel_saturation_rad_s) /
                            gnc::ardito::kRadPerSecondPerRpm * p.geometry.gear_ratio;
    const ardito::RoverOrders& o = chain.due();
    const auto within = [](double value, double most) { return std::abs(value) <= most; };
    return std::ranges::all_of(o.wheel,
                               [&](const auto& w) { return within(w.motor_rpm, most_rpm); }) &&
           std::ranges::all_of(o.steering, [&](const auto& s) {
             return within(s.position_rad, kMostSteering_rad);
           });
  }
  bool rests() const { return chain.world().rover().body().velocity_m_s.norm() < kStill_m_s; }
  std::string motion() const {
    return fmt::format("{:.2f} m/s", chain.world().rover().body().velocity_m_s.norm());
  }
  static std::span<const CommandInfo> commands() { return ardito::kCommands; }

  // ---- flips
  static constexpr double kFlips_s = 2, kAfter_s = 3.5;
  bool begin_flips(Dice& dice) { return chain.start() && drive(dice); }
  void end_flips() { chain.send(lss::CommandKind::stop); }
  std::uint64_t sent() const { return sent_.digest; }

  Chain chain;
  Sent sent_;
};

}  // namespace

Subject ardito() {
  return subject_of<World>(
      "ardito",
      "driving at 0.1 to 0.5 m/s, straight and in arcs; each tenth with rigid bodies, which take "
      "their time, the others with a rover that rolls only",
      "below 0.02 m/s");
}

}  // namespace lss::campaign
