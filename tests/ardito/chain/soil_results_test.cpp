// D.I.A.N.A. Ardito on soil: how it drives, by its motors alone, and what the whole chain makes of
// slip. With LSS_WRITE_RESULTS set, all of it, into docs/soil.md; else a sample as a test.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "idl/angles.h"
#include "idl/ardito/codes.h"
#include "tests/ardito/chain/chain.h"
#include "tests/ardito/chain/drives.h"
#include "tests/ardito/chain/fault_runs.h"
#include "tests/ardito/chain/jobs.h"
#include "tests/support/section.h"
#include "tests/support/stamp.h"
#include "tools/lss-sim/ardito/train.h"

namespace lss::ardito {
namespace {

using sim::ardito::Ground;
using sim::soil::kEarth_m_s2;
using sim::soil::kMoon_m_s2;

bool writing() { return std::getenv("LSS_WRITE_RESULTS") != nullptr; }

// 20, or LSS_RESULTS_SEEDS; in the test one.
unsigned seeds_of_results() {
  if (!writing()) return 1;
  const char* wanted = std::getenv("LSS_RESULTS_SEEDS");
  return wanted == nullptr ? 20 : static_cast<unsigned>(std::atoi(wanted));
}

// Limits of the detection of a single wheel that digs itself in were chosen with seeds below this.
constexpr unsigned kNewSeeds = 101;

void write(const std::string& title, const std::string& test, const std::string& text) {
  testing_support::write_section(
      LSS_DOCUMENT, title,
      "Measured " + testing_support::stamp(LSS_DOCUMENT) +
          " by\n`LSS_WRITE_RESULTS=1 ardito_soil_results_test --gtest_filter=" + test + "`.\n" +
          text);
}

// ---- how it drives

struct Driven {
  double speed_m_s = 0, slip = 0, sinkage_m = 0, current_A = 0;
};

// Straight ahead with motors ordered to this speed of the treads, a second on average, after five.
Driven drive(const sim::ardito::RoverOptions& options, double ordered_m_s) {
  using namespace sim::ardito;
  Rover rover(options);
  std::array<WheelTrain, sim::ardito::kWheels> trains;
  for (WheelTrain& train : trains) train.clutch_ordered = true;
  Driven driven;
  double rim_m_s = 0;
  constexpr int kSteps = 6000, kMeasured = 1000;
  double from_m = 0;
  for (int n = 0; n < kSteps; ++n) {
    const double ramp = std::min(1.0, n * sim::ardito::kStep_s);
    std::array<sim::ShaftDrive, sim::ardito::kWheels> wheels;
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      const double motor_rad_s = ramp * ordered_m_s / dimensions::kWheelRadius_m * kGear;
      wheels[i] = trains[i].step({true, motor_rad_s}, rover.wheels()[i], 25);
    }
    rover.step(wheels, {{{0, 40}, {0, 40}, {0, 40}, {0, 40}}});
    if (n == kSteps - kMeasured) from_m = rover.body().position_m.x();
    if (n < kSteps - kMeasured) continue;
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      const double share = 1.0 / static_cast<double>(kMeasured * wheels.size());
      rim_m_s += share * rover.wheels()[i].velocity_rad_s * dimensions::kWheelRadius_m;
      driven.current_A = std::max(driven.current_A, std::abs(trains[i].current_A()));
      driven.sinkage_m = std::max(driven.sinkage_m, rover.sinkage_m(i));
    }
  }
  driven.speed_m_s = (rover.body().position_m.x() - from_m) / (kMeasured * sim::ardito::kStep_s);
  driven.slip = 1 - driven.speed_m_s / rim_m_s;
  return driven;
}

