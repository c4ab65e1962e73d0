#pragma once

// The limits of D.I.A.N.A. Ardito's supervision (tests/safety/limits.h).

#include "gnc/ardito/rocker_bogie.h"
#include "gnc/ardito/slip.h"
#include "idl/ardito/codes.h"
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

// The wheel that sinks, and the angle of its bogie that lowers it against the plane of the others.
inline constexpr std::uint8_t kLow = 3;
inline double bogie_rad(double lower_m, const gnc::ardito::Geometry& geometry) {
  double least = -1, most = 0;
  for (int i = 0; i < 40; ++i) {
    const double middle = (least + most) / 2;
    const auto poses = gnc::ardito::wheel_poses({0, 0, middle}, geometry);
    (gnc::ardito::lower_than_others_m(poses.z_m)[kLow] > lower_m ? least : most) = middle;
  }
  return most;
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

  const auto stands = [](World& w) {
    w.send(lss::CommandKind::start, {1, 0.1});  // no limit but the vehicle's own
    ASSERT_TRUE(w.run_until(Mode::stopped, 10));
    w.run(1);
  };
  const auto refused_as_too_fast = [](const World& w) {
    const Ack* refused = w.last(Phase::rejected);
    if (refused == nullptr) return false;
    EXPECT_EQ(refused->verdict.reason, reasons::over_cap);
    EXPECT_NEAR(refused->verdict.measured - refused->verdict.limit, 0.001, 1e-9);
    return true;
  };
  const auto asks_at_start = [](World& w, const Parameters& p, bool above) {
    w.send(lss::CommandKind::start, {1, p.mobility.top_speed_m_s + (above ? 0.001 : 0)});
  };
  const auto asks_to_drive = [](World& w, const Parameters& p, bool above) {
    w.send(CommandKind::drive, {p.mobility.top_speed_m_s + (above ? 0.001 : 0), 0, 1, 0});
  };
  // It is halted in the frame in which it would begin to drive, or it is not.
  const auto drives_by_itself = [](World& w, const Parameters& p, bool above) {
    w.send(CommandKind::drive, {0.3, 0, 1, 1});
    w.step();
    for (const TimeNs end = w.time_ns_ + p.autonomy_ns - World::kPeriod; w.time_ns_ < end;) {
      w.step();
      ASSERT_EQ(w.wheel_rpm(0), 0);
    }
    if (!above) w.send(CommandKind::halt);
  };
  // Their motors are too hot.
  const auto lose_wheels = [](World& w, const Parameters& p, bool above) {
    const unsigned lost = p.mobility.max_lost_wheels + (above ? 1 : 0);
    measure<WheelHealth>(w, [=, hot_degC = p.mobility.max_temperature_C + 1](WheelHealth& h) {
      if (h.wheel < lost) h.temperature_degC = hot_degC;
    });
  };
  // Its motor pushes, and speed is lost.
  const auto sinks = [](World& w, const Parameters& p, bool above) {
    const double angle_rad =
        bogie_rad(p.mobility.sink_m + (above ? 0.002 : -0.002), p.mobility.geometry);
    w.distort = [=](std::vector<Reading>& readings) {
      for (Reading& reading : readings) {
        if (auto* rocker = std::get_if<Rocker>(&reading)) rocker->rho2_rad = angle_rad;
        if (auto* imu = std::get_if<Imu>(&reading)) imu->Vtan_mm_s *= 0.85;
        auto* wheel = std::get_if<WheelMotion>(&reading);
        if (wheel != nullptr && wheel->wheel == kLow)
          wheel->current_permille += std::copysign(700, wheel->motor_rpm);
      }
    };
  };
  const auto too_few_wheels = [](const World& w) {
    return (w.vehicle_.command().faults & gnc::ardito::kTooFewWheels) != 0;
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
       noticed(faults::steering_critical, kSteeringNode)},
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
      {"the speed that is asked for at start",
       {"safety.max_speed_m_s"},
       1,
       asks_at_start,
       refused_as_too_fast,
       stay},
      {"the speed that is asked for in a drive",
       {"safety.max_speed_m_s"},
       1,
       asks_to_drive,
       refused_as_too_fast,
       stands},
      {"the lamp before it drives by itself",
       {"safety.autonomy_s"},
       1,
       drives_by_itself,
       [](const World& w) { return w.wheel_rpm(0) != 0; },
       stands},
      {"wheels out of work", {"mobility.lost_wheels"}, 10, lose_wheels, too_few_wheels},
      {"a wheel that digs itself in",
       {"mobility.sink_limit_m"},
       5,
       sinks,
       noticed(faults::wheel_embedded, kLow + 1)},
  };
}

// How it drives and what people read; limits of commands and of the estimate, which the tests
// named have: heading (drive_test.cpp), slip and deceleration (tests/ardito/gnc), error solving
// (watch_test.cpp).
inline std::set<std::string> no_limits() {
  return {"mobility.heading_limit_deg", "mobility.ratio_p",           "mobility.ratio_i",
          "mobility.correction_sign",   "mobility.deceleration_m_s2", "mobility.slip_limit",
          "mobility.slip_slows",        "mobility.slip_speed",        "mobility.slip_load",
          "bus.wheel_rated_A",          "bus.steering_rated_A",       "solve.budget_s"};
}

}  // namespace lss::ardito
