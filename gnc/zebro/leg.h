#pragma once

// Kinematics of one half-circle leg of diameter D = 2R, hip at one end of the arc, toe at the
// other, convex side to the rear when the toe is down. Pure functions of angles in radians,
// callable from every thread. theta: 0 = toe straight down, positive = toe ahead of the hip. With
// theta >= 0 the leg rolls on its arc, with theta < 0 it stands on its toe; therefore forward and
// backward stance differ, and the robot is lower at -62 deg than at +62 deg.

#include <array>

namespace lss::gnc::zebro {

inline constexpr int kLegs = 6;  // 0..5 = LF, RF, LM, RM, LH, RH
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr bool is_left(int leg) noexcept { return leg % 2 == 0; }

// The same angle in (-pi, pi].
double wrap_rad(double angle_rad) noexcept;

double hip_height_m(double theta_rad, double diameter_m) noexcept;
double contact_offset_m(double theta_rad, double diameter_m) noexcept;  // ahead of the hip

// Forward travel of the hip when the leg is at theta, counted from theta = 0; decreases with theta,
// d(advance)/d(theta) = -hip_height.
double advance_m(double theta_rad, double diameter_m) noexcept;

// The angle theta > 0 at which the arc, rolling backward, lowers the hip to this height: from here
// on the belly carries. Needs 0 < height < D.
double lowered_rad(double height_m, double diameter_m) noexcept;

// Stride of a stance from +sweep/2 to -sweep/2, and its inverse by Newton's method; both increase
// on [0, pi].
double stride_m(double sweep_rad, double diameter_m) noexcept;
double sweep_for_stride_rad(double stride_m, double diameter_m) noexcept;

// Speed of each side as a share of the fastest, in [-1, 1], for a heading in [-pi/2, pi/2],
// clockwise positive.
struct SideSpeeds {
  double left = 0;
  double right = 0;
};
SideSpeeds side_speeds(double direction, double heading_rad) noexcept;

// Signed half sweep of a side: stance goes from theta_0 + a to theta_0 - a. The stride is the
// side's share of the full stride; 0 below 5 %, where the leg only steps on the spot.
double half_sweep_rad(double side_speed, double full_sweep_rad, double diameter_m) noexcept;

// Limit of a touchdown further ahead than half the sweep, when a walk begins.
inline constexpr double kFurthestReach = 1.25;

// Decrease of theta on the way from one angle to another, [0, 2 pi).
double fall_rad(double from_rad, double to_rad) noexcept;

// Signed travel to an angle ahead, off the ground: back from between straight down and there, from
// all other angles falling through the top; other ways would push the body.
double lift_rad(double from_rad, double to_rad) noexcept;

// Signed travel from one angle near straight down to another through the top, the shorter way
// round, so never more than a full turn; between equal angles a full turn, robot-forward (theta
// falls) when `forward`.
double travel_through_top_rad(double from_rad, double to_rad, bool forward) noexcept;

}  // namespace lss::gnc::zebro
