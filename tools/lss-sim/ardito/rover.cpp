#include "tools/lss-sim/ardito/rover.h"

#include <algorithm>
#include <cmath>
#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/bullet/BulletCollisionDetector.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/TranslationalJoint.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>
#include <numbers>
#include <stdexcept>
#include <unordered_map>
#include <vector>

#include "idl/angles.h"
#include "tools/lss-sim/ardito/rocks.h"
#include "tools/lss-sim/ardito/wheel_in_soil.h"
#include "tools/lss-sim/frame/shapes.h"

namespace lss::sim::ardito {
namespace {

using namespace dart::dynamics;
using namespace dimensions;

// Shares of the 50 kg; the motors sit in the wheels.
constexpr double kWheel_kg = 2.0, kBracket_kg = 1.0, kRocker_kg = 2.5, kBogie_kg = 2.0;
constexpr double kChassis_kg =
    kMass_kg - 6 * kWheel_kg - 4 * kBracket_kg - 2 * kRocker_kg - 2 * kBogie_kg;
constexpr double kRotor_kg_m2 = 0.025;  // of the motor, behind a gear of 50, at the wheel

// Ardito thesis 13.4: the rockers' axis, the bogies' axis (l2, l3), the wheels' axles below.
constexpr double kRockerX_m = -kCentre_m;
constexpr double kBogieX_m = -0.280, kBogieDown_m = 0.141;
constexpr double kAxleDown_m = 0.375;

// The torsion bar between the rockers: stiff against turning together, free against turning
// opposite ways, which makes the chassis' pitch the mean of the two.
constexpr double kBar_Nm_rad = 4000, kBar_Nms_rad = 60;
constexpr double kBogie_Nms_rad = 1.0;
constexpr double kRockerStop_rad = 35 * kDegree, kBogieStop_rad = 45 * kDegree;
constexpr double kSteeringStop_rad = 75 * kDegree;

// A pulling wheel slips a little, in proportion to the pull: by this share of its speed for a pull
// equal to its load. Without slip, rigid wheels would work against each other.
constexpr double kSlip = 0.15;

// A patch of ground under each wheel: so large that a wheel never leaves it within a step.
const Eigen::Vector3d kPatch_m(0.4, 0.4, 0.2);
constexpr double kResting_rad_s = 1e-3;
constexpr double kLoadFilter = 0.05;  // a step
constexpr double kLeastLoad_N = 5;
constexpr double kNoLimit = 100;  // friction of ground whose limit is set at the wheels

// A wheel touches its own patch, and kerbs.
class WheelOnGround final : public dart::collision::CollisionFilter {
 public:
  static constexpr int kKerb = -1;
  void add(const ShapeFrame* shape, int wheel, bool ground) { parts_[shape] = {wheel, ground}; }

  bool ignoresCollision(const dart::collision::CollisionObject* a,
                        const dart::collision::CollisionObject* b) const override {
    const Part& one = parts_.at(a->getShapeFrame());
    const Part& other = parts_.at(b->getShapeFrame());
    if (one.ground == other.ground) return true;
    return one.wheel != other.wheel && one.wheel != kKerb && other.wheel != kKerb;
  }
  // The wheel of a shape; kKerb for any other shape.
  int wheel(const ShapeFrame* shape) const {
    const Part& part = parts_.at(shape);
    return part.ground ? kKerb : part.wheel;
  }

