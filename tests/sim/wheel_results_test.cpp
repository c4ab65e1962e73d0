// The wheel of lss-sim beside a wheel that others measured. With LSS_WRITE_RESULTS set, into
// docs/soil.md.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "tests/support/section.h"
#include "tests/support/stamp.h"
#include "tools/lss-sim/soil/wheel.h"

namespace lss::sim::soil {
namespace {

// Q. Yu, C. Pavlov, W. Kim, A. M. Johnson, "Modeling wheeled locomotion in granular media using
// 3D-RFT and sand deformation", Journal of Terramechanics 115, 2024: the smooth wheel without slip
// angle, 10 mm/s. Means of three runs at each slip, from the data in their public repository
// 3D-RFT-wheel (commit cdd8f8f, all_smooth_data_2).
constexpr Wheel kMeasuredWheel = {.radius_m = 0.0625, .width_m = 0.06};
struct Measured {
  double slip, load_N, pull_N, depth_m;
};
constexpr Measured kMeasured[] = {
    {-1, 19.50, -38.85, 0.0500},  {-0.7, 21.84, -24.13, 0.0320}, {-0.5, 23.24, -17.15, 0.0233},
    {-0.2, 23.72, -7.31, 0.0147}, {0, 24.58, -1.34, 0.0141},     {0.23, 24.62, 0.70, 0.0175},
    {0.5, 25.28, 0.97, 0.0224},   {0.75, 24.00, 0.82, 0.0251},   {0.9, 25.67, 1.51, 0.0254},
};
// The constants of that sand are not known: ours, as strong as the depth without slip says.
constexpr const char* kSand = "sand:1.5";

TEST(WheelResults, SinksAsAMeasuredOneAtLittleSlipAndNeverPullsMore) {
  const Soil sand = parse_soil(kSand);
  std::string text = fmt::format(
      "A smooth wheel of 125 mm, 60 mm wide, 20 to 26 N, 10 mm/s: Q. Yu, C. Pavlov, W. Kim, A. M. "
      "Johnson, \"Modeling wheeled locomotion\nin granular media using 3D-RFT and sand "
      "deformation\", Journal of Terramechanics 115, 2024; means of three runs (repository\n"
      "3D-RFT-wheel, commit cdd8f8f). The model is `{}`, fitted to the depth without slip only. "
      "*Pull*: drawbar pull by load; slip is\nnegative when the wheel is braked.\n\n"
      "| slip | pull, measured | model | model with K 10 mm | depth, measured, mm | model |\n"
      "|---|---|---|---|---|---|\n",
      kSand);
  for (const Measured& m : kMeasured) {
    SCOPED_TRACE(m.slip);
    const double depth_m = sinkage_m(sand, kMeasuredWheel, m.load_N, m.slip);
    const WheelForces forces = on_soil(sand, kMeasuredWheel, depth_m, m.slip);
    const double measured = m.pull_N / m.load_N, pull = forces.pull_N() / m.load_N;
    const double deeper = depth_m / m.depth_m - 1;
    Soil lower = sand;  // end of the printed range of K, for comparison
    lower.shear_m = 0.010;
    const double lower_m = sinkage_m(lower, kMeasuredWheel, m.load_N, m.slip);
    text += fmt::format("| {:.2f} | {:+.2f} | {:+.2f} | {:+.2f} | {:.1f} | {:.1f} |\n", m.slip,
                        measured, pull,
                        on_soil(lower, kMeasuredWheel, lower_m, m.slip).pull_N() / m.load_N,
                        m.depth_m * 1e3, depth_m * 1e3);
    if (m.slip == 0) {
      EXPECT_LT(std::abs(deeper), 0.02);
    }
    if (std::abs(m.slip) <= 0.5) {
      EXPECT_LT(std::abs(deeper), 0.3);
    }
    if (m.slip >= 0) {
      EXPECT_LT(pull, measured);
      EXPECT_GT(pull, measured - 0.25);
    }
  }
  if (std::getenv("LSS_WRITE_RESULTS") == nullptr) return;
  fmt::print("{}", text);
  testing_support::write_section(LSS_DOCUMENT, "A wheel beside a measured one",
                                 "Measured " + testing_support::stamp(LSS_DOCUMENT) +
                                     " by `LSS_WRITE_RESULTS=1 sim_soil_test "
                                     "--gtest_filter=WheelResults.*`.\n" +
                                     text);
}

}  // namespace
}  // namespace lss::sim::soil
