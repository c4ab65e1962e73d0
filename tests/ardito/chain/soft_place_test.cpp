// A wheel of D.I.A.N.A. Ardito in softer soil than the others: it digs itself in, that is noticed,
// and the rover drives back out. With LSS_WRITE_RESULTS set, all of it, into docs/soil.md; else a
// sample as a test.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "idl/angles.h"
#include "idl/ardito/codes.h"
#include "tests/ardito/chain/soil_document.h"

namespace lss::ardito {
namespace {

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
  double noticed_s = 0;  // since the wheel came to the patch
  double moving_m = 0;   // its depth, at most
  double in_m = 0;       // way of its axle into the patch
  double out_s = 0;      // of the way back
  std::string wrong;     // other faults
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
  const std::vector<unsigned> seeds = seeds_from(kNewSeeds);
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
  const auto wheel_of = [](unsigned seed) { return (seed - kNewSeeds) % kWheels; };
  std::vector<Embedded> runs(places.size() * seeds.size());
  for_each_job(runs.size(), [&](std::size_t i) {
    const SoftPlace& place = places[i / seeds.size()];
    const unsigned seed = seeds[i % seeds.size()];
    const Embedded& run = runs[i] = embed(place, wheel_of(seed), seed);
    fmt::print("{}, seed {}: {}, {:.0f} mm, {:.1f} m in, {}{}\n", place.name(", "), seed,
               run.noticed ? fmt::format("noticed after {:.1f} s", run.noticed_s) : "not noticed",
               run.moving_m * 1e3, run.in_m,
               run.out ? fmt::format("out after {:.1f} s", run.out_s) : "not out", run.wrong);
    std::fflush(stdout);
  });
  std::string text = fmt::format(
      "On regolith, at 0.3 m/s, one wheel (1 to 6 in turn) comes to much softer soil; then "
      "backward for 30 s at most; seeds {} to {} (limits were\nchosen with others). *Noticed*: "
      "`wheel_embedded` of this wheel, *after* its axle came to the patch; *stuck*: stopped as "
      "stuck instead; at\nmost: *depth* of the wheel, *in*, way of its axle into the patch; "
      "*stopped*: within 2 s; *out*: less than 20 mm deep, so long after it turned back.\n\n"
      "| soil of the patch | ground | slope, deg | noticed | after, s | stuck | depth till then, "
      "mm | stopped | in, m | out | after, s |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n",
      seeds.front(), seeds.back());
  std::map<std::string, std::string> failures;  // by place and what: which wheels and seeds
  for (std::size_t c = 0; c < places.size(); ++c) {
    unsigned noticed = 0, stuck = 0, stood = 0, out = 0;
    double least_s = 1e9, most_s = 0, moving_m = 0;
    double in_m = 0, soonest_s = 1e9, latest_s = 0;
    for (std::size_t n = 0; n < seeds.size(); ++n) {
      const Embedded& run = runs[c * seeds.size() + n];
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
          fmt::format(" {}/{}", wheel_of(seeds[n]) + 1, seeds[n]);
    }
    text += fmt::format("| {} | {} of {} | {} | {} | {:.0f} | {} | {:.1f} | {} | {} |\n",
                        places[c].name(" | "), noticed, seeds.size(),
                        noticed == 0 ? "-" : fmt::format("{:.1f} to {:.1f}", least_s, most_s),
                        stuck, moving_m * 1e3, stood, in_m, out,
                        out == 0 ? "-" : fmt::format("{:.1f} to {:.1f}", soonest_s, latest_s));
    if (writing()) continue;
    EXPECT_EQ(noticed, seeds.size());
    EXPECT_EQ(stood, seeds.size());
    EXPECT_EQ(out, seeds.size());
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
  bool lost = false, embedded = false, stuck = false;
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
        run.stuck = chain.has(faults::rover_stuck, 0);
        return run.lost || run.embedded || run.stuck;
      },
      120);
  run.way_m = chain.telemetry().distance_m;
  return run;
}