 private:
  struct Part {
    int wheel;
    bool ground;
  };
  std::unordered_map<const ShapeFrame*, Part> parts_;
};

struct Link {
  RevoluteJoint* joint;
  BodyNode* body;
};

Link add_link(BodyNode& parent, const std::string& name, const Eigen::Vector3d& at_m,
              const Eigen::Vector3d& axis, double mass_kg, const Eigen::Vector3d& inertia_kg_m2,
              const Eigen::Vector3d& centre_m = Eigen::Vector3d::Zero()) {
  RevoluteJoint::Properties joint;
  joint.mName = name;
  joint.mAxis = axis;
  joint.mT_ParentBodyToJoint.translation() = at_m;
  BodyNode::Properties body;
  body.mName = name;
  body.mInertia.setMass(mass_kg);
  body.mInertia.setLocalCOM(centre_m);
  body.mInertia.setMoment(inertia_kg_m2.x(), inertia_kg_m2.y(), inertia_kg_m2.z(), 0, 0, 0);
  const auto [made, node] =
      parent.getSkeleton()->createJointAndBodyNodePair<RevoluteJoint>(&parent, joint, body);
  return {made, node};
}

void add_stops(RevoluteJoint& joint, double most_rad) {
  joint.setPositionLowerLimit(0, -most_rad);
  joint.setPositionUpperLimit(0, most_rad);
  joint.setLimitEnforcement(true);
}

// Turns a shaft against a friction torque: the gear gives the torque of the joint plus the loss. A
// limit against the motion is at least 0: the solver needs 0 between the limits.
void drive(RevoluteJoint& joint, const ShaftDrive& wanted, double friction_Nm) {
  const double velocity_rad_s = joint.getVelocity(0);
  const bool moves = std::abs(velocity_rad_s) > kResting_rad_s;
  const double way = moves ? velocity_rad_s : wanted.velocity_rad_s;  // friction opposes it
  double forward_Nm = wanted.torque_limit_Nm + friction_Nm;
  double backward_Nm = forward_Nm;
  const double against_Nm = std::max(0.0, wanted.torque_limit_Nm - friction_Nm);
  if (way > kResting_rad_s) forward_Nm = against_Nm;
  if (way < -kResting_rad_s) backward_Nm = against_Nm;
  joint.setForceLowerLimit(0, -backward_Nm);
  joint.setForceUpperLimit(0, forward_Nm);
  joint.setCommand(0, wanted.velocity_rad_s);
}

ShaftState felt(const RevoluteJoint& joint, const ShaftDrive& wanted, double friction_Nm) {
  const double velocity_rad_s = joint.getVelocity(0);
  const double net_Nm = joint.getConstraintImpulse(0) / kStep_s;
  const double lost_Nm = std::abs(velocity_rad_s) > kResting_rad_s
                             ? -std::copysign(friction_Nm, velocity_rad_s)
                             : std::clamp(net_Nm, -friction_Nm, friction_Nm);
  return {
      .angle_rad = joint.getPosition(0),
      .velocity_rad_s = velocity_rad_s,
      .torque_Nm = std::clamp(net_Nm - lost_Nm, -wanted.torque_limit_Nm, wanted.torque_limit_Nm)};
}

}  // namespace

struct Rover::World {
  World(const RoverOptions& options)
      : terrain(options.ground, options.seed),
        rocks(options.rocks, options.seed),
        hard_friction(options.friction) {}

  void build(const RoverOptions& options);
  void add_side(BodyNode& chassis, std::size_t side, double friction);
  void build_ground(const RoverOptions& options);
  void place_patches();
  void place_patch(std::size_t wheel, const GroundPoint& at, double below_m);
  soil::Soil soil_under(std::size_t wheel, double x_m) const;
  // Of one wheel, on hard ground and on soil: sets its contact, returns the torques against rolling
  // and steering.
  struct Friction {
    double rolling_Nm, turning_Nm;
  };
  Friction touch(std::size_t wheel, double load_N);
  Friction sink(std::size_t wheel, double load_N);

