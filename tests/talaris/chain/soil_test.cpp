// TALARIS takes off from soil and lands on it, by the whole chain. With LSS_WRITE_RESULTS set, all
// of it, into docs/soil.md; else a sample as a test.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "idl/talaris/codes.h"
#include "tests/support/section.h"
#include "tests/support/stamp.h"
#include "tests/talaris/chain/campaigns.h"
#include "tests/talaris/chain/many.h"

namespace lss::talaris {
namespace {

FlightPlan on(FlightPlan plan, const std::string& ground) {
  if (ground == "hard") return plan;
  plan.world = [soil = sim::soil::parse_soil(ground)](sim::talaris::TalarisOptions& world) {
    world.plant.soil = soil;
  };
  return plan;
}

bool descends(Chain& chain) { return chain.phase() == Phase::descend; }

// Contact is left to the IMU: no height, or that above a hole.
FlightPlan with(const char* fault) { return {.faults = {fault}, .strike = descends}; }

TEST(TalarisSoil, FliesAsPlannedFromSoilToSoil) {
  for (const char* ground : {"sand", "sand:0.25"}) {
    for (const unsigned seed : {1u, 41u, 181u}) {  // 41, 181: light for their fans
      const Flown flown = fly(on({}, ground), seed);
      SCOPED_TRACE(std::string(ground) + " " + flown.text());
      EXPECT_TRUE(flown.accepted);
      EXPECT_TRUE(flown.upright());
      EXPECT_TRUE(flown.succeeded);
      EXPECT_TRUE(safe(flown));
      EXPECT_FALSE(wrong(flown));
      EXPECT_NEAR(flown.max_height_m, 2, 0.1);
      EXPECT_GT(flown.noticed_s, 0);
      EXPECT_LT(flown.noticed_s, 1);
      EXPECT_LT(flown.ground_tilt_deg, 3);
      EXPECT_GT(flown.sinkage_m, 0.012);
    }
  }
}

TEST(TalarisSoil, WithoutHeightItNoticesSoilByTheImu) {
  for (const char* fault : {"altimeter-silent", "altimeter-offset:0.7"}) {
    for (const char* ground : {"sand", "sand:0.25"}) {
      const Flown flown = fly(on(with(fault), ground), 1);
      SCOPED_TRACE(fmt::format("{} {} {}", fault, ground, flown.text()));
      EXPECT_TRUE(flown.upright());
      EXPECT_FALSE(wrong(flown));
      EXPECT_LT(flown.noticed_s, 5);
    }
  }
}

// Nothing moves on it, on a slope and in the wind neither.
TEST(TalarisSoil, CalibrationTakesAsLongAndFindsTheVerticalAsOnHardGround) {
  constexpr unsigned kSeed = 1;
  constexpr double kSame = 2e-4;
  const auto calibrated = [](const char* ground) {
    sim::talaris::TalarisOptions world;
    if (const FlightPlan plan = on({}, ground); plan.world) plan.world(world);
    Chain chain(
        {.world = sim::talaris::dispersed(world, kSeed, sim::talaris::kWide), .seed = kSeed});
    EXPECT_TRUE(chain.prepare()) << ground;
    const Eigen::Vector3d up = Eigen::Vector3d::UnitX();
    const Eigen::Vector3d error =
        chain.vehicle().nav().q_NB.conjugate() * up - chain.body().attitude.conjugate() * up;
    return std::pair(chain.seconds(), error);
  };
  const auto [took_s, error] = calibrated("hard");
  for (const char* ground : {"loam", "regolith", "sand:0.25"}) {
    const auto [there_s, there] = calibrated(ground);
    EXPECT_EQ(there_s, took_s) << ground;
    EXPECT_LT((there - error).norm(), kSame) << ground;
  }
}

struct Row {
  const char* name;
  FlightPlan plan;
  std::vector<const char*> grounds;
};

// "As planned" by fans alone says nothing of the place.
bool told_wrongly(const FlightPlan& plan, const Flown& f) {
  return plan.program == Program::hop ? wrong(f) : f.succeeded && !safe(f);
}

// The cells of the table, after the flight and the ground.
std::string cells(const FlightPlan& plan, const std::vector<Flown>& all, bool soil) {
  std::vector<Flown> noticed, told;  // speeds are reported when nothing failed
  for (const Flown& flown : all) {
    if (std::isfinite(flown.noticed_s)) noticed.push_back(flown);
    if (flown.told_down_m_s > 0) told.push_back(flown);
  }
  const auto most = [](const std::vector<Flown>& of, auto get) { return figures(of, get).most(); };
  const auto pair = [&](const std::vector<Flown>& of, auto down, auto sideways) {
    return of.empty() ? "-" : fmt::format("{:.2f}, {:.2f}", most(of, down), most(of, sideways));
  };
  const Figures after = figures(noticed, [](const Flown& f) { return f.noticed_s; });
  const double depth_m = most(all, [](const Flown& f) { return f.sinkage_m; });
  return fmt::format(
      "{} of {} | {}, {} | {:.2f}, {:.2f}{} | {} | {} | {:.1f} | {} |\n",
      count(all, [](const Flown& f) { return f.upright(); }), all.size(),
      count(all, [](const Flown& f) { return f.succeeded; }),
      count(all, [&](const Flown& f) { return told_wrongly(plan, f); }), after.share(0.5),
      after.most(),
      noticed.size() < all.size() ? fmt::format(" ({} not)", all.size() - noticed.size()) : "",
      pair(
          all, [](const Flown& f) { return f.down_m_s; },
          [](const Flown& f) { return f.sideways_m_s; }),
      pair(
          told, [](const Flown& f) { return f.down_m_s - f.told_down_m_s; },
          [](const Flown& f) { return f.sideways_m_s - f.told_sideways_m_s; }),
      most(all, [](const Flown& f) { return f.ground_tilt_deg; }),
      soil ? fmt::format("{:.0f}", 1e3 * depth_m) : "-");
}

TEST(TalarisSoil, Results) {
  if (std::getenv("LSS_WRITE_RESULTS") == nullptr)
    GTEST_SKIP() << "LSS_WRITE_RESULTS=1 writes docs/soil.md";
  constexpr unsigned kSeeds = 20;
  const Row rows[] = {
      {"hop", {}, {"hard", "loam", "regolith", "sand", "sand:0.25"}},
      {"hop, wide", wide_flight(), {"hard", "regolith", "sand", "sand:0.25"}},
      {"no altimeter", with("altimeter-silent"), {"hard", "sand", "sand:0.25"}},
      {"over a hole", with("altimeter-offset:0.7"), {"hard", "sand", "sand:0.25"}},
      {"parachute", parachute_flight(), {"hard", "sand", "sand:0.25"}},
  };
  std::string text = fmt::format(
      "Measured {} by\n`LSS_WRITE_RESULTS=1 talaris_campaigns_test "
      "--gtest_filter=TalarisSoil.Results`.\n"
      "Off the same soil, seeds 1 to {}, narrow dispersion; *wide*: [a day in the "
      "field](talaris-results.md#a-day-in-the-field); *no altimeter*:\nsilent from the descent on; "
      "*over a hole*: from then on it reads 0.7 m too much. *Wrongly*: reported \"as planned\", "
      "and was not;\n*noticed*: after the first foot was in the ground. At most: speeds at "
      "touchdown; by how much the daemon's are lower (*reported less*);\ntilt since touchdown; "
      "depth of a pad in the end.\n\n"
      "| flight, ground | upright | as planned, wrongly | noticed, s: median, most | down, "
      "sideways, m/s | reported less, m/s | tilt, deg | depth, mm |\n"
      "|---|---|---|---|---|---|---|---|\n",
      testing_support::stamp(LSS_SOIL_DOCUMENT), kSeeds);
  std::string failures;
  std::map<std::string, unsigned> causes;
  for (const Row& row : rows) {
    for (const char* ground : row.grounds) {
      const auto all = runs(kSeeds, [&](unsigned seed) { return fly(on(row.plan, ground), seed); });
      const std::string line = fmt::format("| {}, {} | {}", row.name, ground,
                                           cells(row.plan, all, ground != std::string("hard")));
      std::printf("%s", line.c_str());
      std::fflush(stdout);
      text += line;
      for (const Flown& f : all) {
        const char* why = f.why == Reason::none ? "-" : info(f.why)->name;
        if (!f.succeeded && row.plan.faults.empty()) ++causes[why];
        if (f.upright() && !told_wrongly(row.plan, f)) continue;
        failures += fmt::format("- {}, {}, seed {}: {}, {:.2f} m/s down, {:.2f} sideways{}\n",
                                row.name, ground, f.seed, why, f.down_m_s, f.sideways_m_s,
                                f.upright() ? "" : ", not upright");
      }
    }
  }
  std::string others;
  for (const auto& [why, n] : causes)
    others += fmt::format("{}{} ({})", others.empty() ? "" : ", ", why, n);
  if (!others.empty()) text += "\nNot as planned without a fault: " + others + ".\n";
  if (!failures.empty()) text += "\nNot upright, or wrongly \"as planned\":\n\n" + failures;
  std::printf("%s", failures.c_str());
  testing_support::write_section(LSS_SOIL_DOCUMENT, "TALARIS lands on soil", text);
}

}  // namespace
}  // namespace lss::talaris
