#include "tools/lss-cli/talaris/vehicle.h"

#include <fmt/format.h>
#include <talaris_fields.h>  // of the IDL

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/vehicles/talaris/modes.h"
#include "daemon/vehicles/talaris/tunables.h"
#include "idl/angles.h"
#include "idl/codes.h"
#include "idl/talaris/codes.h"
#include "idl/talaris/commands.h"
#include "tools/lss-cli/session/telemetry.h"
#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/talaris/verbs.h"

namespace lss::cli::talaris {
namespace {

using lss::talaris::CommandKind;
using lss::talaris::GncStep;
using lss::talaris::Mode;
using lss::talaris::Phase;

constexpr VerbHelp kHelp[] = {
    {"start", "  lss-cli start --hold             manual control, everything shut, until Ctrl-C\n"},
    {"valve",
     "  lss-cli valve 3 --time 2s        open, and shut again after 2 s\n"
     "  lss-cli valve 1,3,5,7 --time 500ms\n"
     "  lss-cli valve all --open off     shut\n"},
    {"pulse",
     "  lss-cli pulse 1,3 --on 80ms --delay 20ms --frames 10     in every frame of 200 ms\n"},
    {"enable", "  lss-cli enable 2,4,6,8           the lifting valves stay shut\n"},
    {"gnc",
     "  lss-cli gnc standby --hold\n"
     "  lss-cli run -e 'gnc calibrate; plan hop --height 2 --distance 30; gnc execute'\n"},
    {"plan",
     "  lss-cli plan hop --height 2 --distance 30\n"
     "  lss-cli plan turn --turn 90deg\n"},
    {"gains", "  lss-cli gains 2\n"},
    {"land", "  lss-cli land                     in flight: down, here and now\n"},
};

const lss_TalarisTelemetry& sample(const void* telemetry) {
  return *static_cast<const lss_TalarisTelemetry*>(telemetry);
}

std::vector<Invocation> prepare(const lss_Status& status, const Invocation& wanted) {
  std::vector<Invocation> steps;
  const auto kind = static_cast<CommandKind>(wanted.info->kind);
  const bool motion = wanted.info->leased && wanted.info->kind >= 300;
  if (!motion || status.state == lss_STATE_FATAL_ERROR || status.state == lss_STATE_SOLVE_ERRORS)
    return steps;  // the daemon says why not
  const bool idle = status.state == lss_STATE_IDLE;
  if (idle) add_step(steps, kVehicle, lss::CommandKind::start);
  const Mode mode = idle ? Mode::manual : static_cast<Mode>(status.mode);
  if (kind == CommandKind::pulse && mode == Mode::manual)
    add_step(steps, kVehicle, CommandKind::duty_cycle);
  if (kind == CommandKind::valve && mode == Mode::duty_cycle)
    add_step(steps, kVehicle, CommandKind::manual);
  const bool calibrates =
      kind == CommandKind::gnc && wanted.parameter[0] == static_cast<double>(GncStep::calibrate);
  if (calibrates && (mode == Mode::manual || mode == Mode::duty_cycle)) {
    Invocation standby{&find_command(kVehicle, static_cast<std::uint16_t>(CommandKind::gnc)), {}};
    standby.parameter[0] = static_cast<double>(GncStep::standby);
    steps.push_back(standby);
  }
  return steps;
}

// The longest calibration that the configuration allows; one phase of a flight may last 120 s.
double takes_s(const Invocation& command) {
  if (command.info->kind != static_cast<std::uint16_t>(CommandKind::gnc)) return 0;
  switch (static_cast<GncStep>(command.parameter[0])) {
    case GncStep::calibrate:
      return 300;
    case GncStep::execute:
      return 240;
    default:
      return 0;
  }
}

std::vector<Problem> problems(const lss_Status& status, const void* telemetry) {
  const lss_TalarisTelemetry& t = sample(telemetry);
  std::vector<Problem> list;
  const auto port = [&](bool open, const char* what, std::uint16_t module) {
    if (!open) std::ranges::move(closed_port(status, what, module), std::back_inserter(list));
  };
  port(t.imu_port_open, "the line of the IMU", lss::talaris::kImuModule);
  port(t.altimeter_port_open, "the line of the altimeter", lss::talaris::kAltimeterModule);
  port(t.can_port_open, "the CAN bus", lss::talaris::kValveModule);
  for (const lss_TalarisModule& module : t.modules) {
    const bool needed = module.id != lss::talaris::kLoadCellModule;
    if (module.online || !needed || latched(status, FaultId::module_silent, module.id)) continue;
    list.push_back({true, unheard(kVehicle, module.id, module.age_ms, "last answered"),
                    "check its power and the line"});
  }
  return list;
}

nlohmann::json telemetry_json(const void* telemetry) {
  const lss_TalarisTelemetry& t = sample(telemetry);
  nlohmann::json json = json_of(t);
  json["phase"] = name_of(lss::talaris::kPhaseNames, t.phase);
  json["program"] = name_of(lss::talaris::kProgramNames, t.program);
  name_subjects(kVehicle, json["modules"]);
  constexpr std::size_t kLoadCell = lss::talaris::kLoadCellModule - 1;
  if (never_heard(t.modules[kLoadCell])) json["modules"][kLoadCell]["online"] = nullptr;
  return json;
}

struct Angles {
  double roll_rad, pitch_rad, yaw_rad;
};

// About x (up), y and z: heading and tilt of the vehicle.
Angles angles(const double (&q)[4]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  return {std::atan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
          std::asin(std::clamp(2 * (w * y - x * z), -1.0, 1.0)),
          std::atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))};
}

