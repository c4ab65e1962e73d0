#include "tools/lss-sim/talaris/plant.h"

#include <algorithm>
#include <cmath>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PlanarJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <stdexcept>
#include <vector>

#include "tools/lss-sim/talaris/pad_in_soil.h"

namespace lss::sim::talaris {
namespace {

using dart::dynamics::BodyNode;
using dart::dynamics::Skeleton;
using dart::dynamics::SkeletonPtr;

constexpr double kWeightArm_m = 0.40;  // of the weight on the pivot
const Vector3 kUp = Vector3::UnitX();

// Legs and the corners of the frame; the corners touch only when it lies. Springs with dampers: the
// vehicle sinks 3 mm into its legs and comes to standstill within a tenth of a second.
constexpr double kLeg_m = 0.25;
constexpr double kLeg_N_m = 40'000, kLeg_Ns_m = 1'200;
constexpr std::size_t kPoints = 8;
const std::array<Vector3, kPoints> kTouching = {{{-kLeg_m, -0.30, -0.40},
                                                 {-kLeg_m, -0.30, 0.40},
                                                 {-kLeg_m, 0.30, 0.40},
                                                 {-kLeg_m, 0.30, -0.40},
                                                 {0.05, -0.38, -0.495},
                                                 {0.05, -0.38, 0.495},
                                                 {0.05, 0.38, 0.495},
                                                 {0.05, 0.38, -0.495}}};
constexpr double kReach_m = 0.7;  // of any of them from the origin
constexpr int kFlight_ms = 50;    // longer off the ground is a flight, shorter a bounce
constexpr int kLanding_ms = 300;  // within which the other feet touch down

// The stand's bumpers.
constexpr double kNose_m = 0.55;  // from the origin to the bumper before the wall
constexpr double kStop_rad = 0.6;
constexpr double kStop_Nm_rad = 3'000, kStop_Nms_rad = 100;

constexpr double kInertiaEvery_kg = 0.002;  // gas

Vector3 direction(Axis axis) { return axis == Axis::pitch ? Vector3::UnitY() : Vector3::UnitZ(); }

// Slows a velocity down, to standstill at most.
void slow(Eigen::Ref<Eigen::VectorXd> velocity, double by) {
  const double size = velocity.norm();
  velocity *= size <= by ? 0 : 1 - by / size;
}

}  // namespace

struct Plant::World {
  SkeletonPtr skeleton = Skeleton::create("talaris");
  BodyNode* body = nullptr;
  BodyNode* carriage = nullptr;  // of lift
  double inertia_gas_kg = -1;
  std::array<std::optional<Vector3>, kPoints> anchors;  // points where feet stick to hard ground
  std::vector<PadInSoil> pads;                          // of all points, on soil

