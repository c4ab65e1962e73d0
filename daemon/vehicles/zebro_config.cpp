#include "daemon/vehicles/zebro_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "daemon/config/reading.h"

namespace lss::zebro {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

void read_bus(config::Section s, Parameters& p) {
  p.bus.check = s.choice("check", 0, {"lrc", "crc8"}) == 0 ? Check::lrc : Check::crc8;
  p.bus.stop = s.choice("stop", 0, {"lf", "crlf"}) == 0 ? Stop::lf : Stop::crlf;
  p.bus.reply_timeout_ns =
      config::milliseconds(s, "reply_timeout_ms", p.bus.reply_timeout_ns, 0.5, 1000);
  p.bus.resend_limit = static_cast<int>(s.integer("resend_limit", p.bus.resend_limit, 0, 100));
  p.module_silent_ns = config::milliseconds(s, "module_silent_ms", p.module_silent_ns, 50, 7900);
  p.bus.stale_after_ns = config::milliseconds(s, "stale_ms", p.bus.stale_after_ns, 40, 5000);
  const auto addresses = s.integers("addresses", {1, 2, 3, 4, 5, 6, 7}, kBusModules, 1, 127);
  if (std::set(addresses.begin(), addresses.end()).size() != addresses.size()) {
    s.error("addresses", "two modules have the same address: give each its own");
  }
  for (std::size_t i = 0; i < addresses.size() && i < p.bus.address.size(); ++i) {
    p.bus.address[i] = static_cast<std::uint8_t>(addresses[i]);
  }
}

void read_locomotion(config::Section& root, gnc::zebro::LocomotionParameters& p) {
  config::Section gait = root.section("gait");
  p.flight_s = gait.number("flight_s", p.flight_s, 0.1, 60);
  p.stance_min_s = gait.number("stance_min_s", p.stance_min_s, 0.1, 60);
  p.double_stance_s = gait.number("double_stance_s", p.double_stance_s, 0, 10);
  p.sweep_rad = gait.number("sweep_deg", p.sweep_rad / kDegree, 5, 90) * kDegree;
  p.offset_rad = gait.number("offset_deg", p.offset_rad / kDegree, -30, 30) * kDegree;
  p.start_delay_s = gait.number("start_delay_s", p.start_delay_s, 0.1, 10);

  config::Section body = root.section("body");
  p.leg_diameter_m = body.number("leg_diameter_mm", p.leg_diameter_m * 1e3, 10, 1000) * 1e-3;
  p.track_m = body.number("track_mm", p.track_m * 1e3, 10, 5000) * 1e-3;
  p.belly_height_m = body.number("belly_height_mm", p.belly_height_m * 1e3, 0, 1000) * 1e-3;

  config::Section motion = root.section("motion");
  p.stand_up_s = motion.number("stand_up_s", p.stand_up_s, 0.5, 60);
  p.lay_down_s = motion.number("lay_down_s", p.lay_down_s, 0.5, 60);
  p.lift_s = motion.number("lift_s", p.lift_s, 0.5, 60);
  p.align_s = motion.number("align_s", p.align_s, 0.2, 60);
  p.arrived_rad = motion.number("arrived_deg", p.arrived_rad / kDegree, 0.1, 20) * kDegree;
  p.late_limit_s = motion.number("late_limit_s", p.late_limit_s, 0.5, 60);
  p.swing_limit_rad_s =
      motion.number("swing_limit_deg_s", p.swing_limit_rad_s / kDegree, 10, 720) * kDegree;

  if (const char* wrong = gnc::zebro::check(p)) gait.error("", wrong);
}

void read_solver(config::Section s, Parameters& p) {
  for (std::size_t c = 0; c < kFaultClasses; ++c)
    config::read_strategies(s, kFaultClassNames[c], kStrategyNames, p.solver.order[c]);
  p.solver.budget_ns = config::seconds(s, "budget_s", p.solver.budget_ns, 2, 600);
  p.solver.cool_down_ns = config::seconds(s, "cool_down_s", p.solver.cool_down_ns, 2, 3600);
  p.solver.cool_degC = s.number("cool_degC", p.solver.cool_degC, -50, 150);
  p.solver.rounds = static_cast<unsigned>(s.integer("rounds", p.solver.rounds, 1, 1000));
  p.solver.healthy_ns = config::seconds(s, "healthy_s", p.solver.healthy_ns, 1, 3600);
  p.solver.current_limit_A = p.current_limit_A;
}

}  // namespace

Parameters read_parameters(config::Section& root) {
  Parameters p;
  read_bus(root.section("bus"), p);
  read_locomotion(root, p.locomotion);

  config::Section limits = root.section("limits");
  p.current_limit_A = limits.number("current_A", p.current_limit_A, 0.05, 1.7);
  p.current_time_ns = config::milliseconds(limits, "current_time_ms", p.current_time_ns, 0, 10'000);
  p.temperature_warning_degC =
      limits.number("temperature_warning_degC", p.temperature_warning_degC, -50, 150);

  config::Section panel = root.section("panel");
  p.panel_deployed_deg = panel.number("deployed_deg", p.panel_deployed_deg, 10, 350);
  p.panel_move_ns = config::seconds(panel, "move_s", p.panel_move_ns, 1, 60);

  read_solver(root.section("solve"), p);
  return p;
}

}  // namespace lss::zebro
