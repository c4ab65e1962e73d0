// Lunar Zebro passes the safety suite.

#include "daemon/vehicles/zebro/tunables.h"
#include "daemon/vehicles/zebro/vehicle.h"
#include "idl/zebro/codes.h"
#include "limits.h"
#include "tests/safety/safety_suite.h"
#include "world.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

struct ZebroSafety : safety::Shipped<read_parameters, logic, tuning> {
  using World = zebro::World;
  static constexpr double kRest_s = 26;
  static constexpr safety::Motion kMotion{104, {1, 0, 3}};  // walk
  static constexpr std::array<std::uint16_t, 7> kResettable = {1, 2, 3, 4, 5, 6, 7};
  static constexpr std::uint16_t kVital = 7;

  static bool ready(World& w) { return w.stand(); }
  static bool drives(const ModuleOrder& o) {
    return o.kind == Kind::motion_on || o.kind == Kind::rotate_forward ||
           o.kind == Kind::rotate_backward;
  }
  static bool moves(const World& w) {
    return w.state() == State::operational && w.mode() == Mode::walking;
  }
  // The panel moves in Idle, a blocked leg while errors are solved.
  static bool safe(const World& w) {
    const std::uint8_t flags = w.supervisor_.controller().flags;
    const bool panel = w.state() == State::idle && (flags & kPanelMoving) != 0;
    const bool leg = w.state() == State::solve_errors && (flags & kFreeing) != 0;
    const auto driven = std::ranges::count_if(w.out_.command.module, drives);
    return driven == 0 || (driven == 1 && (leg || (panel && drives(w.out_.command.module[6]))));
  }
  static bool stopped(const World& w) { return w.all_stopped(); }
  static bool in_range(const World& w) {
    return std::ranges::all_of(w.out_.command.module,
                               [](const auto& o) { return o.position_cdeg < 36000; });
  }
  static bool& stop_pending(World::Vehicle::BusReport& bus) { return bus.all_stop_pending; }

  static std::vector<safety::Place<World>> places() {
    using P = safety::Place<World>;
    const auto mode = [](const char* name, Mode m, std::function<void(World&)> go) {
      return P{name, State::operational, static_cast<std::uint8_t>(m), std::move(go)};
    };
    const auto start = [](std::initializer_list<double> p) {
      return [=, p = std::vector<double>(p)](World& w) {
        Request r{.source = source("test"), .kind = 1, .lease_ms = 1000};
        std::ranges::copy(p, r.parameter.begin());
        w.put(r);
      };
    };
    const auto then = [](CommandKind kind) {
      return [=](World& w) {
        ASSERT_TRUE(w.stand());
        w.send(kind);
      };
    };
    return {mode("Holding", Mode::holding, start({0})),
            mode("StandingUp", Mode::standing_up, start({1})),
            mode("Standing", Mode::standing, start({1})),
            mode("Walking", Mode::walking, start({2, 1, 0, 3})),
            mode("FinishingStep", Mode::finishing_step,
                 [](World& w) {
                   ASSERT_TRUE(w.stand());
                   w.send(CommandKind::walk, {1, 0, 3});
                   w.run(8);
                   w.send(CommandKind::stand);
                 }),
            mode("LyingDown", Mode::lying_down, then(CommandKind::lay_down)),
            mode("Lying", Mode::lying, then(CommandKind::lay_down)),
            mode("Stowing", Mode::stowing, then(CommandKind::stow)),
            mode("Stowed", Mode::stowed, then(CommandKind::stow)),
            mode("Bridge", Mode::bridge, [](World& w) {
              ASSERT_TRUE(w.stand());
              w.send(CommandKind::leg, {4, 0.5, 4, 1});
            })};
  }

