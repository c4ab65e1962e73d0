#pragma once

// Supervision of a vehicle's port and bus thread: turns their reports into events and faults of the
// locomotion controller. Shared by all vehicles. Frame thread; time is data; no allocation.

#include "daemon/cycle/supervisor.h"

namespace lss::kit {

class PortWatch {
 public:
  static constexpr TimeNs kBusStuckAfter = 200 * kMillisecond;
  static constexpr TimeNs kMasterGone = 10 * kSecond;  // nothing of another master for so long

  // In every frame. Report: of the bus thread (daemon/runtime/can_bus.h, serial_bus.h); its counts
  // of stops by itself, orders being stale, and of bus-offs. `airborne`: a port that closes is
  // reported after the landing.
  template <class Report>
  void watch(const Report& bus, std::uint64_t stops, std::uint64_t offs, TimeNs now, Supervisor& s,
             bool airborne = false) noexcept {
    if (bus.time_ns == 0) return;  // no report yet
    const bool operational = s.controller().state == State::operational;
    if ((bus.open != open_ && (bus.open || !airborne)) || !reported_) change(bus, now, s);
    if (operational && stands_still(bus, now)) s.raise(FaultId::bus_stuck);
    if (offs != offs_) {
      offs_ = offs;
      s.raise(FaultId::bus_off);
    }
    if (stops != stops_) {
      stops_ = stops;
      s.note(EventId::safe_command_sent);
      if (operational) s.raise(FaultId::orders_stale);
    }
  }

  // In every frame, of a CANopen bus: how many frames came that only its master may send.
  void watch_masters(std::uint64_t frames, TimeNs now, Supervisor& s) noexcept {
    if (frames > master_frames_) {
      master_ns_ = now;
      s.latch(FaultId::other_master);
    } else if (master_ns_ != 0 && now - master_ns_ > kMasterGone) {
      master_ns_ = 0;
      s.clear(FaultId::other_master);
    }
    master_frames_ = frames;
  }

  // The bus thread: what it reported last is old, and orders reach nobody.
  template <class Report>
  static bool stands_still(const Report& bus, TimeNs now) noexcept {
    return bus.open && now - bus.time_ns > kBusStuckAfter;
  }
  bool open() const noexcept { return open_; }
  TimeNs opened_ns() const noexcept { return opened_ns_; }  // 0: never

  template <class V>
  void keep(V& v) {
    v(open_, reported_, opened_ns_, stops_, offs_, master_frames_, master_ns_);
  }

 private:
  template <class Report>
  void change(const Report& bus, TimeNs now, Supervisor& s) noexcept {
    s.happen(bus.open ? lc::Event::port_opened : lc::Event::port_closed);
    if (bus.open) {
      opened_ns_ = now;
      s.note(EventId::port_opened);
      s.clear(FaultId::port_absent);
    } else {
      s.note(EventId::port_closed);
      s.raise(bus.was_open ? FaultId::port_lost : FaultId::port_absent);
    }
    open_ = bus.open;
    reported_ = true;
  }

  bool open_ = false, reported_ = false;
  TimeNs opened_ns_ = 0;
  std::uint64_t stops_ = 0, offs_ = 0, master_frames_ = 0;
  TimeNs master_ns_ = 0;  // when another master was heard last; 0: it is gone
};

}  // namespace lss::kit