struct Wrong {
  std::vector<Embedded> hidden;
  std::vector<Misled> misled;
};

// Of each wrong angle, all seeds.
std::array<Wrong, std::size(kWrongAngles)> with_wrong_angles(const std::vector<unsigned>& seeds) {
  std::array<Wrong, std::size(kWrongAngles)> all;
  for (Wrong& wrong : all) wrong.hidden.resize(seeds.size()), wrong.misled.resize(seeds.size());
  for_each_job(all.size() * seeds.size() * 2, [&](std::size_t n) {
    const std::size_t which = n / 2 / seeds.size(), i = n / 2 % seeds.size();
    const char* fault = kWrongAngles[which];
    if (n % 2 == 0) {
      all[which].hidden[i] = embed({.patch = "sand:0.1", .fault = fault}, 3, seeds[i]);
    } else {
      const Misled& run = all[which].misled[i] = mislead(fault, seeds[i]);
      fmt::print("{}, seed {}: {}{} after {:.0f} m\n", fault, seeds[i],
                 run.lost ? "found" : "not found",
                 run.embedded ? ", dug in by mistake"
                 : run.stuck  ? ", stuck"
                              : "",
                 run.way_m);
      std::fflush(stdout);
    }
  });
  return all;
}

class WrongBogieAngle : public testing::TestWithParam<unsigned> {};

TEST_P(WrongBogieAngle, HidesAndFeignsWheelsThatDigThemselvesInUntilItIsFound) {
  LSS_SKIP_OUTSIDE_SAMPLE(GetParam(), kSeedsOfResults);
  for (const Wrong& wrong : with_wrong_angles({kNewSeeds + GetParam()})) {
    EXPECT_FALSE(wrong.hidden[0].noticed);
    const Misled& misled = wrong.misled[0];
    EXPECT_TRUE(misled.lost || misled.embedded || misled.stuck) << "neither found nor stopped";
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, WrongBogieAngle, testing::Range(0U, kSeedsOfResults));

TEST(ArditoSoil, WrongBogieAngles) {
  if (!writing()) GTEST_SKIP() << "LSS_WRITE_RESULTS=1 writes docs/soil.md";
  const std::vector<unsigned> seeds = seeds_from(kNewSeeds);
  const auto all = with_wrong_angles(seeds);
  std::string text = fmt::format(
      "From the start on the angle of the right bogie is wrong by so much; seeds {} to {}. "
      "*Noticed*: wheel 4 in a patch of sand:0.1 after 1 m.\n*Feigned*: `wheel_embedded` over "
      "hills of regolith without a patch; *found*: `rocker_lost`, after so many metres at 0.4 "
      "m/s.\n\n| wrong by, rad | noticed | feigned | found | after, m |\n|---|---|---|---|---|\n",
      seeds.front(), seeds.back());
  for (std::size_t w = 0; w < all.size(); ++w) {
    unsigned noticed = 0, embedded = 0, lost = 0;
    double least_m = 1e9, most_m = 0;
    for (const Embedded& run : all[w].hidden) noticed += run.noticed ? 1U : 0U;
    for (const Misled& run : all[w].misled) {
      embedded += run.embedded ? 1U : 0U, lost += run.lost ? 1U : 0U;
      if (run.lost) least_m = std::min(least_m, run.way_m), most_m = std::max(most_m, run.way_m);
    }
    text +=
        fmt::format("| {} | {} of {} | {} of {} | {} of {} | {} |\n", w == 0 ? "+0.18" : "-0.18",
                    noticed, seeds.size(), embedded, seeds.size(), lost, seeds.size(),
                    lost == 0 ? "-" : fmt::format("{:.0f} to {:.0f}", least_m, most_m));
  }
  fmt::print("{}", text);
  write("Ardito with a wrong bogie angle", "ArditoSoil.WrongBogieAngles", text);
}

}  // namespace
}  // namespace lss::ardito
