// What the thesis' section 19 measured of failures, on the whole chain in physics. In short as a
// test: a sample of each class of failure is found and treated no later than the thesis says. With
// LSS_WRITE_RESULTS set, all of it, into docs/ardito-results.md.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/ardito/chain/fault_runs.h"
#include "tests/ardito/chain/jobs.h"
#include "tests/ardito/chain/results_document.h"
#include "tests/support/everything.h"

namespace lss::ardito {
namespace {

using sim::ardito::Ground;
using testing_support::in_sample;

constexpr int kFrame_ms = 100;
constexpr double kSteady_s = 0.1;

using Break = FailureTimes (*)(const FailureRow& row, unsigned subject, const DriveCase& drive);

std::string frames_text(int frames) {
  if (frames == FailureTimes::kNothing) return "-";
  return frames >= FailureTimes::kNever ? "not within 8 s" : fmt::format("{}", frames);
}

// Frame 1 is 0.1 s after the failure when that came in step.
bool no_later(int frames, double thesis_s) {
  return frames * kFrame_ms <= std::lround(thesis_s * 1000);
}

std::string found_text(const FailureTimes& times, std::size_t part) {
  return times.found[part] == FailureTimes::kNothing ? "-"
                                                     : fmt::format("{:.2f}", times.found_s[part]);
}

std::string seconds_text(const Thesis& s) { return s ? fmt::format("{:.1f}", *s) : "-"; }

std::string joined(const FailureRow& row, const std::function<std::string(std::size_t)>& cell) {
  std::string text;
  for (std::size_t i = 0; i < row.parts.size(); ++i) text += (i == 0 ? "" : " + ") + cell(i);
  return text;
}

// Against one of the thesis' tables: what is later.
std::string verdict(const FailureRow& row, const FailureTimes& in_step,
                    Thesis FailurePart::*column) {
  bool compared = false;
  for (std::size_t i = 0; i < row.parts.size(); ++i) {
    if (!(row.parts[i].*column)) continue;
    compared = true;
    if (in_step.found[i] == FailureTimes::kNothing) return "nothing left to see";
    if (!no_later(in_step.found[i], *(row.parts[i].*column)))
      return fmt::format("part {} later", i + 1);
  }
  const bool mitigates = column == &FailurePart::coppelia_s && row.mitigated_s;
  if (mitigates && !no_later(in_step.mitigated, *row.mitigated_s)) return "treated later";
  return compared ? "yes" : "-";  // or not in this table
}

std::string unexpected(const FailureTimes& times) {
  std::map<std::string, int> count;
  for (const std::string& what : times.wrong) ++count[what];
  std::string text;
  for (const auto& [what, n] : count)
    text += fmt::format("{}{} ({}x)", text.empty() ? "" : ", ", what, n);
  return text.empty() ? "-" : text;
}

// All grounds, speeds and seeds.
constexpr std::pair<const char*, Ground> kGrounds[] = {
    {"flat", Ground::flat}, {"rough", Ground::rough}, {"hills", Ground::hills}};
constexpr double kSpeeds_m_s[] = {0.2, 0.5, 1.0};
// Of each; LSS_RESULTS_SEEDS sets another number.
unsigned seeds_wanted() {
  const char* text = std::getenv("LSS_RESULTS_SEEDS");
  return text == nullptr ? 3 : static_cast<unsigned>(std::atoi(text));
}

struct Measured {
  FailureTimes in_step, flat, all;  // at 0.5 m/s on flat ground; on flat ground; everywhere
  std::string cells;                // by ground and speed
  bool varies = false;              // not as expected everywhere: the cells are worth reading
};

bool is_reference(Ground ground, double speed_m_s) {
  return ground == Ground::flat && speed_m_s == 0.5;
}

Measured measure(const FailureRow& row, std::span<const unsigned> subjects, Break break_it) {
  Measured m;
  const unsigned seeds = seeds_wanted();
  std::vector<FailureTimes> runs(std::size(kGrounds) * std::size(kSpeeds_m_s) * seeds);
  for_each_job(runs.size(), [&](std::size_t i) {
    const auto seed = static_cast<unsigned>(i % seeds + 1);
    const double speed_m_s = kSpeeds_m_s[i / seeds % std::size(kSpeeds_m_s)];
    const Ground ground = kGrounds[i / seeds / std::size(kSpeeds_m_s)].second;
    runs[i] = break_it(row, subjects[(seed - 1) % subjects.size()], {ground, speed_m_s, seed});
  });
  std::size_t run = 0;
  std::vector<FailureTimes> places;
  for (const auto& [name, ground] : kGrounds) {
    for (const double speed_m_s : kSpeeds_m_s) {
      FailureTimes here;
      for (unsigned seed = 1; seed <= seeds; ++seed) {
        const FailureTimes& one = runs[run++];
        if (is_reference(ground, speed_m_s) && seed % 2 == 1) m.in_step.worst_of(one);
        here.worst_of(one);
      }
      if (ground == Ground::flat) m.flat.worst_of(here);
      m.all.worst_of(here);
      const bool all_found =
          std::ranges::all_of(here.found, [](int frames) { return frames < FailureTimes::kNever; });
      m.cells += fmt::format(
          " {}{} |",
          all_found ? joined(row, [&](std::size_t i) { return found_text(here, i); }) : "not found",
          here.wrong.empty() ? "" : fmt::format(" ({})", unexpected(here)));
      places.push_back(here);
    }
  }
  for (const FailureTimes& here : places) {
    m.varies = m.varies || !here.wrong.empty();
    for (std::size_t i = 0; i < row.parts.size(); ++i)
      m.varies = m.varies || here.found[i] >= FailureTimes::kNever;
  }
  return m;
}

bool sooner_on_flat(const FailureRow& row, const Measured& m) {
  for (std::size_t i = 0; i < row.parts.size(); ++i) {
    if (m.all.found_s[i] - m.flat.found_s[i] > kSteady_s) return true;
  }
  return false;
}

// Both tables of the document.
std::string tables(std::span<const FailureRow> rows, std::span<const unsigned> subjects,
                   Break break_it, bool angles) {
  std::string first =
      "| failure | theoretical, s | 19.1, s | 19.2, s | here, frames | worst, s | expected "
      "treatment, s | 19.2, s | here, frames | FatalError after |";
  first += angles ? " angle 19.1, deg | 19.2 | here, worst |" : "";
  first += "\n|---|---|---|---|---|---|---|---|---|---|";
  first += angles ? "---|---|---|\n" : "\n";
  std::string second = "| failure |", line = "|---|";
  for (const auto& [name, ground] : kGrounds) {
    for (const double speed_m_s : kSpeeds_m_s) {
      second += fmt::format(" {}, {:.1f} m/s |", name, speed_m_s);
      line += "---|";
    }
  }
  second += "\n" + line + "\n";
  std::string later;  // than in the thesis
  std::string sooner;
  bool any_varies = false;
  for (const FailureRow& row : rows) {
    const Measured m = measure(row, subjects, break_it);
    const auto column = [&](Thesis FailurePart::*which) {
      return joined(row, [&](std::size_t i) { return seconds_text(row.parts[i].*which); });
    };
    first +=
        fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |", row.name,
                    column(&FailurePart::theoretical_s), column(&FailurePart::simulink_s),
                    column(&FailurePart::coppelia_s),
                    joined(row, [&](std::size_t i) { return frames_text(m.in_step.found[i]); }),
                    joined(row, [&](std::size_t i) { return found_text(m.all, i); }),
                    seconds_text(row.expected_s), seconds_text(row.mitigated_s),
                    frames_text(m.all.mitigated), row.fatal ? frames_text(m.all.fatal) : "-");
    if (angles)
      first += fmt::format(" {} | {} | {:.1f} |", row.angle_simulink, row.angle_coppelia,
                           m.all.angle_deg);
    first += "\n";
    for (const auto& [name, column_of] : {std::pair("19.1", &FailurePart::simulink_s),
                                          std::pair("19.2", &FailurePart::coppelia_s)}) {
      const std::string is = verdict(row, m.in_step, column_of);
      if (is != "yes" && is != "-") later += fmt::format("- {}, {}: {}\n", row.name, name, is);
    }
    if (sooner_on_flat(row, m))
      sooner += fmt::format("- {}: {}\n", row.name,
                            joined(row, [&](std::size_t i) { return found_text(m.flat, i); }));
    const std::string cells = fmt::format("| {} |{}\n", row.name, m.cells);
    if (m.varies) second += cells;
    any_varies = any_varies || m.varies;
    fmt::print("{}{}", first.substr(first.rfind('\n', first.size() - 2) + 1), cells);
    std::fflush(stdout);
  }
  first += "\nFound and treated no later than in 19.1 and 19.2, where these have a time";
  first += later.empty() ? ".\n" : ", except:\n\n" + later;
  if (!sooner.empty()) first += "\nSooner than *worst*, s at most on flat ground:\n\n" + sooner;
  const std::string steady = "as expected on each ground, at each speed.\n";
  if (!any_varies) return first + "\nAll are " + steady;
  return first +
         "\n*Worst, s* by ground and speed; in brackets what was not as expected, and how "
         "often. All others are\n" +
         steady + "\n" + second;
}

void check_short(std::span<const FailureRow> rows, unsigned subject, Break break_it) {
  std::size_t number = 0;
  for (const FailureRow& row : rows) {
    if (!row.in_short || !in_sample(number++, 3)) continue;
    SCOPED_TRACE(row.name);
    const FailureTimes times = break_it(row, subject, {});
    for (std::size_t i = 0; i < row.parts.size(); ++i) {
      EXPECT_LT(times.found[i], FailureTimes::kNever);
      if (row.parts[i].coppelia_s) {
        EXPECT_TRUE(no_later(times.found[i], *row.parts[i].coppelia_s))
            << row.parts[i].fault << " found in frame " << times.found[i] << ", thesis "
            << *row.parts[i].coppelia_s << " s";
      }
    }
    EXPECT_LT(times.mitigated, FailureTimes::kNever);
    if (row.mitigated_s) {
      EXPECT_TRUE(no_later(times.mitigated, *row.mitigated_s)) << times.mitigated;
    }
    EXPECT_EQ(unexpected(times), "-");
  }
}

constexpr const char* kHow =
    R"(Frames are of 0.1 s; frame 1 is the first whose SYNC came after the failure.

- *19.1*, *19.2*: the thesis' tables; - is "none" or "not tried"
- *here, frames*: broken just after a SYNC, at 0.5 m/s on flat ground; this is compared
- *worst, s*: from a failure at any moment, speed and ground to the frame that found it (TC: isolated it)
- *treatment*: until the clutch is open and the motor stopped, or the sensor is left out

)";

