// The legs of lss-sim in the shape of SandBot, a robot that others measured on poppy seeds: the
// firmer the seeds the faster it is, and in loose ones it stays where it is. With LSS_WRITE_RESULTS
// set, with another gait, too, and into docs/soil.md. Then in the shape of a small hexapod with
// legs of seven curvatures (one of four frequencies at each commit, LSS_EVERYTHING=1 all), and the
// same of Lunar Zebro.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>
#include <string>

#include "tests/support/everything.h"
#include "tests/support/section.h"
#include "tests/support/stamp.h"
#include "tools/lss-sim/zebro/motor.h"
#include "tools/lss-sim/zebro/soil_robot.h"

namespace lss::sim::zebro {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

// C. Li, P. B. Umbanhowar, H. Komsuoglu, D. E. Koditschek, D. I. Goldman, "Sensitive dependence of
// the motion of a legged robot on granular media", PNAS 106, 2009. Mass: abstract; length: Physics
// Today 62, 4, 2009. Legs, height of the hips: from memory. Places of the hips, width of the body:
// ours.
constexpr RobotShape kSandBot = {.mass_kg = 2.3,
                                 .length_m = 0.30,
                                 .width_m = 0.13,
                                 .hip_height_m = 0.025,
                                 .leg_diameter_m = 0.071,
                                 .leg_width_m = 0.010,
                                 .hip_x_m = {0.11, 0.11, 0, 0, -0.11, -0.11},
                                 .hip_y_m = {0.08, -0.08, 0.10, -0.10, 0.08, -0.08}};

// Each leg turns slowly through `sweep_rad` around `middle_rad` (from straight down, negative
// ahead) in the share `duty` of a cycle, fast through the rest of the turn. From memory.
struct Gait {
  double sweep_rad, middle_rad, duty;
};
constexpr Gait kHardGround = {.sweep_rad = 0.85, .middle_rad = 0.13, .duty = 0.56};
constexpr Gait kAdjusted = {.sweep_rad = 1.10, .middle_rad = -0.50, .duty = 0.45};

double angle_rad(const Gait& gait, double cycles) {
  const double whole = std::floor(cycles), part = cycles - whole;
  const double within =
      part < gait.duty ? gait.sweep_rad * part / gait.duty
                       : kTurn_rad - (kTurn_rad - gait.sweep_rad) * (1 - part) / (1 - gait.duty);
  return kTurn_rad * whole + gait.middle_rad - gait.sweep_rad / 2 + within;
}

// Factors of resistive force theory, N/cm3: tests/sim/soil_test.cpp. `middle`: their mean.
constexpr double kLoose = 0.248, kClose = 0.464;
struct Packing {
  const char* name;
  double factor_N_cm3;
};
constexpr Packing kPackings[] = {{"loose", kLoose},
                                 {"middle", (kLoose + kClose) / 2},
                                 {"close", kClose},
                                 {"firm", 100 * kClose}};
constexpr std::size_t kCount = std::size(kPackings);
constexpr std::size_t kOfLoose = 0, kOfClose = 2, kOfFirm = 3;

struct Walked {
  double speed_m_s = 0;
  double free = 0;  // share of the time that the middle of the underside is above the surface
};

// Whole cycles for 2 s, after as many. The legs turn as ordered under any load.
Walked walk(const RobotShape& shape, const soil::Soil& soil, double gravity_m_s2, const Gait& gait,
            double frequency_rad_s) {
  SoilRobot robot({.gravity_m_s2 = gravity_m_s2, .soil = soil, .scatter_rad = 0}, kStep_s, shape);
  const auto step = [&](double cycles, double most_rad_s) {
    std::array<ShaftDrive, kLegs> drives;
    for (std::size_t leg = 0; leg < drives.size(); ++leg) {
      const bool first = leg == 0 || leg == 3 || leg == 4;
      const double away_rad =
          angle_rad(gait, cycles + (first ? 0 : 0.5)) - robot.shafts()[leg].angle_rad;
      drives[leg] = {.velocity_rad_s = std::clamp(away_rad / kStep_s, -most_rad_s, most_rad_s),
                     .torque_limit_Nm = 1e3};
    }
    robot.step(drives);
  };
  for (int i = 0; i < 1000; ++i) step(1, 4);  // from lying, to the beginning of a cycle
  const double cycle_s = kTurn_rad / frequency_rad_s;
  const long steps = std::lround(std::ceil(2 / cycle_s) * cycle_s / kStep_s);
  const auto whole_cycles = [&](long from) {
    Walked walked;
    const BodyState before = robot.body();
    for (long i = from; i < from + steps; ++i) {
      step(1 + static_cast<double>(i + 1) * kStep_s / cycle_s, 1e3);
      if (robot.body().position_m.z() > shape.hip_height_m)
        walked.free += 1 / static_cast<double>(steps);
    }
    const Eigen::Vector3d ahead = before.attitude * Eigen::Vector3d::UnitX();
    const Eigen::Vector2d way_m = (robot.body().position_m - before.position_m).head<2>();
    walked.speed_m_s =
        way_m.dot(ahead.head<2>().normalized()) / (static_cast<double>(steps) * kStep_s);
    return walked;
  };
  whole_cycles(0);
  return whole_cycles(steps);
}

soil::Soil poppy_seeds(double factor_N_cm3) {
  return {.name = "poppy seeds", .source = "", .frictional = factor_N_cm3 * 1e6};
}

Walked walk(const Packing& packing, const Gait& gait, double frequency_rad_s) {
  return walk(kSandBot, poppy_seeds(packing.factor_N_cm3), soil::kEarth_m_s2, gait,
              frequency_rad_s);
}

constexpr const char* kMethod =
    "A robot of 2.3 kg, 30 cm long, six C-shaped legs, alternating tripods, on 1 mm poppy seeds: "
    "C. Li et al., PNAS 106, 2009 (**only the\nabstract was read**). *Limb frequency*: mean rate "
    "of turn of a leg; *loose*, *middle*, *close*, *firm*: 0.248, 0.356, 0.464, 46.4 N/cm3.\n"
    "Cells: speed in cm/s, share of the time with the middle of the underside above the surface. "
    "Nothing is fitted. **From memory**: legs\nof 71 mm, 10 mm wide, hips 25 mm high, both gaits. "
    "Ours: places of the hips, width, half circles as legs, which turn as ordered.\n\n"
    "Measured there: at most 30 cm/s with the adjusted gait; with the hard gait 60 cm/s on hard "
    "ground, about 2 cm/s on seeds. Forces of\nthe model do not depend on speed: on close seeds "
    "the robot lies deeper from 24 rad/s on, but is faster.\n\n";

TEST(SandBot, IsTheFasterTheFirmerTheSeedsAndTheFasterItsLegsAndStaysInLooseSeeds) {
  const bool writing = std::getenv("LSS_WRITE_RESULTS") != nullptr;
  std::string text = "Measured " + testing_support::stamp(LSS_SOIL_DOCUMENT) +
                     " by `LSS_WRITE_RESULTS=1 zebro_sandbot_test`.\n" + kMethod +
                     "| limb frequency, rad/s | loose | middle | close | firm | loose, hard gait "
                     "| middle, hard gait | close, hard gait | firm, hard gait |\n"
                     "|---|---|---|---|---|---|---|---|---|\n";
  std::array<Walked, kCount> before{};  // at the frequency before
  double most_free = 0;                 // on close seeds
  for (double frequency_rad_s = 4; frequency_rad_s <= 28; frequency_rad_s += 4) {
    SCOPED_TRACE(frequency_rad_s);
    text += fmt::format("| {:.0f} |", frequency_rad_s);
    std::array<Walked, kCount> all;
    for (std::size_t i = 0; i < kCount; ++i) {
      const Walked& w = all[i] = walk(kPackings[i], kAdjusted, frequency_rad_s);
      text += fmt::format(" {:.1f}, {:.0f} % |", w.speed_m_s * 100, w.free * 100);
      if (i == kOfLoose) continue;
      EXPECT_GT(w.speed_m_s, all[i - 1].speed_m_s + 0.01) << kPackings[i].name;
      EXPECT_GT(w.speed_m_s, before[i].speed_m_s + 0.01) << kPackings[i].name;
      EXPECT_GE(w.free, all[i - 1].free) << kPackings[i].name;
    }
    EXPECT_LT(std::abs(all[kOfLoose].speed_m_s), 0.01);
    EXPECT_EQ(all[kOfLoose].free, 0);
    EXPECT_GT(all[kOfFirm].free, 0.99);
    most_free = std::max(most_free, all[kOfClose].free);
    before = all;
    for (const Packing& packing : kPackings) {
      if (!writing) break;
      const Walked w = walk(packing, kHardGround, frequency_rad_s);
      text += fmt::format(" {:.1f}, {:.0f} % |", w.speed_m_s * 100, w.free * 100);
    }
    text += "\n";
  }
  EXPECT_GT(most_free, 0.2);
  EXPECT_LT(before[kOfClose].free, most_free / 2) << "fast legs dig";
  fmt::print("{}", text);
  if (writing)
    testing_support::write_section(LSS_SOIL_DOCUMENT, "Legs beside a measured robot", text);
}

// A robot of Li, Zhang and Goldman, Science 339, 2013: supplementary text. Hips, height of the
// underside: their film of their simulation (movie S6), where the body moves in a plane. Here the
// middle hips are twice as far out, so that a tripod does not turn the body: the others 30 to 100
// mm out change the speed by at most 0.6 cm/s.
constexpr RobotShape kSmallHexapod = {.mass_kg = 0.150,
                                      .length_m = 0.13,
                                      .width_m = 0.02,
                                      .hip_height_m = 0.009,
                                      .leg_diameter_m = 0.041,
                                      .leg_width_m = 0.010,
                                      .hip_x_m = {0.0506, 0.0506, 0, 0, -0.0506, -0.0506},
                                      .hip_y_m = {0.05, -0.05, 0.10, -0.10, 0.05, -0.05}};
constexpr Gait kEven = {.sweep_rad = kTurn_rad / 2, .middle_rad = 0, .duty = 0.5};

// Speeds on loose seeds at 1, 2, 3 and 4 turns of a leg per second: figure S13 B and D, from the
// coordinates of its lines; the authors interpolated what they measured.
constexpr std::size_t kFrequencies = 4;
struct Curvature {
  double times_radius;
  std::array<double, kFrequencies> measured_cm_s, simulated_cm_s;  // with the same coefficients
};
constexpr Curvature kCurvatures[] = {{-1, {7.5, 14.3, 21.0, 27.0}, {10.0, 19.6, 30.5, 39.3}},
                                     {-0.92, {7.0, 13.0, 19.6, 19.5}, {8.2, 16.2, 25.5, 34.6}},
                                     {-0.6, {7.8, 15.4, 24.7, 29.5}, {8.7, 17.9, 29.7, 39.6}},
                                     {1e-6, {12.0, 21.7, 30.9, 33.8}, {9.9, 22.7, 33.6, 47.5}},
                                     {0.6, {14.0, 26.5, 39.0, 52.6}, {11.6, 25.4, 37.4, 54.9}},
                                     {0.92, {14.5, 27.0, 38.1, 53.0}, {13.6, 27.0, 39.3, 57.0}},
                                     {1, {14.5, 26.7, 36.3, 49.6}, {15.4, 29.3, 42.8, 59.7}}};
constexpr std::size_t kLegShapes = std::size(kCurvatures);

constexpr const char* kCurvatureMethod =
    "A robot of 150 g, 13 cm long, on loose poppy seeds (0.248 N/cm3): C. Li, T. Zhang, D. I. "
    "Goldman, Science 339, 2013 (**only the supplementary\ntext was read**); speeds from the lines "
    "of its figure S13 B and D. Six legs of 41 mm, 10 mm wide, alternating tripods that turn "
    "evenly.\n*Curvature*: times the radius; 1: C-legs, convex side first; -1: hollow side first. "
    "Cells: speed in cm/s, measured / simulated by the authors\nwith the same coefficients, in a "
    "plane / here. Nothing is fitted. Hips and height of the underside: from the authors' film. "
    "Ours: no force\non front and rear; the middle hips twice as far out, so that the body stays "
    "in a plane, too. With all 60 mm out some legs are 5 cm/s\nslower at 4 Hz, with all 20 mm out "
    "some overturn it.\n\n";

double worst(double now, double value) { return std::abs(value) > std::abs(now) ? value : now; }

TEST(SmallHexapod, IsAboutAsFastAsMeasuredWithLegsOfEachCurvature) {
  const bool writing = std::getenv("LSS_WRITE_RESULTS") != nullptr;
  std::array<std::array<Walked, kFrequencies>, kLegShapes> all;
  double slow = 0, fast = 0, simulated = 0;  // worst errors: up to 3 turns, at 4, of the authors
  for (std::size_t f = 0; f < kFrequencies; ++f) {
    if (!writing && !testing_support::in_sample(f, kFrequencies)) continue;
    for (std::size_t i = 0; i < kLegShapes; ++i) {
      const Curvature& legs = kCurvatures[i];
      SCOPED_TRACE(fmt::format("curvature {}, {} Hz", legs.times_radius, f + 1));
      RobotShape shape = kSmallHexapod;
      shape.leg_curvature = legs.times_radius;
      const Walked w = all[i][f] = walk(shape, poppy_seeds(kLoose), soil::kEarth_m_s2, kEven,
                                        static_cast<double>(f + 1) * kTurn_rad);
      const double more = 100 * w.speed_m_s / legs.measured_cm_s[f] - 1;
      const double theirs = 100 * w.speed_m_s / legs.simulated_cm_s[f] - 1;
      (f < 3 ? slow : fast) = worst(f < 3 ? slow : fast, more);
      simulated = worst(simulated, theirs);
      EXPECT_GT(more, -0.3);
      EXPECT_LT(more, f < 3 ? 0.3 : 0.6);
      EXPECT_GT(theirs, -0.3);
      EXPECT_LT(theirs, 0.1);
      // Measured: slowest are hollow legs of -0.92, then the more convex the faster up to 0.92.
      if (i >= 2) {
        EXPECT_GT(w.speed_m_s, all[i - 1][f].speed_m_s);
      }
      if (f > 0) {
        EXPECT_GT(w.speed_m_s, all[i][f - 1].speed_m_s);  // 0 of one that is not in the sample
      }
    }
    EXPECT_GT(all[0][f].speed_m_s, all[1][f].speed_m_s);
    EXPECT_LT(all[0][f].free, 0.1) << "hollow legs lift less";
    EXPECT_GT(all[kLegShapes - 1][f].free, 0.5);
  }
  if (!writing) return;
  std::string text = "Measured " + testing_support::stamp(LSS_SOIL_DOCUMENT) +
                     " by `LSS_WRITE_RESULTS=1 zebro_sandbot_test`.\n" + kCurvatureMethod +
                     "| curvature | 1 Hz | 2 Hz | 3 Hz | 4 Hz |\n|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < kLegShapes; ++i) {
    const Curvature& legs = kCurvatures[i];
    text += fmt::format("| {:.2f} |", legs.times_radius);
    for (std::size_t f = 0; f < kFrequencies; ++f)
      text += fmt::format(" {:.1f} / {:.1f} / {:.1f} |", legs.measured_cm_s[f],
                          legs.simulated_cm_s[f], 100 * all[i][f].speed_m_s);
    text += "\n";
  }
  text += fmt::format(
      "\nLargest errors: {:+.0f} % up to 3 Hz, {:+.0f} % at 4 Hz; beside the "
      "authors' simulation {:+.0f} %.\n",
      100 * slow, 100 * fast, 100 * simulated);
  fmt::print("{}", text);
  testing_support::write_section(LSS_SOIL_DOCUMENT, "Legs of several curvatures", text);
}

