// TALARIS passes the safety suite.

#include "daemon/vehicles/talaris/tunables.h"
#include "daemon/vehicles/talaris/vehicle.h"
#include "limits.h"
#include "tests/safety/safety_suite.h"
#include "world.h"

namespace lss::talaris {
namespace {

using canopen::NodeState;

struct TalarisSafety : safety::Shipped<read_parameters, logic, tuning> {
  using World = talaris::World;
  static constexpr double kRest_s = 60;                                // from the air
  static constexpr safety::Motion kMotion{304, {0b11, 0.1, 0, 3000}};  // pulses
  static constexpr std::array<std::uint16_t, 2> kResettable = {kValveModule, kFanModule};
  static constexpr std::uint16_t kVital = kFanModule;

  static const Parameters& parameters() {
    static const Parameters kShort = [] {
      Parameters p = Shipped::parameters();
      p.navigation.calibration_s = 4;
      return p;
    }();
    return kShort;
  }

  static bool ready(World& w) { return w.start() && w.why(Kind::duty_cycle) == Reason::none; }
  static bool moves(const World& w) { return !w.shut(); }
  static bool safe(const World& w) { return w.shut(); }
  static bool stopped(const World& w) { return w.orders().all_stop || w.state() == State::idle; }
  static bool in_range(const World& w) {
    const TalarisOrders& o = w.orders();
    const bool fault = w.state() == State::fatal_error || w.state() == State::solve_errors;
    const bool still = w.mode() == Mode::standby || w.mode() == Mode::calibrate;
    const auto valve = [](const ValvePulse& p) {
      return p.delay_ns >= 0 && p.on_ns >= 0 && p.delay_ns + p.on_ns <= kFrame;
    };
    return o.all_stop == fault && (!still || w.shut()) && std::ranges::all_of(o.pulse, valve) &&
           std::ranges::all_of(o.fan_us, [](auto us) { return us >= 1000 && us <= 2000; });
  }
  static bool& stop_pending(World::Vehicle::BusReport& bus) { return bus.edges.all_stop_pending; }

  static std::vector<safety::Place<World>> places() {
    const auto mode = [](const char* name, Mode m, std::function<void(World&)> then) {
      return safety::Place<World>{name, State::operational, static_cast<std::uint8_t>(m),
                                  [=](World& w) {
                                    ASSERT_TRUE(w.start());
                                    then(w);
                                  }};
    };
    return {mode("Manual", Mode::manual,
                 [](World& w) {
                   ASSERT_TRUE(w.arm());
                   w.send(Kind::edf_throttle, {15, 0.3});
                   w.run(1);
                 }),
            mode("ByHand", Mode::manual,
                 [](World& w) {
                   w.send(Kind::valve, {255, 1, 30});
                 }),
            mode("DutyCycle", Mode::duty_cycle,
                 [](World& w) {
                   w.send(Kind::duty_cycle);
                   w.step();
                   w.send(Kind::pulse, {3, 0.1, 0, 3000});
                 }),
            mode("Script", Mode::script,
                 [](World& w) {
                   w.send(Kind::script_begin, {7, 1});
                   w.send(Kind::script_step, {7, 0, 0, 0, 1, 20});
                   w.send(Kind::script_run, {7});
                   w.run(6);
                 }),
            mode("Standby", Mode::standby, [](World& w) { w.send(Kind::gnc, {0}); }),
            mode("Calibrate", Mode::calibrate,
                 [](World& w) {
                   w.send(Kind::gnc, {0});
                   w.step();
                   w.send(Kind::gnc, {1});
                 }),
            {"SpinUp", State::operational, static_cast<std::uint8_t>(Mode::execute), spin_up},
            {"Air", State::operational, static_cast<std::uint8_t>(Mode::execute),
             [](World& w) { ASSERT_TRUE(w.fly(Program::hop)); }}};
  }
  static void spin_up(World& w) {
    ASSERT_TRUE(w.start() && w.arm() && w.calibrate());
    w.send(Kind::plan, {double(Program::hop), 2, 5, 0, 0});
    w.step();
    w.send(Kind::gnc, {2});
  }

  static std::vector<safety::Fault<World>> faults() {
    safety::FaultList<World> list;
    for (const std::size_t node : {kValveNode, kFanNode}) {
      const std::size_t module = kValveModule + node;
      list.add(
          "lost", FaultId::module_silent, module, 0.2,
          [node](World& w) { w.node(node).state = NodeState::lost; },
          [node](World& w) { w.node(node).state = NodeState::operational; }, true);
      list.add(
          "rebooted", FaultId::module_reset, module, 0.2,
          [node](World& w) { ++w.node(node).reboots; }, {}, true);
    }
    list.add(
        "port_lost", FaultId::port_lost, 0, 0.2, [](World& w) { w.in_.bus.can.open = false; },
        [](World& w) { w.in_.bus.can.open = true; });
    list.add("bus_off", FaultId::bus_off, 0, 0.2, [](World& w) { ++w.in_.bus.can.port.bus_offs; });
    list.add("orders_stale", FaultId::orders_stale, 0, 0.2,
             [](World& w) { ++w.in_.bus.can.status.counters.safe_commands; });
    list.add("bus_stuck", FaultId::bus_stuck, 0, 0.2, [](World& w) {
      w.alter = [](World& x) { x.in_.bus.can.time_ns -= 200 * kMillisecond; };
    });
    return list.all;
  }

  static std::vector<std::function<void(TalarisOrders&)>> bad_commands() {
    const auto pulse = [](int delay_ms, int on_ms) {
      return [=](TalarisOrders& o) {
        o.pulse[3] = {delay_ms * kMillisecond, on_ms * kMillisecond};
      };
    };
    return {pulse(0, 39),
            pulse(100, 101),
            pulse(-1, 100),
            pulse(0, -100),
            [](TalarisOrders& o) {
              o.pulse[3] = {INT64_MAX, 100 * kMillisecond};
            },
            [](TalarisOrders& o) { o.enabled = 0; },
            [](TalarisOrders& o) {
              o.hold[1] = {true, o.release_ns + kSecond};
            },
            [](TalarisOrders& o) { o.fan_us[2] = 999; },
            [](TalarisOrders& o) { o.fan_us[2] = 2001; },
            [](TalarisOrders& o) { o.release_ns += 1; },
            [](TalarisOrders& o) { o.all_stop = true; }};
  }

  static std::vector<Limit> limits() { return talaris::limits(); }
  static std::set<std::string> no_limits() { return talaris::no_limits({"gas.min_voltage_V"}); }

  static void take_away(World& w, std::uint16_t module) {
    w.node(module - kValveModule).state = NodeState::booting;
  }
  static void bring_back(World& w, std::uint16_t module) {
    w.node(module - kValveModule).state = NodeState::operational;
    ++w.node(module - kValveModule).boots;
  }
};

}  // namespace
}  // namespace lss::talaris

LSS_SAFETY_SUITE(Talaris, lss::talaris::TalarisSafety);
LSS_SAFETY_LIMITS(Talaris, lss::talaris::TalarisSafety);
LSS_SAFETY_RESETS(Talaris, lss::talaris::TalarisSafety);
