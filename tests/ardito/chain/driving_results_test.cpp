// Driving without failures on the whole chain in physics: false alarms, slip, dead reckoning. With
// LSS_WRITE_RESULTS set, all drives, into docs/ardito-results.md.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>

#include "idl/angles.h"
#include "tests/ardito/chain/drives.h"
#include "tests/ardito/chain/jobs.h"
#include "tests/ardito/chain/results_document.h"
#include "tests/support/everything.h"

namespace lss::ardito {
namespace {

using sim::ardito::Ground;
using testing_support::in_sample;

double minutes_wanted() {
  const char* text = std::getenv("LSS_RESULTS_MINUTES");
  return text == nullptr ? 60 : std::atof(text);
}

std::string false_alarms(unsigned grounds, const Healthy& rough, const Healthy& hills) {
  std::string text =
      measured_by("ArditoResults.FalseAlarms") +
      fmt::format(
          "Nothing broken, all noise on; 0.5 m/s ahead, 0.3 m/s back, straight and in curves of 3 "
          "deg, a stop and a turn on the spot\neach minute; seeds 1 to {} of each ground; {:.0f} "
          "minutes in all (`LSS_RESULTS_MINUTES`). Alarms: any fault, suspicion\ncounted to its "
          "end, stop or isolated wheel, but no slip (17.8.3); after one it starts again on other "
          "ground.\n\n"
          "| ground | minutes | way, m | frames with a suspicion | with slip | with a clutch probe "
          "|\n"
          "|---|---|---|---|---|---|\n",
          grounds, rough.minutes + hills.minutes);
  std::string alarms;
  for (const auto& [name, all] : {std::pair("rough", &rough), std::pair("hills", &hills)}) {
    text += fmt::format("| {} | {:.1f} | {:.0f} | {} of {} | {} | {} |\n", name, all->minutes,
                        all->metres, all->suspect_frames, all->frames, all->slip_frames,
                        all->probe_frames);
    for (const std::string& alarm : all->alarms) alarms += fmt::format("- {}: {}\n", name, alarm);
  }
  return text + (alarms.empty() ? "\nNo false alarm.\n" : "\nFalse alarms:\n\n" + alarms);
}

TEST(ArditoResults, FalseAlarms) {
  if (!writing_results()) {
    for (const Ground ground : {Ground::rough, Ground::hills}) {
      if (!in_sample(ground == Ground::hills, 2)) continue;
      const Healthy seen = drive_healthy({.ground = ground}, 0.4, 3);
      EXPECT_GE(seen.minutes, 0.4);
      EXPECT_GT(seen.metres, 5);
      EXPECT_TRUE(seen.alarms.empty()) << seen.alarms.front();
    }
    return;
  }
  constexpr unsigned kEach = 5;
  std::array<Healthy, 2 * kEach> runs;
  for_each_job(runs.size(), [&](std::size_t i) {
    runs[i] = drive_healthy({.ground = i < kEach ? Ground::rough : Ground::hills},
                            minutes_wanted() / 2 / kEach, static_cast<unsigned>(i % kEach + 1));
  });
  Healthy rough, hills;
  for (std::size_t i = 0; i < runs.size(); ++i) (i < kEach ? rough : hills).add(runs[i]);
  write_section("False alarms", false_alarms(kEach, rough, hills));
}

// Of all seeds of a drive.
class SlipRow {
 public:
  SlipRow(const std::string& name, unsigned seeds, const std::function<Slip(unsigned)>& drive)
      : name_(name), least_m_s_(1e9) {
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      const Slip slip = drive(seed);
      EXPECT_TRUE(slip.arrived) << name << ", seed " << seed;
      if (slip.yaw_rad != 0) {
        EXPECT_NEAR(slip.yaw_rad, slip.reckoned_yaw_rad, 2 * kDegree) << name;
      }
      if (slip.reckoned_m != 0) {
        EXPECT_NEAR(slip.way_m, slip.reckoned_m, 0.05 * slip.way_m) << name;
      }
      mean_m_s += slip.tread_rms_m_s / seeds;
      least_m_s_ = std::min(least_m_s_, slip.tread_rms_m_s);
      most_m_s_ = std::max(most_m_s_, slip.tread_rms_m_s);
      worst_m_s_ = std::max(worst_m_s_, slip.worst_rms_m_s);
      last_ = slip;
    }
  }
  std::string text() const {
    const std::string way = fmt::format("{:.2f}", last_.way_m),
                      both = fmt::format("{} ({:.2f})", way, last_.reckoned_m),
                      turned = fmt::format("{:.1f} ({:.1f})", last_.yaw_rad / kDegree,
                                           last_.reckoned_yaw_rad / kDegree);
    return fmt::format("| {} | {:.1f} | {:.1f} to {:.1f} | {:.1f} | {} | {} |\n", name_,
                       mean_m_s * 1e3, least_m_s_ * 1e3, most_m_s_ * 1e3, worst_m_s_ * 1e3,
                       last_.reckoned_m != 0 ? both : way, last_.yaw_rad != 0 ? turned : "-");
  }

