#include "tests/talaris/drivers/hopper_world.h"

#include <algorithm>

namespace lss::talaris {

HopperWorld::HopperWorld(const HopperBusParameters& p) : parameters(p), bus(p) {
  node.emplace_back(HopperNode::kValves, 0x0006'0191);
  node.emplace_back(HopperNode::kFans, 0x000C'0191);
  if (p.load_cell) node.emplace_back(HopperNode::kLoadCell, 0x0004'0191);
  for (HopperNode& n : node) n.power_on(now);
  bus.restart(now);
}

void HopperWorld::put(const CanFrame& frame) {
  sent.push_back(frame);
  for (HopperNode& to : node) to.receive(frame, now);
}

void HopperWorld::collect() {
  for (HopperNode& n : node) {
    for (const CanFrame& frame : n.take()) events_.emplace(frame.time_ns, frame);
  }
}

void HopperWorld::pump() {
  CanFrame frame;
  for (int n = 0; !actuate_dead && valves.due(now, frame); ++n) {
    ASSERT_LT(n, 10) << "the valves do not come to an end";
    valves.sent(true, now);
    put(frame);
  }
  for (int n = 0; !master_dead && bus.transmit(now, frame); ++n) {
    ASSERT_LT(n, 1'000) << "the bus does not come to an end";
    put(frame);
  }
  collect();
}

void HopperWorld::run_until(TimeNs end) {
  pump();
  while (true) {
    TimeNs next = actuate_dead ? INT64_MAX : valves.next_wake();
    if (!master_dead) next = std::min(next, bus.next_wake());
    ASSERT_GT(next, now) << "asked to be woken in the past";
    for (const HopperNode& n : node) next = std::min(next, n.next_wake());
    if (!events_.empty()) next = std::min(next, events_.begin()->first);
    if (next > end) break;
    now = std::max(now, next);
    for (HopperNode& n : node) n.run(now);
    collect();
    while (!events_.empty() && events_.begin()->first <= now) {
      const CanFrame frame = events_.begin()->second;
      events_.erase(events_.begin());
      if (!master_dead) bus.receive({&frame, 1});
    }
    pump();
  }
  now = end;
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

std::vector<CanFrame> HopperWorld::sent_with(std::uint32_t id) const {
  std::vector<CanFrame> found;
  std::copy_if(sent.begin(), sent.end(), std::back_inserter(found),
               [id](const CanFrame& f) { return f.id == id; });
  return found;
}

std::vector<TalarisSample> HopperWorld::take_all() {
  std::vector<TalarisSample> all(HopperBus::kMaxSamples);
  all.resize(bus.take(all));
  return all;
}

}  // namespace lss::talaris
