#include "tests/ardito/drivers/rover_world.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lss::ardito {

using canopen::NodeState;

RoverWorld::RoverWorld(const RoverBusParameters& p) : parameters(p), bus(p) {
  for (const std::uint8_t id : p.wheel_node) node.emplace_back(CanNode::Kind::wheel, id);
  for (const std::uint8_t id : p.steering_node) node.emplace_back(CanNode::Kind::steering, id);
  node.emplace_back(CanNode::Kind::io, p.io_node);
  node.emplace_back(CanNode::Kind::imu, p.imu_node);
  for (CanNode& n : node) n.reboot(now);
  bus.restart(now);
}

void RoverWorld::collect() {
  for (CanNode& n : node) {
    for (const CanFrame& frame : n.take()) events_.emplace(frame.time_ns, frame);
  }
}

void RoverWorld::pump() {
  CanFrame frame;
  for (int n = 0; !master_dead && bus.transmit(now, frame); ++n) {
    ASSERT_LT(n, 1'000) << "the bus does not come to an end";
    sent.push_back(frame);
    for (CanNode& to : node) to.receive(frame, now);
  }
  collect();
}

void RoverWorld::run_until(TimeNs end) {
  pump();
  while (true) {
    TimeNs next = master_dead ? INT64_MAX : bus.next_wake();
    if (next <= now) {
      if (!stuck) ADD_FAILURE() << "the bus asked to be woken in the past";
      stuck = true;
      next = now + kMillisecond;
    }
    for (const CanNode& n : node) next = std::min(next, n.next_wake());
    if (!events_.empty()) next = std::min(next, events_.begin()->first);
    if (next > end) break;
    now = std::max(now, next);
    for (CanNode& n : node) n.run(now);
    collect();
    while (!events_.empty() && events_.begin()->first <= now) {
      const CanFrame frame = events_.begin()->second;
      events_.erase(events_.begin());
      if (!master_dead) deliver(frame);
    }
    pump();
  }
  now = end;
}

void RoverWorld::release(bool anew) {
  if (anew) ++orders.serial;
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

std::vector<CanFrame> RoverWorld::sent_with(std::uint32_t id) const {
  std::vector<CanFrame> found;
  std::copy_if(sent.begin(), sent.end(), std::back_inserter(found),
               [id](const CanFrame& f) { return f.id == id; });
  return found;
}

std::vector<RoverSample> RoverWorld::take_all() {
  std::vector<RoverSample> all(RoverBus::kMaxSamples);
  all.resize(bus.take(all));
  return all;
}

}  // namespace lss::ardito
