// Requirements of the frame thread: no allocation, the same bits for the same calls, and pulses and
// throttles within their limits for any input.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "tests/support/allocations.h"
#include "tests/talaris/gnc/hopper.h"

namespace lss::gnc::talaris::test {
namespace {

static_assert(std::is_copy_constructible_v<Flight> && std::is_trivially_destructible_v<Flight>);

bool same(const Actuation& a, const Actuation& b) {
  for (std::size_t i = 0; i < kValves; ++i) {
    if (std::memcmp(&a.valve[i], &b.valve[i], sizeof(Pulse)) != 0) return false;
  }
  return std::memcmp(a.fan_throttle.data(), b.fan_throttle.data(), sizeof(a.fan_throttle)) == 0;
}

TEST(TalarisRealtime, NothingAllocatesInAnyPhaseOrFault) {
  for (int fault = 0; fault < 4; ++fault) {
    Hopper hopper(World{}, Parameters{});
    Flight flight(hopper.parameters);
    std::uint64_t before = testing_support::allocations();
    ASSERT_TRUE(flight.plan({}).feasible());
    ASSERT_TRUE(flight.execute());
    EXPECT_EQ(testing_support::allocations(), before);
    hopper.flight.plan({});
    hopper.flight.execute();
    for (int n = 0; n < 150; ++n) {
      if (n == 60 && fault == 1) hopper.valves_dead = true;
      if (n == 60 && fault == 2) hopper.fans_silent = true;
      if (n == 60 && fault == 3) hopper.imu_silent = true;
      hopper.frame();
      before = testing_support::allocations();
      flight.step(hopper.inputs);
      ASSERT_EQ(testing_support::allocations(), before);
    }
  }
}

TEST(TalarisRealtime, SameInputsGiveTheSameBitsAndACopyGoesOnAlike) {
  Hopper hopper(World{}, Parameters{});
  Flight twin(hopper.parameters);
  for (Flight* flight : {&hopper.flight, &twin}) {
    ASSERT_TRUE(flight->plan({}).feasible());
    ASSERT_TRUE(flight->execute());
  }
  Flight copy = twin;
  for (int n = 0; n < 150; ++n) {
    if (n == 70) copy = twin;
    if (n == 90) hopper.range_silent = true;
    hopper.frame();
    ASSERT_TRUE(same(twin.step(hopper.inputs).actuation, hopper.out.actuation));
    if (n >= 70) {
      ASSERT_TRUE(same(copy.step(hopper.inputs).actuation, hopper.out.actuation));
    }
  }
}

TEST(TalarisRealtime, AFanSpeedWhoseSquareIsInfiniteIsNone) {
  Hopper hopper(World{}, Parameters{});
  PlanRequest request;
  request.height_m = 1;
  request.distance_m = 5;
  ASSERT_TRUE(hopper.flight.plan(request).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  for (int n = 0; n < 22; ++n) hopper.frame();
  hopper.inputs.rpm[0] = 1e308;
  hopper.flight.land();
  for (int n = 0; n < 4; ++n)
    EXPECT_TRUE(hopper.flight.step(hopper.inputs).attitude_error_rad.allFinite()) << n;
}

double any_double() {
  using Limits = std::numeric_limits<double>;
  return *rc::gen::oneOf(
      rc::gen::element(Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), 1e308, -1e308,
                       1e-320, 0.0, -0.0, 1e6, -1e6),
      rc::gen::map(rc::gen::inRange(-1000, 1001), [](int n) { return n * 0.01; }));
}

RC_GTEST_PROP(TalarisRealtime, NonsenseNeverComesOutAsNonsense, ()) {
  Hopper hopper(World{}, Parameters{});
  PlanRequest request;
  request.program = static_cast<Program>(*rc::gen::inRange(0, 8));
  request.height_m = 1;
  request.distance_m = 5;
  request.turn_rad = 0.5;
  RC_ASSERT(hopper.flight.plan(request).feasible());
  RC_ASSERT(hopper.flight.execute());
  const int good = *rc::gen::inRange(0, 80);
  for (int n = 0; n < good; ++n) hopper.frame();
  FlightInputs in = hopper.inputs;
  const Thrusters& t = hopper.parameters.thrusters;
  for (int n = 0; n < 40; ++n) {
    double* all[] = {&in.nav.position_N_m.x(),
                     &in.nav.position_N_m.z(),
                     &in.nav.velocity_N_m_s.x(),
                     &in.nav.velocity_N_m_s.y(),
                     &in.nav.rate_B_rad_s.x(),
                     &in.nav.rate_B_rad_s.y(),
                     &in.nav.q_NB.w(),
                     &in.nav.q_NB.y(),
                     &in.nav.acceleration_N_m_s2.x(),
                     &in.range_m,
                     &in.imu_age_s,
                     &in.range_age_s,
                     &in.valve_age_s,
                     &in.fan_age_s,
                     &in.rpm[0],
                     &in.rpm[3],
                     &in.tank_kPa,
                     &in.regulated_kPa};
    const int hits = *rc::gen::inRange(0, 3);
    for (int hit = 0; hit < hits; ++hit) {
      *all[*rc::gen::inRange<std::size_t>(0, std::size(all))] = any_double();
    }
    if (*rc::gen::inRange(0, 4) == 0) in = hopper.inputs;
    if (*rc::gen::inRange(0, 10) == 0) hopper.flight.land();
    const FlightOutput out = hopper.flight.step(in);
    for (const Pulse& p : out.actuation.valve) {
      RC_ASSERT(p.on_s == 0 || (p.on_s >= t.min_on_s && p.on_s <= t.long_on_s));
      RC_ASSERT(p.delay_s >= 0 && p.delay_s + p.on_s <= kFrame_s + 1e-12);
    }
    for (const double throttle : out.actuation.fan_throttle)
      RC_ASSERT(throttle >= 0 && throttle <= 1);
    for (const double value : {out.height_m, out.gas_used_s, out.gas_left_s, out.gas_needed_s,
                               out.target_roll_rad, out.phase_s, out.attitude_error_rad.norm(),
                               out.target_N_m.norm(), out.target_N_m_s.norm()})
      RC_ASSERT(std::isfinite(value));
  }
}

}  // namespace
}  // namespace lss::gnc::talaris::test