TEST(ArditoSoil, Drives) {
  struct Case {
    const char* soil;
    double gravity_m_s2, slope_deg;
  };
  constexpr std::array kSlopes_deg = {-15.0, 0.0, 5.0, 10.0, 15.0};
  std::vector<Case> cases;
  if (writing()) {
    for (const char* soil : {"hard", "loam", "regolith", "regolith:0.25", "sand"}) {
      for (const double gravity_m_s2 : {kEarth_m_s2, kMoon_m_s2}) {
        for (const double slope_deg : kSlopes_deg) cases.push_back({soil, gravity_m_s2, slope_deg});
      }
    }
  } else {
    cases = {{"regolith", kEarth_m_s2, 0}, {"regolith", kEarth_m_s2, 15}};
  }
  std::vector<Driven> driven(cases.size());
  for_each_job(cases.size(), [&](std::size_t i) {
    sim::ardito::RoverOptions options{.gravity_m_s2 = cases[i].gravity_m_s2,
                                      .slope_rad = cases[i].slope_deg * kDegree};
    if (cases[i].soil != std::string("hard")) options.soil = sim::soil::parse_soil(cases[i].soil);
    driven[i] = drive(options, 0.2);
  });
  if (!writing()) {
    EXPECT_NEAR(driven[0].slip, 0.15, 0.05);
    EXPECT_GT(driven[1].slip, 0.95) << "a wheel pulls 23 % of its load at best";
    return;
  }
  std::string text =
      "Motors ordered to 0.2 m/s, straight ahead, the sixth second; on slopes of -15, 0, 5, 10, 15 "
      "deg. *Slip*: lost share of the treads'\nmean speed, negative when the rover pushes its "
      "wheels; *depth*, *current* of the worst wheel (rated 4 A, limit 10 A).\n\n"
      "| soil, gravity | slip, % | depth, mm | current, A |\n|---|---|---|---|\n";
  for (std::size_t i = 0; i < cases.size(); i += kSlopes_deg.size()) {
    std::string slip, depth, current;
    for (std::size_t k = i; k < i + kSlopes_deg.size(); ++k) {
      const char* comma = k == i ? "" : ", ";
      slip += fmt::format("{}{:.0f}", comma, driven[k].slip * 100);
      depth += fmt::format("{}{:.0f}", comma, driven[k].sinkage_m * 1e3);
      current += fmt::format("{}{:.2f}", comma, driven[k].current_A);
    }
    if (cases[i].soil == std::string("hard")) depth = "-";
    text += fmt::format("| {}, {} | {} | {} | {} |\n", cases[i].soil,
                        cases[i].gravity_m_s2 > 5 ? "Earth" : "Moon", slip, depth, current);
  }
  fmt::print("{}", text);
  write("Ardito on soil", "ArditoSoil.Drives", text);
}

// ---- false alarms

struct Place {
  const char* name;
  sim::ardito::RoverOptions rover;
};

constexpr double kRocks = 0.5;  // of the square metres

std::vector<Place> places() {
  const sim::soil::Soil regolith = sim::soil::parse_soil("regolith");
  return {
      {"slope of 10 deg, Earth", {.soil = regolith, .slope_rad = 10 * kDegree}},
      {"slope of 15 deg, Earth", {.soil = regolith, .slope_rad = 15 * kDegree}},
      {"hills, Earth", {.ground = Ground::hills, .soil = regolith}},
      {"rough, Earth", {.ground = Ground::rough, .soil = regolith}},
      {"rocks, Earth", {.soil = regolith, .rocks = kRocks}},
      {"hills with rocks, Moon",
       {.ground = Ground::hills, .soil = regolith, .gravity_m_s2 = kMoon_m_s2, .rocks = kRocks}},
      {"slope of 15 deg, Moon",
       {.soil = regolith, .gravity_m_s2 = kMoon_m_s2, .slope_rad = 15 * kDegree}},
      {"hard hills, Earth", {.ground = Ground::hills}},
      {"hard, rough, Earth", {.ground = Ground::rough}},
      {"hard, rocks, Earth", {.rocks = kRocks}},
  };
}

