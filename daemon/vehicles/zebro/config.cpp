#include "daemon/vehicles/zebro/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "daemon/config/reading.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "idl/angles.h"

namespace lss::zebro {
namespace {

void read_adjustable(config::Section& s, std::string_view section, Parameters& p) {
  config::read_tunables(s, section, tuning().tunables, p);
}

void read_bus(config::Section s, Parameters& p) {
  p.bus.check = s.choice("check", 0, {"lrc", "crc8"}) == 0 ? Check::lrc : Check::crc8;
  p.bus.stop = s.choice("stop", 0, {"lf", "crlf"}) == 0 ? Stop::lf : Stop::crlf;
  p.bus.reply_timeout_ns =
      config::milliseconds(s, "reply_timeout_ms", p.bus.reply_timeout_ns, 0.5, 1000);
  p.bus.resend_limit = static_cast<int>(s.integer("resend_limit", p.bus.resend_limit, 0, 100));
  read_adjustable(s, "bus", p);
  p.bus.stale_after_ns = config::milliseconds(s, "stale_ms", p.bus.stale_after_ns, 40, 5000);
  const auto addresses = s.integers("addresses", {1, 2, 3, 4, 5, 6, 7}, kBusModules, 1, 127);
  if (std::set(addresses.begin(), addresses.end()).size() != addresses.size()) {
    s.error("addresses", "two modules have the same address: give each its own");
  }
  for (std::size_t i = 0; i < addresses.size() && i < p.bus.address.size(); ++i) {
    p.bus.address[i] = static_cast<std::uint8_t>(addresses[i]);
  }
}

void read_locomotion(config::Section& root, Parameters& all) {
  gnc::zebro::LocomotionParameters& p = all.locomotion;
  config::Section gait = root.section("gait");
  read_adjustable(gait, "gait", all);
  p.sweep_rad = gait.number("sweep_deg", p.sweep_rad / kDegree, 5, 90) * kDegree;
  p.offset_rad = gait.number("offset_deg", p.offset_rad / kDegree, -30, 30) * kDegree;

  config::Section body = root.section("body");
  p.leg_diameter_m = body.number("leg_diameter_mm", p.leg_diameter_m * 1e3, 10, 1000) * 1e-3;
  p.track_m = body.number("track_mm", p.track_m * 1e3, 10, 5000) * 1e-3;
  p.belly_height_m = body.number("belly_height_mm", p.belly_height_m * 1e3, 0, 1000) * 1e-3;

  config::Section motion = root.section("motion");
  read_adjustable(motion, "motion", all);

  if (const char* wrong = gnc::zebro::check(p)) gait.error("", wrong);
}

void read_solver(config::Section s, Parameters& p) {
  for (std::size_t c = 0; c < kFaultClasses; ++c)
    config::read_strategies(s, kFaultClassNames[c], kStrategyNames, p.solver.order[c]);
  read_adjustable(s, "solve", p);
}

}  // namespace

Parameters read_parameters(config::Section& root) {
  Parameters p;
  read_bus(root.section("bus"), p);
  read_locomotion(root, p);

  config::Section limits = root.section("limits");
  read_adjustable(limits, "limits", p);

  config::Section panel = root.section("panel");
  read_adjustable(panel, "panel", p);

  read_solver(root.section("solve"), p);
  tuning().derive(p);
  return p;
}

}  // namespace lss::zebro
