#include "tools/lss-cli/zebro/vehicle.h"

#include <fmt/format.h>
#include <zebro_fields.h>  // of the IDL

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "daemon/vehicles/zebro/modes.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "idl/angles.h"
#include "idl/zebro/codes.h"
#include "idl/zebro/commands.h"
#include "tools/lss-cli/session/telemetry.h"
#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli::zebro {
namespace {

using lss::zebro::CommandKind;
using lss::zebro::Mode;

constexpr VerbHelp kHelp[] = {
    {"start",
     "  lss-cli start --hold             motors on, until Ctrl-C\n"
     "  lss-cli start stand --hold       and stand up\n"},
    {"stand",
     "  lss-cli stand --hold             from wherever it is; stays standing until Ctrl-C\n"
     "  lss-cli stand --dry-run          would it be accepted?\n"},
    {"lay-down", "  lss-cli lay-down\n"},
    {"stow", "  lss-cli stow\n"},
    {"walk",
     "  lss-cli walk forward --speed high --for 20s\n"
     "  lss-cli walk backward low        until Ctrl-C\n"
     "  lss-cli walk --heading 90 --for 1min    turns right on the spot\n"
     "  lss-cli walk --detach            the heartbeat comes from somebody else\n"},
    {"panel", "  lss-cli panel deploy\n  lss-cli panel retract\n"},
    {"leg",
     "  lss-cli leg RM 90 --hold         one leg to 90 deg, then hold\n"
     "  lss-cli leg 4 1.57rad backward --duration 5s\n"},
};

const lss_ZebroTelemetry& sample(const void* telemetry) {
  return *static_cast<const lss_ZebroTelemetry*>(telemetry);
}

std::vector<Invocation> prepare(const lss_Status& status, const Invocation& wanted) {
  std::vector<Invocation> steps;
  const auto add = [&](CommandKind step) { add_step(steps, kVehicle, step); };
  const auto kind = static_cast<CommandKind>(wanted.info->kind);
  const bool motion = wanted.info->leased && wanted.info->kind >= 100;
  if (!motion || status.state == lss_STATE_FATAL_ERROR || status.state == lss_STATE_SOLVE_ERRORS) {
    return steps;  // the daemon says why not
  }
  if (status.state == lss_STATE_IDLE) {
    add_step(steps, kVehicle, lss::CommandKind::start);
    if (kind == CommandKind::walk) add(CommandKind::stand);
    return steps;
  }
  // A movement that cannot be interrupted in favour of the wanted one ends first.
  const auto mode = static_cast<Mode>(status.mode);
  const bool rising = mode == Mode::standing_up, lying = mode == Mode::lying_down,
             stowing = mode == Mode::stowing;
  const bool stepping = mode == Mode::walking || mode == Mode::finishing_step;
  if (lying && kind != CommandKind::lay_down) add(CommandKind::lay_down);
  if (stowing && kind != CommandKind::stow) add(CommandKind::stow);
  if (rising && kind != CommandKind::stand && kind != CommandKind::walk) add(CommandKind::stand);
  if (stepping && kind == CommandKind::leg) add(CommandKind::stand);
  if (kind == CommandKind::walk && mode != Mode::standing && mode != Mode::walking)
    add(CommandKind::stand);
  return steps;
}

bool ends(const Invocation& walk) { return walk.parameter[2] == 0; }

std::vector<Problem> problems(const lss_Status& status, const void* telemetry) {
  const lss_ZebroTelemetry& t = sample(telemetry);
  if (!t.port_open) return closed_port(status, "the bus port");
  std::vector<Problem> list;
  for (const lss_ZebroModule& module : t.modules) {
    if (module.online || latched(status, FaultId::module_silent, module.id)) continue;
    list.push_back({true,
                    unheard(kVehicle, module.id, module.age_ms, "does not answer, last reply"),
                    "check its power and the bus"});
  }
  return list;
}

const char* speed_name(const lss_ZebroTelemetry& t) {
  return t.speed < std::size(lss::zebro::kSpeeds) ? lss::zebro::kSpeeds[t.speed] : "?";
}

nlohmann::json telemetry_json(const void* telemetry) {
  const lss_ZebroTelemetry& t = sample(telemetry);
  nlohmann::json json = json_of(t);
  json["speed"] = speed_name(t);
  name_subjects(kVehicle, json["modules"]);
  return json;
}

std::string module_row(const lss_ZebroModule& m, const Style& style) {
  const std::string name = fmt::format("{:<6}", subject_name(kVehicle, m.id));
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
  return fmt::format("{} {}, heading {:.0f} deg", t.direction < 0 ? "backward" : "forward",
                     speed_name(t), t.heading_rad / kDegree);
}

std::string screen(const void* telemetry, const Style& style) {
  const lss_ZebroTelemetry& t = sample(telemetry);
  std::string text =
      style.dim("leg    link     calib  motion     angle  target   speed current   temp supply") +
      "\n";
  text += style.dim("                                  deg     deg   deg/s       A   degC      V") +
          "\n";
  for (const lss_ZebroModule& module : t.modules) text += module_row(module, style);
  const bool walks = t.mode == static_cast<std::uint8_t>(Mode::walking);
  text +=
      fmt::format("\n{} {}{}\n", style.dim("walked    "), walks ? gait(t) + ": " : "", walked(t));
  const std::string port = t.port_open ? "port open" : style.bad("port closed");
  text +=
      fmt::format("{} {}, cycle {:.1f} ms, {} sent, {} received, {} broken, {} overflows\n",
                  style.dim("bus       "), port, static_cast<double>(t.bus_cycle_ns) * 1e-6,
                  t.bus_frames_sent, t.bus_frames_received, t.bus_frames_dropped, t.bus_overflows);
  return text;
}

// Of ResetCause.
constexpr const char* kResetCauses[] = {"power-on", "watchdog", "brown-out", "command", "software"};

std::string details(const void* telemetry, const Style& style) {
  std::string text = style.dim(
                         "leg    address firmware reset      up       last reply    replies "
                         "resends  flags time left") +
                     "\n";
  for (const lss_ZebroModule& m : sample(telemetry).modules) {
    if (never_heard(m)) continue;
    text += fmt::format("{} {:>7} {:>8} {:<10} {:<12} {:>6} ms {:>10} {:>7} {:#06x} {:>9}\n",
                        style.bold(fmt::format("{:<6}", subject_name(kVehicle, m.id))), m.address,
                        fmt::format("{}.{}", m.firmware_major, m.firmware_minor),
                        name_of(kResetCauses, m.reset_cause), format_duration(m.uptime_s), m.age_ms,
                        m.replies, m.resends, m.flags, fixed(m.time_left_s, 2) + " s");
  }
  return text;
}

std::string progress(const void* telemetry) {
  const lss_ZebroTelemetry& t = sample(telemetry);
  const bool walks = t.mode == static_cast<std::uint8_t>(Mode::walking);
  return walks ? fmt::format(" {}: {}", gait(t), walked(t)) : "";
}

}  // namespace

const Vehicle kVehicle{
    .name = "zebro",
    .commands = lss::zebro::kCommands,
    .subjects = lss::zebro::kModuleNames,
    .help = kHelp,
    .telemetry = &lss_ZebroTelemetry_desc,
    .allowed = allowed_by(lss::zebro::logic, lss::zebro::kModeNames),
    .prepare = prepare,
    .rest = static_cast<std::uint16_t>(CommandKind::stand),
    .problems = problems,
    .json = telemetry_json,
    .screen = screen,
    .details = details,
    .progress = progress,
    .distance_m = [](const void* telemetry) { return sample(telemetry).distance_m; },
    .add_report = add_report,
    .ends = ends,
    .tunables = [] { return lss::zebro::tuning().infos; },
    .codes = lss::zebro::kOwnCodes,
};

}  // namespace lss::cli::zebro
