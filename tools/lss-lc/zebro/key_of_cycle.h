#pragma once

// A key of the state of Lunar Zebro's cycle, quantised: two states with the same key behave alike
// as far as supervisor, watch and solver decide. A visitor of keep() (daemon/record/state.h). What
// it leaves out is said at each type; docs/verification.md has what that costs.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "daemon/record/state.h"
#include "daemon/vehicles/zebro/vehicle.h"

namespace lss::zebro {

class Numbers {
 public:
  template <class... T>
  void operator()(const T&... x) {
    (put(static_cast<std::uint64_t>(x)), ...);
  }
  std::uint64_t value() const { return mix(state_); }

 private:
  static std::uint64_t mix(std::uint64_t x) {
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    return x ^ x >> 31;
  }
  void put(std::uint64_t x) { state_ = mix(state_ + 0x9E3779B97F4A7C15u + x) ^ state_ << 1; }
  std::uint64_t state_ = 1;
};

class KeyOfCycle {
 public:
  KeyOfCycle(TimeNs now, TimeNs step) : now_(now), step_(step) {}
  void solving(bool solves) { solves_ = solves; }
  Numbers& numbers() { return n_; }

  // In steps, negative in the future; at most so many.
  std::int64_t age(TimeNs time, std::int64_t most) const {
    if (time == 0) return most + 1;
    return std::clamp<std::int64_t>((now_ - time) / step_, -6000, most);
  }

  template <class... T>
  void operator()(T&... members) {
    (visit(members), ...);
  }

 private:
  template <class T>
  void visit(T& x) {
    if constexpr (std::is_same_v<T, Solver>) {
      // Only while it runs: each time it begins from the start.
      if (!solves_) return;
      in_solver_ = true;
      x.keep(*this);
      in_solver_ = false;
    } else if constexpr (std::is_same_v<T, EventSeries>) {
      // Reported, and decides nothing.
    } else if constexpr (record::Keeps<T, KeyOfCycle>) {
      x.keep(*this);
    } else {
      take(x);
    }
  }

  // Constant, or derived from other members in each frame.
  void take(const Parameters&) {}
  void take(const SolverParameters&) {}
  void take(const TunableValues&) {}
  void take(const gnc::zebro::WalkRequest&) {}
  void take(const std::array<gnc::zebro::LegMeasured, kLegs>&) {}
  // Its modules draw the same at all angles: there is no soil.
  void take(const gnc::zebro::Sinking&) {}
  // Counters, of which only changes are noticed.
  void take(const std::array<std::uint64_t, kModules>&) {}
  void take(const std::array<std::uint32_t, kLegs>& segments) {
    for (std::size_t i = 0; i < kLegs; ++i) n_(segments[i] == segments_[i]);
  }
  void take(const std::uint64_t&) {}
  // Without angles, times of the gait's schedule and odometry.
  void take(const gnc::zebro::Locomotion& l) {
    n_(l.motion(), l.progress(), l.isolated(), l.motion() == gnc::zebro::Motion::hold);
    for (std::size_t i = 0; i < kLegs; ++i) {
      const gnc::zebro::LegTarget& t = l.targets()[i];
      segments_[i] = t.segment;
      if (l.motion() != gnc::zebro::Motion::hold) n_(t.rotation, t.swing);
    }
  }
  void take(const std::array<Module, kModules>& modules) {
    for (const Module& m : modules)
      n_(m.status.flags, m.reported, m.believed, age(m.heard_ns, 6), age(m.status_ns, 6),
         age(m.over_limit_ns, 2), m.hot, m.greeted);
  }
  // Angles are those of the modules' movements.
  void take(const std::array<ReportCheck, kModules>& checks) {
    for (const ReportCheck& c : checks) {
      n_(c.finding(now_));
      c.times([&](TimeNs found, TimeNs strange, TimeNs window, TimeNs still, int refused) {
        n_(age(found, 11), age(strange, 4), refused == 0 ? 0 : age(window, 21), age(still, 3),
           refused);
      });
    }
  }
  // Reported, and decide nothing.
  void take(const std::array<Lateness, kModules>&) {}
  // Angles of orders are those of the modules' movements.
  void take(const BusOrders& orders) {
    for (const ModuleOrder& o : orders.module) n_(o.kind);
  }
  void take(const SupervisorState& s) {
    take_plain(s.controller);
    n_(s.authority.front(), s.active.kind, s.active.source.front(), s.resetting,
       s.another_daemon_ns != 0);
    if ((s.controller.links & lc::kHeld) != 0) n_(s.lease_ns, age(s.heartbeat_ns, 700));
    n_(age(s.contact_ns, 301));
    std::uint64_t faults = 0;  // in any order
    for (const FaultRecord& f : s.faults) {
      Numbers one;
      one(f.id, f.subject);
      if (f.id != FaultId::none) faults += one.value();
    }
    n_(faults);
  }
  void take(const SupervisorState::Active& active) { n_(active.kind); }
  // A moment: past ones are past. In the solver, as long as it proves.
  void take(const TimeNs& time) { n_(age(time, in_solver_ ? 40 : 1)); }
  void take(const double& x) {
    if (!in_solver_) take_plain(x);
  }
  template <class T>
  void take(const T& x) {
    take_plain(x);
  }
  // Whole words; those that look like a moment are relative to now.
  template <class T>
  void take_plain(const T& x) {
    std::array<std::uint64_t, (sizeof x + 7) / 8> words{};
    std::memcpy(words.data(), static_cast<const void*>(&x), sizeof x);
    for (const std::uint64_t word : words) {
      const auto moment = static_cast<TimeNs>(word);
      const bool is_moment = moment > now_ - 100'000 * kSecond && moment < now_ + 100'000 * kSecond;
      n_(is_moment ? static_cast<std::uint64_t>(age(moment, 100)) + 0x1000'0000'0000'0000u : word);
    }
  }

  TimeNs now_, step_;
  bool solves_ = false, in_solver_ = false;
  std::array<std::uint32_t, kLegs> segments_{};
  Numbers n_;
};

}  // namespace lss::zebro