  double mean_m_s = 0;

 private:
  std::string name_;
  double least_m_s_, most_m_s_ = 0, worst_m_s_ = 0;
  Slip last_;
};

TEST(ArditoResults, SlipAndDeadReckoning) {
  const unsigned seeds = writing_results() ? 5 : 1;
  std::string text =
      "| drive | slip of all wheels, mm/s RMS: mean | of the seeds | of the worst wheel | way, "
      "true "
      "(reckoned), m | turned, true (reckoned), deg |\n"
      "|---|---|---|---|---|---|\n";
  const auto row = [&](const std::string& name, const std::function<Slip(unsigned)>& drive) {
    const SlipRow result(name, seeds, drive);
    text += result.text();
    if (writing_results()) {
      fmt::print("{}", result.text());
      std::fflush(stdout);
    }
    return result.mean_m_s;
  };
  const auto runs = [](std::size_t number) { return writing_results() || in_sample(number, 2); };
  if (runs(0))
    row("60 mm step, left wheels; no correction", [](unsigned seed) { return climb(0, seed); });
  if (runs(1))
    row("the same; correction as shipped (plus)", [](unsigned seed) { return climb(1, seed); });
  if (writing_results())
    row("the same; correction as printed (minus)", [](unsigned seed) { return climb(-1, seed); });
  double none_m_s = 0, plus_m_s = 0;
  for (const auto& [name, ground] : {std::pair("hills", Ground::hills), {"rough", Ground::rough}}) {
    for (const double speed_m_s : {0.2, 0.5, 1.0}) {
      const bool in_short = ground == Ground::hills && speed_m_s == 0.5 && runs(2);
      if (!writing_results() && !in_short) continue;
      const std::string drive = fmt::format("{}, 30 s at {:.1f} m/s; ", name, speed_m_s);
      const auto with = [&](int sign) {
        return [=](unsigned seed) { return cross(ground, speed_m_s, sign, seed); };
      };
      const double none = row(drive + "no correction", with(0)),
                   plus = row(drive + "as shipped", with(1));
      none_m_s += none;
      plus_m_s += plus;
      if (writing_results()) row(drive + "as printed", with(-1));
    }
  }
  if (runs(2)) {
    EXPECT_LT(plus_m_s, 0.95 * none_m_s);
  }
  if (runs(3)) {
    // hubs roll along their wheels while the steering is under way
    const double s_m_s = row("flat; S: 3 deg right, 3 deg left, 4 s each",
                             [](unsigned seed) { return drive_s(seed); });
    EXPECT_LT(s_m_s, 0.030);
    row("flat; on the spot, 10 s", [](unsigned seed) { return turn_on_the_spot(seed); });
  }
  fmt::print("{}", text);
  if (!writing_results()) return;
  write_section(
      "Slip", measured_by("ArditoResults.SlipAndDeadReckoning") +
                  fmt::format("How much faster than its hub a wheel's tread moves along the ground "
                              "(true; wheels that touch it); 0.5 m/s unless\nnamed; seeds 1 to {}, "
                              "ways of the last. Dead reckoning is the daemon's, clockwise.\n\n",
                              seeds) +
                  text);
}

}  // namespace
}  // namespace lss::ardito