TEST(ArditoSoil, FalseAlarms) {
  if (!writing()) {
    // Up the slope, in curves, and straight on: 30 to 34 s after the start the IMU was blamed.
    const Healthy seen = drive_healthy(places()[0].rover, 0.6, 1);
    EXPECT_GE(seen.minutes, 0.6);
    EXPECT_GT(seen.slip_frames, 100ul);
    EXPECT_TRUE(seen.alarms.empty()) << seen.alarms.front();
    EXPECT_GT(seen.slowed_frames, 50ul);
    EXPECT_EQ(seen.slowed_wrong, 0ul);
    return;
  }
  const char* wanted = std::getenv("LSS_RESULTS_MINUTES");
  const double minutes = wanted == nullptr ? 60 : std::atof(wanted);
  constexpr unsigned kSeeds = 2;
  const std::vector<Place> all = places();
  std::vector<Healthy> runs(all.size() * kSeeds);
  for_each_job(runs.size(), [&](std::size_t i) {
    runs[i] = drive_healthy(all[i / kSeeds].rover, minutes / static_cast<double>(runs.size()),
                            static_cast<unsigned>(i % kSeeds) + kNewSeeds);
    fmt::print("{} {:.1f} min, {} alarms\n", all[i / kSeeds].name, runs[i].minutes,
               runs[i].alarms.size());
    std::fflush(stdout);
  });
  std::string text = fmt::format(
      "The daemon's chain over regolith, and on hard ground to compare, nothing broken, all noise "
      "on: 0.5 m/s ahead, 0.3 m/s back, straight\nand in curves of 3 deg, a stop and a turn on the "
      "spot each minute; seeds {} to {}; {:.0f} minutes in all; rocks: of {:.0f} % of the square\n"
      "metres, 10 to 60 mm high. On the Moon `mobility.slip_load` is 0.03: motors push with the "
      "weight. *Stuck*: stopped as stuck, and truly\nslower than half the speed of its wheels. "
      "*Slowed*: by slip, frames; *wrongly*: of them those in which the treads truly lose less\n"
      "than a quarter of their speed.\n\n"
      "| place | minutes | way, m | frames with a suspicion | with slip | slowed | wrongly | with "
      "a clutch probe | stuck | wheels isolated | sensors left out | FatalErrors |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      kNewSeeds, kNewSeeds + kSeeds - 1, minutes, kRocks * 100);
  std::string alarms;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Healthy sum;
    for (unsigned n = 0; n < kSeeds; ++n) sum.add(runs[i * kSeeds + n]);
    text +=
        fmt::format("| {} | {:.1f} | {:.0f} | {} of {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
                    all[i].name, sum.minutes, sum.metres, sum.suspect_frames, sum.frames,
                    sum.slip_frames, sum.slowed_frames, sum.slowed_wrong, sum.probe_frames,
                    sum.stuck, sum.isolated, sum.left_out, sum.fatal);
    std::map<std::string, int> count;  // by what, of which the first
    for (const std::string& alarm : sum.alarms) ++count[alarm.substr(alarm.find(" s: ") + 4)];
    for (const auto& [what, n] : count)
      alarms += fmt::format("- {}: {} ({}x)\n", all[i].name, what, n);
  }
  text += alarms.empty() ? "\nNo false alarm.\n" : "\nFalse alarms:\n\n" + alarms;
  fmt::print("{}", text);
  write("Ardito's failure detection on soil: false alarms", "ArditoSoil.FalseAlarms", text);
}

// ---- slowed by slip

// Up 10 deg of regolith it loses half of its wheels' speed.
TEST(ArditoSoil, SlipSlowsItAndFailuresAreFoundAndStopsComeAsBefore) {
  Chain chain({.rover = {.soil = sim::soil::parse_soil("regolith"), .slope_rad = 10 * kDegree},
               .seed = 1,
               .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }});
  ASSERT_TRUE(chain.start());
  ASSERT_TRUE(chain.drive(0.5));
  ASSERT_TRUE(chain.run_until([&] { return chain.telemetry().speed_share == 0.5; }, 10));
  chain.run(1);
  EXPECT_NEAR(chain.telemetry().slip_share, 0.45, 0.1);
  EXPECT_NEAR(chain.telemetry().measured_m_s, 0.25, 0.03);
  EXPECT_NEAR(chain.telemetry().ground_m_s, chain.world().rover().body().velocity_m_s.norm(), 0.03);
  EXPECT_EQ(chain.supervisor().fault_count, 0u);

  chain.inject("E-TM:3");
  EXPECT_TRUE(chain.run_until([&] { return chain.telemetry().wheels[2].state != 0; }, 0.6));
  chain.run(5);
  for (std::size_t i = 0; i < kWheels; ++i)
    EXPECT_EQ(chain.telemetry().wheels[i].state, i == 2 ? 1 : 0) << i;
  EXPECT_LT(chain.telemetry().speed_share, 1);
  EXPECT_FALSE(chain.has(faults::imu_lost, kImuNode));

  chain.send(CommandKind::halt);
  EXPECT_TRUE(chain.run_until(Mode::stopped, 2));
  EXPECT_EQ(chain.telemetry().speed_share, 1);
  ASSERT_TRUE(chain.drive(-0.3)) << "back, downhill";
  chain.run(3);
  EXPECT_EQ(chain.telemetry().speed_share, 1);
}