  void set_inertia(const PlantOptions& options, double mass_kg) {
    Vector3 cg_m = options.cg_m;
    Eigen::Matrix3d moment = options.inertia_kg_m2.asDiagonal();
    double total_kg = mass_kg;
    if (options.stand == Stand::pivot && options.weight_kg > 0) {
      const Vector3 arm =
          options.axis == Axis::pitch ? Vector3(0, 0, kWeightArm_m) : Vector3(0, kWeightArm_m, 0);
      total_kg += options.weight_kg;
      const Vector3 centre = (mass_kg * cg_m + options.weight_kg * arm) / total_kg;
      const auto steiner = [&](double mass, const Vector3& at) -> Eigen::Matrix3d {
        const Vector3 r = at - centre;
        return mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
      };
      moment += steiner(mass_kg, cg_m) + steiner(options.weight_kg, arm);
      cg_m = centre;
    }
    body->setInertia(dart::dynamics::Inertia(total_kg, cg_m, moment));
  }
};

Plant::Plant(const PlantOptions& options)
    : options_(options),
      world_(std::make_unique<World>()),
      mass_kg_(options.mass_kg),
      ground_m_(-kLeg_m + mass_kg_ * kGravity_m_s2 / (kFeet * kLeg_N_m)) {
  using namespace dart::dynamics;
  World& w = *world_;
  const auto make = [&]<class JointType>(BodyNode* parent) {
    typename JointType::Properties joint_properties;
    joint_properties.mName = parent == nullptr ? "stand" : "pivot";
    BodyNode::Properties body_properties;
    body_properties.mName = parent == nullptr ? "first" : "second";
    const auto [joint, body] = w.skeleton->createJointAndBodyNodePair<JointType>(
        parent, joint_properties, body_properties);
    w.body = body;
    return joint;
  };
  switch (options.stand) {
    case Stand::free: {
      const Vector3 level(0, std::cos(options.uphill_rad), -std::sin(options.uphill_rad));
      const Eigen::AngleAxisd slope(options.slope_rad, level);
      normal_ = slope * kUp;
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.translation() = options.height_m * kUp;
      pose.linear() = (slope * Eigen::AngleAxisd(options.heading_rad, kUp) *
                       Eigen::AngleAxisd(options.tilt_rad, direction(options.axis)))
                          .toRotationMatrix();
      make.operator()<FreeJoint>(nullptr)->setTransform(pose);
      break;
    }
    case Stand::rail: make.operator()<PrismaticJoint>(nullptr)->setAxis(Vector3::UnitZ()); break;
    case Stand::sled: {
      auto* joint = make.operator()<PlanarJoint>(nullptr);
      joint->setArbitraryPlane(Vector3::UnitY(), Vector3::UnitZ());
      joint->setPosition(2, options.heading_rad);
      break;
    }
    case Stand::pivot: {
      auto* joint = make.operator()<RevoluteJoint>(nullptr);
      joint->setAxis(direction(options.axis));
      joint->setPosition(0, options.tilt_rad);
      break;
    }
    case Stand::lift: {
      auto* slider = make.operator()<PrismaticJoint>(nullptr);
      slider->setAxis(kUp);
      slider->setPosition(0, options.height_m);
      w.carriage = w.body;
      w.carriage->setGravityMode(false);
      w.carriage->setInertia(
          Inertia(options.counterweight_kg, Vector3::Zero(), Eigen::Matrix3d::Identity()));
      auto* joint = make.operator()<RevoluteJoint>(w.carriage);
      joint->setAxis(direction(options.axis));
      joint->setPosition(0, options.tilt_rad);
      // The rope takes this load from the legs.
      ground_m_ =
          -kLeg_m + (mass_kg_ - options.counterweight_kg) * kGravity_m_s2 / (kFeet * kLeg_N_m);
      break;
    }
    case Stand::fans: {
      auto* slider = make.operator()<PrismaticJoint>(nullptr);
      slider->setAxis(kUp);
      slider->setPosition(0, options.height_m);
      break;
    }
    case Stand::load: make.operator()<WeldJoint>(nullptr); break;
  }
  w.skeleton->setGravity(-kGravity_m_s2 * kUp);
  w.set_inertia(options_, mass_kg_);
  feel(Vector3::Zero());
  if (options.soil) press_pads();
  body_.force_B_m_s2 = body_.attitude.conjugate() * (kGravity_m_s2 * kUp);
  contact_ = clearance_m() <= 0;
}

Plant::~Plant() = default;

// Where it stands all pads rest at the depth of a quarter of the weight.
void Plant::press_pads() {
  if (options_.stand != Stand::free)
    throw std::invalid_argument("soil is for the stand free only: leave out --ground or --stand");
  const soil::Soil here = soil::in_gravity(*options_.soil, kGravity_m_s2);
  const PadInSoil pad(here, {kLeg_N_m, kLeg_Ns_m}, normal_);
  const double rest_m = pad.carries_at_m(mass_kg_ * kGravity_m_s2 / kFeet);
  ground_m_ += rest_m;
  world_->pads.assign(kPoints, pad);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double into_m =
        std::max(0.0, into_ground_m(body_.position_m + body_.attitude * kTouching[i]));
    world_->pads[i].press(std::min(into_m, rest_m), into_m);
  }
}