  dart::simulation::WorldPtr world = dart::simulation::World::create();
  std::shared_ptr<WheelOnGround> filter = std::make_shared<WheelOnGround>();
  Terrain terrain;
  Rocks rocks;
  double hard_friction;
  SkeletonPtr robot, ground;
  BodyNode* chassis = nullptr;
  std::array<RevoluteJoint*, 2> rockers{}, bogies{};  // left, right
  std::array<RevoluteJoint*, kWheels> wheels{};
  std::array<RevoluteJoint*, kSteered> steering{};
  std::array<BodyNode*, kWheels> hubs{};
  std::array<DynamicsAspect*, kWheels> treads{};
  std::array<ShapeNode*, kWheels> patches{};
  std::array<GroundPoint, kWheels> under{};
  std::array<bool, kWheels> on_rock{};
  // On soil: of each wheel, how it sinks and the motion of its patch.
  std::vector<WheelInSoil> in_soil;
  soil::Soil around;  // and its patches, in this gravity
  std::vector<Patch> soft;
  std::array<dart::dynamics::TranslationalJoint*, kWheels> moving{};
  std::array<double, kWheels> sinking_m_s{};
};

void Rover::World::add_side(BodyNode& body, std::size_t side, double friction) {
  const double y_m = side == 0 ? kTrack_m / 2 : -kTrack_m / 2;
  const std::string name = side == 0 ? "left" : "right";
  const Eigen::Vector3d lifting = -Eigen::Vector3d::UnitY();
  const Link rocker = add_link(body, name + "_rocker", {kRockerX_m, y_m, 0}, lifting, kRocker_kg,
                               {0.02, 0.15, 0.15}, {0.15, 0, -0.15});
  const Link bogie = add_link(*rocker.body, name + "_bogie", {kBogieX_m, 0, -kBogieDown_m}, lifting,
                              kBogie_kg, {0.01, 0.08, 0.08}, {0, 0, -0.08});
  rockers[side] = rocker.joint;
  bogies[side] = bogie.joint;
  add_stops(*rocker.joint, kRockerStop_rad);
  add_stops(*bogie.joint, kBogieStop_rad);
  bogie.joint->setDampingCoefficient(0, kBogie_Nms_rad);

  const double down_m = -kAxleDown_m + kBogieDown_m;
  const Eigen::Vector3d places_m[3] = {
      {kFront_m, 0, -kAxleDown_m}, {-kBogieX_m, 0, down_m}, {-kBogieX_m - kRear_m, 0, down_m}};
  for (std::size_t axle = 0; axle < 3; ++axle) {
    const std::size_t wheel = 2 * axle + side;
    BodyNode* carrier = axle == 0 ? rocker.body : bogie.body;
    Eigen::Vector3d at_m = places_m[axle];
    const auto* steered = std::ranges::find(kSteeredWheels, wheel);
    if (steered != kSteeredWheels.end()) {
      const Link bracket =
          add_link(*carrier, "steering" + std::to_string(wheel + 1), at_m, Eigen::Vector3d::UnitZ(),
                   kBracket_kg, {0.01, 0.01, 0.005}, {0, 0, 0.1});
      bracket.joint->setActuatorType(dart::dynamics::Joint::SERVO);
      add_stops(*bracket.joint, kSteeringStop_rad);
      steering[static_cast<std::size_t>(steered - kSteeredWheels.begin())] = bracket.joint;
      carrier = bracket.body;
      at_m.setZero();
    }
    const double across_kg_m2 = kWheel_kg * kWheelRadius_m * kWheelRadius_m / 4;
    const Link hub =
        add_link(*carrier, "wheel" + std::to_string(wheel + 1), at_m, Eigen::Vector3d::UnitY(),
                 kWheel_kg, {across_kg_m2, 2 * across_kg_m2 + kRotor_kg_m2, across_kg_m2});
    hub.joint->setActuatorType(dart::dynamics::Joint::SERVO);
    wheels[wheel] = hub.joint;
    hubs[wheel] = hub.body;
    auto* tread = add_shape<dart::dynamics::SphereShape>(*hub.body, friction, kWheelRadius_m);
    filter->add(tread, static_cast<int>(wheel), false);
    treads[wheel] = tread->getDynamicsAspect();
  }
}

void Rover::World::build_ground(const RoverOptions& options) {
  ground = Skeleton::create("ground");
  BodyNode* node = ground->createJointAndBodyNodePair<dart::dynamics::WeldJoint>().second;
  const double friction = options.soil ? kNoLimit : options.friction;
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    BodyNode* under_wheel = node;
    if (options.soil) {
      // Its place is that of its shape; only its velocity is the joint's.
      dart::dynamics::TranslationalJoint::Properties joint_names;
      BodyNode::Properties names;
      joint_names.mName = names.mName = "patch" + std::to_string(wheel + 1);
      const auto [joint, body] =
          ground->createJointAndBodyNodePair<dart::dynamics::TranslationalJoint>(node, joint_names,
                                                                                 names);
      moving[wheel] = joint;
      under_wheel = body;
    }
    patches[wheel] = add_shape<dart::dynamics::BoxShape>(*under_wheel, friction, kPatch_m);
    filter->add(patches[wheel], static_cast<int>(wheel), true);
  }
  if (options.step_height_m > 0) {
    const double width_m = options.step_side == StepSide::both ? 100 : 50;
    const double y_m = options.step_side == StepSide::left    ? width_m / 2
                       : options.step_side == StepSide::right ? -width_m / 2
                                                              : 0;
    auto* kerb = add_shape<dart::dynamics::BoxShape>(
        *node, options.friction,
        Eigen::Vector3d(options.step_length_m, width_m, 2 * options.step_height_m));
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.translation() = Eigen::Vector3d(options.step_at_m + options.step_length_m / 2, y_m, 0);
    kerb->setRelativeTransform(place);
    filter->add(kerb, WheelOnGround::kKerb, true);
  }
  if (options.soil) ground->setMobile(false);
  world->addSkeleton(ground);
}