std::string module_row(const lss_TalarisModule& m, const Style& style) {
  const std::string name = style.bold(fmt::format("{:<10}", subject_name(kVehicle, m.id)));
  if (never_heard(m))
    return fmt::format(
        "{} {}\n", name,
        m.id == lss::talaris::kLoadCellModule ? style.dim("not there") : style.bad("never heard"));
  const std::string link = fmt::format("{:<7}", m.online ? "online" : "silent");
  return fmt::format("{} {} {:>6} ms {:>10} {:>7} {:>6}\n", name,
                     m.online ? style.good(link) : style.bad(link), m.age_ms, m.samples, m.errors,
                     m.lost);
}

std::string valve_row(const lss_TalarisTelemetry& t, const Style& style) {
  std::string text = style.bold("valves    ");
  for (const lss_TalarisValve& v : t.valves) {
    const std::string pulse = v.on_s > 0 ? fmt::format("{}:{:.0f}ms", v.id, v.on_s * 1000)
                              : v.open   ? fmt::format("{}:open", v.id)
                                         : fmt::format("{}:shut", v.id);
    const std::string cell = fmt::format(" {:<7}", v.enabled ? pulse : fmt::format("{}:off", v.id));
    text += v.on_s > 0 || v.open ? style.good(cell) : style.dim(cell);
  }
  return text + "\n";
}

std::string fan_row(const lss_TalarisTelemetry& t, const Style& style) {
  std::string text = style.bold("fans      ");
  for (const lss_TalarisFan& f : t.fans) {
    text += fmt::format(" {}: {:>5} rpm ({:>3} %){}", f.id, fixed(f.rpm, 0),
                        fixed(f.throttle * 100, 0), f.armed ? "" : style.dim(" off"));
  }
  return text + "\n";
}

std::string flight(const lss_TalarisTelemetry& t) {
  return fmt::format("height {} m, along {} m, climbing {} m/s", fixed(t.position_m[0], 2),
                     fixed(t.position_m[2], 2), fixed(t.velocity_m_s[0], 2));
}

