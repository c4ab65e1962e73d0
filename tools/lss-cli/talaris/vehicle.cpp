#include "tools/lss-cli/talaris/vehicle.h"

#include <fmt/format.h>
#include <talaris_fields.h>  // of the IDL

#include <algorithm>
#include <cmath>

#include "daemon/config/config.h"
#include "idl/angles.h"
#include "idl/talaris/commands.h"
#include "tools/lss-cli/certify/wire.h"
#include "tools/lss-cli/session/overlay.h"
#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/talaris/verbs.h"

namespace lss::cli::talaris {
namespace {

using lss::talaris::CommandKind;
using lss::talaris::GncStep;
using lss::talaris::Mode;
using lss::talaris::Phase;

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

std::string module_row(const Vehicle& vehicle, const lss_TalarisModule& m, const Style& style) {
  const std::string name = style.bold(fmt::format("{:<10}", subject_name(vehicle, m.id)));
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

std::string screen(const Vehicle& vehicle, const lss_TalarisTelemetry& t, const Style& style) {
  std::string text = style.dim("module     link    last data     samples  errors   lost") + "\n";
  for (const lss_TalarisModule& module : t.modules) text += module_row(vehicle, module, style);
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

std::string progress(const lss_TalarisTelemetry& t) {
  switch (static_cast<Mode>(t.mode)) {
    case Mode::calibrate: return fmt::format(" {:.0f} %, keep still", t.calibrated_share * 100);
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
    default: return "";
  }
}

// docs/icd-talaris.md: valves and fans, and what the nodes send by their timers; section 1: the
// packet of 18 bytes that begins a frame.
certify::Wire wire(const config::Config& config, config::Section& own, std::int64_t bit_s) {
  constexpr std::int64_t kOurs[] = {2, 8}, kTheirs[] = {8, 8, 6, 6};
  certify::Wire wire = certify::of_can(kOurs, kTheirs, bit_s);
  const bool crossbow = own.section("imu").choice("kind", 0, {"landmark30", "crossbow"}) == 1;
  const auto imu = std::ranges::find(config.ports, "imu", &config::Port::name);
  if (imu != config.ports.end())
    wire.packet_us = certify::bits_us(18 * (crossbow ? 10 : 12), imu->baud);
  return wire;
}

}  // namespace

const Overlay kOverlay{
    .telemetry = view_of<lss_TalarisTelemetry, screen, progress>(lss_TalarisTelemetry_desc),
    .add_report = add_report,
    .add_verbs = add_verbs,
    .composed = kComposed,
    .scripts = {script_commands, kScriptParts},
    .wire = wire,
};

const Vehicle& vehicle() {
  static const Vehicle& built = *find_vehicle("talaris");
  return built;
}

}  // namespace lss::cli::talaris
