#include "daemon/vehicles/zebro/config.h"

#include <fmt/format.h>

#include <set>

#include "daemon/config/reading.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "idl/angles.h"

namespace lss::zebro {
namespace {

void read_bus(config::Section s, Parameters& p) {
  p.bus.check = s.choice("check", 0, {"lrc", "crc8"}) == 0 ? Check::lrc : Check::crc8;
  p.bus.stop = s.choice("stop", 0, {"lf", "crlf"}) == 0 ? Stop::lf : Stop::crlf;
  // On one pair of wires an emergency stop waits for a reply that does not come.
  p.bus.reply_timeout_ns =
      config::milliseconds(s, "reply_timeout_ms", p.bus.reply_timeout_ns, 0.5, 40);
  p.bus.resend_limit = static_cast<int>(s.integer("resend_limit", p.bus.resend_limit, 0, 100));
  config::read_tunables(s, "bus", tuning().tunables, p);
  p.bus.stale_after_ns = config::milliseconds(s, "stale_ms", p.bus.stale_after_ns, 40, 5000);
  const auto addresses = s.integers("addresses", {1, 2, 3, 4, 5, 6, 7}, kBusModules, 1, 127);
  if (std::set(addresses.begin(), addresses.end()).size() != addresses.size()) {
    s.error("addresses", "two modules have the same address: give each its own");
  }
  for (std::size_t i = 0; i < addresses.size() && i < p.bus.address.size(); ++i) {
    p.bus.address[i] = static_cast<std::uint8_t>(addresses[i]);
  }
}

// The places of the hips on the body; the algorithm wants them from the centre of mass.
void read_hips(config::Section& body, gnc::zebro::LocomotionParameters& p) {
  const auto places = [&](const char* key, const gnc::zebro::PerLeg<double>& fallback_m) {
    std::vector<double> all_mm;
    for (const double place_m : fallback_m) all_mm.push_back(place_m * 1e3);
    return body.numbers(key, all_mm, kLegs, -5000, 5000);
  };
  const std::vector<double> x_mm = places("hip_x_mm", p.hips.x_m);
  const std::vector<double> y_mm = places("hip_y_mm", p.hips.y_m);
  const std::vector<double> mass_mm = body.numbers("centre_of_mass_mm", {0, 0}, 2, -1000, 1000);
  for (std::size_t i = 0; i < kLegs; ++i) {
    p.hips.x_m[i] = (x_mm[i] - mass_mm[0]) * 1e-3;
    p.hips.y_m[i] = (y_mm[i] - mass_mm[1]) * 1e-3;
    const bool left = gnc::zebro::is_left(static_cast<int>(i));
    if (left != (y_mm[i] > 0))
      body.error("hip_y_mm", "a left leg (LF, LM, LH) is at positive y, a right one at negative");
  }
  const auto& x = x_mm;
  if (!(x[0] > x[2] && x[2] > x[4] && x[1] > x[3] && x[3] > x[5]))
    body.error("hip_x_mm",
               "of each side the front leg is ahead of the middle one, that of the hind one");
}

void read_locomotion(config::Section& root, Parameters& all) {
  gnc::zebro::LocomotionParameters& p = all.locomotion;
  config::Section gait = root.section("gait");
  p.coordination = static_cast<gnc::zebro::Coordination>(
      gait.choice("coordination", 0, {"groups", "neighbours"}));
  config::read_tunables(gait, "gait", tuning().tunables, all);
  p.sweep_rad = gait.number("sweep_deg", p.sweep_rad / kDegree, 5, 90) * kDegree;
  p.offset_rad = gait.number("offset_deg", p.offset_rad / kDegree, -30, 30) * kDegree;

  config::Section body = root.section("body");
  p.leg_diameter_m = body.number("leg_diameter_mm", p.leg_diameter_m * 1e3, 10, 1000) * 1e-3;
  p.track_m = body.number("track_mm", p.track_m * 1e3, 10, 5000) * 1e-3;
  p.belly_height_m = body.number("belly_height_mm", p.belly_height_m * 1e3, 0, 1000) * 1e-3;

  read_hips(body, p);

  config::Section motion = root.section("motion");
  config::read_tunables(motion, "motion", tuning().tunables, all);

  if (const char* wrong = gnc::zebro::check(p)) gait.error("", wrong);
}

void read_solver(config::Section s, Parameters& p) {
  for (std::size_t c = 0; c < kFaultClasses; ++c)
    config::read_strategies(s, kFaultClassNames[c], kStrategyNames, p.solver.order[c]);
  config::read_tunables(s, "solve", tuning().tunables, p);
}

}  // namespace

Parameters read_parameters(config::Section& root) {
  Parameters p;
  read_bus(root.section("bus"), p);
  read_locomotion(root, p);

  config::Section limits = root.section("limits");
  p.power_limit_A = limits.number("power_A", p.power_limit_A, 0.1, 100);
  config::read_tunables(limits, "limits", tuning().tunables, p);
  if (const char* wrong = check_currents(p)) limits.error("total_A", wrong);

  config::Section ground = root.section("ground");
  config::read_tunables(ground, "ground", tuning().tunables, p);

  config::Section panel = root.section("panel");
  config::read_tunables(panel, "panel", tuning().tunables, p);
  if (const char* wrong = check_panel(p)) panel.error("move_s", wrong);

  read_solver(root.section("solve"), p);
  tuning().derive(p);
  return p;
}

Parameters with_link(Parameters parameters, const config::Config& config) noexcept {
  parameters.obc_timeout_ns = config.obc_timeout_ns;
  parameters.lease_min_ns = config.lease_min_ms * kMillisecond;
  return parameters;
}

}  // namespace lss::zebro