// ---- digging in

struct DugIn {
  bool noticed = false, stood = false, out = false;
  double noticed_s = 0, moving_m = 0, stopped_m = 0;  // depth of the deepest wheel: at most before
};

// Up a slope that the soil does not let it climb, then back.
DugIn dig_in(const char* soil, double slope_deg, unsigned seed) {
  Chain chain({.rover = {.soil = sim::soil::parse_soil(soil), .slope_rad = slope_deg * kDegree},
               .seed = seed,
               .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }});
  const sim::ardito::RoverPlant& rover = chain.world().rover();
  const auto deepest_m = [&] {
    double depth_m = 0;
    for (std::size_t i = 0; i < kWheels; ++i) depth_m = std::max(depth_m, rover.sinkage_m(i));
    return depth_m;
  };
  DugIn dug;
  if (!chain.start() || !chain.drive(0.3)) return dug;
  const double from_s = chain.seconds();
  dug.noticed = chain.run_until(
      [&] {
        dug.moving_m = std::max(dug.moving_m, deepest_m());
        return chain.has(faults::rover_stuck, 0);
      },
      10);
  dug.noticed_s = chain.seconds() - from_s;
  chain.run(2);
  dug.stood = true;
  for (const sim::ShaftState& wheel : rover.wheels())
    dug.stood = dug.stood && std::abs(wheel.velocity_rad_s) < 0.05;
  dug.stopped_m = deepest_m();
  const Eigen::Vector3d at_m = rover.body().position_m;
  if (!chain.drive(-0.3)) return dug;
  chain.run(4);
  dug.out = at_m.x() - rover.body().position_m.x() > 0.5 && !chain.has(faults::rover_stuck, 0);
  return dug;
}

TEST(ArditoSoil, DigsIn) {
  const unsigned seeds = seeds_of_results();
  const std::vector<std::pair<const char*, double>> cases = {{"regolith", 15}, {"sand", 10}};
  const std::size_t tried = writing() ? cases.size() : 1;
  std::vector<DugIn> runs(tried * seeds);
  for_each_job(runs.size(), [&](std::size_t i) {
    const auto& [soil, slope_deg] = cases[i / seeds];
    runs[i] = dig_in(soil, slope_deg, static_cast<unsigned>(i % seeds + 1));
  });
  std::string text = fmt::format(
      "Up a slope that is too steep, at 0.3 m/s in the Earth's gravity, then by command backward "
      "for 4 s; seeds 1 to {}. *Noticed*: from\nthe wheels' start to `rover_stuck`; *depth* of the "
      "deepest wheel; *stopped*: all wheels stand 2 s later; *out*: more than 0.5 m\nback, and not "
      "stuck again.\n\n"
      "| soil | slope, deg | noticed | after, s | depth till then, mm | stopped | depth then, mm | "
      "out "
      "|\n|---|---|---|---|---|---|---|---|\n",
      seeds);
  for (std::size_t c = 0; c < tried; ++c) {
    unsigned noticed = 0, stood = 0, out = 0;
    double least_s = 1e9, most_s = 0, moving_m = 0, stopped_m = 0;
    for (unsigned n = 0; n < seeds; ++n) {
      const DugIn& run = runs[c * seeds + n];
      noticed += run.noticed ? 1 : 0, stood += run.stood ? 1 : 0, out += run.out ? 1 : 0;
      least_s = std::min(least_s, run.noticed_s), most_s = std::max(most_s, run.noticed_s);
      moving_m = std::max(moving_m, run.moving_m), stopped_m = std::max(stopped_m, run.stopped_m);
    }
    if (!writing()) {
      EXPECT_EQ(noticed, seeds);
      EXPECT_EQ(stood, seeds);
      EXPECT_EQ(out, seeds);
      EXPECT_LT(most_s, 5);
    }
    text +=
        fmt::format("| {} | {:.0f} | {} of {} | {:.1f} to {:.1f} | {:.0f} | {} | {:.0f} | {} |\n",
                    cases[c].first, cases[c].second, noticed, seeds, least_s, most_s,
                    moving_m * 1e3, stood, stopped_m * 1e3, out);
  }
  fmt::print("{}", text);
  if (writing()) write("Ardito digs itself in", "ArditoSoil.DigsIn", text);
}

