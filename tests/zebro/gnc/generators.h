#pragma once

// Random gaits, times and event vectors for the properties. All times are multiples of 1/64 s:
// their sums are exact, so that "equal" can mean equal.

#include <rapidcheck.h>

#include <algorithm>
#include <vector>

#include "gnc/zebro/locomotion.h"
#include "idl/angles.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {

// A leg anywhere, with its count right or not.
inline void put_anywhere(RobotLeg& leg) {
  leg.theta_rad = *rc::gen::inRange(-180, 180) * kDegree;
  leg.calibrated = *rc::gen::arbitrary<bool>();
  if (!leg.calibrated) leg.zero_rad = *rc::gen::inRange(-180, 180) * kDegree;
}

inline rc::Gen<double> dyadic_s(int low_64ths, int high_64ths) {
  return rc::gen::map(rc::gen::inRange(low_64ths, high_64ths + 1),
                      [](int n) { return static_cast<double>(n) / 64; });
}

// Any ordered partition of the six legs: every leg draws a group, then the empty groups are closed
// up.
inline rc::Gen<Partition> any_partition() {
  return rc::gen::map(rc::gen::container<std::vector<int>>(kLegs, rc::gen::inRange(0, kLegs)),
                      [](const std::vector<int>& drawn) {
                        std::vector<int> used = drawn;
                        std::sort(used.begin(), used.end());
                        used.erase(std::unique(used.begin(), used.end()), used.end());
                        Partition partition;
                        partition.groups = static_cast<int>(used.size());
                        for (std::size_t i = 0; i < kLegs; ++i) {
                          const auto at = std::lower_bound(used.begin(), used.end(), drawn[i]);
                          partition.group_of[i] = static_cast<std::uint8_t>(at - used.begin());
                        }
                        return partition;
                      });
}

inline rc::Gen<GaitTimes> any_times() {
  return rc::gen::build<GaitTimes>(rc::gen::set(&GaitTimes::flight_s, dyadic_s(1, 320)),
                                   rc::gen::set(&GaitTimes::stance_min_s, dyadic_s(1, 640)),
                                   rc::gen::set(&GaitTimes::double_stance_s, dyadic_s(0, 64)));
}

// Times with which the gait synchronises, up to the very edge.
inline rc::Gen<GaitTimes> synchronising_times(const Partition& gait) {
  return rc::gen::mapcat(any_times(), [gait](GaitTimes times) {
    // A pronk needs tau_g <= tau_Delta: give it some.
    times.double_stance_s += 1.0 / 64;
    const double most_s = gait.groups * (times.flight_s + times.double_stance_s) - times.flight_s;
    return rc::gen::map(dyadic_s(1, static_cast<int>(most_s * 64)), [times](double ground_s) {
      GaitTimes chosen = times;
      chosen.stance_min_s = ground_s;
      return chosen;
    });
  });
}

// [t_1..t_6 l_1..l_6]
inline max_plus::Vector to_vector(const Events& events) {
  max_plus::Vector x{};
  std::copy(events.touchdown_s.begin(), events.touchdown_s.end(), x.begin());
  std::copy(events.lift_off_s.begin(), events.lift_off_s.end(), x.begin() + kLegs);
  return x;
}

inline Events to_events(const max_plus::Vector& x) {
  Events events;
  std::copy_n(x.begin(), kLegs, events.touchdown_s.begin());
  std::copy_n(x.begin() + kLegs, kLegs, events.lift_off_s.begin());
  return events;
}

inline rc::Gen<Events> any_events(int last_64ths = 3200) {
  return rc::gen::map(
      rc::gen::container<std::vector<double>>(max_plus::kSize, dyadic_s(0, last_64ths)),
      [](const std::vector<double>& drawn) {
        max_plus::Vector x{};
        std::copy(drawn.begin(), drawn.end(), x.begin());
        return to_events(x);
      });
}

inline rc::Gen<Partition> shipped_gait() { return rc::gen::element(kTripod, kTetrapodB, kWave); }

inline rc::Gen<Speed> any_pace() {
  return rc::gen::element(Speed::low, Speed::medium, Speed::high);
}

inline rc::Gen<WalkRequest> any_walk() {
  return rc::gen::build<WalkRequest>(
      rc::gen::set(&WalkRequest::direction, rc::gen::element(1.0, -1.0)),
      rc::gen::set(
          &WalkRequest::heading_rad,
          rc::gen::map(rc::gen::inRange(-90, 91), [](int deg) { return deg * kPi / 180; })),
      rc::gen::set(&WalkRequest::speed, any_pace()));
}

}  // namespace lss::gnc::zebro::test

// Found by RapidCheck by argument-dependent look-up when it prints a counter-example.
namespace lss::gnc::zebro {
inline void showValue(const WalkRequest& walk, std::ostream& out) {
  out << "direction " << walk.direction << " heading " << walk.heading_rad << " speed "
      << static_cast<int>(walk.speed);
}
inline void showValue(const Partition& partition, std::ostream& out) {
  for (const std::uint8_t group : partition.group_of) out << static_cast<int>(group);
}
inline void showValue(const GaitTimes& times, std::ostream& out) {
  out << "tau_f " << times.flight_s << " tau_g " << times.stance_min_s << " tau_D "
      << times.double_stance_s;
}
inline void showValue(const Events& events, std::ostream& out) {
  for (const double x : test::to_vector(events)) out << x << ' ';
}
}  // namespace lss::gnc::zebro
