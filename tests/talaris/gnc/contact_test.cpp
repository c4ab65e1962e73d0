// Touchdown felt by the IMU.

#include "gnc/talaris/contact.h"

#include <gtest/gtest.h>

#include <random>

namespace lss::gnc::talaris::test {
namespace {

struct Felt {
  std::mt19937_64 engine{1};
  std::array<ImuSample, 40> samples;
  Batch frame(double force_x) {
    std::normal_distribution<double> noise(0, 0.28);
    for (ImuSample& s : samples) s.force_B_m_s2 = {force_x + noise(engine), noise(engine), 0};
    return {samples, {}, 0};
  }
};

constexpr double kLift = 9.3;  // m/s2: sinking slowly

TEST(Contact, FlyingIsNone) {
  Felt felt;
  Contact contact;
  for (int i = 0; i < 10'000; ++i) ASSERT_FALSE(contact.step(felt.frame(kLift), kLift));
}

TEST(Contact, AShockIsOne) {
  Felt felt;
  Contact contact;
  felt.frame(kLift);
  felt.samples[7].force_B_m_s2.x() = kLift + 7;
  EXPECT_TRUE(contact.step({felt.samples, {}, 0}, kLift));
  EXPECT_TRUE(contact.step(felt.frame(kLift), kLift)) << "until it is reset";
  contact.reset();
  EXPECT_FALSE(contact.step(felt.frame(kLift), kLift));
}

// Set down softly, then the lift goes: the ground carries.
TEST(Contact, SupportIsOneAfterTwoFrames) {
  Felt felt;
  Contact contact;
  EXPECT_FALSE(contact.step(felt.frame(9.8), 8.2));
  EXPECT_TRUE(contact.step(felt.frame(9.8), 8.2));
}

TEST(Contact, OneFrameOfSupportIsNot) {
  Felt felt;
  Contact contact;
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(contact.step(felt.frame(kLift + 1.5), kLift));
    EXPECT_FALSE(contact.step(felt.frame(kLift), kLift));
  }
}

TEST(Contact, HeldFramesAndNonsenseSayNothing) {
  Felt felt;
  Contact contact;
  EXPECT_FALSE(contact.step({{}, {}, 0}, kLift));
  felt.frame(kLift);
  for (ImuSample& s : felt.samples) s.force_B_m_s2.x() = kNaN;
  EXPECT_FALSE(contact.step({felt.samples, {}, 0}, kLift));
  EXPECT_FALSE(contact.step(felt.frame(kLift), kNaN));
}

}  // namespace
}  // namespace lss::gnc::talaris::test
