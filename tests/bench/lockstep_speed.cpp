// Row xiv: simulated time in lockstep. lss-sim, lssd and lss-cli as they ship, as fast as this
// machine goes: wall-clock of a simulated second of motion, against real time and, with rigid
// bodies, against the same chain in one process (tests/zebro/chain).

#include <fmt/format.h>

#include <cstdlib>

#include "daemon/runtime/clock.h"
#include "tests/bench/lockstep.h"
#include "tests/bench/programs.h"
#include "tests/zebro/chain/chain.h"

namespace lss::bench {
namespace {

constexpr double kGoalTimes = 20;      // with the kinematic plant
constexpr double kOfOneProcess = 0.8;  // of its speed, with rigid bodies
constexpr double kFrame_us = 600;

// Of a simulated second of motion.
Samples second_ms(const Moving& moving, const std::string& plant, int seconds) {
  return {lockstep_ms(moving, plant, seconds) / seconds};
}

Samples one_process_ms(int seconds) {
  zebro::Chain chain;
  if (!chain.stand() || !chain.walk()) throw std::runtime_error("the simulated robot fell");
  const TimeNs begin = now_ns();
  chain.run(seconds);
  return {static_cast<double>(now_ns() - begin) * 1e-6 / seconds};
}

double period_ms(const std::string& vehicle) {
  const std::string text = shipped_config(vehicle);
  const std::string key = "period_ms = ";
  return std::strtod(text.c_str() + text.find(key) + key.size(), nullptr);
}

void kinematic(const Moving& moving, const Options& options, Figures& figures) {
  Samples all;
  for (int i = 0; i < options.count(kRounds, 1); ++i)
    all.push_back(second_ms(moving, "kinematic", options.count(30, 10)).front());
  const double ms = median(all);
  figures.push_back(figure_of(
      "xiv", fmt::format("{} in lockstep, kinematic plant, a simulated second", moving.vehicle),
      "ms", ms, 1000, 1 / kGoalTimes,
      fmt::format("{:.0f} times real time; lss-sim, lssd and lss-cli", 1000 / ms)));
  const double frame_ms = period_ms(moving.vehicle);
  Figure frame =
      figure_of("xiv", fmt::format("{} in lockstep, kinematic plant, a frame", moving.vehicle),
                "us", ms * frame_ms, kNone, kFrame_us,
                fmt::format("of {:.0f} ms; hand-overs, cycle, bus and plant together", frame_ms));
  frame.absolute = true;
  figures.push_back(frame);
}

}  // namespace

Figures lockstep_speed(const Options& options) {
  Figures figures;
  kinematic(kWalk, options, figures);
#ifdef LSS_BENCH_ARDITO
  kinematic(kDrive, options, figures);
#endif
  const int seconds = options.count(10, 5);
  const Rounds rounds =
      turn_by_turn([&] { return second_ms(kWalk, "dart", seconds); },
                   [&] { return one_process_ms(seconds); }, options.count(kRounds, 1));
  figures.push_back(
      noted(figure("xiv", "zebro in lockstep, rigid bodies, a simulated second", "ms", rounds,
                   median, 1 / kOfOneProcess),
            "reference: the same chain in one process, with pieces of 8 characters instead of 64"));
  return figures;
}

}  // namespace lss::bench
