#pragma once

// TALARIS as a rigid body (DART) in free flight, on its legs, or on a test stand: its motion under
// the forces of thrusters and fans. Frames as in gnc/talaris/types.h: body B with x up, z along the
// horizontal thrusters, y completing right-handed; world the same axes, origin where the body's
// origin is when the vehicle stands. The body's origin is the nominal centre of mass, where the IMU
// is. Used by one thread (physics). One step is 1 ms.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "tools/lss-sim/soil/soil.h"

namespace lss::sim::talaris {

inline constexpr std::size_t kValves = 8;  // index i: valve i + 1
inline constexpr std::size_t kFans = 4;
inline constexpr double kStep_s = 0.001;
inline constexpr double kGravity_m_s2 = 9.80665;

// The degrees of freedom (TALARIS thesis 5.2).
enum class Stand : std::uint8_t {
  free,   // everything; legs on the ground
  rail,   // along z only, a wall ahead (5.2.6)
  sled,   // y, z and roll on an air cushion, a wall ahead (5.2.7)
  pivot,  // one axis of attitude, balanced or with a weight (5.2.8)
  lift,   // height and one axis of attitude; a counterweight carries 5/6 (5.2.9)
  fans,   // height only (5.2.3)
  load,   // nothing: bolted to a load cell (5.2.5)
};

enum class Axis : std::uint8_t { pitch, yaw };  // about y, about z

// Vectors in plain structs, free of alignment.
using Vector3 = Eigen::Vector3d;
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

struct PlantOptions {
  Stand stand = Stand::free;
  Axis axis = Axis::pitch;               // of pivot and lift
  double mass_kg = 45;                   // with full tanks (TALARIS thesis 2.3.3)
  Vector3 inertia_kg_m2{4.5, 3.0, 1.8};  // estimated from the parts
  Vector3 cg_m = Vector3::Zero();        // where the centre of mass really is, B
  double tilt_rad = 0;                   // at the start, about `axis`
  double heading_rad = 0;                // at the start, about x; not on rail, pivot and lift
  double height_m = 0;                   // at the start, above where it stands
  double wall_m = 5;                     // of rail and sled: from the origin along +z
  double weight_kg = 0;                  // of pivot: a weight at the end of the frame
  double counterweight_kg = 37.5;        // of lift
  double friction_m_s2 = 0.05;           // of rail, sled, lift: dynamic friction
  double pivot_friction_Nm = 0.1;        // of pivot, lift
  double ground_friction = 0.8;          // of the feet
  double slope_rad = 0;                  // of free: the ground rises by this angle,
  double uphill_rad = 0;                 // along +z turned by this one towards +y; it stands on it
  std::optional<soil::Soil> soil{};      // of free: instead of hard ground (pad_in_soil.h)
};

// On the body, in B, about its origin.
struct Wrench {
  Vector3 force_N = Vector3::Zero();
  Vector3 torque_Nm = Vector3::Zero();
  void add(const Vector3& at_m, const Vector3& force) {
    force_N += force;
    torque_Nm += at_m.cross(force);
  }
};

struct BodyState {
  Vector3 position_m = Vector3::Zero();
  Quaternion attitude = Quaternion::Identity();  // B to world
  Vector3 velocity_m_s = Vector3::Zero();        // world
  Vector3 rate_B_rad_s = Vector3::Zero();
  Vector3 force_B_m_s2 = Vector3::Zero();  // specific force at the origin, mean of the last step
};

// The last time that a foot came down after a flight.
struct Touchdown {
  double down_m_s = 0;        // of the first foot, or of a later and faster one
  double horizontal_m_s = 0;  // of the body
};

class Plant {
 public:
  static constexpr std::size_t kFeet = 4;

  // It stands, hangs or lies at standstill. Throws std::invalid_argument for a soil on a stand.
  explicit Plant(const PlantOptions& options);
  ~Plant();
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  // `gas_used_kg` so far; `push_N` on the centre of mass, world: wind.
  void step(const Wrench& wrench, double gas_used_kg, const Vector3& push_N);

  const BodyState& body() const { return body_; }
  double mass_kg() const { return mass_kg_; }
  bool contact() const { return contact_; }
  double clearance_m() const;                // of the lowest foot; in soil negative
  double sinkage_m(std::size_t foot) const;  // of its pad in soil
  const Touchdown& touchdown() const { return touchdown_; }
  double energy_J() const;  // kinetic, potential relative to the origin, and of the legs' springs

  // The length of a beam from `at_m` (B) in direction `along` (B) to ground or wall; unset when it
  // does not hit, or hits at more than `most_rad` from the normal.
  std::optional<double> distance_m(const Vector3& at_m, const Vector3& along,
                                   double most_rad) const;

 private:
  struct World;
  void feel(const Vector3& last_velocity_m_s);
  void brake();
  Wrench feet();
  void note_contact(bool now, double down_m_s);
  double into_ground_m(const Vector3& at_m) const { return ground_m_ - normal_.dot(at_m); }
  void press_pads();
  double legs_J() const;

  PlantOptions options_;
  std::unique_ptr<World> world_;
  BodyState body_;
  Vector3 normal_ = Vector3::UnitX();  // of the ground
  double mass_kg_, ground_m_;          // where the ground is along it
  bool contact_ = false;
  int airborne_ms_ = 0, landing_ms_ = 1'000'000;
  Touchdown touchdown_;
};

}  // namespace lss::sim::talaris