// ---- one wheel digs itself in

// A patch of softer soil in the way of one wheel, in regolith.
struct SoftPlace {
  const char* patch;
  double slope_deg = 0;
  Ground ground = Ground::flat;
  double gravity_m_s2 = kEarth_m_s2;
  const char* fault = "";  // of lss-sim, from the beginning

  // Patch, ground and slope, with this between them.
  std::string name(const char* between) const {
    return fmt::format("{}{}{}, {}{}{:.0f}", patch, between,
                       ground == Ground::hills ? "hills" : "level",
                       gravity_m_s2 == kMoon_m_s2 ? "Moon" : "Earth", between, slope_deg);
  }
};

struct Embedded {
  bool noticed = false, stuck = false, stood = false, out = false;
  double noticed_s = 0;                // since the wheel came to the patch
  double moving_m = 0, stopped_m = 0;  // its depth
  double in_m = 0;                     // way of its axle into the patch
  double out_s = 0;                    // of the way back
  std::string wrong;                   // other faults
};

struct WayOut {
  const char* name = "";
  double speed_m_s = -0.3;
  bool free = false;  // the clutch of the wheel is open
};

// This wheel alone comes to the patch, then back by command until it is out, for 30 s at most.
Embedded embed(const SoftPlace& place, std::size_t wheel, unsigned seed, const WayOut& way = {}) {
  constexpr double kFrom_m = 1, kOut_m = 0.02;
  constexpr std::array kAxle_m = {0.542, 0.542, -0.07, -0.07, -0.657, -0.657};
  sim::ardito::RoverOptions options{.ground = place.ground,
                                    .soil = sim::soil::parse_soil("regolith"),
                                    .gravity_m_s2 = place.gravity_m_s2,
                                    .slope_rad = place.slope_deg * kDegree};
  options.patches.push_back(
      sim::ardito::parse_patch(fmt::format("{}@{}@{}..100", place.patch, wheel + 1, kFrom_m)));
  Chain chain({.rover = options, .seed = seed, .adjust = [&](Parameters& p) {
                 p.beacon_ns = 1500 * kMillisecond;
                 p.mobility.slip_load *= place.gravity_m_s2 / kEarth_m_s2;
               }});
  const sim::ardito::RoverPlant& rover = chain.world().rover();
  const auto subject = static_cast<std::uint16_t>(wheel + 1);
  Embedded run;
  const auto judge = [&](const char* when) {
    for (const FaultRecord& fault : chain.supervisor().faults) {
      if (fault.id == FaultId::none) continue;
      if (fault.id == faults::wheel_embedded && fault.subject == subject) continue;
      if (fault.id == faults::rover_stuck && run.stuck && !run.noticed) continue;
      run.wrong += fmt::format(", {} of {} {}", info(fault.id)->name, fault.subject, when);
    }
  };
  if (!chain.start()) return run;
  if (*place.fault != 0) chain.inject(place.fault);
  if (!chain.drive(0.3)) return run;
  chain.run_until([&] { return rover.body().position_m.x() + kAxle_m[wheel] > kFrom_m; }, 30);
  const double from_s = chain.seconds();
  chain.run_until(
      [&] {
        run.moving_m = std::max(run.moving_m, rover.sinkage_m(wheel));
        run.noticed = chain.has(faults::wheel_embedded, subject);
        run.stuck = chain.has(faults::rover_stuck, 0);
        return run.noticed || run.stuck;
      },
      10);
  run.noticed_s = chain.seconds() - from_s;
  judge("on the way");
  chain.run(2);
  run.stood = true;
  for (const sim::ShaftState& one : rover.wheels())
    run.stood = run.stood && std::abs(one.velocity_rad_s) < 0.05;
  run.stopped_m = rover.sinkage_m(wheel);
  run.in_m = rover.body().position_m.x() + kAxle_m[wheel] - kFrom_m;
  if (way.free) chain.inject(fmt::format("TC:{}", subject));
  if (!chain.drive(way.speed_m_s)) return run;
  const double back_from_s = chain.seconds();
  chain.run_until(
      [&] {
        run.out = rover.sinkage_m(wheel) < kOut_m;
        return run.out || chain.mode() != Mode::running;
      },
      30);
  run.out_s = chain.seconds() - back_from_s;
  if (chain.has(faults::wheel_embedded, subject)) run.wrong += ", noticed on the way back";
  judge("on the way back");
  return run;
}