// The gait of docs/gait-zebro.md at high speed: 40 deg in 3.6 s of 6.6 s.
TEST(ZebrosLegs, DigInOnlyWhenTheyTurnFasterThanTheirMotorsCan) {
  constexpr Gait kHigh = {.sweep_rad = 40 * kTurn_rad / 360, .middle_rad = 0, .duty = 3.6 / 6.6};
  constexpr double kAsOrdered_rad_s = kTurn_rad / 6.6;
  const bool writing = std::getenv("LSS_WRITE_RESULTS") != nullptr;
  std::string text =
      "Measured " + testing_support::stamp(LSS_SOIL_DOCUMENT) +
      " by `LSS_WRITE_RESULTS=1 zebro_sandbot_test`.\nLunar Zebro's shape in `sand`, tripod, 40 "
      "deg in 55 % of a cycle; cells as [above](#legs-beside-a-measured-robot). Its gait has 0.95 "
      "rad/s;\nthe gears allow at most 2.05 rad/s, also while a leg swings.\n\n"
      "| limb frequency, rad/s | Earth | Moon |\n|---|---|---|\n";
  const soil::Soil sand = soil::parse_soil("sand");
  std::array<double, 2> last_free = {1, 1};
  for (const double faster : {1.0, 2.0, 4.0, 8.0, 16.0, 32.0}) {
    const double frequency_rad_s = faster * kAsOrdered_rad_s;
    SCOPED_TRACE(frequency_rad_s);
    text += fmt::format("| {:.2f} |", frequency_rad_s);
    for (std::size_t i = 0; i < last_free.size(); ++i) {
      const double gravity_m_s2 = i == 0 ? soil::kEarth_m_s2 : soil::kMoon_m_s2;
      const Walked w = walk({}, sand, gravity_m_s2, kHigh, frequency_rad_s);
      text += fmt::format(" {:.1f}, {:.0f} % |", w.speed_m_s * 100, w.free * 100);
      if (frequency_rad_s < motor::kMaxSpeed_rad_s) {
        EXPECT_GT(w.free, 0.95);
        EXPECT_GT(w.speed_m_s, 0.01 * faster);
      }
      last_free[i] = w.free;
    }
    text += "\n";
  }
  EXPECT_LT(last_free[0], 0.5);
  EXPECT_LT(last_free[1], 0.5);
  fmt::print("{}", text);
  if (writing)
    testing_support::write_section(LSS_SOIL_DOCUMENT, "How fast Lunar Zebro's legs may turn", text);
}

}  // namespace
}  // namespace lss::sim::zebro
