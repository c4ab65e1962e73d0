// D.I.A.N.A. Ardito passes the safety suite.

#include "daemon/vehicles/ardito/tunables.h"
#include "daemon/vehicles/ardito/vehicle.h"
#include "idl/ardito/codes.h"
#include "limits.h"
#include "tests/safety/safety_suite.h"
#include "world.h"

namespace lss::ardito {
namespace {

using canopen::DriveState;
using canopen::NodeState;

struct ArditoSafety : safety::Shipped<read_parameters, logic, tuning> {
  using World = ardito::World;
  static constexpr double kRest_s = 20;
  static constexpr safety::Motion kMotion{201, {0.3, 0, 1, 0}};  // drive
  static constexpr std::array<std::uint16_t, 11> kResettable = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  static constexpr std::uint16_t kVital = 7;
  static constexpr std::array<std::uint16_t, 1> kAlsoReset = {kImuNode};

  static bool ready(World& w) {
    w.acks.clear();  // it waits for the answer
    return w.start();
  }
  static bool moves(const World& w) { return w.mode() == Mode::running && w.wheel_rpm(0) != 0; }
  static bool safe(const World& w) {
    const auto off = [](const auto& drive) { return !drive.enabled; };
    return std::ranges::all_of(w.out_.command.wheel, off) &&
           std::ranges::all_of(w.out_.command.steering, off);
  }
  static bool stopped(const World& w) { return w.all_stopped(); }
  static bool in_range(const World& w) {
    const RoverOrders& o = w.out_.command;
    return (w.mode() != Mode::warning || safe(w)) &&
           std::ranges::all_of(o.wheel,
                               [](const auto& x) { return std::abs(x.motor_rpm) < 6000; }) &&
           std::ranges::all_of(o.steering,
                               [](const auto& x) { return std::abs(x.position_rad) < 1.14; });
  }
  static bool& stop_pending(World::Vehicle::BusReport& bus) { return bus.all_stop_pending; }

  static std::vector<safety::Place<World>> places() {
    const auto mode = [](const char* name, Mode m, lss::CommandKind first, double parameter,
                         std::function<void(World&)> then) {
      return safety::Place<World>{name, State::operational, static_cast<std::uint8_t>(m),
                                  [=](World& w) {
                                    if (!then) return w.send(first, {parameter});
                                    ASSERT_TRUE(w.start());
                                    then(w);
                                  }};
    };
    constexpr auto kStart = lss::CommandKind::start;
    const auto drive = [](World& w) { w.send(CommandKind::drive, {0.3, 0, 1, 0}); };
    return {mode("Warning", Mode::warning, kStart, 0, {}),
            mode("Stopped", Mode::stopped, kStart, 0, {}),
            mode("Steering", Mode::steering, kStart, 0,
                 [](World& w) {
                   w.send(CommandKind::drive, {0.3, 0.08, 1, 0});
                 }),
            mode("Running", Mode::running, kStart, 0, drive),
            mode("Parking", Mode::parking, kStart, 0,
                 [](World& w) { w.send(CommandKind::park, {0.5}); }),
            mode("Decelerating", Mode::decelerating, kStart, 0, [=](World& w) {
              ASSERT_TRUE(w.drive_at(0.3));
              w.run(3);
              w.send(CommandKind::halt);
            })};
  }

