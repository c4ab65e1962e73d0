// Soft errors: any bit of one instance, parameters and state, at any time.

#include "gnc/ardito/redundant.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstring>

#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

void flip(MobilityController& controller, std::size_t bit) {
  unsigned char bytes[sizeof controller];
  std::memcpy(bytes, static_cast<const void*>(&controller), sizeof bytes);
  bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ (1U << (bit % 8)));
  std::memcpy(static_cast<void*>(&controller), bytes, sizeof bytes);
}

bool same(Command a, Command b) {
  Command c = a;
  return vote(a, b, c) == 0;
}

RC_GTEST_PROP(Redundant, AnyBitOfOneInstanceHasNoEffectAndIsReported, ()) {
  Rover rover(static_cast<unsigned>(*rc::gen::inRange(0, 1000)));
  rover.request.run = true;
  rover.request.speed = 0.6;
  rover.request.parking = *rc::gen::arbitrary<bool>();
  rover.run(*rc::gen::inRange(0, 10));
  for (int n = 0; n < 40; ++n) {
    if (n % 10 == 5) rover.wheel_faults[*rc::gen::inRange<std::size_t>(0, 6)].hall = Broken::zero;
    Redundant twin = rover.redundant();
    const std::size_t instance = *rc::gen::inRange<std::size_t>(0, 3);
    const std::size_t bit = *rc::gen::inRange<std::size_t>(0, 8 * sizeof(MobilityController));
    flip(rover.redundant().instance(instance), bit);
    rover.step();
    const Command expected = twin.step(rover.request, rover.measured);
    RC_ASSERT(same(rover.command, expected));
    RC_ASSERT(rover.redundant().report().disagreed == only(instance));
    RC_ASSERT(rover.redundant().report().no_majority == 0U);
    // re-synchronised
    rover.step();
    RC_ASSERT(rover.redundant().report().disagreed == 0U);
  }
  RC_ASSERT(rover.redundant().report().upsets == 40U);
}

TEST(Redundant, EverySingleBitOnce) {
  Rover rover(1);
  rover.request.run = true;
  rover.request.speed = 0.6;
  rover.run(5);
  const Redundant before = rover.redundant();
  Redundant clean = before;
  const Command expected = clean.step(rover.request, rover.measured);
  for (std::size_t bit = 0; bit < 8 * sizeof(MobilityController); ++bit) {
    Redundant hit = before;
    flip(hit.instance(bit % 3), bit);
    ASSERT_TRUE(same(hit.step(rover.request, rover.measured), expected)) << bit;
    ASSERT_EQ(hit.report().disagreed, only(bit % 3)) << bit;
  }
}

TEST(Redundant, HitsInDifferentPlacesOfTwoInstancesStopForAFrameAndAreRestored) {
  Rover rover(1);
  rover.request.run = true;
  rover.request.speed = 0.6;
  rover.run(8);
  Redundant hit = rover.redundant(), twin = rover.redundant();
  flip(hit.instance(0), 8 * sizeof(Parameters) + 700);
  flip(hit.instance(2), 8 * sizeof(Parameters) + 5000);
  const Command stop = hit.step(rover.request, rover.measured);
  twin.step(rover.request, rover.measured);
  EXPECT_EQ(hit.report().no_majority, 1U);
  EXPECT_EQ(hit.report().disagreed, 0b101U);
  EXPECT_EQ(stop.error, 1U);
  EXPECT_EQ(stop.steering_known, 0U);
  for (const double w : stop.wheel_rad_s) EXPECT_EQ(w, 0);
  EXPECT_TRUE(
      same(hit.step(rover.request, rover.measured), twin.step(rover.request, rover.measured)));
  EXPECT_EQ(hit.report().no_majority, 0U);
}

TEST(Redundant, WithoutAMajorityAWheelOutOfWorkStaysSo) {
  constexpr std::size_t kWheel = 2;
  Rover rover = driving();
  rover.wheel_faults[kWheel].motor_blocked = true;
  const auto out_of_work = [](const Command& c) { return contains(c.motors_stopped, kWheel); };
  frames_until(rover, 50, out_of_work);
  ASSERT_TRUE(out_of_work(rover.command));
  ASSERT_FALSE(contains(rover.command.clutches_engaged, kWheel));
  flip(rover.redundant().instance(0), 8 * sizeof(Parameters) + 700);
  flip(rover.redundant().instance(2), 8 * sizeof(Parameters) + 5000);
  rover.step();
  ASSERT_EQ(rover.redundant().report().no_majority, 1U);
  EXPECT_EQ(rover.command.error, 1U);
  EXPECT_EQ(rover.command.clutches_engaged, kAllWheels & ~only(kWheel));
  EXPECT_EQ(rover.command.motors_stopped, only(kWheel));
}

TEST(Vote, BitsThatTwoHaveWin) {
  double a = 1.5, b = 1.5, c = -0.0;
  EXPECT_EQ(vote(a, b, c), 4U);
  EXPECT_EQ(c, 1.5);
  double zero = 0.0, minus = -0.0, other = 0.0;
  EXPECT_EQ(vote(zero, minus, other), 2U);  // equal by ==, not by bits
  EXPECT_FALSE(std::signbit(minus));
  double nan = NAN, nan2 = NAN, number = 1;
  EXPECT_EQ(vote(nan, nan2, number), 4U);
}

}  // namespace
}  // namespace lss::gnc::ardito::test
