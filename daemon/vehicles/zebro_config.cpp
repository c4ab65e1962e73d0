#include "daemon/vehicles/zebro_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <set>

namespace lss::zebro {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TimeNs milliseconds(config::Section& s, std::string_view key, TimeNs fallback, double min,
                    double max) {
  return static_cast<TimeNs>(s.number(key, static_cast<double>(fallback) * 1e-6, min, max) * 1e6);
}
TimeNs seconds(config::Section& s, std::string_view key, TimeNs fallback, double min, double max) {
  return static_cast<TimeNs>(s.number(key, static_cast<double>(fallback) * 1e-9, min, max) * 1e9);
}

void read_bus(config::Section s, Parameters& p) {
  p.bus.check = s.choice("check", 0, {"lrc", "crc8"}) == 0 ? Check::lrc : Check::crc8;
  p.bus.stop = s.choice("stop", 0, {"lf", "crlf"}) == 0 ? Stop::lf : Stop::crlf;
  p.bus.reply_timeout_ns = milliseconds(s, "reply_timeout_ms", p.bus.reply_timeout_ns, 0.5, 1000);
  p.bus.resend_limit = static_cast<int>(s.integer("resend_limit", p.bus.resend_limit, 0, 100));
  p.module_silent_ns = milliseconds(s, "module_silent_ms", p.module_silent_ns, 50, 7900);
  p.bus.stale_after_ns = milliseconds(s, "stale_ms", p.bus.stale_after_ns, 40, 5000);
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

// The strategies of a fault class, in their order.
void read_order(config::Section& s, std::size_t fault_class, SolverParameters& p) {
  const std::vector<std::string> known(std::begin(kStrategyNames) + 1, std::end(kStrategyNames));
  StrategyList& order = p.order[fault_class];
  std::vector<std::string> fallback;
  for (const StrategyKind kind : order) {
    if (kind != StrategyKind::none)
      fallback.emplace_back(kStrategyNames[static_cast<std::size_t>(kind)]);
  }
  const char* const key = kFaultClassNames[fault_class];
  const std::vector<std::string> names = s.texts(key, fallback);
  if (names.empty() || names.size() > order.size()) {
    s.error(key, fmt::format("{} strategies: name between one and {}", names.size(), order.size()));
    return;
  }
  order.fill(StrategyKind::none);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::find(known.begin(), known.end(), names[i]);
    if (found == known.end()) {
      s.error(key, fmt::format("\"{}\" is no strategy: use {}", names[i], config::join(known)));
      continue;
    }
    order[i] = static_cast<StrategyKind>(found - known.begin() + 1);
  }
}

void read_solver(config::Section s, Parameters& p) {
  for (std::size_t c = 0; c < kFaultClasses; ++c) read_order(s, c, p.solver);
  p.solver.budget_ns = seconds(s, "budget_s", p.solver.budget_ns, 2, 600);
  p.solver.cool_down_ns = seconds(s, "cool_down_s", p.solver.cool_down_ns, 2, 3600);
  p.solver.cool_degC = s.number("cool_degC", p.solver.cool_degC, -50, 150);
  p.solver.current_limit_A = p.current_limit_A;
}

}  // namespace

Parameters read_parameters(config::Section& root) {
  Parameters p;
  read_bus(root.section("bus"), p);
  read_locomotion(root, p.locomotion);

  config::Section limits = root.section("limits");
  p.current_limit_A = limits.number("current_A", p.current_limit_A, 0.05, 1.7);
  p.current_time_ns = milliseconds(limits, "current_time_ms", p.current_time_ns, 0, 10'000);
  p.temperature_warning_degC =
      limits.number("temperature_warning_degC", p.temperature_warning_degC, -50, 150);

  config::Section panel = root.section("panel");
  p.panel_deployed_deg = panel.number("deployed_deg", p.panel_deployed_deg, 10, 350);
  p.panel_move_ns = seconds(panel, "move_s", p.panel_move_ns, 1, 60);

  read_solver(root.section("solve"), p);
  return p;
}

}  // namespace lss::zebro
