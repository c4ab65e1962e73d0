// D.I.A.N.A. Ardito on soil: how it drives, by its motors alone, and what the whole chain makes of
// slip. With LSS_WRITE_RESULTS set, all of it, into docs/soil.md; else a sample as a test.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "idl/angles.h"
#include "idl/ardito/codes.h"
#include "tests/ardito/chain/drives.h"
#include "tests/ardito/chain/fault_runs.h"
#include "tests/ardito/chain/soil_document.h"
#include "tools/lss-sim/ardito/train.h"

namespace lss::ardito {
namespace {

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
  const auto soft =
      std::ranges::count_if(all, [](const Place& place) { return place.rover.soil.has_value(); });
  const double each_minutes = minutes / static_cast<double>(soft * kSeeds);
  std::vector<Healthy> runs(all.size() * kSeeds);
  for_each_job(runs.size(), [&](std::size_t i) {
    runs[i] = drive_healthy(all[i / kSeeds].rover, each_minutes,
                            static_cast<unsigned>(i % kSeeds) + kNewSeeds);
    fmt::print("{} {:.1f} min, {} alarms\n", all[i / kSeeds].name, runs[i].minutes,
               runs[i].alarms.size());
    std::fflush(stdout);
  });
  std::string text = fmt::format(
      "Over regolith, and on hard ground to compare, nothing broken, all noise on: drives as in "
      "[ardito-results.md](ardito-results.md#false-alarms);\nseeds {} to {}; {:.0f} minutes over "
      "regolith; rocks: on {:.0f} % of the square metres, 10 to 60 mm high. On the Moon "
      "`mobility.slip_load`\nis 0.03. *Stuck*: stopped as stuck, and truly slower than half the "
      "speed of its wheels. *Slowed*: by slip, frames; *wrongly*: of\nthem those in which the "
      "treads "
      "truly lose less than a quarter of their speed.\n\n"
      "| place | minutes | way, m | frames with a suspicion | with slip | slowed | wrongly | with "
      "a clutch probe | stuck |\n|---|---|---|---|---|---|---|---|---|\n",
      kNewSeeds, kNewSeeds + kSeeds - 1, minutes, kRocks * 100);
  std::string alarms;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Healthy sum;
    for (unsigned n = 0; n < kSeeds; ++n) sum.add(runs[i * kSeeds + n]);
    text +=
        fmt::format("| {} | {:.1f} | {:.0f} | {} of {} | {} | {} | {} | {} | {} |\n", all[i].name,
                    sum.minutes, sum.metres, sum.suspect_frames, sum.frames, sum.slip_frames,
                    sum.slowed_frames, sum.slowed_wrong, sum.probe_frames, sum.stuck);
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
  const std::vector<unsigned> seeds = seeds_from(1);
  const std::vector<std::pair<const char*, double>> cases = {{"regolith", 15}, {"sand", 10}};
  const std::size_t tried = writing() ? cases.size() : 1;
  std::vector<DugIn> runs(tried * seeds.size());
  for_each_job(runs.size(), [&](std::size_t i) {
    const auto& [soil, slope_deg] = cases[i / seeds.size()];
    runs[i] = dig_in(soil, slope_deg, seeds[i % seeds.size()]);
  });
  std::string text = fmt::format(
      "Up a slope that is too steep, at 0.3 m/s on the Earth, then backward for 4 s; seeds {} to "
      "{}. *Noticed*: from the wheels' start to\n`rover_stuck`; *depth* of the deepest wheel; "
      "*stopped*: within 2 s; *out*: more than 0.5 m back, and not stuck again.\n\n"
      "| soil | slope, deg | noticed | after, s | depth till then, mm | stopped | depth then, mm | "
      "out "
      "|\n|---|---|---|---|---|---|---|---|\n",
      seeds.front(), seeds.back());
  for (std::size_t c = 0; c < tried; ++c) {
    unsigned noticed = 0, stood = 0, out = 0;
    double least_s = 1e9, most_s = 0, moving_m = 0, stopped_m = 0;
    for (std::size_t n = 0; n < seeds.size(); ++n) {
      const DugIn& run = runs[c * seeds.size() + n];
      noticed += run.noticed ? 1 : 0, stood += run.stood ? 1 : 0, out += run.out ? 1 : 0;
      least_s = std::min(least_s, run.noticed_s), most_s = std::max(most_s, run.noticed_s);
      moving_m = std::max(moving_m, run.moving_m), stopped_m = std::max(stopped_m, run.stopped_m);
    }
    if (!writing()) {
      EXPECT_EQ(noticed, seeds.size());
      EXPECT_EQ(stood, seeds.size());
      EXPECT_EQ(out, seeds.size());
      EXPECT_LT(most_s, 5);
    }
    text +=
        fmt::format("| {} | {:.0f} | {} of {} | {:.1f} to {:.1f} | {:.0f} | {} | {:.0f} | {} |\n",
                    cases[c].first, cases[c].second, noticed, seeds.size(), least_s, most_s,
                    moving_m * 1e3, stood, stopped_m * 1e3, out);
  }
  fmt::print("{}", text);
  if (writing()) write("Ardito digs itself in", "ArditoSoil.DigsIn", text);
}

// ---- failures

// Of rows that are broken in the same way, a row of a table for those with the same result. In a
// test the chosen rows are found, and `most_frames` late at most.
template <class Break, class Chosen>
std::string failures(std::span<const FailureRow> rows, std::span<const unsigned> subjects,
                     const Break& break_it, const Chosen& chosen, int most_frames) {
  std::vector<const FailureRow*> broken;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (writing() || chosen(i)) broken.push_back(&rows[i]);
  }
  const std::size_t seeds = writing() ? subjects.size() : 1;
  std::vector<FailureTimes> runs(broken.size() * seeds);
  for_each_job(runs.size(), [&](std::size_t i) {
    runs[i] = break_it(*broken[i / seeds], subjects[i % seeds],
                       {.ground = writing() ? Ground::hills : Ground::flat,
                        .speed_m_s = 0.5,
                        .seed = static_cast<unsigned>(i % seeds + 1),
                        .soil = sim::soil::parse_soil("regolith")});
  });
  std::vector<std::pair<std::string, std::string>> results;  // and the failures that have it
  for (std::size_t r = 0; r < broken.size(); ++r) {
    const FailureRow& row = *broken[r];
    FailureTimes all;
    for (std::size_t n = 0; n < seeds; ++n) all.worst_of(runs[r * seeds + n]);
    std::string found, wrong;
    for (std::size_t part = 0; part < row.parts.size(); ++part) {
      const char* plus = part == 0 ? "" : " + ";
      const int frames = all.found[part];
      found += plus + (frames == FailureTimes::kNothing ? "-"
                       : frames >= FailureTimes::kNever ? "not within 8 s"
                                                        : fmt::format("{:.2f}", all.found_s[part]));
      if (!writing()) {
        EXPECT_LT(frames, most_frames) << row.name;
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
  std::string text =
      "Columns as in\n[ardito-results.md](ardito-results.md); in brackets what was not as "
      "expected.\n\n| failures | found, worst, s | treated, frames |\n|---|---|---|\n";
  for (const auto& [result, names] : results) text += fmt::format("| {} | {} |\n", names, result);
  fmt::print("{}", text);
  return text;
}

TEST(ArditoSoil, Failures) {
  const std::span<const FailureRow> rows = wheel_rows();
  constexpr unsigned kSubjects[] = {4, 5};
  const std::string text = failures(
      rows, kSubjects, break_wheel,
      [&](std::size_t i) { return rows[i].name == std::string_view("TC"); }, 30);
  if (!writing()) return;
  write("Ardito's failure detection on soil: failures of wheels", "ArditoSoil.Failures",
        "Broken on hills of regolith, the Earth's gravity, 0.5 m/s straight ahead; wheels 4 and 5, "
        "seeds 1 to 2. " +
            text);
}

TEST(ArditoSoil, SteeringFailures) {
  const std::span<const FailureRow> rows = steering_rows();
  constexpr unsigned kSubjects[] = {3, 4};
  const std::string text = failures(
      rows, kSubjects, break_steering,
      [&](std::size_t i) { return testing_support::in_sample(i, rows.size()); },
      FailureTimes::kNever);
  if (!writing()) return;
  write("Ardito's failure detection on soil: failures of steering systems",
        "ArditoSoil.SteeringFailures",
        "Broken on hills of regolith, the Earth's gravity, 0.5 m/s, in a curve of 3 deg; systems "
        "of wheels 5 and 6, seeds 1 to 2. " +
            text);
}

}  // namespace
}  // namespace lss::ardito
