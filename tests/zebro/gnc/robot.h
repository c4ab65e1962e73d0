#pragma once

// Six legs that follow LegTarget like a leg module: a new segment is a rotation at constant rate in
// the ordered direction, to be over at the ordered time; what is passed by less than 5 deg is gone
// back to. A leg counts from an unknown zero until it passes its sensor at the top. Virtual time;
// no physics.

#include <algorithm>
#include <cmath>
#include <functional>

#include "gnc/zebro/locomotion.h"
#include "idl/angles.h"

namespace lss::gnc::zebro::test {

inline constexpr double kFrame_s = 0.02;
inline constexpr double kStride_m = 36.42e-3;

// The three speeds of the gait table (Zebro thesis, table 10.1).
struct Pace {
  Speed speed;
  double cycle_s, speed_m_s;
};
inline constexpr Pace kPaces[] = {
    {Speed::low, 19.8, 2.2e-3}, {Speed::medium, 9.9, 5.3e-3}, {Speed::high, 6.6, 10.1e-3}};

inline double cycle_s(Speed speed) {
  return std::ranges::find(kPaces, speed, &Pace::speed)->cycle_s;
}

struct RobotLeg {
  double theta_rad = 0;  // true, unwrapped
  double zero_rad = 0;   // excess of its count until it has passed its sensor
  bool calibrated = true;
  bool has_sensor = true;
  bool answers = true;
  double stuck_until_s = -1;
  // the order under way
  std::uint32_t segment = 0;
  double left_rad = 0;  // signed, still to travel
  double due_s = 0;
  double rate_rad_s = 0;
};

struct Robot {
  explicit Robot(const LocomotionParameters& with = {}, double start_s = 0)
      : parameters(with), locomotion(with), now_s(start_s), fastest_rad_s(with.swing_limit_rad_s) {}

  // Called with each new order before it is followed: leg, target, way to go in the ordered
  // direction.
  std::function<void(std::size_t, const LegTarget&, double)> on_order;

  // The present report of the legs: their state report_age_frames ago.
  PerLeg<LegMeasured> measured() const { return history[report_age_frames]; }

  PerLeg<LegMeasured> seen_now() const {
    PerLeg<LegMeasured> out;
    for (std::size_t i = 0; i < kLegs; ++i) {
      out[i] = {.angle_rad = legs[i].theta_rad + legs[i].zero_rad,
                .known = legs[i].answers,
                .calibrated = legs[i].calibrated};
    }
    return out;
  }

  void follow_targets() {
    for (std::size_t i = 0; i < kLegs; ++i) {
      const LegTarget& target = locomotion.targets()[i];
      RobotLeg& leg = legs[i];
      if (target.segment == leg.segment || target.rotation == 0) continue;
      leg.segment = target.segment;
      double way_rad = wrap_rad(target.angle_rad - leg.theta_rad - leg.zero_rad);
      if (target.rotation > 0 && way_rad > 5 * kDegree) way_rad -= 2 * kPi;
      if (target.rotation < 0 && way_rad < -5 * kDegree) way_rad += 2 * kPi;
      if (on_order) on_order(i, target, way_rad);
      leg.left_rad = way_rad;
      leg.due_s = target.arrive_s;
    }
  }

  void turn_legs() {
    for (RobotLeg& leg : legs) {
      if (now_s < leg.stuck_until_s) continue;
      const double remaining_s = std::max(leg.due_s - now_s, kFrame_s);
      const double fastest_rad = fastest_rad_s * kFrame_s;
      const double step_rad =
          std::clamp(leg.left_rad * kFrame_s / remaining_s, -fastest_rad, fastest_rad);
      const double before = std::floor((leg.theta_rad - kPi) / (2 * kPi));
      leg.theta_rad += step_rad;
      leg.left_rad -= step_rad;
      leg.rate_rad_s = step_rad / kFrame_s;
      if (leg.has_sensor && before != std::floor((leg.theta_rad - kPi) / (2 * kPi))) {
        leg.calibrated = true;
        leg.zero_rad = 0;
      }
    }
  }

  void remember() {
    for (std::size_t age = history.size() - 1; age > 0; --age) history[age] = history[age - 1];
    history[0] = seen_now();
    if (!remembered) history.fill(history[0]);
    remembered = true;
  }

  void frame() {
    remember();
    update_and_move();
  }

  void update_and_move() {
    locomotion.update(now_s, measured());
    follow_targets();
    turn_legs();
    now_s += kFrame_s;
  }

  void run(double duration_s) {
    const double until_s = now_s + duration_s;
    while (now_s < until_s - kFrame_s / 2) frame();
  }

  // Until the motion is over; false when it takes longer than most_s.
  bool finish(double most_s = 120) {
    const double until_s = now_s + most_s;
    while (now_s < until_s) {
      frame();
      if (locomotion.progress() != Progress::running) return true;
    }
    return false;
  }
  // Until it is over, as it should be.
  bool succeeds() { return finish() && locomotion.progress() == Progress::done; }

  int flying() const {
    return static_cast<int>(std::count_if(locomotion.targets().begin(), locomotion.targets().end(),
                                          [](const LegTarget& t) { return t.swing; }));
  }

  double theta_rad(std::size_t leg) const { return wrap_rad(legs[leg].theta_rad); }

  LocomotionParameters parameters;
  Locomotion locomotion;
  double now_s;
  double fastest_rad_s;
  std::size_t report_age_frames = 0;
  bool remembered = false;
  std::array<PerLeg<LegMeasured>, 3> history{};
  PerLeg<RobotLeg> legs{};
};

// Distance of two whole cycles in the steady rhythm.
inline double two_cycles_m(Robot& robot, double period_s) {
  robot.run(2 * period_s + robot.parameters.start_delay_s);
  const double from_m = robot.locomotion.distance_m();
  robot.run(2 * period_s);
  return robot.locomotion.distance_m() - from_m;
}

}  // namespace lss::gnc::zebro::test
