#pragma once

// The limits of D.I.A.N.A. Ardito's supervision (tests/safety/limits.h).

#include "tests/safety/limits.h"
#include "world.h"

namespace lss::ardito {

using Limit = safety::Limit<World, Parameters>;

inline constexpr std::uint8_t kWheel = 4;  // front right is 0
inline constexpr std::uint16_t kWheelNode = kWheel + 1;
inline constexpr std::size_t kSteering = 1;
inline constexpr std::uint16_t kSteeringNode = kWheels + kSteering + 1;

// Changes each reading of one type, before it is sent.
template <class Kind, class Change>
void measure(World& w, Change change) {
  w.distort = [change](std::vector<Reading>& readings) {
    for (Reading& reading : readings) {
      if (auto* one = std::get_if<Kind>(&reading)) change(*one);
    }
  };
}

inline void heat(World& w, double degC) {
  measure<WheelHealth>(w, [degC](WheelHealth& h) {
    if (h.wheel == kWheel) h.temperature_degC = degC;
  });
}

inline std::vector<Limit> limits() {
  const auto noticed = [](FaultId id, std::uint16_t subject = 0) {
    return safety::fault_noticed<World>(id, subject);
  };
  const auto starts = [](World& w) { w.send(lss::CommandKind::start, {0}); };
  const auto stay = [](World&) {};
  const auto quiet_io_for = [](World& w, const Parameters& p, bool above) {
    // It is heard in every frame, a millisecond before it; what is altered counts from the next on.
    const TimeNs missing = (p.io_silent_ns - kMillisecond) / World::kPeriod + (above ? 1 : 0);
    const TimeNs frames = missing - 1;
    safety::for_so_long(
        w, frames * World::kPeriod,
        [](World& x) {
          x.distort = [](std::vector<Reading>& readings) {
            std::erase_if(readings,
                          [](const Reading& r) { return std::holds_alternative<Inputs>(r); });
          };
        },
        [](World& x) { x.distort = nullptr; });
    w.alter(w);
  };
  const auto draws = [](World& w, const Parameters& p, bool above) {
    const double permille = 1000 * p.mobility.max_current + (above ? 1 : -1);
    measure<WheelMotion>(w, [=](WheelMotion& m) {
      if (m.wheel == kWheel) m.current_permille = std::copysign(permille, m.motor_rpm);
    });
  };
  const auto steering_draws = [](World& w, const Parameters& p, bool above) {
    const double permille = 1000 * p.mobility.max_steering_current + (above ? 1 : -1);
    measure<SteeringMotion>(w, [=](SteeringMotion& m) {
      if (m.wheel == kSteeredWheel[kSteering]) m.current_permille = permille;
    });
  };
  const auto out_of_work = [](const World& w) {
    return (w.vehicle_.command().motors_stopped & gnc::ardito::only(kWheel)) != 0;
  };
  const auto stands_still_for = [](World& w, const Parameters&, bool above) {
    const TimeNs since = w.time_ns_;
    w.alter = [=](World& x) {
      const TimeNs age = std::min(x.time_ns_ - since, 200 * kMillisecond + (above ? 1 : 0));
      x.in_.bus.time_ns = x.time_ns_ - age;
    };
  };
  const auto away_for = [](World& w, const Parameters& p, bool above) {
    w.boot_ns[kWheel] = p.reset_ns + (above ? 2 : -3) * World::kPeriod;
    w.send(lss::CommandKind::reset, {kWheelNode});
  };

  return {
      {"no message of the button",
       {"safety.io_silent_ms"},
       8,
       quiet_io_for,
       noticed(FaultId::stale_input, kIoNode)},
      {"a motor's temperature",
       {"mobility.motor_temperature_degC"},
       5,
       [](World& w, const Parameters& p, bool above) {
         heat(w, p.mobility.warm_temperature_C + (above ? 0.1 : -0.1));
       },
       noticed(FaultId::temperature_warning, kWheelNode)},
      {"a motor that was hot has cooled down",
       {},
       5,
       [](World& w, const Parameters& p, bool above) {
         heat(w, p.mobility.warm_temperature_C + 0.1);
         w.run(2);
         heat(w, p.mobility.warm_temperature_C - (above ? 3.1 : 2.9));
       },
       [](const World& w) {
         return w.heard(EventId::fault_cleared) != nullptr &&
                !w.has(FaultId::temperature_warning, kWheelNode);
       }},
      {"a motor is too hot",
       {"mobility.motor_cutoff_degC"},
       10,
       [](World& w, const Parameters& p, bool above) {
         heat(w, p.mobility.max_temperature_C + (above ? 0.1 : -0.1));
       },
       out_of_work},
      {"a motor's current", {"mobility.motor_current"}, 10, draws, out_of_work},
      {"a steering motor's current",
       {"mobility.steering_current"},
       10,
       steering_draws,
       noticed(FaultId::steering_critical, kSteeringNode)},
      {"the bus thread stands still", {}, 1, stands_still_for, noticed(FaultId::bus_stuck)},
      {"a node that is reset comes back",
       {"bus.reset_s"},
       130,
       away_for,
       noticed(FaultId::module_silent, kWheelNode),
       stay},
      {"the lamp before the motors go on",
       {"safety.beacon_s"},
       70,
       [](World& w, const Parameters& p, bool above) {
         // Until the frame before it is over, or until it is.
         const TimeNs end = w.time_ns_ + p.beacon_ns + (above ? 5 : -2) * World::kPeriod;
         while (w.time_ns_ < end) w.step();
         if (!above) w.send(lss::CommandKind::stop);
       },
       [](const World& w) {
         return w.in_.bus.status.link[0].drive == canopen::DriveState::operation_enabled;
       },
       starts},
  };
}

// How it drives and what people read; limits of commands and of the estimate, which the tests
// named have: heading and speed (cycle_test.cpp, drive_test.cpp), slip, deceleration and lost
// wheels (tests/ardito/gnc), error solving (watch_test.cpp).
inline std::set<std::string> no_limits() {
  return {"mobility.heading_limit_deg",
          "mobility.ratio_p",
          "mobility.ratio_i",
          "mobility.correction_sign",
          "mobility.deceleration_m_s2",
          "mobility.slip_limit",
          "mobility.slip_load",
          "mobility.lost_wheels",
          "bus.wheel_rated_A",
          "bus.steering_rated_A",
          "safety.autonomy_s",
          "safety.max_speed_m_s",
          "solve.budget_s"};
}

}  // namespace lss::ardito
