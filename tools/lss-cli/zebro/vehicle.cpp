#include "tools/lss-cli/zebro/vehicle.h"

#include <fmt/format.h>
#include <zebro_fields.h>  // of the IDL

#include "daemon/config/config.h"
#include "drivers/zebro/leg_bus.h"
#include "idl/angles.h"
#include "idl/zebro/commands.h"
#include "tools/lss-cli/certify/wire.h"
#include "tools/lss-cli/session/overlay.h"
#include "tools/lss-cli/session/vehicle_words.h"

namespace lss::cli::zebro {
namespace {

using lss::zebro::CommandKind;
using lss::zebro::Mode;

const char* speed_name(const lss_ZebroTelemetry& t) {
  return name_of(lss::zebro::kSpeeds, t.speed);
}

std::string module_row(const Vehicle& vehicle, const lss_ZebroModule& m, const Style& style) {
  const std::string name = fmt::format("{:<6}", subject_name(vehicle, m.id));
  if (never_heard(m)) return fmt::format("{} {}\n", style.bold(name), style.bad("never heard"));
  const std::string link = fmt::format("{:<8}", m.online ? "online" : "silent");
  const std::string calibrated = fmt::format("{:<6}", m.calibrated ? "yes" : "no");
  const char* activity = m.isolated          ? "isolated"
                         : !m.motion_control ? "off"
                         : m.swing           ? "swing"
                         : m.moving          ? "moving"
                                             : "holding";
  return fmt::format("{} {} {} {:<8} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6}\n", style.bold(name),
                     m.online ? style.good(link) : style.bad(link),
                     m.calibrated ? calibrated : style.dim(calibrated), activity,
                     fixed(m.position_rad / kDegree, 1), fixed(m.set_point_rad / kDegree, 1),
                     fixed(m.velocity_rad_s / kDegree, 1), fixed(m.current_A, 3),
                     fixed(m.temperature_degC, 1), fixed(m.supply_V, 1));
}

std::string walked(const lss_ZebroTelemetry& t) {
  return fmt::format("{:.3f} m, {:.1f} mm/s, turned {:.1f} deg, {} steps", t.distance_m,
                     t.speed_m_s * 1000, t.yaw_rad / kDegree, t.steps);
}

std::string gait(const lss_ZebroTelemetry& t) {
  return fmt::format("{} {}{}, heading {:.0f} deg", t.direction < 0 ? "backward" : "forward",
                     speed_name(t), t.rows ? " by rowing" : "", t.heading_rad / kDegree);
}

std::string screen(const Vehicle& vehicle, const lss_ZebroTelemetry& t, const Style& style) {
  std::string text =
      style.dim("leg    link     calib  motion     angle  target   speed current   temp supply") +
      "\n";
  text += style.dim("                                  deg     deg   deg/s       A   degC      V") +
          "\n";
  for (const lss_ZebroModule& module : t.modules) text += module_row(vehicle, module, style);
  const bool walks = t.mode == static_cast<std::uint8_t>(Mode::walking);
  text +=
      fmt::format("\n{} {}{}\n", style.dim("walked    "), walks ? gait(t) + ": " : "", walked(t));
  text += fmt::format(
      "{} left side {}, right side {} (0: none at the belly's height; -: not measured)\n",
      style.dim("in soil   "), fixed(t.soil_share[0], 2), fixed(t.soil_share[1], 2));
  const std::string port = t.port_open ? "port open" : style.bad("port closed");
  text +=
      fmt::format("{} {}, cycle {:.1f} ms, {} sent, {} received, {} broken, {} overflows\n",
                  style.dim("bus       "), port, static_cast<double>(t.bus_cycle_ns) * 1e-6,
                  t.bus_frames_sent, t.bus_frames_received, t.bus_frames_dropped, t.bus_overflows);
  return text;
}

std::string progress(const lss_ZebroTelemetry& t) {
  const bool walks = t.mode == static_cast<std::uint8_t>(Mode::walking);
  return walks ? fmt::format(" {}: {}", gait(t), walked(t)) : "";
}

// docs/icd-zebro.md section 8; turning round in half duplex takes two characters at most.
certify::Wire wire(const config::Config& config, config::Section& own, std::int64_t) {
  const config::Port& port = config.ports.front();
  const auto baud = static_cast<int>(port.baud);
  const bool crlf = own.section("bus").choice("stop", 0, {"lf", "crlf"}) == 1;
  const TimeNs frame_ns =
      lss::zebro::frame_time_ns(baud, crlf ? lss::zebro::Stop::crlf : lss::zebro::Stop::lf);
  const double frame_us = static_cast<double>(frame_ns) / 1000;
  const double each_us = port.half_duplex ? 2 * (frame_us + certify::bits_us(10, baud)) : frame_us;
  return {.orders_us = static_cast<double>(lss::zebro::kBusModules) * each_us,
          .formula = fmt::format("{} requests{} of {:.1f} us at {} baud", lss::zebro::kBusModules,
                                 port.half_duplex ? " and replies" : "", frame_us, baud)};
}

}  // namespace

const Overlay kOverlay{
    .telemetry = view_of<lss_ZebroTelemetry, screen, progress>(lss_ZebroTelemetry_desc),
    .add_report = add_report,
    .wire = wire,
};

}  // namespace lss::cli::zebro
