#pragma once

// The world of a vehicle on kit::DriveVehicle, for the safety suite and the vehicle's own tests:
// drives that run and execute their orders within a frame, in virtual time. And the part of the
// suite's traits (safety_suite.h) that all such vehicles have in common:
//
//   struct World : safety::DriveWorld<World, Vehicle, Mode> {
//     explicit World(const Parameters& p = {}, const Supervisor::Parameters& links = {})
//         : DriveWorld(p, logic(), links, kDrives) {}
//   };
//   struct ScoutSafety : safety::DriveTraits<World, kDrives>,
//                        safety::Shipped<read_parameters, logic, tuning> { ... };

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cycle_world.h"
#include "daemon/kit/drive_vehicle.h"
#include "scene.h"

namespace lss::safety {

template <class Derived, class V, class M>
class DriveWorld : public CycleWorld<Derived, V, M> {
  using Base = CycleWorld<Derived, V, M>;

 public:
  using Base::in_;
  using Base::out_;
  using Base::time_ns_;

  template <class P>
  DriveWorld(const P& parameters, const Logic& logic, const Supervisor::Parameters& links,
             std::size_t drives)
      : Base(parameters, logic, links, parameters.bus.period_ns), drives_(drives) {
    in_.bus.was_open = in_.bus.open = true;
    for (std::size_t i = 0; i < drives; ++i) {
      link(i).node.state = canopen::NodeState::operational;
      link(i).drive = canopen::DriveState::switch_on_disabled;
    }
  }

  canopen::DriveLink& link(std::size_t drive) { return in_.bus.status.link[drive]; }

  void sense() {
    in_.bus.time_ns = time_ns_ - kMillisecond;
    for (std::size_t i = 0; i < drives_ && in_.bus.open; ++i) {
      if (link(i).node.state == canopen::NodeState::operational)
        link(i).node.heartbeat_ns = time_ns_ - kMillisecond;
      in_.samples[in_.sample_count++] = {.time_ns = time_ns_ - kMillisecond,
                                         .drive = static_cast<std::uint8_t>(i),
                                         .motor_rpm = rpm[i],
                                         .current_permille = std::copysign(200, rpm[i])};
    }
  }

  void obey() {
    const canopen::VelocityOrders& orders = out_.command;
    const bool reset = orders.fault_reset_serial != fault_reset_serial_;
    fault_reset_serial_ = orders.fault_reset_serial;
    for (std::size_t i = 0; i < drives_; ++i) {
      const canopen::VelocityOrder& order = orders.drive[i];
      canopen::DriveState& state = link(i).drive;
      if (state == canopen::DriveState::fault && !reset) continue;
      const bool runs = order.enabled && !orders.quick_stop;
      state =
          runs ? canopen::DriveState::operation_enabled : canopen::DriveState::switch_on_disabled;
      rpm[i] = runs && std::isfinite(order.motor_rpm) ? order.motor_rpm : 0;
    }
  }

  std::array<double, canopen::kMostVelocityDrives> rpm{};  // of the motors

 private:
  std::size_t drives_;
  std::uint32_t fault_reset_serial_ = 0;
};

template <class W, std::size_t kDrives>
struct DriveTraits {
  using World = W;

  static bool safe(const W& w) {
    return std::ranges::none_of(w.out_.command.drive, [](const auto& d) { return d.enabled; });
  }
  static bool stopped(const W& w) { return safe(w) && w.out_.command.quick_stop; }
  static bool& stop_pending(kit::DriveVehicle::BusReport& bus) { return bus.all_stop_pending; }

  static std::vector<Fault<W>> faults() {
    FaultList<W> list;
    constexpr double kSoon_s = 0.15;
    for (std::size_t n = 0; n < kDrives; ++n) {
      const std::string number = " " + std::to_string(n + 1);
      list.add(
          "lost" + number, FaultId::module_silent, n + 1, kSoon_s,
          [n](W& w) { w.link(n).node.state = canopen::NodeState::lost; },
          [n](W& w) { w.link(n).node.state = canopen::NodeState::operational; }, true);
      list.add(
          "rebooted" + number, FaultId::module_reset, n + 1, kSoon_s,
          [n](W& w) { ++w.link(n).node.reboots; }, {}, true);
      list.add("drive fault" + number, FaultId::drive_fault, n + 1, kSoon_s,
               [n](W& w) { w.link(n).drive = canopen::DriveState::fault; });
      list.add(
          "disobeys" + number, FaultId::module_disobeys, n + 1, kSoon_s,
          [n](W& w) { w.link(n).disobeys = true; }, [n](W& w) { w.link(n).disobeys = false; });
    }
    list.add(
        "port lost", FaultId::port_lost, 0, kSoon_s, [](W& w) { w.in_.bus.open = false; },
        [](W& w) { w.in_.bus.open = true; });
    list.add("bus off", FaultId::bus_off, 0, kSoon_s, [](W& w) { ++w.in_.bus.port.bus_offs; });
    list.add("orders stale", FaultId::orders_stale, 0, kSoon_s,
             [](W& w) { ++w.in_.bus.status.counters.safe_commands; });
    list.add("bus stuck", FaultId::bus_stuck, 0, kSoon_s,
             [](W& w) { w.alter = [](W& x) { x.in_.bus.time_ns -= 200 * kMillisecond; }; });
    list.add("no samples", FaultId::stale_input, 1, 1,
             [](W& w) { w.alter = [](W& x) { x.in_.sample_count = 0; }; });
    return list.all;
  }

  static std::vector<std::function<void(canopen::VelocityOrders&)>> bad_commands() {
    constexpr std::size_t kLast = kDrives - 1;
    return {
        [](auto& o) { o.drive[kLast].motor_rpm = std::numeric_limits<double>::quiet_NaN(); },
        [](auto& o) { o.drive[0].motor_rpm = HUGE_VAL; },
        [](auto& o) { o.drive[0].motor_rpm = 1e6; },
        [](auto& o) { o.drive[kLast].motor_rpm *= -10; },
        [](auto& o) { o.drive[kDrives].enabled = true; },
        [](auto& o) { o.quick_stop = true; },
        [](auto& o) { --o.issued_ns; },
    };
  }

  static void take_away(W& w, std::uint16_t module) {
    w.link(module - 1u).node.state = canopen::NodeState::booting;
  }
  static void bring_back(W& w, std::uint16_t module) {
    canopen::NodeStatus& node = w.link(module - 1u).node;
    node.state = canopen::NodeState::operational;
    node.since_ns = w.time_ns_;
    ++node.boots;
  }
};

}  // namespace lss::safety
