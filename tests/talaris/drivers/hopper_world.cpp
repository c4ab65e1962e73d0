#include "tests/talaris/drivers/hopper_world.h"

#include <algorithm>

namespace lss::talaris {

HopperWorld::HopperWorld(const HopperBusParameters& p) : CanWorld(p), parameters(p) {
  node.emplace_back(HopperNode::kValves, 0x0006'0191);
  node.emplace_back(HopperNode::kFans, 0x000C'0191);
  if (p.load_cell) node.emplace_back(HopperNode::kLoadCell, 0x0004'0191);
  for (HopperNode& n : node) n.power_on(now);
  bus.restart(now);
}

void HopperWorld::pump() {
  CanFrame frame;
  for (int n = 0; !actuate_dead && valves.due(now, frame); ++n) {
    ASSERT_LT(n, 10) << "the valves do not come to an end";
    valves.sent(true, now);
    put(frame);
  }
  pump_master();
}

TimeNs HopperWorld::next_wake() const {
  const TimeNs valves_ns = actuate_dead ? INT64_MAX : valves.next_wake();
  return master_dead ? valves_ns : std::min(valves_ns, bus.next_wake());
}

void HopperWorld::release() {
  orders.boundary_ns = orders.issued_ns = orders.release_ns = now;
  if (!actuate_dead) valves.release(orders, now);
  bus.release(orders, now);
  pump();
}

void HopperWorld::run_frames(int n) {
  for (; n > 0; --n) {
    release();
    run_for(200 * kMillisecond);
  }
}

void HopperWorld::boot() {
  run_frames(5);
  for (std::size_t i = 0; i < node.size(); ++i) ASSERT_EQ(state(i), NodeState::operational) << i;
  sent.clear();
  take_all();
}

}  // namespace lss::talaris