void Rover::World::build(const RoverOptions& options) {
  world->setTimeStep(kStep_s);
  const double g = options.gravity_m_s2;
  // A slope is simulated by tilted gravity, so that the ground stays a height over x and y.
  world->setGravity({-g * std::sin(options.slope_rad), 0, -g * std::cos(options.slope_rad)});
  world->getConstraintSolver()->setCollisionDetector(
      dart::collision::BulletCollisionDetector::create());
  world->getConstraintSolver()->getCollisionOption().collisionFilter = filter;

  build_ground(options);
  robot = Skeleton::create("rover");
  auto [free, body] = robot->createJointAndBodyNodePair<dart::dynamics::FreeJoint>();
  chassis = body;
  chassis->setMass(kChassis_kg);
  chassis->setMomentOfInertia(1.0, 1.6, 2.2);
  for (const std::size_t side : {0u, 1u}) add_side(*chassis, side, options.friction);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().z() = kAxleDown_m + kWheelRadius_m;
  if (options.soil) {
    around = soil::in_gravity(*options.soil, g);
    in_soil.assign(kWheels, WheelInSoil(around, kMass_kg * g / kWheels));
    for (const Patch& patch : options.patches) {
      soft.push_back(patch);
      soft.back().soil = soil::in_gravity(patch.soil, g);
    }
    pose.translation().z() -= in_soil[0].sinkage_m();
  }
  free->setTransform(pose);
  world->addSkeleton(robot);
}

soil::Soil Rover::World::soil_under(std::size_t wheel, double x_m) const {
  soil::Soil found = around;
  for (const Patch& patch : soft) found = mixed(found, patch.soil, patch.share(wheel, x_m));
  return found;
}

// Moves each wheel's patch so that it touches the ground where the wheel is nearest to it.
void Rover::World::place_patches() {
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    const Eigen::Vector3d centre = hubs[wheel]->getWorldTransform().translation();
    if (!soft.empty()) in_soil[wheel].enter(soil_under(wheel, centre.x()));
    const GroundPoint& point = under[wheel] =
        terrain.nearest(centre.x(), centre.y(), centre.z(), under[wheel]);
    const double below_m = in_soil.empty() ? 0 : in_soil[wheel].sinkage_m();
    const auto far_m = [&](const GroundPoint& of) {
      return (centre - Eigen::Vector3d(of.x_m, of.y_m, of.z_m))
          .dot(Eigen::Vector3d(of.normal.data()));
    };
    const std::optional<GroundPoint> rock =
        rocks.nearest(centre.x(), centre.y(), centre.z(), terrain);
    on_rock[wheel] = rock && far_m(*rock) < far_m(point) + below_m;
    if (on_rock[wheel]) {
      place_patch(wheel, *rock, 0);
    } else {
      place_patch(wheel, point, below_m);
    }
  }
}

