#include "tools/lss-cli/ardito/vehicle.h"

#include <ardito_fields.h>  // of the IDL
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/vehicles/ardito/modes.h"
#include "daemon/vehicles/ardito/tunables.h"
#include "idl/angles.h"
#include "idl/ardito/codes.h"
#include "idl/ardito/commands.h"
#include "idl/codes.h"
#include "tools/lss-cli/session/telemetry.h"
#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli::ardito {
namespace {

using lss::ardito::CommandKind;
using lss::ardito::Mode;

constexpr VerbHelp kHelp[] = {
    {"start",
     "  lss-cli start --hold             beacon, then motors on, until Ctrl-C\n"
     "  lss-cli start --limit urc --hold up to 1 m/s, where the config allows it\n"},
    {"drive",
     "  lss-cli drive 0.3 --for 20s      straight ahead, then a safe stop\n"
     "  lss-cli drive 0.3 --heading 5deg --for 10s      an arc to the right\n"
     "  lss-cli drive -0.2               backward until Ctrl-C\n"
     "  lss-cli drive 0.3 --driver autonomous --detach  the heartbeat comes from somebody else\n"},
    {"park",
     "  lss-cli park 0.3 --for 10s       turn right on the spot\n"
     "  lss-cli park -0.3                to the left until Ctrl-C\n"},
    {"halt", "  lss-cli halt --hold              stand, motors on, until Ctrl-C\n"},
};

const lss_ArditoTelemetry& sample(const void* telemetry) {
  return *static_cast<const lss_ArditoTelemetry*>(telemetry);
}

std::vector<Invocation> prepare(const lss_Status& status, const Invocation& wanted) {
  std::vector<Invocation> steps;
  const bool motion = wanted.info->leased && wanted.info->kind >= 200;
  if (motion && status.state == lss_STATE_IDLE) {
    add_step(steps, kVehicle, lss::CommandKind::start);
    // The limit that the requested speed needs; the daemon rejects a speed above its cap.
    const double speed_m_s = static_cast<CommandKind>(wanted.info->kind) != CommandKind::halt
                                 ? std::abs(wanted.parameter[0])
                                 : 0;
    steps.back().parameter[0] = speed_m_s > lss::ardito::kSpeedLimits_m_s[0] ? 1 : 0;
    steps.back().parameter[1] = speed_m_s;
  }
  return steps;
}

std::vector<Problem> problems(const lss_Status& status, const void* telemetry) {
  const lss_ArditoTelemetry& t = sample(telemetry);
  if (!t.port_open) return closed_port(status, "the CAN bus");
  std::vector<Problem> list;
  for (const lss_ArditoNode& node : t.nodes) {
    if (node.online || latched(status, FaultId::module_silent, node.id) ||
        latched(status, FaultId::node_wrong, node.id))
      continue;
    list.push_back(
        {node.id != lss::ardito::kImuNode,
         unheard(kVehicle, node.id, node.age_ms,
                 fmt::format("is {}, last message", name_of(lss::ardito::kLinkNames, node.link))),
         "check its power and the bus"});
  }
  if (t.emergency_button)
    list.push_back({true, "the emergency-stop button is pressed", "release it"});
  return list;
}

nlohmann::json telemetry_json(const void* telemetry) {
  const lss_ArditoTelemetry& t = sample(telemetry);
  nlohmann::json json = json_of(t);
  name_subjects(kVehicle, json["wheels"]);
  name_subjects(kVehicle, json["steering"], lss::ardito::kDriveWheels);
  name_subjects(kVehicle, json["nodes"]);
  for (std::size_t i = 0; i < std::size(t.nodes); ++i) {
    json["nodes"][i]["link"] = name_of(lss::ardito::kLinkNames, t.nodes[i].link);
    json["nodes"][i]["drive"] = name_of(lss::ardito::kDriveNames, t.nodes[i].drive);
  }
  return json;
}

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
         std::isnan(t.imu_speed_m_s) ||
         std::ranges::any_of(t.steering, [](const auto& s) { return std::isnan(s.reduction_rad); });
}

std::string state_text(const std::string& name, bool good, const Style& style) {
  const std::string text = fmt::format("{:<13}", name);
  return good ? text : style.bad(text);
}

