#pragma once

// A LegBus in virtual time with seven modules on its wires, written from docs/icd-zebro.md as far
// as the master can see them. Bytes travel one character at a time at the baud rate; nothing waits
// for a clock.

#include <array>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "drivers/zebro/leg_bus.h"

namespace lss::zebro {

struct TestModule {
  bool dead = false;
  int deaf = 0;  // commands, not requests, that it will not receive; -1: never any
  bool on = false;
  std::uint16_t set_point_cdeg = 0;
  TimeNs arrival_ns = 0;
  TimeNs boot_ns = -100 * kSecond;
  bool reset_since_status = false;
  bool tells_resets = true;  // in its status
  double clock = 1;          // its seconds for one of ours
};

struct Sent {
  TimeNs start_ns = 0;  // on the wire
  TimeNs end_ns = 0;
  Frame frame;
};

class World {
 public:
  explicit World(const LegBusParameters& parameters = {}, TimeNs turn_around_characters = 1);

  void release() {
    orders.issued_ns = now;
    bus.release(orders, now);
  }
  void run_until(TimeNs end);
  void run_for(TimeNs duration) { run_until(now + duration); }
  void run_frames(int n);  // each: release, then one period
  void settle() {
    run_frames(100);
    sent.clear();
  }  // boot is over: stops confirmed, identities known
  void order(int module, ModuleOrder::Kind kind, std::uint16_t position_cdeg = 0,
             TimeNs arrive_ns = 0);
  void emergency() { ++orders.emergency_serial; }
  void deliver(const std::string& characters) {
    bus.receive(std::vector<std::uint8_t>(characters.begin(), characters.end()), now);
  }

  std::vector<Sent> sent_with(Code code) const;
  std::vector<Sent> sent_to(std::uint8_t address, Code code) const;
  std::vector<ModuleReply> take_all();

  LegBusParameters parameters;
  LegBus bus;
  BusOrders orders{};
  std::array<TestModule, kBusModules> module{};
  TimeNs now = kSecond;
  TimeNs frame_ns;
  std::vector<Sent> sent;
  // The changes of a reply's characters in transport; more than one element: one after the other.
  std::function<std::vector<std::string>(const Frame&, std::string)> reply_filter;
  bool collision = false;      // two replies were on the line at once
  bool too_far_ahead = false;  // more than one frame was written ahead of the wire
  bool stuck = false;          // the bus asked to be woken in the past

 private:
  void written(std::span<const std::uint8_t> bytes);
  void execute(const Frame& frame);
  void reply(const Frame& frame);

  TimeNs character_ns_, turn_around_ns_;
  TimeNs tx_free_ns_ = 0, rx_free_ns_ = 0;
  std::multimap<TimeNs, std::function<void()>> events_;
};

}  // namespace lss::zebro