TEST(ArditoSoil, OneWheelDigsIn) {
  const unsigned seeds = seeds_of_results();
  std::vector<SoftPlace> places = {{"sand:0.1"}, {"sand:0.1", 5}};
  if (writing()) {
    places = {{"sand:0.05"},
              {"sand:0.1"},
              {"sand:0.1", -5},
              {"sand:0.1", 5},
              {"sand:0.2", 5},
              {"sand:0.1", 8},
              {"sand:0.1", 0, Ground::hills},
              {"sand:0.1", 0, Ground::flat, kMoon_m_s2}};
  }
  std::vector<Embedded> runs(places.size() * seeds);
  for_each_job(runs.size(), [&](std::size_t i) {
    const auto n = static_cast<unsigned>(i % seeds);
    const Embedded& run = runs[i] =
        embed(places[i / seeds], writing() ? n % kWheels : 3, n + kNewSeeds);
    fmt::print("{}, seed {}: {}, {:.0f} mm, {:.1f} m in, {}{}\n", places[i / seeds].name(", "),
               n + kNewSeeds,
               run.noticed ? fmt::format("noticed after {:.1f} s", run.noticed_s) : "not noticed",
               run.moving_m * 1e3, run.in_m,
               run.out ? fmt::format("out after {:.1f} s", run.out_s) : "not out", run.wrong);
    std::fflush(stdout);
  });
  std::string text = fmt::format(
      "On regolith, at 0.3 m/s, one wheel comes to much softer soil, the others do not; then by "
      "command backward for 30 s at most; seeds {} to {}\n(the limits were chosen with others), "
      "wheel 1 to 6 in turn. *Noticed*: `wheel_embedded` of this wheel; *after*: from its axle's "
      "way into\nthe patch, least to most; *stuck*: stopped as stuck instead; *depth* of the "
      "wheel, at most; *stopped*: all wheels stand 2 s later; *in*: way of\nthe axle into the "
      "patch, at most; *out*: less than 20 mm deep, so long after the wheels began to turn "
      "back.\n\n"
      "| soil of the patch | ground | slope, deg | noticed | after, s | stuck | depth till then, "
      "mm | stopped | depth then, mm | in, m | out | after, s |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      kNewSeeds, kNewSeeds + seeds - 1);
  std::map<std::string, std::string> failures;  // by place and what: which wheels and seeds
  for (std::size_t c = 0; c < places.size(); ++c) {
    unsigned noticed = 0, stuck = 0, stood = 0, out = 0;
    double least_s = 1e9, most_s = 0, moving_m = 0, stopped_m = 0;
    double in_m = 0, soonest_s = 1e9, latest_s = 0;
    for (unsigned n = 0; n < seeds; ++n) {
      const Embedded& run = runs[c * seeds + n];
      in_m = std::max(in_m, run.in_m);
      if (run.out)
        soonest_s = std::min(soonest_s, run.out_s), latest_s = std::max(latest_s, run.out_s);
      noticed += run.noticed ? 1 : 0, stuck += run.stuck ? 1 : 0;
      stood += run.stood ? 1 : 0, out += run.out ? 1 : 0;
      if (run.noticed)
        least_s = std::min(least_s, run.noticed_s), most_s = std::max(most_s, run.noticed_s);
      moving_m = std::max(moving_m, run.moving_m);
      std::string what = run.wrong;
      if (!run.noticed) what += run.stuck ? ", stuck" : ", missed";
      if (!run.stood) what += ", does not stop";
      if (!run.out) what += ", not out";
      if (what.empty()) continue;
      failures[fmt::format("{:02} {} deg: {}", c, places[c].name(", "), what.substr(2))] +=
          fmt::format(" {}/{}", (writing() ? n % kWheels : 3) + 1, n + kNewSeeds);
    }
    text += fmt::format("| {} | {} of {} | {} | {} | {:.0f} | {} | {:.0f} | {:.1f} | {} | {} |\n",
                        places[c].name(" | "), noticed, seeds,
                        noticed == 0 ? "-" : fmt::format("{:.1f} to {:.1f}", least_s, most_s),
                        stuck, moving_m * 1e3, stood, stopped_m * 1e3, in_m, out,
                        out == 0 ? "-" : fmt::format("{:.1f} to {:.1f}", soonest_s, latest_s));
    if (writing()) continue;
    EXPECT_EQ(noticed, seeds);
    EXPECT_EQ(stood, seeds);
    EXPECT_EQ(out, seeds);
    EXPECT_LT(most_s, 3);
  }
  text += failures.empty() ? "\nNo failure.\n" : "\nFailures, wheel/seed:\n\n";
  for (const auto& [what, which] : failures)
    text += fmt::format("- {}:{}\n", what.substr(3), which);
  if (!writing()) {
    EXPECT_TRUE(failures.empty()) << text;
    return;
  }
  fmt::print("{}", text);
  write("Ardito: one wheel digs itself in", "ArditoSoil.OneWheelDigsIn", text);
}

// A wheel stands low beside one that pushes nothing: over a hole, or on its way down from a rock.
TEST(ArditoSoil, AWheelBesideOneThatCarriesNothingIsNotTakenForDugIn) {
  for (const bool digs : {false, true}) {
    Chain chain({.rover = {.soil = sim::soil::parse_soil("regolith")},
                 .seed = kNewSeeds,
                 .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }});
    ASSERT_TRUE(chain.start());
    ASSERT_TRUE(chain.drive(0.3));
    chain.run(3);
    chain.inject("encoder-jump:0x20:3:-1800");  // the right bogie: wheel 4 is lower by 67 mm
    chain.inject("encoder-jump:0x03:4:-500");   // wheel 3 brakes
    if (digs) chain.inject("encoder-jump:0x04:4:600");
    EXPECT_EQ(chain.run_until([&] { return chain.has(faults::wheel_embedded, 4); }, 5), digs);
    if (!digs) {
      EXPECT_EQ(chain.mode(), Mode::running);
    }
  }
}