void Rover::World::place_patch(std::size_t wheel, const GroundPoint& at, double below_m) {
  const Eigen::Vector3d normal(at.normal.data());
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  place.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal).toRotationMatrix();
  place.translation() =
      Eigen::Vector3d(at.x_m, at.y_m, at.z_m) - normal * (kPatch_m.z() / 2 + below_m);
  patches[wheel]->setRelativeTransform(place);
  const double sinking = on_rock[wheel] ? 0 : sinking_m_s[wheel];
  if (!in_soil.empty()) moving[wheel]->setVelocities(-sinking * normal);
}

Rover::World::Friction Rover::World::touch(std::size_t wheel, double load_N) {
  const double speed_m_s = std::abs(wheels[wheel]->getVelocity(0)) * kWheelRadius_m;
  const double compliance_m_sN = kSlip * speed_m_s / std::max(load_N, kLeastLoad_N);
  treads[wheel]->setFrictionCoeff(hard_friction);
  treads[wheel]->setPrimarySlipCompliance(compliance_m_sN);
  treads[wheel]->setSecondarySlipCompliance(compliance_m_sN);
  return {kRollingResistance * load_N * kWheelRadius_m, kPatchRadius_m * load_N};
}

Rover::World::Friction Rover::World::sink(std::size_t wheel, double load_N) {
  const Eigen::Vector3d normal(under[wheel].normal.data());
  const Eigen::Vector3d axle = hubs[wheel]->getWorldTransform().linear().col(1);
  const Eigen::Vector3d ahead = axle.cross(normal).normalized();
  const Eigen::Vector3d hub_m_s = hubs[wheel]->getLinearVelocity();
  const SoilGrip grip =
      in_soil[wheel].step({.load_N = on_rock[wheel] ? 0 : load_N,
                           .rim_m_s = wheels[wheel]->getVelocity(0) * kWheelRadius_m,
                           .ahead_m_s = hub_m_s.dot(ahead),
                           .left_m_s = hub_m_s.dot(normal.cross(ahead))});
  sinking_m_s[wheel] = grip.sinking_m_s;
  if (on_rock[wheel]) return touch(wheel, load_N);
  treads[wheel]->setFrictionCoeff(grip.friction);
  treads[wheel]->setPrimarySlipCompliance(grip.compliance_m_sN);
  treads[wheel]->setSecondarySlipCompliance(grip.compliance_m_sN);
  hubs[wheel]->addExtForce(grip.resistance_N * ahead, Eigen::Vector3d::Zero(), false, true);
  return {grip.rolling_Nm, grip.turning_Nm};
}

Rover::Rover(const RoverOptions& options) : world_(std::make_unique<World>(options)) {
  if (options.soil && options.step_height_m > 0)
    throw std::invalid_argument(
        "there is no step on soil: leave out --step or the soil of --ground");
  if (!options.soil && !options.patches.empty())
    throw std::invalid_argument(
        "a patch is in a soil: leave out --patch or add one to --ground, for example regolith");
  world_->build(options);
  loads_N_.fill(kMass_kg * options.gravity_m_s2 / kWheels);
}

Rover::~Rover() = default;

