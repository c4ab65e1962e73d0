#include "tools/lss-sim/zebro/robot.h"

#include <algorithm>
#include <cmath>
#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/bullet/BulletCollisionDetector.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>
#include <numbers>
#include <random>
#include <string>
#include <unordered_set>

#include "tools/lss-sim/frame/shapes.h"

namespace lss::sim::zebro {
namespace {

using namespace dart::dynamics;

constexpr double kLegMass_kg = 0.02;
const Eigen::Vector3d kBodySize_m(kBodyLength_m, kBodyWidth_m, 2 * kHipHeightLying_m);
constexpr int kSpheres = 10;  // along the half circle from the toe to the hip

SkeletonPtr make_ground(const TerrainOptions& terrain, const Eigen::Isometry3d& tilt) {
  SkeletonPtr ground = Skeleton::create("ground");
  BodyNode* node = ground->createJointAndBodyNodePair<dart::dynamics::WeldJoint>().second;
  const Eigen::Vector3d up = tilt.linear() * Eigen::Vector3d::UnitZ();
  add_shape<dart::dynamics::PlaneShape>(*node, terrain.friction, up, 0.0);
  if (!terrain.rocks) return ground;

  // Half-buried stones, up to a third of a leg high, over the first metres; none under the start.
  std::mt19937 random(terrain.seed + 1);
  std::uniform_real_distribution<double> along(-2.0, 2.0), radius(0.008, 0.025),
      height(0.003, 0.018);
  for (int placed = 0; placed < 500;) {
    const double x = along(random), y = along(random), r = radius(random), h = height(random);
    if (std::abs(x) < 0.18 && std::abs(y) < 0.16) continue;
    auto* stone = add_shape<dart::dynamics::SphereShape>(*node, terrain.friction, r);
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.translation() = tilt * Eigen::Vector3d(x, y, std::min(h, r) - r);
    stone->setRelativeTransform(place);
    ++placed;
  }
  return ground;
}

void add_leg(Skeleton& robot, BodyNode& body, int leg, double friction) {
  RevoluteJoint::Properties joint;
  joint.mName = "hip" + std::to_string(leg + 1);
  joint.mAxis = Eigen::Vector3d::UnitY();  // down turns to the rear: forward rotation
  joint.mT_ParentBodyToJoint.translation() = Eigen::Vector3d(kHipX_m[leg], kHipY_m[leg], 0);
  BodyNode::Properties properties;
  properties.mName = "leg" + std::to_string(leg + 1);
  const double radius = kLegDiameter_m / 2;
  properties.mInertia.setMass(kLegMass_kg);
  properties.mInertia.setLocalCOM(Eigen::Vector3d(-radius * 2 / std::numbers::pi, 0, -radius));
  const double inertia = kLegMass_kg * radius * radius / 2;
  properties.mInertia.setMoment(inertia, 2 * inertia, inertia, 0, 0, 0);
  auto [hip, node] = robot.createJointAndBodyNodePair<RevoluteJoint>(&body, joint, properties);
  hip->setActuatorType(dart::dynamics::Joint::SERVO);

  // Centres on a half circle inside the outline, so that outside the leg is a half circle of its
  // diameter: straight down (0) it stands on its toe, the convex side to the rear.
  for (int i = 0; i < kSpheres; ++i) {
    const double around = std::numbers::pi * i / (kSpheres - 1);
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.translation() = Eigen::Vector3d(-(radius - kTread_m) * std::sin(around), 0,
                                          -radius - (radius - kTread_m) * std::cos(around));
    add_shape<dart::dynamics::SphereShape>(*node, friction, kTread_m)->setRelativeTransform(place);
  }
}

SkeletonPtr make_robot(const TerrainOptions& terrain) {
  SkeletonPtr robot = Skeleton::create("robot");
  BodyNode* body = robot->createJointAndBodyNodePair<dart::dynamics::FreeJoint>().second;
  const double mass = kMass_kg - kLegs * kLegMass_kg;
  body->setMass(mass);
  const Eigen::Vector3d square = kBodySize_m.cwiseAbs2() * (mass / 12);
  body->setMomentOfInertia(square.y() + square.z(), square.x() + square.z(),
                           square.x() + square.y());
  add_shape<dart::dynamics::BoxShape>(*body, terrain.friction, kBodySize_m);
  for (int leg = 0; leg < kLegs; ++leg) add_leg(*robot, *body, leg, terrain.friction);
  return robot;
}

// Only robot and ground collide. DART's own filter has the same result here, but counts references
// for each of the hundreds of pairs of the robot's own spheres: more than half of the time of a
// step (2026-11).
class OnlyWithGround final : public dart::collision::CollisionFilter {
 public:
  explicit OnlyWithGround(const Skeleton& ground) {
    const BodyNode* node = ground.getBodyNode(0);
    for (std::size_t i = 0; i < node->getNumShapeNodes(); ++i)
      ground_.insert(node->getShapeNode(i));
  }