void Plant::step(const Wrench& wrench, double gas_used_kg, const Vector3& push_N) {
  World& w = *world_;
  mass_kg_ = options_.mass_kg - gas_used_kg;
  if (std::abs(gas_used_kg - w.inertia_gas_kg) > kInertiaEvery_kg) {
    w.set_inertia(options_, mass_kg_);
    w.inertia_gas_kg = gas_used_kg;
  }
  Wrench all = feet();
  all.force_N += wrench.force_N;
  all.torque_Nm += wrench.torque_Nm;
  all.add(options_.cg_m, body_.attitude.conjugate() * push_N);
  w.body->addExtForce(all.force_N, Vector3::Zero(), true, true);
  w.body->addExtTorque(all.torque_Nm, true);
  if (w.carriage != nullptr) {
    w.carriage->addExtForce(options_.counterweight_kg * kGravity_m_s2 * kUp, Vector3::Zero(), false,
                            true);
  }
  const Vector3 last = body_.velocity_m_s;
  w.skeleton->computeForwardDynamics();
  w.skeleton->integrateVelocities(kStep_s);
  brake();
  w.skeleton->integratePositions(kStep_s);
  w.skeleton->clearExternalForces();
  feel(last);
}

// Dry friction of a stand reduces the velocity, and so keeps it at standstill within its limit.
void Plant::brake() {
  if (options_.stand == Stand::free || options_.stand == Stand::load) return;
  Skeleton& skeleton = *world_->skeleton;
  Vector3 velocity = Vector3::Zero();  // of the stand's degrees of freedom, at most three
  for (std::size_t i = 0; i < skeleton.getNumDofs(); ++i)
    velocity[static_cast<Eigen::Index>(i)] = skeleton.getVelocity(i);
  const double slide = options_.friction_m_s2 * kStep_s;
  const auto turn = [&] {
    const double about = options_.inertia_kg_m2[options_.axis == Axis::pitch ? 1 : 2];
    return options_.pivot_friction_Nm / about * kStep_s;
  };
  switch (options_.stand) {
    case Stand::free:
    case Stand::load: break;
    case Stand::rail:
    case Stand::fans: slow(velocity, slide); break;
    case Stand::sled:
      slow(velocity.head(2), slide);
      // The cushion's friction acts at about 0.3 m from the axis.
      slow(velocity.tail(1), slide * 0.3 * mass_kg_ / options_.inertia_kg_m2.x());
      break;
    case Stand::pivot: slow(velocity, turn()); break;
    case Stand::lift:
      slow(velocity.head(1), slide);
      slow(velocity.segment(1, 1), turn());
      break;
  }
  for (std::size_t i = 0; i < skeleton.getNumDofs(); ++i)
    skeleton.setVelocity(i, velocity[static_cast<Eigen::Index>(i)]);
}

void Plant::feel(const Vector3& last_velocity_m_s) {
  const Eigen::Isometry3d& pose = world_->body->getWorldTransform();
  body_.position_m = pose.translation();
  body_.attitude = Quaternion(pose.linear());
  body_.velocity_m_s = world_->body->getLinearVelocity();
  body_.rate_B_rad_s =
      world_->body->getAngularVelocity(dart::dynamics::Frame::World(), world_->body);
  const Vector3 change = (body_.velocity_m_s - last_velocity_m_s) / kStep_s;
  body_.force_B_m_s2 = pose.linear().transpose() * (change + kGravity_m_s2 * kUp);
}

