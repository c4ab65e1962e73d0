#pragma once

// A bus master and the nodes on its CAN bus in virtual time. Nothing waits for a clock. World
// derives from it and gives next_wake(), of the master, and pump(), which sends what is due with
// put() and ends with collect().

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <vector>

#include "drivers/can/frame.h"

namespace lss::testing_support {

template <class World, class Bus, class Node, class Sample>
class CanWorld {
 public:
  explicit CanWorld(const auto& parameters) : bus(parameters) {}

  void run_until(TimeNs end) {
    World& world = static_cast<World&>(*this);
    world.pump();
    while (true) {
      TimeNs next = world.next_wake();
      if (next <= now) {
        if (!stuck) ADD_FAILURE() << "asked to be woken in the past";
        stuck = true;
        next = now + kMillisecond;
      }
      for (const Node& n : node) next = std::min(next, n.next_wake());
      if (!events_.empty()) next = std::min(next, events_.begin()->first);
      if (next > end) break;
      now = std::max(now, next);
      for (Node& n : node) n.run(now);
      collect();
      while (!events_.empty() && events_.begin()->first <= now) {
        const CanFrame frame = events_.begin()->second;
        events_.erase(events_.begin());
        if (!master_dead) deliver(frame);
      }
      world.pump();
    }
    now = end;
  }
  void run_for(TimeNs duration) { run_until(now + duration); }
  void deliver(const CanFrame& frame) { bus.receive({&frame, 1}); }

  std::vector<CanFrame> sent_with(std::uint32_t id) const {  // since sent was cleared
    std::vector<CanFrame> found;
    std::ranges::copy_if(sent, std::back_inserter(found),
                         [id](const CanFrame& f) { return f.id == id; });
    return found;
  }
  std::vector<Sample> take_all() {
    std::vector<Sample> all(Bus::kMaxSamples);
    all.resize(bus.take(all));
    return all;
  }

  Bus bus;
  std::vector<Node> node;
  TimeNs now = kSecond;
  std::vector<CanFrame> sent;  // to the nodes
  bool master_dead = false;    // sends and receives nothing
  bool stuck = false;          // the bus asked to be woken in the past

 protected:
  void put(const CanFrame& frame) {
    sent.push_back(frame);
    for (Node& to : node) to.receive(frame, now);
  }
  void pump_master() {
    CanFrame frame;
    for (int n = 0; !master_dead && bus.transmit(now, frame); ++n) {
      ASSERT_LT(n, 1'000) << "the bus does not come to an end";
      put(frame);
    }
    collect();
  }
  void collect() {
    for (Node& n : node) {
      for (const CanFrame& frame : n.take()) events_.emplace(frame.time_ns, frame);
    }
  }

 private:
  std::multimap<TimeNs, CanFrame> events_;  // on their way to the master
};

}  // namespace lss::testing_support
