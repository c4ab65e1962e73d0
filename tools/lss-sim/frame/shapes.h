#pragma once

// Shapes of bodies that touch others, for the vehicles that are simulated as bodies.

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <memory>
#include <utility>

namespace lss::sim {

template <typename Shape, typename... Arguments>
dart::dynamics::ShapeNode* add_shape(dart::dynamics::BodyNode& body, double friction,
                                     Arguments&&... arguments) {
  auto* node =
      body.createShapeNodeWith<dart::dynamics::CollisionAspect, dart::dynamics::DynamicsAspect>(
          std::make_shared<Shape>(std::forward<Arguments>(arguments)...));
  node->getDynamicsAspect()->setFrictionCoeff(friction);
  node->getDynamicsAspect()->setRestitutionCoeff(0.0);
  return node;
}

}  // namespace lss::sim