std::string screen(const void* telemetry, const Style& style) {
  const lss_TalarisTelemetry& t = sample(telemetry);
  std::string text = style.dim("module     link    last data     samples  errors   lost") + "\n";
  for (const lss_TalarisModule& module : t.modules) text += module_row(module, style);
  text += valve_row(t, style) + fan_row(t, style);
  const Angles a = angles(t.attitude_wxyz);
  text += fmt::format("{} {}, {}{}{}\n", style.dim("GNC       "),
                      name_of(lss::talaris::kProgramNames, t.program),
                      name_of(lss::talaris::kPhaseNames, t.phase),
                      t.calibrated ? "" : style.dim(", not calibrated"),
                      t.airborne ? style.bold(", IN THE AIR") : "");
  text += fmt::format("{} {}, sideways {} m, range {} m\n", style.dim("position  "), flight(t),
                      fixed(t.position_m[1], 2), fixed(t.range_m, 3));
  text += fmt::format("{} roll {}, pitch {}, yaw {} deg; turning {}, {}, {} deg/s\n",
                      style.dim("attitude  "), fixed(a.roll_rad / kDegree, 1),
                      fixed(a.pitch_rad / kDegree, 1), fixed(a.yaw_rad / kDegree, 1),
                      fixed(t.rate_rad_s[0] / kDegree, 1), fixed(t.rate_rad_s[1] / kDegree, 1),
                      fixed(t.rate_rad_s[2] / kDegree, 1));
  text += fmt::format(
      "{} {} thruster-s used, {} left; tank {} bar, regulated {} bar; {} V, {} degC\n",
      style.dim("gas       "), fixed(t.gas_thruster_s, 1), fixed(t.gas_left_thruster_s, 1),
      fixed(t.pressure_Pa[0] * 1e-5, 1), fixed(t.pressure_Pa[1] * 1e-5, 1), fixed(t.voltage_V, 1),
      fixed(t.temperature_degC, 0));
  if (t.script_id != 0) {
    text += fmt::format("{} step {} of {}, {} s\n", style.dim("script    "), t.script_done,
                        t.script_steps, fixed(t.script_s - lss::talaris::kScriptLead_s, 1));
  }
  text += fmt::format("{} IMU {}, altimeter {}, CAN {}; {} sent, {} received, {} dropped\n",
                      style.dim("lines     "), t.imu_port_open ? "open" : style.bad("closed"),
                      t.altimeter_port_open ? "open" : style.bad("closed"),
                      t.can_port_open ? "open" : style.bad("closed"), t.bus_frames_sent,
                      t.bus_frames_received, t.bus_frames_dropped);
  return text;
}

std::string details(const void* telemetry, const Style& style) {
  const lss_TalarisTelemetry& t = sample(telemetry);
  std::string text = style.dim("valve  enabled  pulses   open so far") + "\n";
  for (const lss_TalarisValve& v : t.valves) {
    text += fmt::format("{}      {:<8} {:>6} {:>11} s\n", style.bold(fmt::format("{}", v.id)),
                        v.enabled ? "yes" : "no", v.pulses, fixed(v.fired_s, 2));
  }
  text += fmt::format("edges  {}, the worst {} us behind its time\n", t.edges,
                      fixed(t.edge_worst_s * 1e6, 0));
  text += fmt::format(
      "bias   gyros {}, {}, {} deg/s; accelerometers {}, {}, {} m/s2\n",
      fixed(t.gyro_bias_rad_s[0] / kDegree, 3), fixed(t.gyro_bias_rad_s[1] / kDegree, 3),
      fixed(t.gyro_bias_rad_s[2] / kDegree, 3), fixed(t.accelerometer_bias_m_s2[0], 3),
      fixed(t.accelerometer_bias_m_s2[1], 3), fixed(t.accelerometer_bias_m_s2[2], 3));
  return text;
}

std::string progress(const void* telemetry) {
  const lss_TalarisTelemetry& t = sample(telemetry);
  switch (static_cast<Mode>(t.mode)) {
    case Mode::calibrate:
      return fmt::format(" {:.0f} %, keep still", t.calibrated_share * 100);
    case Mode::execute: {
      const Angles a = angles(t.attitude_wxyz);
      return fmt::format(" {}: {}, pitch {}, yaw {} deg, gas {} left",
                         name_of(lss::talaris::kPhaseNames, t.phase), flight(t),
                         fixed(a.pitch_rad / kDegree, 1), fixed(a.yaw_rad / kDegree, 1),
                         fixed(t.gas_left_thruster_s, 1));
    }
    case Mode::script:
      return fmt::format(" step {} of {}, {} s", t.script_done, t.script_steps,
                         fixed(t.script_s - lss::talaris::kScriptLead_s, 1));
    default:
      return "";
  }
}

}  // namespace

const Vehicle kVehicle{
    .name = "talaris",
    .commands = lss::talaris::kCommands,
    .subjects = lss::talaris::kSubjectNames,
    .help = kHelp,
    .telemetry = &lss_TalarisTelemetry_desc,
    .allowed = allowed_by(lss::talaris::logic, lss::talaris::kModeNames),
    .prepare = prepare,
    .rest = static_cast<std::uint16_t>(CommandKind::manual),
    .problems = problems,
    .json = telemetry_json,
    .screen = screen,
    .details = details,
    .progress = progress,
    .distance_m = [](const void* telemetry) { return sample(telemetry).position_m[2]; },
    .at_rest = "everything shut",
    .add_report = add_report,
    .takes_s = takes_s,
    .add_verbs = add_verbs,
    .composed = kComposed,
    .tunables = [] { return lss::talaris::tuning().infos; },
    .script = script_commands,
    .codes = lss::talaris::kOwnCodes,
};

}  // namespace lss::cli::talaris