  static std::vector<safety::Fault<World>> faults() {
    std::vector<safety::Fault<World>> all;
    for (std::uint16_t n = 1; n <= kModules; ++n) {
      all.push_back({"module_silent " + std::to_string(n), FaultId::module_silent, n, 0.52,
                     [n](World& w) { w.modules[n - 1u].alive = false; },
                     [n](World& w) { w.modules[n - 1u].alive = true; }, n == 4});
    }
    for (const std::uint16_t n : std::to_array<std::uint16_t>({1, 4, 7})) {
      all.push_back({"module_reset " + std::to_string(n),
                     FaultId::module_reset,
                     n,
                     0.04,
                     [n](World& w) {
                       w.modules[n - 1u].flags = kFlagReset;
                       w.modules[n - 1u].position_deg = w.modules[n - 1u].rate_deg_s = 0;
                     },
                     {},
                     true});
    }
    const auto flag = [&](const char* name, FaultId id, std::size_t module, std::uint16_t set) {
      all.push_back({name,
                     id,
                     static_cast<std::uint16_t>(module + 1),
                     0.04,
                     [=](World& w) { w.modules[module].flags = set; },
                     {}});
    };
    flag("over_current", FaultId::module_over_current, 1, kFlagCalibrated | kFlagOverCurrent);
    flag("driver_fault", faults::module_driver_fault, 5, kFlagCalibrated | kFlagDriverFault);
    flag("watchdog", faults::module_watchdog, 0, kFlagCalibrated | kFlagWatchdog);
    flag("motor_off", FaultId::module_disobeys, 3, kFlagCalibrated);
    const auto bus = [&](const char* name, FaultId id, std::uint16_t subject, double within_s,
                         std::function<void(World&)> alter) {
      all.push_back({name, id, subject, within_s, [=](World& w) { w.alter = alter; }, {}});
    };
    bus("disobeys", FaultId::module_disobeys, 2, 0.02,
        [](World& w) { w.in_.bus.counters.module[1].disobeys = true; });
    bus("no_samples", FaultId::module_silent, 1, 0.52, [](World& w) { w.in_.sample_count = 0; });
    bus("old_samples", FaultId::module_silent, 1, 0.02, [](World& w) {
      for (ModuleReply& sample : w.in_.samples) sample.time_ns -= 600 * kMillisecond;
    });
    bus("bus_stuck", FaultId::bus_stuck, 0, 0.02,
        [](World& w) { w.in_.bus.time_ns -= 200 * kMillisecond; });
    all.push_back({"orders_stale",
                   FaultId::orders_stale,
                   0,
                   0.02,
                   [](World& w) { ++w.in_.bus.counters.safe_commands; },
                   {}});
    all.push_back({"current_limit", faults::current_limit, 3, 0.14,
                   [](World& w) { w.modules[2].current_mA = 1400; },
                   [](World& w) { w.modules[2].current_mA = 100; }});
    all.push_back({"stuck_leg", faults::leg_still, 1, 5,
                   [](World& w) { w.modules[0].stuck = true; },
                   [](World& w) { w.modules[0].stuck = false; }});
    all.push_back({"port_lost", FaultId::port_lost, 0, 0.02,
                   [](World& w) { w.in_.bus.open = false; },
                   [](World& w) { w.in_.bus.open = true; }});
    return all;
  }

  static std::vector<std::function<void(BusOrders&)>> bad_commands() {
    const auto leg = [](std::uint16_t cdeg, TimeNs in) {
      return [=](BusOrders& o) {
        o.module[0] = {.kind = Kind::rotate_forward,
                       .position_cdeg = cdeg,
                       .arrive_ns = o.issued_ns + in,
                       .serial = o.module[0].serial + 1};
      };
    };
    return {leg(36000, kSecond),
            leg(0, 0),
            leg(0, -kSecond),
            leg(0, 66 * kSecond),
            [](BusOrders& o) { o.module[6].kind = Kind::motion_on; },
            [](BusOrders& o) { o.module[3].kind = Kind::reset; }};
  }

  static std::vector<Limit> limits() { return zebro::limits(); }
  static std::set<std::string> no_limits() { return zebro::no_limits(); }

  static void take_away(World& w, std::uint16_t module) { w.modules[module - 1u].alive = false; }
  static void bring_back(World& w, std::uint16_t module) {
    IdealModule& m = w.modules[module - 1u];
    m.restart_count();
    m.alive = true;
    m.serial = w.out_.command.module[module - 1u].serial;
    ++m.resets;
  }
};

}  // namespace
}  // namespace lss::zebro

LSS_SAFETY_SUITE(Zebro, lss::zebro::ZebroSafety);
LSS_SAFETY_LIMITS(Zebro, lss::zebro::ZebroSafety);
LSS_SAFETY_RESETS(Zebro, lss::zebro::ZebroSafety);
