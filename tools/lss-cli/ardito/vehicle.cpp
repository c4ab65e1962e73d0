#include "tools/lss-cli/ardito/vehicle.h"

#include <ardito_fields.h>  // of the IDL
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/config/config.h"
#include "idl/angles.h"
#include "idl/ardito/commands.h"
#include "tools/lss-cli/certify/wire.h"
#include "tools/lss-cli/session/overlay.h"
#include "tools/lss-cli/session/vehicle_words.h"

namespace lss::cli::ardito {
namespace {

using lss::ardito::CommandKind;
using lss::ardito::Mode;

constexpr const char* kWheelStates[] = {"good",        "motor sensor",  "encoder",
                                        "motor",       "gear",          "clutch",
                                        "two sensors", "clutch+sensor", "all sensors"};
constexpr const char* kSteeringStates[] = {"good", "motor encoder", "encoder", "critical",
                                           "both encoders"};

std::string link_text(const lss_ArditoNode& node, const Style& style) {
  const std::string text = fmt::format(
      "{:<11}", node.isolated ? "isolated" : name_of(lss::ardito::kLinkNames, node.link));
  return node.online && !node.isolated ? style.good(text) : style.bad(text);
}

// Failure of a wheel, and what else is known of it.
std::string condition(const lss_ArditoWheel& w) {
  if (w.state != 0) return name_of(kWheelStates, w.state);
  if (w.unproven) return "unproven";
  if (w.hot) return "hot";
  if (w.suspect != 0) return fmt::format("{}?", name_of(kWheelStates, w.suspect));
  if (w.inconclusive) return "inconclusive";
  return w.probing ? "clutch probed" : "good";
}

bool unmeasured(const lss_ArditoTelemetry& t) {
  const auto never = [](const lss_ArditoWheel& w) {
    return std::isnan(w.motor_rad_s) || std::isnan(w.temperature_degC) || std::isnan(w.voltage_V);
  };
  return std::ranges::any_of(t.wheels, never) || std::isnan(t.beta_rad) ||
         std::isnan(t.sunk_m[0]) || std::isnan(t.imu_speed_m_s) ||
         std::ranges::any_of(t.steering, [](const auto& s) { return std::isnan(s.reduction_rad); });
}

std::string state_text(const std::string& name, bool good, const Style& style) {
  const std::string text = fmt::format("{:<13}", name);
  return good ? text : style.bad(text);
}

std::string wheel_row(const Vehicle& vehicle, const lss_ArditoWheel& w, const lss_ArditoNode& node,
                      const Style& style) {
  return fmt::format("{} {} {} {:<7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6}\n",
                     style.bold(fmt::format("{:<8}", subject_name(vehicle, w.id))),
                     link_text(node, style),
                     state_text(condition(w), w.state == 0 && !w.unproven && !w.hot, style),
                     w.clutch ? "engaged" : "open", fixed(w.target_rad_s, 3),
                     fixed(w.motor_rad_s, 3), fixed(w.hall_rad_s, 3), fixed(w.reduction_rad_s, 3),
                     fixed(w.current_A, 2), fixed(w.temperature_degC, 1), fixed(w.voltage_V, 1));
}

std::string steering_row(const Vehicle& vehicle, const lss_ArditoSteering& s,
                         const lss_ArditoNode& node, const Style& style) {
  return fmt::format("{} {} {} {:<7} {:>7} {:>7} {:>7} {:>7} {:>7}\n",
                     style.bold(fmt::format("{:<8}", subject_name(vehicle, node.id))),
                     link_text(node, style),
                     state_text(name_of(kSteeringStates, s.state), s.state == 0, style), "",
                     fixed(s.target_rad / kDegree, 2), fixed(s.motor_rad / kDegree, 2), "",
                     fixed(s.reduction_rad / kDegree, 2), fixed(s.current_A, 2));
}

std::string driven(const lss_ArditoTelemetry& t) {
  return fmt::format("{:.3f} m, {:.3f} m/s, turned {:.1f} deg, at {:.2f} m ahead, {:.2f} m left",
                     t.distance_m, t.ground_m_s, t.yaw_rad / kDegree, t.x_m, t.y_m);
}

std::string asked(const lss_ArditoTelemetry& t) {
  const auto mode = static_cast<Mode>(t.mode);
  if (t.autonomy_wait_s > 0) return fmt::format("drives by itself in {:.1f} s", t.autonomy_wait_s);
  const std::string slowed =
      t.speed_share < 1 ? fmt::format(", slowed to {:.0f} % by slip", t.speed_share * 100) : "";
  if (mode == Mode::parking) return fmt::format("{:.2f} m/s on the spot{}", t.speed_m_s, slowed);
  return fmt::format("{:.2f} m/s{}, heading {:.1f} deg{}", t.speed_m_s, slowed,
                     t.heading_rad / kDegree, t.autonomous ? ", autonomous" : "");
}

std::string screen(const Vehicle& vehicle, const lss_ArditoTelemetry& t, const Style& style) {
  std::string text = style.dim(
                         "wheel    link        failure       clutch   target   motor    Hall "
                         "encoder current   temp supply") +
                     "\n" +
                     style.dim(
                         "                                            rad/s   rad/s   rad/s   "
                         "rad/s       A   degC      V") +
                     "\n";
  for (std::size_t i = 0; i < std::size(t.wheels); ++i)
    text += wheel_row(vehicle, t.wheels[i], t.nodes[i], style);
  text += style.dim(
              "steering                                       deg     deg             deg       "
              "A") +
          "\n";
  for (std::size_t i = 0; i < std::size(t.steering); ++i)
    text += steering_row(vehicle, t.steering[i], t.nodes[i + lss::ardito::kDriveWheels], style);
  const lss_ArditoNode& io = t.nodes[lss::ardito::kIoNode - 1];
  const lss_ArditoNode& imu = t.nodes[lss::ardito::kImuNode - 1];
  text += fmt::format("{} {} beacon {}, power {}{}\n", style.bold("IO      "), link_text(io, style),
                      t.beacon ? "on" : "off", t.power_good ? "good" : style.bad("bad"),
                      t.emergency_button ? style.bad(", EMERGENCY BUTTON PRESSED") : "");
  text += fmt::format(
      "{} {} {} m/s, {} deg, turning {} deg/s{}\n", style.bold("IMU     "), link_text(imu, style),
      fixed(t.imu_speed_m_s, 3), fixed(t.imu_heading_rad / kDegree, 1),
      fixed(t.imu_yaw_rate_rad_s / kDegree, 1), t.imu_valid ? "" : style.bad(", not trusted"));
  text += fmt::format("{} rocker {} deg, bogies {} and {} deg\n", style.dim("suspension"),
                      fixed(t.beta_rad / kDegree, 1), fixed(t.rho_rad[0] / kDegree, 1),
                      fixed(t.rho_rad[1] / kDegree, 1));
  text += style.dim("sunk by   ");
  for (std::size_t i = 0; i < std::size(t.sunk_m); ++i)
    text += fmt::format(" {} {}", lss::ardito::kNodeNames[i], fixed(t.sunk_m[i], 3));
  text += " m\n";
  text += fmt::format(
      "{} {} m/s, {:.0f} % of the wheels' speed{}{}, motors {:.2f} of rated above no load, cap "
      "{:.2f} m/s\n",
      style.dim("slip      "), fixed(t.slip_m_s, 3), t.slip_share * 100,
      t.stuck             ? style.bad(", STUCK")
      : t.speed_share < 1 ? style.bad(", slowed by it")
      : t.slipping        ? style.bad(", slipping")
                          : "",
      t.incoherent_speed || t.incoherent_heading ? style.bad(", wheels incoherent") : "", t.load,
      t.cap_m_s);
  const bool moves = t.mode >= static_cast<std::uint8_t>(Mode::steering) || t.autonomy_wait_s > 0;
  text +=
      fmt::format("{} {}{}\n", style.dim("driven    "), moves ? asked(t) + ": " : "", driven(t));
  text += fmt::format("{} {}, {} sent, {} received, {} dropped\n", style.dim("bus       "),
                      t.port_open ? "open" : style.bad("closed"), t.bus_frames_sent,
                      t.bus_frames_received, t.bus_frames_dropped);
  if (unmeasured(t)) text += style.dim("-: not measured") + "\n";
  return text;
}

std::string progress(const lss_ArditoTelemetry& t) {
  const bool moves = t.mode >= static_cast<std::uint8_t>(Mode::steering) || t.autonomy_wait_s > 0;
  return moves ? fmt::format(" {}: {}", asked(t), driven(t)) : "";
}

// The limit that the requested speed needs; the daemon rejects a speed above its cap.
void start(Invocation& start, const Invocation& wanted) {
  const double speed_m_s = static_cast<CommandKind>(wanted.info->kind) != CommandKind::halt
                               ? std::abs(wanted.parameter[0])
                               : 0;
  start.parameter[0] = speed_m_s > lss::ardito::kSpeedLimits_m_s[0] ? 1 : 0;
  start.parameter[1] = speed_m_s;
}

// docs/icd-ardito.md section 5: six wheels, four steering drives, I/O. The measurements answered
// SYNC before T_k; heartbeats go last.
certify::Wire wire(const config::Config&, config::Section&, std::int64_t bit_s) {
  constexpr std::int64_t kOurs[] = {6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 1};
  return certify::of_can(kOurs, {}, bit_s);
}

}  // namespace

const Overlay kOverlay{
    .telemetry = view_of<lss_ArditoTelemetry, screen, progress>(lss_ArditoTelemetry_desc),
    .add_report = add_report,
    .start = start,
    .wire = wire,
};

}  // namespace lss::cli::ardito
