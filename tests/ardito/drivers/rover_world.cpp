#include "tests/ardito/drivers/rover_world.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lss::ardito {

using canopen::NodeState;

RoverWorld::RoverWorld(const RoverBusParameters& p) : CanWorld(p), parameters(p) {
  for (const std::uint8_t id : p.wheel_node) node.emplace_back(CanNode::Kind::wheel, id);
  for (const std::uint8_t id : p.steering_node) node.emplace_back(CanNode::Kind::steering, id);
  node.emplace_back(CanNode::Kind::io, p.io_node);
  node.emplace_back(CanNode::Kind::imu, p.imu_node);
  for (CanNode& n : node) n.reboot(now);
  bus.restart(now);
}

void RoverWorld::release(bool again) {
  if (again) ++orders.serial;
  orders.issued_ns = now;
  orders.next_frame_ns = now + parameters.period_ns;
  bus.release(orders, now);
  pump();
}

void RoverWorld::run_frames(int n) {
  for (; n > 0; --n) {
    release();
    run_for(parameters.period_ns);
  }
}

void RoverWorld::boot() {
  orders.standing = true;
  run_frames(20);
  for (std::size_t i = 0; i < kNodes; ++i) ASSERT_EQ(state(i), NodeState::operational) << i;
  sent.clear();
  take_all();
}

void RoverWorld::drive(double motor_rpm) {
  orders.standing = false;
  orders.clutches = 0x3F;
  for (WheelOrder& w : orders.wheel) w = {true, motor_rpm};
  for (SteeringOrder& s : orders.steering) s.enabled = true;
  run_frames(6);
  for (std::size_t i = 0; i < kFirstSteering; ++i) {
    ASSERT_EQ(wheel(i).target(), static_cast<std::int32_t>(motor_rpm)) << i;
  }
  sent.clear();
  take_all();
}

}  // namespace lss::ardito