std::string wheel_row(const lss_ArditoWheel& w, const lss_ArditoNode& node, const Style& style) {
  return fmt::format("{} {} {} {:<7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6}\n",
                     style.bold(fmt::format("{:<8}", subject_name(kVehicle, w.id))),
                     link_text(node, style),
                     state_text(condition(w), w.state == 0 && !w.unproven && !w.hot, style),
                     w.clutch ? "engaged" : "open", fixed(w.target_rad_s, 3),
                     fixed(w.motor_rad_s, 3), fixed(w.hall_rad_s, 3), fixed(w.reduction_rad_s, 3),
                     fixed(w.current_A, 2), fixed(w.temperature_degC, 1), fixed(w.voltage_V, 1));
}

std::string steering_row(const lss_ArditoSteering& s, const lss_ArditoNode& node,
                         const Style& style) {
  return fmt::format("{} {} {} {:<7} {:>7} {:>7} {:>7} {:>7} {:>7}\n",
                     style.bold(fmt::format("{:<8}", subject_name(kVehicle, node.id))),
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
  if (mode == Mode::parking) return fmt::format("{:.2f} m/s on the spot", t.speed_m_s);
  return fmt::format("{:.2f} m/s, heading {:.1f} deg{}", t.speed_m_s, t.heading_rad / kDegree,
                     t.autonomous ? ", autonomous" : "");
}

std::string screen(const void* telemetry, const Style& style) {
  const lss_ArditoTelemetry& t = sample(telemetry);
  std::string text = style.dim(
                         "wheel    link        failure       clutch   target   motor    Hall "
                         "encoder current   temp supply") +
                     "\n" +
                     style.dim(
                         "                                            rad/s   rad/s   rad/s   "
                         "rad/s       A   degC      V") +
                     "\n";
  for (std::size_t i = 0; i < std::size(t.wheels); ++i)
    text += wheel_row(t.wheels[i], t.nodes[i], style);
  text += style.dim(
              "steering                                       deg     deg             deg       "
              "A") +
          "\n";
  for (std::size_t i = 0; i < std::size(t.steering); ++i)
    text += steering_row(t.steering[i], t.nodes[i + lss::ardito::kDriveWheels], style);
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
  text += fmt::format(
      "{} {} m/s{}{}, motors {:.2f} of rated above no load, cap {:.2f} m/s\n",
      style.dim("slip      "), fixed(t.slip_m_s, 3),
      t.stuck      ? style.bad(", STUCK")
      : t.slipping ? style.bad(", slipping")
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

std::string details(const void* telemetry, const Style& style) {
  std::string text =
      style.dim("node     address drive                  last frame  emergency  so far") + "\n";
  for (const lss_ArditoNode& n : sample(telemetry).nodes) {
    text +=
        fmt::format("{}    0x{:02x} {:<22} {:>10} {:>10} {:>7}\n",
                    style.bold(fmt::format("{:<8}", subject_name(kVehicle, n.id))), n.address,
                    n.id <= lss::ardito::kDriveWheels + lss::ardito::kSteeredWheels
                        ? name_of(lss::ardito::kDriveNames, n.drive)
                        : "",
                    never_heard(n) ? std::string("never") : fmt::format("{} ms", n.age_ms),
                    n.emergency == 0 ? std::string("none") : fmt::format("{:#06x}", n.emergency),
                    n.emergencies);
  }
  return text;
}

std::string progress(const void* telemetry) {
  const lss_ArditoTelemetry& t = sample(telemetry);
  const bool moves = t.mode >= static_cast<std::uint8_t>(Mode::steering) || t.autonomy_wait_s > 0;
  return moves ? fmt::format(" {}: {}", asked(t), driven(t)) : "";
}

}  // namespace

const Vehicle kVehicle{
    .name = "ardito",
    .commands = lss::ardito::kCommands,
    .subjects = lss::ardito::kNodeNames,
    .help = kHelp,
    .telemetry = &lss_ArditoTelemetry_desc,
    .allowed = allowed_by(lss::ardito::logic, lss::ardito::kModeNames),
    .prepare = prepare,
    .rest = static_cast<std::uint16_t>(CommandKind::halt),
    .problems = problems,
    .json = telemetry_json,
    .screen = screen,
    .details = details,
    .progress = progress,
    .distance_m = [](const void* telemetry) { return sample(telemetry).distance_m; },
    .add_report = add_report,
    .tunables = [] { return lss::ardito::tuning().infos; },
    .codes = lss::ardito::kOwnCodes,
};

}  // namespace lss::cli::ardito