void Rover::step(const std::array<ShaftDrive, kWheels>& wheels,
                 const std::array<ShaftDrive, kSteered>& steering) {
  World& w = *world_;
  w.place_patches();
  std::array<double, kWheels> rolling_Nm{}, in_place_Nm{};
  std::array<double, kSteered> turning_Nm{};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const World::Friction friction =
        w.in_soil.empty() ? w.touch(i, loads_N_[i]) : w.sink(i, loads_N_[i]);
    rolling_Nm[i] = friction.rolling_Nm;
    in_place_Nm[i] = friction.turning_Nm;
    drive(*w.wheels[i], wheels[i], rolling_Nm[i]);
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    turning_Nm[i] = in_place_Nm[kSteeredWheels[i]];
    drive(*w.steering[i], steering[i], turning_Nm[i]);
  }
  const double twist_rad = w.rockers[0]->getPosition(0) + w.rockers[1]->getPosition(0);
  const double twist_rad_s = w.rockers[0]->getVelocity(0) + w.rockers[1]->getVelocity(0);
  for (RevoluteJoint* rocker : w.rockers) {
    rocker->setForce(0, -kBar_Nm_rad * twist_rad - kBar_Nms_rad * twist_rad_s);
  }
  w.world->step();

  for (std::size_t i = 0; i < kWheels; ++i) {
    wheels_[i] = felt(*w.wheels[i], wheels[i], rolling_Nm[i]);
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    steering_[i] = felt(*w.steering[i], steering[i], turning_Nm[i]);
  }
  std::array<double, kWheels> pressed_N{};
  for (const auto& contact : w.world->getLastCollisionResult().getContacts()) {
    const int one = w.filter->wheel(contact.collisionObject1->getShapeFrame());
    const int other = w.filter->wheel(contact.collisionObject2->getShapeFrame());
    const auto wheel = static_cast<std::size_t>(std::max(one, other));
    pressed_N[wheel] += std::abs(contact.force.dot(contact.normal));
  }
  for (std::size_t i = 0; i < kWheels; ++i) {
    loads_N_[i] += kLoadFilter * (pressed_N[i] - loads_N_[i]);
  }
}

// The hub's speed in the wheel's plane, so that climbing a kerb does not count as slip.
double Rover::slip_m_s(std::size_t wheel) const {
  const World& w = *world_;
  const Eigen::Isometry3d& pose = w.hubs[wheel]->getWorldTransform();
  const Eigen::Vector3d axle = pose.linear().col(1);
  Eigen::Vector3d hub_m_s = w.hubs[wheel]->getLinearVelocity();
  hub_m_s -= axle * axle.dot(hub_m_s);
  const Eigen::Vector3d ahead = axle.cross(Eigen::Vector3d::UnitZ());
  const double tread_m_s = wheels_[wheel].velocity_rad_s * kWheelRadius_m;
  return tread_m_s - std::copysign(hub_m_s.norm(), hub_m_s.dot(ahead));
}

double Rover::sinkage_m(std::size_t wheel) const {
  const World& w = *world_;
  if (w.in_soil.empty() || w.on_rock[wheel]) return 0;
  const Eigen::Vector3d centre = w.hubs[wheel]->getWorldTransform().translation();
  const GroundPoint& point = w.under[wheel];
  const Eigen::Vector3d up(point.normal.data());
  return kWheelRadius_m - (centre - Eigen::Vector3d(point.x_m, point.y_m, point.z_m)).dot(up);
}

Suspension Rover::suspension() const {
  const World& w = *world_;
  return {.beta_rad = (w.rockers[0]->getPosition(0) - w.rockers[1]->getPosition(0)) / 2,
          .rho1_rad = w.bogies[0]->getPosition(0),
          .rho2_rad = w.bogies[1]->getPosition(0)};
}

BodyState Rover::body() const {
  const BodyNode& chassis = *world_->chassis;
  const Eigen::Isometry3d& pose = chassis.getWorldTransform();
  const Eigen::Vector3d velocity = chassis.getLinearVelocity();
  const Eigen::Vector3d rate = chassis.getAngularVelocity(dart::dynamics::Frame::World(), &chassis);
  return {.position_m = pose.translation(),
          .attitude = Eigen::Quaterniond(pose.linear()),
          .velocity_m_s = velocity,
          .velocity_B_m_s = pose.linear().transpose() * velocity,
          .yaw_rate_rad_s = rate.z()};
}

}  // namespace lss::sim::ardito
