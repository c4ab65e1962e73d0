// Altimeters at the corners, as the cycle takes them.

#include <gtest/gtest.h>

#include <algorithm>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

Parameters with_corners() {
  Parameters p = quick();
  p.navigation.corners = p.buses.has_corners = true;
  return p;
}

TalarisSample range(TimeNs time, double range_m, std::uint8_t corner, std::uint8_t error = 0) {
  return {.time_ns = time, .reading = Range{.range_m = range_m, .error = error, .corner = corner}};
}

TEST(TalarisCornerSamples, AreInTheOrderOfTimeAndApartFromTheAltimeter) {
  Sensors sensors{with_corners()};
  sensors.begin(2 * kSecond, true);
  sensors.take(range(1'900'000'000, 1.0, 0));
  for (std::uint8_t corner = 1; corner <= 2; ++corner)
    for (const TimeNs ms : {1'800, 1'900})
      sensors.take(range(ms * kMillisecond + corner, 1, corner));
  sensors.take(range(1'850'000'000, 9, 3, 15));  // an error
  sensors.take(range(1'850'000'000, 9, 5));      // there is none
  const auto batch = sensors.batch();
  EXPECT_EQ(batch.ranges.size(), 1u);
  ASSERT_EQ(batch.corners.size(), 4u);
  EXPECT_TRUE(std::ranges::is_sorted(batch.corners, {}, &gnc::talaris::RangeSample::time_ns));
  EXPECT_FALSE(sensors.corner_lost(0));
  EXPECT_TRUE(sensors.corner_lost(2)) << "errors only";
}

TEST(TalarisCornerSamples, OneThatBabblesDisplacesNoOther) {
  Sensors sensors{with_corners()};
  sensors.begin(2 * kSecond, true);
  for (int i = 0; i < 100; ++i) sensors.take(range(kSecond + i, 1, 1));
  sensors.take(range(kSecond, 1, 4));
  const auto corners = sensors.batch().corners;
  EXPECT_EQ(std::ranges::count(corners, 1, &gnc::talaris::RangeSample::corner), 5);
  EXPECT_EQ(std::ranges::count(corners, 4, &gnc::talaris::RangeSample::corner), 1);
}

// Each that is silent, by its name, until it is heard again.
TEST(TalarisFaults, AnAltimeterAtACornerThatIsSilentIsReported) {
  World w(with_corners());
  unsigned silent = 0;
  w.distort = [&](std::vector<TalarisSample>& samples) {
    const TimeNs last = samples.empty() ? 0 : samples.back().time_ns;
    for (std::uint8_t corner = 1; corner <= 4; ++corner)
      if (corner != silent) samples.push_back(range(last, 1, corner));
  };
  ASSERT_TRUE(w.start());
  w.run(5);
  for (std::uint16_t i = 0; i < 4; ++i)
    EXPECT_FALSE(
        w.has(faults::corner_altimeter_lost, static_cast<std::uint16_t>(kFirstCorner + i)));
  silent = 3;
  w.run(1.5);
  EXPECT_TRUE(w.has(faults::corner_altimeter_lost, kFirstCorner + 2));
  EXPECT_FALSE(w.has(faults::corner_altimeter_lost, kFirstCorner + 1));
  silent = 0;
  w.run(0.5);
  EXPECT_FALSE(w.has(faults::corner_altimeter_lost, kFirstCorner + 2));
}

}  // namespace
}  // namespace lss::talaris
