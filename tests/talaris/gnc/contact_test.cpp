// Touchdown felt by the IMU.

#include "gnc/talaris/contact.h"

#include <gtest/gtest.h>

#include <random>

namespace lss::gnc::talaris::test {
namespace {

struct Felt {
  std::mt19937_64 engine{1};
  std::array<ImuSample, 40> samples;
  double scatter_m_s2 = 0.28;
  // The leg springs: some samples.
  Batch hit(double force_x, double shock_m_s2) {
    frame(force_x);
    samples[7].force_B_m_s2.x() = force_x + shock_m_s2;
    samples[8].force_B_m_s2.x() = force_x + 0.6 * shock_m_s2;
    return {samples, {}, 0};
  }
  Batch frame(double force_x) {
    std::normal_distribution<double> noise(0, scatter_m_s2);
    for (ImuSample& s : samples) s.force_B_m_s2 = {force_x + noise(engine), noise(engine), 0};
    return {samples, {}, 0};
  }
};

constexpr double kLift = 9.3;  // m/s2: sinking slowly

bool felt_anything(const Contact& contact) { return contact.shocked() || contact.supported(); }

TEST(Contact, FlyingIsNone) {
  Felt felt;
  Contact contact;
  for (int i = 0; i < 10'000; ++i) {
    contact.step(felt.frame(kLift), kLift);
    ASSERT_FALSE(felt_anything(contact));
  }
}

TEST(Contact, AShockIsOneInItsFrameAndTheNext) {
  Felt felt;
  Contact contact;
  contact.step(felt.frame(kLift), kLift);
  contact.step(felt.hit(kLift, 7), kLift);
  EXPECT_TRUE(contact.shocked());
  contact.step(felt.frame(kLift), kLift);
  EXPECT_TRUE(contact.shocked());
  contact.step(felt.frame(kLift), kLift);
  EXPECT_FALSE(felt_anything(contact));
}

// 0.2 m/s of one corner: the springs take 10 ms, and 2 m/s2 of the middle.
TEST(Contact, AFootThatTurnsItIsAJolt) {
  for (int at = 2; at < 40; ++at) {
    Felt felt;
    Contact contact;
    contact.step(felt.frame(kLift), kLift);
    EXPECT_FALSE(contact.jolted());
    felt.frame(kLift);
    for (int i = at; i < 40; ++i) {
      const double share = std::min(1.0, (i - at + 1) / 2.0);
      felt.samples[static_cast<std::size_t>(i)].rate_B_rad_s = {0, 0.12 * share, -0.15 * share};
    }
    contact.step({felt.samples, {}, 0}, kLift);
    const bool at_once = contact.jolted();
    felt.frame(kLift);
    for (ImuSample& s : felt.samples) s.rate_B_rad_s = {0, 0.12, -0.15};
    contact.step({felt.samples, {}, 0}, kLift);
    EXPECT_EQ(at_once, at <= 37) << at;  // two samples after it suffice
    EXPECT_EQ(contact.jolted(), !at_once) << at;
    EXPECT_FALSE(contact.shocked());
    contact.step({felt.samples, {}, 0}, kLift);
    EXPECT_FALSE(contact.jolted());
  }
}

// A valve that opens 20 ms before the one opposite; rolling; a sample that is wrong.
TEST(Contact, PulsesAreNoJoltNorIsOneWrongSample) {
  Felt felt;
  Contact contact;
  const auto turn = [&](int from, int to, const Vector3& rad_s2) {
    felt.frame(kLift);
    Vector3 rate = Vector3::Zero();
    for (int i = 0; i < 40; ++i) {
      if (i >= from && i < to) rate += rad_s2 * 0.005;
      felt.samples[static_cast<std::size_t>(i)].rate_B_rad_s = rate;
    }
    contact.step({felt.samples, {}, 0}, kLift);
    return contact.jolted();
  };
  EXPECT_FALSE(turn(10, 14, {0, 4, 5}));
  EXPECT_FALSE(turn(0, 40, {40, 0, 0}));
  for (std::size_t i = 0; i < 40; ++i) {
    felt.frame(kLift);
    for (ImuSample& s : felt.samples) s.rate_B_rad_s.setZero();
    felt.samples[i].rate_B_rad_s = {0, 3, 3};
    contact.step({felt.samples, {}, 0}, kLift);
    EXPECT_FALSE(contact.jolted()) << i;
    felt.samples[i].rate_B_rad_s = {0, kNaN, 3};
    contact.step({felt.samples, {}, 0}, kLift);
    EXPECT_FALSE(contact.jolted()) << i;
  }
}

TEST(Contact, OneWrongSampleIsNone) {
  Felt felt;
  Contact contact;
  for (int i = 0; i < 40; ++i) {
    felt.frame(kLift);
    felt.samples[static_cast<std::size_t>(i)].force_B_m_s2.x() = kLift + 30;
    contact.step({felt.samples, {}, 0}, kLift);
    EXPECT_FALSE(felt_anything(contact)) << i;
  }
}

// Valves push for parts of the frame, their mean is in the lift.
TEST(Contact, PulsesOfTheValvesDoNotHideAShock) {
  Felt felt;
  Contact contact;
  const auto pulse = [&] {
    for (std::size_t i = 0; i < felt.samples.size(); ++i)
      felt.samples[i].force_B_m_s2.x() += i >= 14 && i < 28 ? 3.6 : -1.9;
  };
  for (int i = 0; i < 100; ++i) {
    felt.frame(kLift);
    pulse();
    contact.step({felt.samples, {}, 0}, kLift);
    ASSERT_FALSE(felt_anything(contact));
  }
  felt.frame(kLift);
  felt.samples[20].force_B_m_s2.x() = kLift + 3.5;
  felt.samples[21].force_B_m_s2.x() = kLift + 2.4;
  pulse();
  contact.step({felt.samples, {}, 0}, kLift);
  EXPECT_TRUE(contact.shocked());
}

// Samples of 4 m/s2 (sigma) are each as far off as a shock in a still vehicle.
TEST(Contact, WhatFansShakeIsNoShockAndTheGroundStillIs) {
  for (const double scatter_m_s2 : {1.0, 2.0, 4.0, 8.0}) {
    Felt felt;
    felt.scatter_m_s2 = scatter_m_s2;
    Contact contact;
    for (int i = 0; i < 10'000; ++i) {
      contact.step(felt.frame(kLift), kLift);
      ASSERT_FALSE(contact.shocked()) << scatter_m_s2;
    }
    contact.step(felt.hit(kLift, std::max(8 * scatter_m_s2, 7.0)), kLift);
    EXPECT_TRUE(contact.shocked()) << scatter_m_s2;
  }
}

// Set down softly, then the lift goes: the ground carries.
TEST(Contact, SupportIsOneAfterTwoFrames) {
  Felt felt;
  Contact contact;
  contact.step(felt.frame(9.8), 8.2);
  EXPECT_FALSE(contact.supported());
  contact.step(felt.frame(9.8), 8.2);
  EXPECT_TRUE(contact.supported());
  contact.step(felt.frame(9.8), 8.2);
  EXPECT_TRUE(contact.supported());
  contact.step(felt.frame(8.2), 8.2);
  EXPECT_FALSE(contact.supported());
}

TEST(Contact, OneFrameOfSupportIsNot) {
  Felt felt;
  Contact contact;
  for (int i = 0; i < 20; ++i) {
    contact.step(felt.frame(kLift + 1.5), kLift);
    EXPECT_FALSE(felt_anything(contact));
    contact.step(felt.frame(kLift), kLift);
    EXPECT_FALSE(felt_anything(contact));
  }
}

TEST(Contact, HeldFramesAndNonsenseSayNothing) {
  Felt felt;
  Contact contact;
  contact.step({{}, {}, 0}, kLift);
  EXPECT_FALSE(felt_anything(contact));
  felt.frame(kLift);
  for (ImuSample& s : felt.samples) s.force_B_m_s2.x() = kNaN;
  contact.step({felt.samples, {}, 0}, kLift);
  EXPECT_FALSE(felt_anything(contact));
  contact.step(felt.frame(kLift), kNaN);
  EXPECT_FALSE(felt_anything(contact));
}

}  // namespace
}  // namespace lss::gnc::talaris::test