// ---- a wrong angle of the right bogie, from the beginning

constexpr const char* kWrongAngles[] = {"encoder-jump:0x20:3:1800", "encoder-jump:0x20:3:-1800"};

// Over hills of regolith, where no wheel digs itself in.
struct Misled {
  bool lost = false, embedded = false;
  double way_m = 0;  // until it was found
};

Misled mislead(const char* fault, unsigned seed) {
  Chain chain({.rover = {.ground = Ground::hills, .soil = sim::soil::parse_soil("regolith")},
               .seed = seed,
               .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }});
  Misled run;
  if (!chain.start()) return run;
  chain.inject(fault);
  if (!chain.drive(0.4)) return run;
  chain.run_until(
      [&] {
        run.lost = chain.has(faults::rocker_lost, kIoNode);
        for (std::uint16_t wheel = 1; wheel <= kWheels; ++wheel)
          run.embedded = run.embedded || chain.has(faults::wheel_embedded, wheel);
        return run.lost || run.embedded;
      },
      120);
  run.way_m = chain.telemetry().distance_m;
  return run;
}

TEST(ArditoSoil, AWrongBogieAngleHidesAndFeignsWheelsThatDigThemselvesInUntilItIsFound) {
  const unsigned seeds = seeds_of_results();
  constexpr std::size_t kWrong = std::size(kWrongAngles);
  std::vector<Embedded> hidden(kWrong * seeds);
  std::vector<Misled> misled(kWrong * seeds);
  for_each_job(hidden.size() * 2, [&](std::size_t n) {
    const std::size_t i = n / 2;
    const char* fault = kWrongAngles[i / seeds];
    const auto seed = static_cast<unsigned>(i % seeds) + kNewSeeds;
    if (n % 2 == 0) {
      hidden[i] = embed({.patch = "sand:0.1", .fault = fault}, 3, seed);
    } else {
      misled[i] = mislead(fault, seed);
    }
  });
  std::string text = fmt::format(
      "From the start on the angle of the right bogie is wrong by so much. *Noticed*: wheel 4 in a "
      "patch of sand:0.1 after 1 m, as below.\n*Feigned*: `wheel_embedded` over hills of regolith "
      "without a patch; *found*: `rocker_lost`, after so many metres at 0.4 m/s. Seeds\n{} to "
      "{}.\n\n| wrong by, rad | noticed | feigned | found | after, m |\n|---|---|---|---|---|\n",
      kNewSeeds, kNewSeeds + seeds - 1);
  for (std::size_t w = 0; w < kWrong; ++w) {
    unsigned noticed = 0, embedded = 0, lost = 0;
    double least_m = 1e9, most_m = 0;
    for (unsigned n = 0; n < seeds; ++n) {
      const Misled& run = misled[w * seeds + n];
      noticed += hidden[w * seeds + n].noticed ? 1U : 0U;
      embedded += run.embedded ? 1 : 0, lost += run.lost ? 1 : 0;
      if (run.lost) least_m = std::min(least_m, run.way_m), most_m = std::max(most_m, run.way_m);
    }
    if (!writing()) {
      EXPECT_EQ(noticed, 0U) << kWrongAngles[w];
      EXPECT_EQ(lost + embedded, seeds) << "neither found nor stopped: " << kWrongAngles[w];
    }
    text += fmt::format("| {} | {} of {} | {} of {} | {} of {} | {} |\n",
                        w == 0 ? "+0.18" : "-0.18", noticed, seeds, embedded, seeds, lost, seeds,
                        lost == 0 ? "-" : fmt::format("{:.0f} to {:.0f}", least_m, most_m));
  }
  fmt::print("{}", text);
  if (writing())
    write("Ardito with a wrong bogie angle",
          "ArditoSoil.AWrongBogieAngleHidesAndFeignsWheelsThatDigThemselvesInUntilItIsFound", text);
}