std::string everywhere() {
  return fmt::format("0.2, 0.5 and 1.0 m/s; flat, rough and hills; seeds 1 to {}.\n",
                     seeds_wanted());
}

TEST(ArditoResults, WheelFailures) {
  constexpr unsigned kSubjects[] = {1, 4, 5};
  if (!writing_results()) return check_short(wheel_rows(), 4, break_wheel);
  const std::string rows = tables(wheel_rows(), kSubjects, break_wheel, false);
  write_section(
      "Failures of wheels (19.1, 19.2)",
      measured_by("ArditoResults.WheelFailures") + "Straight ahead; wheels 1, 4 and 5. " +
          everywhere() + kHow + rows +
          "\nTM + TC: the clutch of a failed motor is already open. TC + TRG: the thesis has 0.1 s "
          "for TC, but 4.8 s for TC alone; here\nboth are a proven clutch test.\n");
}

TEST(ArditoResults, SteeringFailures) {
  constexpr unsigned kSubjects[] = {1, 3, 4};
  if (!writing_results()) return check_short(steering_rows(), 3, break_steering);
  const std::string rows = tables(steering_rows(), kSubjects, break_steering, true);
  write_section(
      "Failures of steering systems (19.1, 19.2)",
      measured_by("ArditoResults.SteeringFailures") +
          "In a curve of 3 deg to the left; broken while steered 3 deg to the right; second "
          "part 4 s later, while steered back.\nSystems of wheels 1, 5 and 6. " +
          everywhere() +
          "Columns as above. *Angle*: largest error of steering against its command (here it turns "
          "by up to 80 deg) until found.\n\n" +
          rows);
}

}  // namespace
}  // namespace lss::ardito
