// TALARIS takes off from soil and lands on it, by the whole chain. With LSS_WRITE_RESULTS set, all
// of it, into docs/soil.md; else a sample as a test.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

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

struct Row {
  const char* name;
  FlightPlan plan;
  std::vector<const char*> grounds;
};

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
      "The whole chain, off the same soil, seeds 1 to {}, narrow dispersion; *wide*: [a day in the "
      "field](talaris-results.md#a-day-in-the-field); *no\naltimeter*: silent from the descent "
      "on; *over a hole*: from then on it reads 0.7 m too much. *Wrongly*: said \"as planned\", "
      "and "
      "was not;\n*noticed*: by the daemon, after the first foot was in the ground. At most: speeds "
      "at touchdown; by how much the daemon's are lower\n(*told less*: down, sideways); tilt since "
      "touchdown; depth of a pad in the end; time from execute to the end.\n\n"
      "| flight, ground | upright | as planned, wrongly | noticed, s: median, most | down, "
      "sideways, m/s | told less, m/s | tilt, deg | depth, mm | time, s |\n"
      "|---|---|---|---|---|---|---|---|---|\n",
      testing_support::stamp(LSS_SOIL_DOCUMENT), kSeeds);
  std::string failures;
  for (const Row& row : rows) {
    for (const char* ground : row.grounds) {
      const auto all = runs(kSeeds, [&](unsigned seed) { return fly(on(row.plan, ground), seed); });
      const auto most = [&](auto get) { return figures(all, get).most(); };
      std::vector<Flown> noticed;
      for (const Flown& flown : all) {
        if (std::isfinite(flown.noticed_s)) noticed.push_back(flown);
        const bool failed = !flown.succeeded && row.plan.faults.empty();
        if (flown.upright() && !wrong(flown) && !failed) continue;
        failures +=
            fmt::format("- {}, {}, seed {}: {}, {:.2f} m/s down, {:.2f} sideways{}\n", row.name,
                        ground, flown.seed, flown.why == Reason::none ? "?" : info(flown.why)->name,
                        flown.down_m_s, flown.sideways_m_s, flown.upright() ? "" : ", not upright");
      }
      const Figures after = figures(noticed, [](const Flown& f) { return f.noticed_s; });
      const std::string line = fmt::format(
          "| {}, {} | {} of {} | {}, {} | {:.2f}, {:.2f}{} | {:.2f}, {:.2f} | {:.2f}, {:.2f} | "
          "{:.1f} | {} | {:.0f} |\n",
          row.name, ground, count(all, [](const Flown& f) { return f.upright(); }), kSeeds,
          count(all, [](const Flown& f) { return f.succeeded; }), count(all, wrong),
          after.share(0.5), after.most(),
          noticed.size() < all.size() ? fmt::format(" ({} not)", all.size() - noticed.size()) : "",
          most([](const Flown& f) { return f.down_m_s; }),
          most([](const Flown& f) { return f.sideways_m_s; }),
          most([](const Flown& f) { return f.down_m_s - f.told_down_m_s; }),
          most([](const Flown& f) { return f.sideways_m_s - f.told_sideways_m_s; }),
          most([](const Flown& f) { return f.ground_tilt_deg; }),
          ground == std::string("hard")
              ? "-"
              : fmt::format("{:.0f}", 1e3 * most([](const Flown& f) { return f.sinkage_m; })),
          most([](const Flown& f) { return f.run_s; }));
      std::printf("%s", line.c_str());
      std::fflush(stdout);
      text += line;
    }
  }
  if (!failures.empty()) text += "\nNot as planned without a fault, or not upright:\n\n" + failures;
  std::printf("%s", failures.c_str());
  testing_support::write_section(LSS_SOIL_DOCUMENT, "TALARIS lands on soil", text);
}

}  // namespace
}  // namespace lss::talaris
