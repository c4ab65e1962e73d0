#include "tools/lss-sim/soil/wheel.h"

#include <algorithm>
#include <cmath>

namespace lss::sim::soil {
namespace {

constexpr int kPieces = 24;  // of the rim in the ground

// Wong and Reece: where along the rim the pressure is highest, as a share of the entry angle,
// c1 + c2 slip, for compact sand; the angle at which the rim leaves the ground, as a share of it.
constexpr double kHighest = 0.43, kHighestSlip = 0.32, kExit = -0.1;

// A slipping wheel carries soil to the rear and sinks deeper: by (1 + i) / (1 - i / 2) for slip i
// (G. A. Lyasko, "Slip sinkage effect in soil-vehicle mechanics", J. of Terramechanics 47, 2010).
double slip_sinkage(double slip) {
  const double i = std::clamp(slip, 0.0, 1.0);
  return (1 + i) / (1 - i / 2);
}

}  // namespace

WheelForces on_soil(const Soil& soil, const Wheel& wheel, double sinkage_m, double slip) {
  WheelForces sum;
  const double depth_m = std::min(sinkage_m, wheel.radius_m);
  if (depth_m <= 0) return sum;
  const double entry_rad = std::acos(1 - depth_m / wheel.radius_m);
  const double exit_rad = kExit * entry_rad;
  const double highest_rad = (kHighest + kHighestSlip * std::abs(slip)) * entry_rad;
  const double piece_rad = (entry_rad - exit_rad) / kPieces;
  const double cos_entry = std::cos(entry_rad);
  const double deeper = slip_sinkage(slip);
  const double tangent = std::tan(soil.friction_rad);
  const double piece_m2 = wheel.radius_m * wheel.width_m * piece_rad;
  for (int i = 0; i < kPieces; ++i) {
    const double at_rad = exit_rad + (i + 0.5) * piece_rad;
    // Behind the highest pressure the rim feels what an angle in front of it does.
    const double front_rad = at_rad >= highest_rad
                                 ? at_rad
                                 : entry_rad - (at_rad - exit_rad) / (highest_rad - exit_rad) *
                                                   (entry_rad - highest_rad);
    const double pressed_m = wheel.radius_m * (std::cos(front_rad) - cos_entry) / deeper;
    const double normal_Pa = pressure_Pa(soil, wheel.width_m, pressed_m);
    const double sheared_m =
        wheel.radius_m *
        ((entry_rad - at_rad) - (1 - slip) * (std::sin(entry_rad) - std::sin(at_rad)));
    const double strength_Pa = soil.factor * soil.cohesion_Pa + normal_Pa * tangent;
    const double shear_Pa =
        std::copysign(strength_Pa * -std::expm1(-std::abs(sheared_m) / soil.shear_m), sheared_m);
    const double sine = std::sin(at_rad), cosine = std::cos(at_rad);
    sum.load_N += (normal_Pa * cosine + shear_Pa * sine) * piece_m2;
    sum.thrust_N += shear_Pa * cosine * piece_m2;
    sum.resistance_N += normal_Pa * sine * piece_m2;
    sum.torque_Nm += shear_Pa * wheel.radius_m * piece_m2;
  }
  return sum;
}

double sinkage_m(const Soil& soil, const Wheel& wheel, double load_N, double slip) {
  double above_m = 0, below_m = wheel.radius_m;
  for (int i = 0; i < 40; ++i) {
    const double middle_m = (above_m + below_m) / 2;
    (on_soil(soil, wheel, middle_m, slip).load_N < load_N ? above_m : below_m) = middle_m;
  }
  return load_N <= 0 ? 0 : below_m;
}

}  // namespace lss::sim::soil