  static std::vector<safety::Fault<World>> faults() {
    safety::FaultList<World> list;
    for (std::size_t n = 0; n < kImu; ++n) {
      const std::string number = " " + std::to_string(n + 1);
      list.add(
          "lost" + number, FaultId::module_silent, n + 1, 0.1,
          [n](World& w) { w.node(n).state = NodeState::lost; },
          [n](World& w) { w.node(n).state = NodeState::operational; }, n % 5 == 0);
      list.add(
          "rebooted" + number, FaultId::module_reset, n + 1, 0.1,
          [n](World& w) { ++w.node(n).reboots; }, {}, n % 5 == 0);
      if (n == kIo) continue;
      list.add("drive_fault" + number, FaultId::drive_fault, n + 1, 0.1,
               [n](World& w) { w.drive(n) = DriveState::fault; });
      list.add(
          "disobeys" + number, FaultId::module_disobeys, n + 1, 0.1,
          [n](World& w) { w.in_.bus.status.link[n].disobeys = true; },
          [n](World& w) { w.in_.bus.status.link[n].disobeys = false; });
    }
    list.add(
        "button", faults::emergency_button, kIoNode, 0.1,
        [](World& w) { w.inputs.emergency_button = true; },
        [](World& w) { w.inputs.emergency_button = false; });
    list.add(
        "power", faults::power_lost, kIoNode, 0.1, [](World& w) { w.inputs.power_good = false; },
        [](World& w) { w.inputs.power_good = true; });
    list.add(
        "port_lost", FaultId::port_lost, 0, 0.1, [](World& w) { w.in_.bus.open = false; },
        [](World& w) { w.in_.bus.open = true; });
    list.add("bus_off", FaultId::bus_off, 0, 0.1, [](World& w) { ++w.in_.bus.port.bus_offs; });
    list.add("orders_stale", FaultId::orders_stale, 0, 0.1,
             [](World& w) { ++w.in_.bus.status.counters.safe_commands; });
    const auto alter = [&](const char* name, FaultId id, std::size_t node, double within_s,
                           std::function<void(World&)> how) {
      list.add(name, id, node, within_s, [=](World& w) { w.alter = how; });
    };
    alter("bus_stuck", FaultId::bus_stuck, 0, 0.1,
          [](World& w) { w.in_.bus.time_ns -= 200 * kMillisecond; });
    alter("no_samples", FaultId::stale_input, kIoNode, 0.7,
          [](World& w) { w.in_.sample_count = 0; });
    alter("old_samples", FaultId::stale_input, kIoNode, 0.3, [](World& w) {
      for (RoverSample& sample : w.in_.samples) sample.time_ns -= kSecond;
    });
    for (std::uint8_t wheel = 0; wheel < kWheels; ++wheel) {
      const auto is_of = [wheel](const Reading& r) {
        const auto* motion = std::get_if<WheelMotion>(&r);
        return motion != nullptr && motion->wheel == wheel;
      };
      list.add(
          "stale wheel " + std::to_string(wheel + 1), FaultId::stale_input, wheel + 1u, 0.7,
          [=](World& w) { w.distort = [=](auto& readings) { std::erase_if(readings, is_of); }; },
          [](World& w) { w.distort = nullptr; });
    }
    // The angle of a steering drive stays while the others turn.
    list.add(
        "steering_stuck", faults::steering_critical, 7, 3,
        [](World& w) {
          w.send(CommandKind::drive, {0.3, 0.087, 1, 0});
          w.distort = [](std::vector<Reading>& readings) {
            for (Reading& r : readings) {
              if (auto* m = std::get_if<SteeringMotion>(&r); m && m->wheel == 0) m->motor_rad = 0;
              if (auto* a = std::get_if<SteeringAngle>(&r); a && a->wheel == 0)
                a->reduction_rad = 0;
            }
          };
        },
        [](World& w) { w.distort = nullptr; });
    return list.all;
  }

  static std::vector<std::function<void(RoverOrders&)>> bad_commands() {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    return {[](RoverOrders& o) { o.wheel[5].motor_rpm = kNaN; },
            [](RoverOrders& o) { o.wheel[0].motor_rpm = HUGE_VAL; },
            [](RoverOrders& o) { o.steering[3].position_rad = kNaN; },
            [](RoverOrders& o) { o.steering[0].position_rad = -HUGE_VAL; },
            [](RoverOrders& o) { o.steering[1].position_rad = -1.2; },
            [](RoverOrders& o) { o.wheel[2].motor_rpm = 1e4; },
            [](RoverOrders& o) { o.wheel[2].motor_rpm = -1200; },
            [](RoverOrders& o) { o.quick_stop = true; }};
  }

  static std::vector<Limit> limits() { return ardito::limits(); }
  static std::set<std::string> no_limits() { return ardito::no_limits(); }

  static void take_away(World& w, std::uint16_t module) {
    w.node(module - 1u).state = NodeState::booting;
  }
  static void bring_back(World& w, std::uint16_t module) {
    canopen::NodeStatus& node = w.node(module - 1u);
    node.state = NodeState::operational;
    node.since_ns = w.time_ns_;
    ++node.boots;
  }
};

}  // namespace
}  // namespace lss::ardito

LSS_SAFETY_SUITE(Ardito, lss::ardito::ArditoSafety);
LSS_SAFETY_LIMITS(Ardito, lss::ardito::ArditoSafety);
LSS_SAFETY_RESETS(Ardito, lss::ardito::ArditoSafety);
