// Requirements of the frame thread: no allocation, the same bits for the same calls, and finite
// numbers for any input.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "tests/ardito/gnc/rover.h"
#include "tests/support/allocations.h"

namespace lss::gnc::ardito::test {
namespace {

bool same(Command a, Command b) {
  Command c = a;
  return vote(a, b, c) == 0;
}

TEST(Realtime, NothingAllocatesInAnyModeOrFailure) {
  Rover rover(3);
  rover.request.run = true;
  rover.request.speed = 0.7;
  for (int n = 0; n < 1500; ++n) {
    if (n == 300) rover.wheel_faults[0].motor_blocked = true;
    if (n == 500) rover.wheel_faults[1].clutch = true;
    if (n == 800) rover.request.parking = true;
    if (n == 1100) rover.steering_faults[0].motor = true;
    if (n == 1300) rover.request.retry_wheels = kAllWheels;
    if (n == 1300) rover.request.retry_steering = kAllSteered;
    rover.step();
    const std::uint64_t before = testing_support::allocations();
    rover.redundant().step(rover.request, rover.measured);
    ASSERT_EQ(testing_support::allocations(), before);
  }
}

RC_GTEST_PROP(Realtime, SameInputsGiveTheSameBits, ()) {
  Rover rover(static_cast<unsigned>(*rc::gen::inRange(0, 1000)));
  MobilityController twin;
  std::optional<MobilityController> copy;
  const int copied_at = *rc::gen::inRange(0, 300);
  rover.request.run = true;
  for (int n = 0; n < 300; ++n) {
    if (n % 40 == 0) {
      rover.request.speed = *rc::gen::inRange(-10, 11) * 0.1;
      rover.request.parking = *rc::gen::inRange(0, 4) == 0;
      rover.wheel_faults[*rc::gen::inRange<std::size_t>(0, 6)].motor_blocked = true;
    }
    if (n == copied_at) copy = twin;
    rover.step();
    RC_ASSERT(same(twin.step(rover.request, rover.measured), rover.command));
    if (copy) RC_ASSERT(same(copy->step(rover.request, rover.measured), rover.command));
  }
}

double any_double() {
  using Limits = std::numeric_limits<double>;

  return *rc::gen::oneOf(
      rc::gen::element(Limits::quiet_NaN(), Limits::signaling_NaN(), Limits::infinity(),
                       -Limits::infinity(), 1e308, -1e308, 1e-320, 0.0, -0.0, 1e6, -1e6),
      rc::gen::map(rc::gen::inRange(-1000, 1001), [](int n) { return n * 0.01; }));
}

Reading any_reading() {
  return {any_double(), *rc::gen::weightedElement<double>(
                            {{8, 0.01}, {1, 0.5}, {1, -1}, {1, std::nan("")}, {1, HUGE_VAL}})};
}

// Everything at once is nonsense in every frame.
RC_GTEST_PROP(Realtime, NonsenseNeverComesOutAsNonsense, ()) {
  Rover rover(1);
  rover.request.run = true;
  rover.request.speed = 0.6;
  if (*rc::gen::arbitrary<bool>()) rover.run(8);
  Redundant controller = rover.redundant();
  Measured m = rover.measured;
  for (int n = 0; n < 30; ++n) {
    Request r = rover.request;
    const int hits = *rc::gen::inRange(1, 12);
    for (int hit = 0; hit < hits; ++hit) {
      const std::size_t i = *rc::gen::inRange<std::size_t>(0, kWheels), s = i % kSteered;
      Reading* all[] = {&m.wheels[i].motor_rad_s,
                        &m.wheels[i].hall_rad_s,
                        &m.wheels[i].reduction_rad_s,
                        &m.wheels[i].current,
                        &m.wheels[i].temperature_C,
                        &m.steering[s].motor_rad,
                        &m.steering[s].reduction_rad,
                        &m.steering[s].current,
                        &m.beta_rad,
                        &m.rho1_rad,
                        &m.rho2_rad,
                        &m.imu.speed_m_s,
                        &m.imu.sigma_rad,
                        &m.imu.yaw_rate_rad_s};
      *all[*rc::gen::inRange<std::size_t>(0, std::size(all))] = any_reading();
    }
    if (*rc::gen::inRange(0, 3) == 0) r.speed = any_double();
    if (*rc::gen::inRange(0, 3) == 0) r.sigma_rad = any_double();
    if (*rc::gen::inRange(0, 3) == 0) r.speed_limit_m_s = any_double();
    m.imu.counter = *rc::gen::arbitrary<std::uint32_t>();
    r.retry_wheels = *rc::gen::inRange<std::uint32_t>(0, 4);
    const Command c = controller.step(r, m);
    for (const double w : c.wheel_rad_s) {
      RC_ASSERT(std::isfinite(w));
      RC_ASSERT(std::abs(w) <= 1.5 * 1.05 / 0.15);
    }
    for (const double a : c.steering_rad) {
      RC_ASSERT(std::isfinite(a));
      RC_ASSERT(std::abs(a) <= 65.001 * kPi / 180);
    }
    RC_ASSERT(std::isfinite(c.estimate.speed_m_s) && std::isfinite(c.estimate.sigma_rad) &&
              std::isfinite(c.estimate.yaw_rate_rad_s));
    for (const double w : c.estimate.wheel_rad_s) RC_ASSERT(std::isfinite(w));
    for (const double v : c.estimate.wheel_speed_m_s) RC_ASSERT(std::isfinite(v));
    RC_ASSERT((c.motors_stopped & c.clutches_engaged) == 0U);
  }
}

}  // namespace
}  // namespace lss::gnc::ardito::test