  bool ignoresCollision(const dart::collision::CollisionObject* a,
                        const dart::collision::CollisionObject* b) const override {
    return ground_.contains(a->getShapeFrame()) == ground_.contains(b->getShapeFrame());
  }

 private:
  std::unordered_set<const dart::dynamics::ShapeFrame*> ground_;
};

}  // namespace

struct Robot::World {
  dart::simulation::WorldPtr world = dart::simulation::World::create();
  SkeletonPtr robot;
  BodyNode* body = nullptr;
  std::array<RevoluteJoint*, kLegs> hips{};
};

Robot::Robot(const TerrainOptions& terrain) : world_(std::make_unique<World>()) {
  World& w = *world_;
  w.world->setTimeStep(kStep_s);
  w.world->setGravity(Eigen::Vector3d(0, 0, -terrain.gravity_m_s2));
  w.world->getConstraintSolver()->setCollisionDetector(
      dart::collision::BulletCollisionDetector::create());

  Eigen::Isometry3d tilt = Eigen::Isometry3d::Identity();
  tilt.linear() =
      Eigen::AngleAxisd(-terrain.slope_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const SkeletonPtr ground = make_ground(terrain, tilt);
  w.world->addSkeleton(ground);
  w.world->getConstraintSolver()->getCollisionOption().collisionFilter =
      std::make_shared<OnlyWithGround>(*ground);
  w.robot = make_robot(terrain);
  w.body = w.robot->getRootBodyNode();
  w.world->addSkeleton(w.robot);

  const std::array<double, kLegs> angles = boot_angles(terrain);
  for (int leg = 0; leg < kLegs; ++leg) {
    const auto index = static_cast<std::size_t>(leg);
    w.hips[index] = dynamic_cast<RevoluteJoint*>(w.robot->getJoint(index + 1));
    w.hips[index]->setPosition(0, angles[index]);
    shafts_[index].angle_rad = angles[index];
  }
  Eigen::Isometry3d pose = tilt;
  pose.translation() = tilt * Eigen::Vector3d(0, 0, kHipHeightLying_m);
  dynamic_cast<dart::dynamics::FreeJoint*>(w.robot->getRootJoint())->setTransform(pose);
}

Robot::~Robot() = default;

void Robot::step(const std::array<ShaftDrive, kLegs>& drives) {
  World& w = *world_;
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    w.hips[leg]->setForceLowerLimit(0, -drives[leg].torque_limit_Nm);
    w.hips[leg]->setForceUpperLimit(0, drives[leg].torque_limit_Nm);
    w.hips[leg]->setCommand(0, drives[leg].velocity_rad_s);
  }
  w.world->step();
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    shafts_[leg] = {.angle_rad = w.hips[leg]->getPosition(0),
                    .velocity_rad_s = w.hips[leg]->getVelocity(0),
                    .torque_Nm = w.hips[leg]->getConstraintImpulse(0) / kStep_s};
  }
}

BodyState Robot::body() const {
  const Eigen::Isometry3d& pose = world_->body->getWorldTransform();
  return {.position_m = pose.translation(),
          .attitude = Eigen::Quaterniond(pose.linear()),
          .velocity_m_s = world_->body->getLinearVelocity()};
}

}  // namespace lss::sim::zebro
