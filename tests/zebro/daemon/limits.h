#pragma once

// The limits of Lunar Zebro's supervision (tests/safety/limits.h).

#include "idl/zebro/codes.h"
#include "tests/safety/limits.h"
#include "world.h"

namespace lss::zebro {

using Limit = safety::Limit<World, Parameters>;

inline constexpr TimeNs kTwoFrames = 2 * World::kPeriod;
inline constexpr std::size_t kLM = 2;
inline constexpr std::uint16_t kLMNumber = kLM + 1;

inline std::uint16_t milliampere(double current_A, int more) {
  return static_cast<std::uint16_t>(static_cast<int>(std::lround(current_A * 1000)) + more);
}

// Of one leg, or of all modules.
inline void draw(World& w, std::uint16_t current_mA, bool all = false) {
  for (std::size_t i = 0; i < w.modules.size(); ++i) {
    if (all || i == kLM) w.modules[i].current_mA = current_mA;
  }
}

// In each status of a module.
inline void put_position(World& w, std::size_t module, std::uint16_t position_cdeg) {
  for (ModuleReply& reply : std::span(w.in_.samples).first(w.in_.sample_count)) {
    if (reply.module != module || reply.code != static_cast<std::uint8_t>(Code::status)) continue;
    reply.data[2] = static_cast<std::uint8_t>(position_cdeg >> 8);
    reply.data[3] = static_cast<std::uint8_t>(position_cdeg & 0xFF);
  }
}

// Which legs, as bits.
inline constexpr unsigned kAllLegs = 0b111111, kLeftLegs = 0b010101, kRightLegs = 0b101010;

// Legs draw 50 mA, these in soil 100 mA more, and a share of it where the belly would touch the
// ground.
inline void draw_in_soil(World& w, double share, unsigned legs = kAllLegs) {
  for (ModuleReply& reply : std::span(w.in_.samples).first(w.in_.sample_count)) {
    if (reply.module >= kLegs || reply.code != static_cast<std::uint8_t>(Code::status)) continue;
    const double ahead_deg = 360 - (reply.data[2] * 256 + reply.data[3]) * 0.01;
    const bool in_soil = (legs >> reply.module & 1u) != 0;
    const double soil_A = !in_soil || ahead_deg >= 95 ? 0 : ahead_deg < 65 ? 0.1 : 0.1 * share;
    const std::uint16_t current_mA = milliampere(0.05 + soil_A, 0);
    reply.data[6] = static_cast<std::uint8_t>(current_mA >> 8);
    reply.data[7] = static_cast<std::uint8_t>(current_mA & 0xFF);
  }
}

inline std::vector<Limit> limits() {
  const auto noticed = [](FaultId id, std::uint16_t subject = 0) {
    return safety::fault_noticed<World>(id, subject);
  };
  // For so long the leg draws more, or all do.
  const auto draws_for = [](bool all) {
    return [all](World& w, const Parameters& p, bool above) {
      const auto much =
          all ? milliampere(p.total_limit_A / kModules, 10) : milliampere(p.current_limit_A, 100);
      safety::for_so_long(
          w, p.current_time_ns + (above ? kTwoFrames : -kTwoFrames),
          [=](World& x) { draw(x, much, all); }, [=](World& x) { draw(x, 100, true); });
    };
  };
  const auto broken_frames = [](World& w, const Parameters&, bool above) {
    // The windows are a second each, whenever they began: all in the first frame of one.
    const TimeNs window = w.time_ns_ + kSecond;
    w.alter = [=, left = above ? 20u : 19u](World& x) mutable {
      if (x.time_ns_ >= window) x.in_.bus.counters.bad_check += std::exchange(left, 0u);
    };
  };
  const auto silent_for = [](World& w, const Parameters& p, bool above) {
    safety::for_so_long(
        w, p.module_silent_ns + (above ? kTwoFrames : -kTwoFrames),
        [](World& x) { x.modules[kLM].alive = false; },
        [](World& x) { x.modules[kLM].alive = true; });
  };
  const auto away_for = [](World& w, const Parameters& p, bool above) {
    w.modules[kLM].boot_ns = p.reset_ns + (above ? kTwoFrames : -3 * kTwoFrames);
    w.send(lss::CommandKind::reset, {kLMNumber});
  };
  const auto stands_still_for = [](World& w, const Parameters&, bool above) {
    constexpr TimeNs kAllowed = 200 * kMillisecond;
    const TimeNs since = w.time_ns_;
    w.alter = [=](World& x) {
      const TimeNs age = std::min(x.time_ns_ - since, kAllowed + (above ? 1 : 0));
      x.in_.bus.time_ns = x.time_ns_ - age;
    };
  };
  const auto warm = [](World& w, double degC) {
    w.modules[kLM].temperature_cdegC = static_cast<std::int16_t>(std::lround(degC * 100));
  };
  const auto stay = [](World&) {};
  // Its module stands on its way, and comes to the end of it in the last frame that is in time or
  // in the one after the first that is not.
  const auto panel_takes = [](World& w, const Parameters& p, bool above) {
    constexpr TimeNs kGrace = 3 * kSecond;
    IdealModule& panel = w.modules.back();
    panel.stuck = true;
    w.send(CommandKind::panel, {1});
    ASSERT_TRUE(w.run_until([&] { return w.out_.command.module.back().rotates(); }, 1));
    const TimeNs end = w.time_ns_ + p.panel_move_ns + kGrace + (above ? kTwoFrames : 0);
    w.alter = [=](World& x) { x.modules.back().stuck = x.time_ns_ + World::kPeriod < end; };
  };
  // A leg jams as often, and each time `solve` is asked for.
  const auto solved_so_often = [](World& w, const Parameters& p, bool above) {
    for (unsigned round = above ? 0 : 1; round <= p.solver.rounds; ++round) {
      w.send(lss::CommandKind::start, {1});
      ASSERT_TRUE(w.run_until(Mode::standing_up, 5));
      w.modules[kLM].flags |= kFlagOverCurrent;
      ASSERT_TRUE(w.run_until(State::fatal_error, 0.2));
      w.send(lss::CommandKind::solve);
      if (round < p.solver.rounds) {
        ASSERT_TRUE(w.run_until(State::idle, 120));
      }
    }
  };
  const auto needs_a_person = [](const World& w) {
    const Ack* refused = w.answer(lss::CommandKind::solve, Phase::rejected);
    return refused != nullptr && refused->verdict.reason == reasons::solved_too_often;
  };
  // In these frames its status has a position that cannot be.
  const auto odd_status = [](std::vector<TimeNs> frames) {
    return [=](World& w) {
      const TimeNs begin = w.time_ns_ + World::kPeriod;
      w.alter = [=](World& x) {
        if (std::ranges::find(frames, (x.time_ns_ - begin) / World::kPeriod) == frames.end())
          return;
        put_position(x, kLM, 0xFFFF);
      };
    };
  };
  const auto odd_at = [=](std::vector<TimeNs> below, std::vector<TimeNs> beyond) {
    return [=](World& w, const Parameters&, bool above) { odd_status(above ? beyond : below)(w); };
  };

  return {
      {"a module is silent",
       {"bus.module_silent_ms"},
       16,
       silent_for,
       noticed(FaultId::module_silent, kLMNumber)},
      {"a leg's current",
       {"limits.current_A"},
       12,
       [](World& w, const Parameters& p, bool above) {
         draw(w, milliampere(p.current_limit_A, above ? 1 : -1));
       },
       noticed(faults::current_limit, kLMNumber)},
      {"how long a leg's current",
       {"limits.current_time_ms"},
       12,
       draws_for(false),
       noticed(faults::current_limit, kLMNumber)},
      {"the current of all",
       {"limits.total_A"},
       12,
       [](World& w, const Parameters& p, bool above) {
         draw(w, milliampere(p.total_limit_A / kModules, above ? 1 : -1), true);
       },
       noticed(faults::current_sum)},
      {"how long the current of all", {}, 12, draws_for(true), noticed(faults::current_sum)},
      {"a module's temperature",
       {"limits.temperature_warning_degC"},
       3,
       [=](World& w, const Parameters& p, bool above) {
         warm(w, p.temperature_warning_degC + (above ? 0.02 : -0.02));
       },
       noticed(FaultId::temperature_warning, kLMNumber)},
      {"soil where the belly is",
       {"ground.soil_share"},
       20,
       [](World& w, const Parameters& p, bool above) {
         const double share = p.soil_share + (above ? 0.015 : -0.015);
         w.alter = [=](World& x) { draw_in_soil(x, share); };
       },
       noticed(faults::belly_in_soil)},
      {"soil where a side is",
       {},
       27,
       [](World& w, const Parameters& p, bool above) {
         const double share = 2 * p.soil_share + (above ? 0.015 : -0.015);
         w.alter = [=](World& x) { draw_in_soil(x, share, kLeftLegs); };
       },
       noticed(faults::left_in_soil)},
      {"a module that was hot has cooled down",
       {},
       3,
       [=](World& w, const Parameters& p, bool above) {
         warm(w, p.temperature_warning_degC + 1);
         w.run(1);
         warm(w, p.temperature_warning_degC - (above ? 5.02 : 4.98));
       },
       [](const World& w) {
         return w.heard(EventId::fault_cleared) != nullptr &&
                !w.has(FaultId::temperature_warning, kLMNumber);
       }},
      {"broken frames in a second", {}, 4, broken_frames, noticed(FaultId::bus_noise)},
      {"the bus thread stands still", {}, 1, stands_still_for, noticed(FaultId::bus_stuck)},
      {"a module that is reset comes back",
       {"bus.reset_s"},
       130,
       away_for,
       noticed(FaultId::module_silent, kLMNumber),
       stay},
      {"the panel's way",
       {"panel.move_s"},
       70,
       panel_takes,
       noticed(faults::motion_timeout, kModules),
       stay},
      {"how often the same is solved", {"solve.rounds"}, 1, solved_so_often, needs_a_person, stay},
      {"odd reports",
       {},
       4,
       odd_at({0, 1}, {0, 1, 2}),
       noticed(faults::report_impossible, kLMNumber)},
      {"odd reports in two seconds",
       {},
       4,
       odd_at({0, 50, 101}, {0, 50, 100}),
       noticed(faults::report_impossible, kLMNumber)},
      {"a position",
       {},
       1,
       [](World& w, const Parameters&, bool above) {
         w.alter = [=](World& x) { put_position(x, 0, above ? 36'000 : 35'999); };
       },
       [](const World& w) { return w.supervisor_.state().fault_count != 0; },
       stay},
  };
}

// How it moves, and error solving, whose other limits solver_test.cpp and rounds_test.cpp test.
inline std::set<std::string> no_limits() {
  return {"gait.flight_s",       "gait.stance_min_s",        "gait.double_stance_s",
          "gait.start_delay_s",  "motion.stand_up_s",        "motion.lay_down_s",
          "motion.lift_s",       "motion.align_s",           "motion.arrived_deg",
          "motion.late_limit_s", "motion.swing_limit_deg_s", "panel.deployed_deg",
          "solve.budget_s",      "solve.cool_down_s",        "solve.cool_degC",
          "solve.healthy_s"};
}

}  // namespace lss::zebro
