#pragma once

// Six wheels that roll about one centre of rotation on the middle axle: from the velocity of the CM
// to steering angles and hub speeds, and back (Ardito thesis 11.2.5, 11.2.6 and 17.7). Written
// without r = f / sin(sigma), so that straight ahead and turning on the spot are ordinary cases and
// nothing is clipped (E9, E10). Pure functions, callable from every thread.
//
// sigma is the direction and v the speed of the CM, f its distance from the middle axle, s =
// sin(sigma), c = cos(sigma). For a wheel p ahead of the middle axle and q left of the centre line:
//
//   across = f c + q s    along = p s    alpha = atan(-along/across)  (steered wheels)
//   hub = v/f sign(across) hypot(across, along)    yaw rate = v s/f
//
// On the spot (s, c) = (1, 0), v = Vtan f / 3.429 m. Inverse: (s, c) ~ (f sin(alpha), -p cos(alpha)
// - q sin(alpha)).

#include "gnc/ardito/direction.h"
#include "gnc/ardito/parameters.h"

namespace lss::gnc::ardito {

inline constexpr Direction kOnTheSpot = {1, 0};
// In (-pi/2, pi/2].
double sigma_rad(const Direction& direction) noexcept;

// On the spot v_m_s is the CM's, which is f behind the front: yaw rate * f.
struct PlaneMotion {
  Direction direction;
  double v_m_s = 0;  // of the CM along the direction, negative backwards
};
double yaw_rate_rad_s(const PlaneMotion& motion, const Geometry& geometry) noexcept;

struct PlaneWheels {
  PerWheel<double> steering_rad{};  // 0 for the middle wheels
  PerWheel<double> hub_m_s{};
};
PlaneWheels ackermann(const PlaneMotion& motion, const Geometry& geometry) noexcept;
// Half of it each.
PerWheel<double> steering_angles_rad(const Direction& direction, const Geometry& geometry) noexcept;
PerWheel<double> hub_speeds_m_s(const PlaneMotion& motion, const Geometry& geometry) noexcept;
// Of one of them.
double steering_angle_rad(std::size_t wheel, const Direction& direction,
                          const Geometry& geometry) noexcept;

// Of one steered wheel (0, 1, 4, 5): the direction that its angle belongs to (17.7.1).
Direction direction_from_steering(std::size_t wheel, const Direction& steering,
                                  const Geometry& geometry) noexcept;
// For any wheel: speed of its hub when v of the CM is 1. Near 0 the wheel is at the centre of
// rotation and gives no information on v.
PerWheel<double> hub_ratios(const Direction& direction, const Geometry& geometry) noexcept;
double hub_ratio(std::size_t wheel, const Direction& direction, const Geometry& geometry) noexcept;
// Speed of this wheel's hub along the wheel as it is steered now, of a rover that moves like this:
// the same as its ratio times v when it is steered for that motion.
double hub_speed_m_s(std::size_t wheel, const PlaneMotion& motion, const Direction& steering,
                     const Geometry& geometry) noexcept;
// v of the CM for this speed of this wheel's hub (17.7.2, E8); 0 without information.
double v_from_hub_m_s(std::size_t wheel, double hub_m_s, const Direction& direction,
                      const Geometry& geometry) noexcept;

}  // namespace lss::gnc::ardito