// ---- failures

TEST(ArditoSoil, Failures) {
  const std::span<const FailureRow> rows = wheel_rows();
  const unsigned seeds = writing() ? 2 : 1;
  constexpr unsigned kSubjects[] = {4, 5};
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (writing() || rows[i].name == std::string_view("TC")) chosen.push_back(i);
  }
  std::vector<FailureTimes> runs(chosen.size() * seeds);
  for_each_job(runs.size(), [&](std::size_t i) {
    const auto seed = static_cast<unsigned>(i % seeds + 1);
    runs[i] = break_wheel(rows[chosen[i / seeds]], kSubjects[seed - 1],
                          {.ground = writing() ? Ground::hills : Ground::flat,
                           .speed_m_s = 0.5,
                           .seed = seed,
                           .soil = sim::soil::parse_soil("regolith")});
  });
  std::string text = fmt::format(
      "Broken on hills of regolith, the Earth's gravity, 0.5 m/s straight ahead; wheels 4 and 5, "
      "seeds 1 to {}. Columns as in\n[ardito-results.md](ardito-results.md); in brackets what was "
      "not as expected.\n\n"
      "| failures | found, worst, s | treated, frames |\n"
      "|---|---|---|\n",
      seeds);
  std::vector<std::pair<std::string, std::string>> results;  // and the failures that have it
  for (std::size_t r = 0; r < chosen.size(); ++r) {
    const FailureRow& row = rows[chosen[r]];
    FailureTimes all;
    for (unsigned n = 0; n < seeds; ++n) all.worst_of(runs[r * seeds + n]);
    std::string found, wrong;
    for (std::size_t part = 0; part < row.parts.size(); ++part) {
      const char* plus = part == 0 ? "" : " + ";
      const int frames = all.found[part];
      found += plus + (frames == FailureTimes::kNothing ? "-"
                       : frames >= FailureTimes::kNever ? "not within 8 s"
                                                        : fmt::format("{:.2f}", all.found_s[part]));
      if (!writing()) {
        EXPECT_LT(frames, 30) << row.name;
      }
    }
    for (const std::string& what : all.wrong) wrong += (wrong.empty() ? "" : ", ") + what;
    const std::string result =
        fmt::format("{} | {}{}", found,
                    all.mitigated >= FailureTimes::kNever ? "never" : std::to_string(all.mitigated),
                    wrong.empty() ? "" : " (" + wrong + ")");
    const auto same = std::find_if(results.begin(), results.end(),
                                   [&](const auto& other) { return other.first == result; });
    if (same == results.end()) {
      results.emplace_back(result, row.name);
    } else {
      same->second += fmt::format("; {}", row.name);
    }
  }
  for (const auto& [result, names] : results) text += fmt::format("| {} | {} |\n", names, result);
  fmt::print("{}", text);
  if (writing())
    write("Ardito's failure detection on soil: failures of wheels", "ArditoSoil.Failures", text);
}

}  // namespace
}  // namespace lss::ardito
