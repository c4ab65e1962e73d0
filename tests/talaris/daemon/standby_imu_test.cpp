// Samples of two IMUs as one stream.

#include "daemon/vehicles/talaris/standby_imu.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/allocations.h"

namespace lss::talaris {
namespace {

using gnc::talaris::Vector3;
constexpr TimeNs kFrame = 200 * kMillisecond;

// The second is off by 0.02 rad/s and 0.1 m/s2, and its y axis is the first's -z.
class TalarisStandby : public ::testing::Test {
 protected:
  TalarisStandby() : standby_(parameters()) {}
  static Parameters parameters() {
    Parameters p;
    p.standby_axes = {{{0, 1}, {2, 1}, {1, -1}}};
    return p;
  }
  double rate(TimeNs at) const { return 0.1 * std::sin(static_cast<double>(at) * 1e-9) + odd_; }

  // A frame; of the first only samples in [from, to) of it, ms.
  std::span<const StandbyImu::Sample> frame(int from = 0, int to = 200, bool second = true) {
    standby_.begin(now_, first_, true);
    first_.clear();
    for (int ms = 0; ms < 200; ms += 5) {
      const TimeNs at = now_ + ms * kMillisecond;
      if (ms >= from && ms < to)
        first_.push_back({at, Vector3(0, 0, rate(at)), Vector3(9.81, 0, 0.3)});
      if (second && ms % 10 == 5)
        standby_.take({.rate_rad_s = {0, -(rate(at) - odd_ + 0.02), 0},
                       .force_m_s2 = {9.91, -0.3, 1e-6 * static_cast<double>(++count_)}},
                      at - 2 * kMillisecond);
    }
    now_ += kFrame;
    return standby_.with(first_);
  }

  StandbyImu standby_;
  TimeNs now_ = kSecond;
  std::vector<StandbyImu::Sample> first_;
  double odd_ = 0;
  int count_ = 0;
};

void expect_whole(std::span<const StandbyImu::Sample> samples, const char* what) {
  ASSERT_GE(samples.size(), 38u) << what;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const TimeNs step = samples[i].time_ns - samples[i - 1].time_ns;
    EXPECT_GT(step, 2 * kMillisecond) << what << " " << i;
    EXPECT_LE(step, 13 * kMillisecond) << what << " " << i;
  }
  for (const auto& s : samples) {
    EXPECT_NEAR(s.force_B_m_s2.x(), 9.81, 1e-3) << what;
    EXPECT_NEAR(s.force_B_m_s2.z(), 0.3, 1e-3) << what;
    EXPECT_NEAR(s.rate_B_rad_s.z(), 0.1 * std::sin(static_cast<double>(s.time_ns) * 1e-9), 3e-3)
        << what;
  }
}

TEST_F(TalarisStandby, FillsWhatTheFirstLeavesOutAndNothingElse) {
  for (int i = 0; i < 60; ++i) {
    const auto both = frame();
    ASSERT_EQ(both.size(), first_.size());
    EXPECT_EQ(both.data()[0].time_ns, first_[0].time_ns);
  }
  EXPECT_TRUE(standby_.usable());
  expect_whole(frame(0, 90), "it stops within the frame");
  expect_whole(frame(0, 0), "it is away");
  expect_whole(frame(0, 0), "it stays away");
  expect_whole(frame(110, 200), "it comes back");
  expect_whole(frame(), "it is back");
}

TEST_F(TalarisStandby, IsNotUsedBeforeItsDifferenceIsKnownNorAfterACalibrationBegan) {
  for (int i = 0; i < 20; ++i) frame();
  EXPECT_FALSE(standby_.usable());
  EXPECT_TRUE(frame(0, 0).empty());
  for (int i = 0; i < 20; ++i) frame();
  EXPECT_TRUE(standby_.usable());
  standby_.forget();
  EXPECT_FALSE(standby_.usable());
}

TEST_F(TalarisStandby, OneThatIsSilentOrStuckIsNotUsed) {
  for (int i = 0; i < 40; ++i) frame();
  EXPECT_FALSE(standby_.silent());
  for (int i = 0; i < 3; ++i) frame(0, 200, false);
  EXPECT_TRUE(standby_.silent());
  EXPECT_TRUE(frame(0, 0, false).empty());
  for (int i = 0; i < 40; ++i) frame();
  EXPECT_TRUE(standby_.usable());
  for (int i = 0; i < 12; ++i)
    standby_.take({.rate_rad_s = {0, 0, 0}, .force_m_s2 = {9.81, 0, 0}}, now_ + i * kMillisecond);
  EXPECT_FALSE(standby_.usable());
}

TEST_F(TalarisStandby, ADifferenceThatGrowsIsReportedAfterASecondAndNotLearnt) {
  for (int i = 0; i < 60; ++i) frame();
  odd_ = 0.05;
  for (int i = 0; i < 5; ++i) {
    frame();
    EXPECT_FALSE(standby_.disagrees()) << i;
  }
  frame();
  EXPECT_TRUE(standby_.disagrees());
  for (int i = 0; i < 100; ++i) frame();
  EXPECT_TRUE(standby_.disagrees());
  odd_ = 0;
  frame();
  frame();
  EXPECT_FALSE(standby_.disagrees());
  expect_whole(frame(0, 0), "as before");
}

TEST_F(TalarisStandby, AnyNumbersAndAnyTimesAreTaken) {
  for (int i = 0; i < 40; ++i) frame();
  standby_.begin(now_, first_, true);
  for (int i = 0; i < 500; ++i)
    standby_.take(
        {.rate_rad_s = {gnc::talaris::kNaN, 1e300, -1e300}, .force_m_s2 = {i * 1e300, 0, 0}},
        now_ - (i % 7) * kSecond);
  const auto both = standby_.with(first_);
  EXPECT_LE(both.size(), 3 * StandbyImu::kMax);
  standby_.begin(now_ + kFrame, first_, true);
  for (int i = 0; i < 40; ++i) frame();
  expect_whole(frame(0, 0), "as before");
}

TEST_F(TalarisStandby, AllocatesNothing) {
  frame();
  std::uint64_t allocated = 0;
  for (int i = 0; i < 40; ++i) {
    frame(0, 100);
    const std::uint64_t before = testing_support::allocations();
    standby_.begin(now_, first_, true);
    standby_.take({.rate_rad_s = {0, 0, 0.001 * i}}, now_);
    standby_.with(first_);
    allocated += testing_support::allocations() - before;
  }
  EXPECT_EQ(allocated, 0u);
}

}  // namespace
}  // namespace lss::talaris