// The ground's, the wall's and the stops' forces, in B about the origin.
Wrench Plant::feet() {
  World& w = *world_;
  Wrench wrench;
  const Eigen::Matrix3d to_world = body_.attitude.toRotationMatrix();
  if (options_.stand == Stand::rail || options_.stand == Stand::sled) {
    const double into_m = body_.position_m.z() + kNose_m - options_.wall_m;
    contact_ = into_m > 0;
    if (contact_) {
      const double push = kLeg_N_m * into_m + kLeg_Ns_m * body_.velocity_m_s.z();
      wrench.force_N = to_world.transpose() * Vector3(0, 0, -std::max(0.0, push));
    }
    return wrench;
  }
  if (options_.stand == Stand::pivot || options_.stand == Stand::lift) {
    const double angle = w.skeleton->getPosition(w.skeleton->getNumDofs() - 1);
    const double rate = w.skeleton->getVelocity(w.skeleton->getNumDofs() - 1);
    const double beyond = angle - std::clamp(angle, -kStop_rad, kStop_rad);
    if (beyond != 0) {
      wrench.torque_Nm -= (kStop_Nm_rad * beyond + kStop_Nms_rad * rate) * direction(options_.axis);
    }
    if (options_.stand == Stand::pivot) return wrench;
  }
  if (options_.stand == Stand::load) return wrench;

  bool touching = false;
  double down_m_s = 0;
  const bool near = normal_.dot(body_.position_m) - ground_m_ < kReach_m;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Vector3 arm = to_world * kTouching[i];
    const Vector3 at = body_.position_m + arm;
    const double into_m = into_ground_m(at);
    if (!near || into_m <= 0) {
      w.anchors[i].reset();
      if (options_.soil) w.pads[i].step({});
      continue;
    }
    const Vector3 velocity = body_.velocity_m_s + (to_world * body_.rate_B_rad_s).cross(arm);
    const double apart_m_s = normal_.dot(velocity);
    touching = true;
    down_m_s = std::max(down_m_s, -velocity.x());
    if (options_.soil) {
      const Vector3 push_N = w.pads[i].step({into_m, at, velocity});
      wrench.add(kTouching[i], to_world.transpose() * push_N);
      continue;
    }
    const double normal = std::max(0.0, kLeg_N_m * into_m - kLeg_Ns_m * apart_m_s);
    if (!w.anchors[i]) w.anchors[i] = at;
    Vector3 sideways = -kLeg_N_m * (at - *w.anchors[i]) - kLeg_Ns_m * velocity;
    sideways -= normal_.dot(sideways) * normal_;
    const double most = options_.ground_friction * normal;
    if (sideways.norm() > most) {  // slides: the spring follows
      sideways *= most / sideways.norm();
      *w.anchors[i] = at + sideways / kLeg_N_m;
    }
    wrench.add(kTouching[i], to_world.transpose() * (normal * normal_ + sideways));
  }
  note_contact(touching, down_m_s);
  return wrench;
}

void Plant::note_contact(bool now, double down_m_s) {
  if (now && airborne_ms_ > kFlight_ms) {
    touchdown_ = {down_m_s, std::hypot(body_.velocity_m_s.y(), body_.velocity_m_s.z())};
    landing_ms_ = 0;
  } else if (++landing_ms_ < kLanding_ms) {
    touchdown_.down_m_s = std::max(touchdown_.down_m_s, down_m_s);
  }
  airborne_ms_ = now ? 0 : airborne_ms_ + 1;
  contact_ = now;
}

double Plant::clearance_m() const {
  double lowest = kReach_m;
  for (std::size_t i = 0; i < kFeet; ++i) {
    lowest = std::min(lowest, normal_.dot(body_.attitude * kTouching[i]));
  }
  return normal_.dot(body_.position_m) + lowest - ground_m_;
}

double Plant::sinkage_m(std::size_t foot) const {
  return options_.soil ? world_->pads[foot].depth_m() : 0;
}

double Plant::legs_J() const {
  double sum_J = 0;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Vector3 at = body_.position_m + body_.attitude * kTouching[i];
    const double into_m = into_ground_m(at);
    if (options_.soil) {
      sum_J += world_->pads[i].leg_J({into_m, at});
    } else if (const auto& anchor = world_->anchors[i]; anchor && into_m > 0) {
      const Vector3 bent_m = at - *anchor;
      const double sideways_m2 = bent_m.squaredNorm() - std::pow(normal_.dot(bent_m), 2);
      sum_J += kLeg_N_m / 2 * (into_m * into_m + sideways_m2);
    }
  }
  return sum_J;
}

double Plant::energy_J() const {
  // DART computes potential energy as if a body's origin were its centre of mass.
  const World& w = *world_;
  double moment_kg_m = w.body->getMass() * w.body->getCOM().x();
  if (w.carriage != nullptr) moment_kg_m -= options_.counterweight_kg * body_.position_m.x();
  return w.skeleton->computeKineticEnergy() + moment_kg_m * kGravity_m_s2 + legs_J();
}

std::optional<double> Plant::distance_m(const Vector3& at_m, const Vector3& along,
                                        double most_rad) const {
  const bool wall = options_.stand == Stand::rail || options_.stand == Stand::sled;
  const Vector3 normal = wall ? Vector3(Vector3::UnitZ()) : Vector3(-normal_);  // into it
  const double from = wall ? options_.wall_m : -ground_m_;
  const double cosine = normal.dot(body_.attitude * along);
  if (cosine < std::cos(most_rad)) return std::nullopt;
  return (from - normal.dot(body_.position_m + body_.attitude * at_m)) / cosine;
}

}  // namespace lss::sim::talaris
