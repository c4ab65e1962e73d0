#include "tests/ardito/chain/fmea.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "idl/angles.h"
#include "idl/ardito/codes.h"
#include "tests/ardito/chain/chain.h"

namespace lss::ardito {
namespace {

using sim::ardito::PlantKind;

// A rover that drives, and the first deviation from what is expected.
class Broken {
 public:
  struct Setup {
    double speed_m_s = 0.4;
    double heading_rad = 0;
    bool by_itself = false;
    sim::ardito::RoverOptions rover{.plant = PlantKind::kinematic};
    std::vector<const char*> before{};  // faults from the beginning
  };

  Broken() : Broken(Setup{}) {}
  explicit Broken(const Setup& setup)
      : chain({.rover = setup.rover, .seed = 3, .adjust = [](Parameters& p) {
                 p.beacon_ns = p.autonomy_ns = 1500 * kMillisecond;  // they cost time
               }}) {
    for (const char* fault : setup.before) chain.inject(fault);
    if (!chain.start()) wrong("does not start");
    chain.send(CommandKind::drive,
               {setup.speed_m_s, setup.heading_rad, 1.0, setup.by_itself ? 1.0 : 0.0});
    if (!chain.run_until(Mode::running, 20)) wrong("does not drive");
    chain.run(3);
    if (chain.supervisor().fault_count != 0) wrong("a fault before anything was broken");
  }

  Broken& breaks(const char* fault) {
    chain.inject(fault);
    return *this;
  }
  Broken& steers(double heading_rad) {
    chain.send(CommandKind::drive, {0.4, heading_rad, 1.0, 0.0});
    return *this;
  }
  Broken& finds(FaultId id, std::uint16_t subject, double limit_s) {
    if (!chain.run_until([&] { return chain.has(id, subject); }, limit_s))
      wrong(fmt::format("no fault {} of {} within {} s", info(id)->name, subject, limit_s));
    return *this;
  }
  // Five wheels, or all with another sensor.
  Broken& drives_on() {
    chain.run(2);
    if (chain.mode() != Mode::running) wrong("does not drive on");
    if (speed() < 0.25) wrong(fmt::format("goes {:.2f} m/s only", speed()));
    return *this;
  }
  Broken& isolated(std::size_t wheel) {
    const lss_ArditoWheel& w = chain.telemetry().wheels[wheel - 1];
    if (w.clutch || !w.stopped) wrong("the wheel is not taken out");
    return *this;
  }
  Broken& emergency(double limit_s = 1) {
    if (!chain.run_until(State::fatal_error, limit_s)) wrong("no FatalError");
    return rests();
  }
  Broken& rests(double limit_s = 3) {
    if (!chain.run_until([&] { return speed() < 0.02; }, limit_s)) wrong("does not come to rest");
    return *this;
  }
  Broken& expects(bool is, const char* what) {
    if (!is) wrong(what);
    return *this;
  }
  double speed() const { return chain.world().rover().body().velocity_m_s.norm(); }
  bool told(EventId id) const {
    return std::ranges::any_of(
        chain.events, [&](const EventRecord& e) { return e.id == static_cast<std::uint16_t>(id); });
  }
  operator std::string() const { return wrong_; }

  Chain chain;

 private:
  void wrong(const std::string& what) {
    if (wrong_.empty()) wrong_ = what;
  }
  std::string wrong_;
};

constexpr double kLeft = -3 * kDegree, kRight = 3 * kDegree;

// A wheel's sensor that is substituted.
std::function<std::string()> sensor(const char* fault) {
  return [=] {
    return std::string(Broken().breaks(fault).finds(faults::wheel_sensor, 3, 2).drives_on());
  };
}
std::function<std::string()> taken_out(const char* fault, FaultId id, double limit_s) {
  return [=] {
    Broken rover;
    return std::string(rover.breaks(fault).finds(id, 4, limit_s).drives_on().isolated(4));
  };
}
// Broken in a curve to the left and steered to the right.
std::function<std::string()> steering(const char* fault, FaultId id, bool fatal) {
  return [=] {
    Broken rover({.heading_rad = kLeft});
    rover.breaks(fault).steers(kRight).finds(id, 7, 6);
    return std::string(fatal ? rover.emergency() : rover.drives_on());
  };
}
std::function<std::string()> rocker(const char* fault) {
  return [=] {
    return std::string(Broken().breaks(fault).finds(faults::rocker_lost, kIoNode, 1).drives_on());
  };
}
// By a plausible angle, for ever: found over a long way.
std::function<std::string()> wrong_angle(const char* fault) {
  return [=] {
    return std::string(Broken().breaks(fault).finds(faults::rocker_lost, kIoNode, 60).drives_on());
  };
}
std::function<std::string()> cut(const char* fault, FaultId id, std::uint16_t subject) {
  return [=] { return std::string(Broken().breaks(fault).finds(id, subject, 3).emergency()); };
}

std::string silent_commander() {
  Broken rover;
  rover.chain.lease_ms = 1000;
  rover.steers(0);
  rover.chain.run(0.5);
  rover.chain.heartbeat(false);
  rover.expects(rover.chain.run_until(State::idle, 5), "no safe stop");
  return rover.expects(!rover.chain.has(FaultId::emergency_stop), "an emergency").rests();
}
std::string dead(Chain::Daemon how) {
  Broken rover;
  rover.chain.daemon = how;
  return rover.rests(1.5);
}
std::string upset(std::size_t instances) {
  Broken rover;
  for (std::size_t i = 1; i <= instances; ++i) {
    gnc::ardito::Parameters other;
    other.proportional = 0.2 * static_cast<double>(i);
    rover.chain.instances().instance(i) = gnc::ardito::MobilityController(other);
  }
  if (instances == 1) return rover.finds(faults::instance_disagreed, 0, 0.5).drives_on();
  return rover.finds(faults::no_majority, 0, 0.5).emergency();
}
std::string blocked() {
  Broken rover({.speed_m_s = 0.3, .rover = {.step_height_m = 0.150, .step_at_m = 2.6}});
  rover.finds(faults::rover_stuck, 0, 12);
  rover.expects(rover.chain.run_until(Mode::stopped, 3), "does not stop");
  return rover.expects(rover.told(events::slip_begun), "slip is not reported")
      .expects(!rover.chain.has(faults::imu_lost, kImuNode), "blames the IMU");
}
std::string bent() {
  Broken rover({.speed_m_s = 0.5, .before = {"bracket-bent:1:30", "bracket-bent:5:-30"}});
  return rover.finds(faults::yaw_disagrees, 0, 20).drives_on();
}
std::string warm() {
  Broken rover;
  rover.breaks("motor-hot:4:95").finds(FaultId::temperature_warning, 4, 3).drives_on();
  return rover.expects(!rover.chain.telemetry().wheels[3].stopped, "taken out");
}
std::string imu(const char* fault, bool by_itself) {
  Broken rover({.by_itself = by_itself});
  rover.breaks(fault).finds(faults::imu_lost, kImuNode, 4);
  if (!by_itself) return rover.drives_on();
  rover.expects(rover.chain.run_until(Mode::stopped, 4), "does not stop");
  return rover.expects(rover.told(events::autonomy_ended), "no event");
}
std::string embedded() {
  sim::ardito::RoverOptions ground{.soil = sim::soil::parse_soil("regolith")};
  ground.patches.push_back(sim::ardito::parse_patch("sand:0.1@4@2.5..100"));
  Broken rover({.speed_m_s = 0.3, .rover = ground});
  rover.finds(faults::wheel_embedded, 4, 15);
  rover.expects(rover.chain.run_until(Mode::stopped, 3), "does not stop");
  rover.expects(rover.told(events::stopped_embedded), "no event").rests();
  rover.expects(rover.chain.drive(-0.3), "no way back");
  rover.chain.run(2);
  return rover.expects(rover.chain.supervisor().fault_count == 0, "a fault on the way back");
}
// As a rover that is blocked: climbing motors push, too.
std::string imu_zero_uphill() {
  Broken rover({.rover = {.slope_rad = 5 * kDegree}});
  rover.breaks("imu-jump:-400").finds(faults::rover_stuck, 0, 3);
  return rover.expects(rover.chain.run_until(Mode::stopped, 3), "does not stop");
}

std::string lamp() {
  Chain chain({.rover = {.plant = PlantKind::kinematic}});
  chain.run(6);
  chain.send(lss::CommandKind::start, {0});
  const double from_s = chain.seconds();
  const auto on = [&] { return chain.orders().wheel[0].enabled; };
  bool lit = true;
  chain.run_until(
      [&] {
        lit = lit && (chain.orders().beacon || chain.seconds() < from_s + 0.2);
        return on();
      },
      10);
  if (!on() || !lit) return "the lamp is dark, or the motors stay off";
  return chain.seconds() - from_s >= 5 ? "" : "earlier than 5 s";
}
std::string flash() {
  Chain chain({.rover = {.plant = PlantKind::kinematic}});
  if (!chain.start()) return "does not start";
  chain.run(10);
  chain.send(CommandKind::drive, {0.4, 0.0, 1.0, 1.0});
  const double from_s = chain.seconds();
  bool dark = false;
  chain.run_until(
      [&] {
        dark = dark || (chain.seconds() > from_s + 0.2 && !chain.orders().beacon);
        return chain.mode() == Mode::running;
      },
      10);
  if (!dark) return "does not flash";
  return chain.mode() == Mode::running && chain.seconds() - from_s >= 5 ? "" : "earlier than 5 s";
}
std::string button() {
  Broken rover;
  rover.breaks("e-stop-button").finds(faults::emergency_button, kIoNode, 1).emergency();
  rover.chain.send(lss::CommandKind::solve);
  rover.chain.run(40);
  rover.expects(rover.chain.state() == State::fatal_error, "solved while it is pressed");
  rover.breaks("clear:e-stop-button");
  rover.chain.run(1);
  rover.chain.send(lss::CommandKind::solve);
  return rover.expects(rover.chain.run_until(State::idle, 40), "not solved");
}
std::string cap() {
  Broken rover;
  rover.chain.acks.clear();
  rover.chain.send(CommandKind::drive, {0.6, 0.0, 1.0, 0.0});
  rover.chain.run(0.3);
  const auto refused = [](const Ack& ack) {
    return ack.phase == Phase::rejected && ack.verdict.reason == reasons::over_cap &&
           ack.verdict.measured == 0.6 && ack.verdict.limit == 0.5;
  };
  return rover.expects(std::ranges::any_of(rover.chain.acks, refused), "0.6 m/s is not refused")
      .expects(rover.speed() < 0.5, "too fast");
}
// From the beginning: reported, `start` refused for this reason.
std::string unfit(const char* fault, FaultId id, Reason reason) {
  Chain chain({.rover = {.plant = PlantKind::kinematic}});
  chain.inject(fault);
  chain.run(9);
  if (id != FaultId::none && !chain.has(id, 2)) return "no fault";
  chain.send(lss::CommandKind::start, {0});
  chain.run(0.3);
  return !chain.acks.empty() && chain.acks.back().verdict.reason == reason
             ? ""
             : "start is not refused, or for another reason";
}
std::string drop_outs() {
  Broken rover;
  for (int n = 0; n < 4; ++n) {
    rover.breaks("drive-drop:0x02");
    rover.chain.run(1.25);
  }
  return rover.expects(rover.told(EventId::drive_dropped_out), "no event")
      .finds(FaultId::drive_drops_out, 2, 1)
      .emergency();
}
std::string harmless(const char* fault) {
  Broken rover;
  rover.breaks(fault).drives_on();
  return rover.expects(rover.chain.supervisor().fault_count == 0, "a fault");
}

const std::vector<FailureMode> kWheels = {
    {"motor_stuck", "7.1.1", "motor burnt",
     "motor and wheel do not follow, their sensors agree (state 3)", "wheel out; `wheel_motor`",
     taken_out("TM:4", faults::wheel_motor, 3)},
    {"motor_without_torque", "7.1.1", "motor burnt",
     "no current while the others work; clutch probe", "the same",
     taken_out("TM:4:1", faults::wheel_motor, 6)},
    {"motor_warm", "7.1.1", "", "above `motor_temperature_degC`", "`temperature_warning`", warm},
    {"motor_hot", "7.1.1", "", "above `motor_cutoff_degC`", "wheel out; `wheel_motor`",
     taken_out("motor-hot:4:107", faults::wheel_motor, 5)},
    {"motor_over_current", "7.1.1", "", "above `motor_current` for 1 s", "the same",
     taken_out("encoder-jump:0x04:4:2500", faults::wheel_motor, 3)},
    {"clutch_open", "7.1.2", "always open", "wheel rolls along at no-load current (state 5), probe",
     "wheel out; `wheel_clutch`", taken_out("TC:4", faults::wheel_clutch, 6)},
    {"gear_jammed", "7.1.3", "", "motor turns with its clutch open, wheel does not (state 4)",
     "wheel out; `wheel_gear`; emergency when it lasts",
     [] {
       return std::string(Broken().breaks("TRG:4").finds(faults::wheel_gear, 4, 3).emergency(3));
     }},
    {"gear_coupling_lost", "7.1.3", "", "as `clutch_open`", "wheel out; `wheel_clutch`",
     taken_out("TRG:4:1", faults::wheel_clutch, 6)},
    {"no_grip", "7.1.4, 7.1.5", "grousers without grip, rover blocked",
     "[slip](gnc-ardito.md#slip-or-a-wrong-imu)",
     "event `slip_begun`, odometry by the IMU; above `slip_limit` for 1.2 s safe stop, "
     "`rover_stuck`",
     blocked},
    {"wheel_embedded", "7.1.4", "one wheel digs itself in",
     "[depth, load and slip](gnc-ardito.md#one-wheel-digs-itself-in), 0.4 s; **not** less deep, "
     "nor without an IMU or suspension angles",
     "safe stop, `wheel_embedded`; the way back is free", embedded},
    {"", "7.1.4 to 7.1.9", "torn grouser; skin, cylinders, hub, slewing ring", "mechanical", ""},
    {"motor_encoder_dead", "7.1.10", "",
     "alone differs from Hall, reduction encoder, command (state 1)",
     "Hall sensors instead; `wheel_sensor`", sensor("E-TM:3")},
    {"motor_encoder_wrong", "7.1.10", "", "the same", "the same", sensor("E-TM:3:500")},
    {"hall_dead", "7.1.11", "", "alone differ (state 1)", "motor encoder instead; `wheel_sensor`",
     sensor("H-TM:3")},
    {"hall_wrong", "7.1.11", "", "the same", "the same", sensor("H-TM:3:500")},
    {"reduction_encoder_dead", "7.1.12", "", "alone differs, is 0 (state 2)",
     "motor encoder by the gear ratio; `wheel_sensor`", sensor("E-TRG:3")},
    {"reduction_encoder_wrong", "7.1.12", "", "alone differs; motor load or IMU contradicts it",
     "the same", sensor("E-TRG:3:12")},
};

const std::vector<FailureMode> kSteeringModes = {
    {"bracket_bent", "7.2.1", "two of one side, 30 deg",
     "IMU yaw rate against the inverse model over 5 s; only large angles, as in the thesis",
     "`yaw_disagrees`", bent},
    {"steering_motor_burnt", "7.2.2", "", "both encoders agree, not with the command (state 3)",
     "emergency `steering_critical`", steering("SM:1", faults::steering_critical, true)},
    {"steering_over_current", "7.2.2", "", "above `steering_current` for 1 s", "the same",
     [] {
       return std::string(Broken()
                              .breaks("encoder-jump:0x11:3:2500")
                              .finds(faults::steering_critical, 7, 3)
                              .emergency());
     }},
    {"steering_gear_jammed", "7.2.3", "", "both encoders stand (state 3), or current", "the same",
     steering("SRG:1", faults::steering_critical, true)},
    {"steering_coupling_lost", "7.2.3", "",
     "motor follows, wheel does not (state 2): looks like its encoder", "`steering_sensor`",
     steering("SRG:1:1", faults::steering_sensor, false)},
    {"steering_motor_encoder", "7.2.4", "wrong or dead", "stands alone (state 1)",
     "reduction encoder instead; `steering_sensor`",
     steering("E-SM:1", faults::steering_sensor, false)},
    {"steering_reduction_encoder", "7.2.5", "wrong or dead", "stands alone (state 2)",
     "motor encoder by the gear ratio; `steering_sensor`",
     steering("E-SRG:1", faults::steering_sensor, false)},
    {"", "7.2.6", "support", "mechanical", ""},
};

const std::vector<FailureMode> kRockerModes = {
    {"torsion_bar_jumps", "7.3.1", "encoder jumps", "0.5 rad in a frame: faster than a rocker",
     "5 s without correction to uneven ground; `rocker_lost` (the thesis stops)",
     rocker("rocker-encoder:1:0.8")},
    {"torsion_bar_impossible", "7.3.1", "encoder wrong", "beyond the range of the suspension",
     "the same, while it lasts", rocker("rocker-encoder:1:2")},
    {"torsion_bar_wrong", "7.3.1", "encoder wrong, plausible",
     "[mean over 20 m](gnc-ardito.md#suspension); **not** a smaller error, nor on shorter ways "
     "(the thesis: needs a second encoder)",
     "no correction, no wheel counts as dug in, while it lasts; `rocker_lost`. Before, "
     "`wheel_embedded` without cause, or not",
     wrong_angle("encoder-jump:0x20:1:900")},
    {"bogie_wrong", "7.3.2", "encoder wrong, plausible", "the same", "the same",
     wrong_angle("encoder-jump:0x20:3:-1800")},
    {"left_bogie_jumps", "7.3.2", "encoder jumps", "0.5 rad in a frame", "as `torsion_bar_jumps`",
     rocker("rocker-encoder:2:0.8")},
    {"right_bogie_jumps", "7.3.2", "encoder jumps", "the same", "the same",
     rocker("rocker-encoder:3:0.8")},
    {"suspension_silent", "7.3.1, 7.3.2", "encoders silent",
     "heartbeat of the node, 300 ms; age of values, 0.25 s",
     "emergency `module_silent` (the node has the stop button)",
     cut("node-silent:0x20", FaultId::module_silent, kIoNode)},
    {"", "7.3.3 to 7.3.7", "slewing rings, hub, rocker arm, torsion bar", "mechanical", ""},
};

const std::vector<FailureMode> kLogicModes = {
    {"encoder_logic_silent", "7.5.1", "", "heartbeat of the node, 300 ms; age of values",
     "emergency `module_silent`", cut("node-silent:0x03", FaultId::module_silent, 3)},
    {"driver_fault", "7.5.2", "", "CiA 402 state", "emergency `drive_fault`",
     cut("drive-fault:0x03", FaultId::drive_fault, 3)},
    {"driver_drops_out", "7.5.2", "of operation enabled", "statusword against the order",
     "event `drive_dropped_out`; four in 10 s: emergency `drive_drops_out`", drop_outs},
    {"cycle_halted", "7.5.3", "controller silent", "bus thread: orders older than 300 ms",
     "quick stop of all drives", [] { return dead(Chain::Daemon::halted); }},
    {"computer_dead", "7.5.3", "controller silent, process or computer dead",
     "nodes: master's heartbeat, 300 ms; systemd's watchdog", "nodes stop by themselves",
     [] { return dead(Chain::Daemon::killed); }},
    {"controller_upset", "7.5.3", "wrong values",
     "three instances, compared bit by bit each frame; gate",
     "the majority overwrites the other; `instance_disagreed`", [] { return upset(1); }},
    {"controllers_upset", "7.5.3", "two instances at once", "no majority",
     "emergency `no_majority`", [] { return upset(2); }},
    {"commander_silent", "7.6.1, 7.6.3, 7.8", "main CPU, switch or radio silent",
     "heartbeat of who commands (lease), of anyone (link)", "safe stop; emergency after 30 s",
     silent_commander},
    {"power_lost", "7.6.2", "battery management cuts the motors", "motor power good, link voltage",
     "emergency `power_lost`", cut("power-bad", faults::power_lost, kIoNode)},
};

const std::vector<FailureMode> kSensorModes = {
    {"imu_silent", "7.7.1", "manual drive", "heartbeat, age, standing counter",
     "`imu_lost`; no slip detection", [] { return imu("imu-silent", false); }},
    {"imu_stuck", "7.7.1", "manual drive", "standing counter", "the same",
     [] { return imu("imu-stuck", false); }},
    {"imu_wrong", "7.7.1", "manual drive",
     "[velocity against that of agreeing wheels](gnc-ardito.md#slip-or-a-wrong-imu); small errors "
     "of direction look like sliding on a slope",
     "the same", [] { return imu("imu-jump:800", false); }},
    {"imu_silent_autonomous", "7.7.2", "", "as in manual drive",
     "safe stop, back to manual; `imu_lost`", [] { return imu("imu-silent", true); }},
    {"imu_wrong_autonomous", "7.7.2", "", "the same", "the same",
     [] { return imu("imu-jump:800", true); }},
    {"imu_zero_uphill", "7.7", "IMU speed towards 0, 5 deg straight uphill",
     "**not** distinguished from turning wheels: climbing motors push too, the IMU reports no "
     "pitch",
     "safe stop; `rover_stuck` names both causes", imu_zero_uphill},
    {"", "7.4, 7.5.4, 7.9", "arm, cameras", "not of the Locomotion Sub-System", ""},
};

const std::vector<FailureMode> kSafetyModes = {
    {"lamp", "3", "5 s before any operation", "", "mode Warning: beacon on, no drive enabled",
     lamp},
    {"lamp_flashes", "2", "autonomous operation 5 s after its activation at the earliest", "",
     "the lamp flashes, the rover stands for `autonomy_s`", flash},
    {"button", "3", "stop button cuts everything until reset", "",
     "FatalError until `solve`, rejected while pressed", button},
    {"cap", "10", "never above 0.5 m/s (ERC), 1 m/s (URC)", "",
     "`max_speed_m_s`, limit chosen at `start`: guards `over_cap`, `over_limit`; controller; gate",
     cap},
};

const std::vector<FailureMode> kBusModes = {
    {"node_missing", "", "", "boot of the CANopen master", "`start` rejected: never heard",
     [] { return unfit("node-silent:0x02", FaultId::none, Reason::never_heard); }},
    {"node_wrong", "", "another type", "device type",
     "`node_wrong`; `start` rejected: not as configured",
     [] { return unfit("wrong-device-type:0x02", FaultId::node_wrong, Reason::not_configured); }},
    {"node_refuses", "", "its configuration", "SDO abort of a needed object",
     "`node_refuses`; `start` rejected: not as configured",
     [] { return unfit("sdo-abort:0x02", FaultId::node_refuses, Reason::not_configured); }},
    {"node_without_optional", "", "object missing", "SDO abort: no such object", "done without",
     [] { return std::string(Broken({.before = {"no-object:2:0x1029"}}).drives_on()); }},
    {"node_restarts", "", "while driving", "boot-up message",
     "emergency `module_reset`; configured again at standstill",
     cut("node-reboot:0x03", FaultId::module_reset, 3)},
    {"wrong_length", "", "PDOs", "mapping",
     "counted, not used; values age: emergency `stale_input`",
     cut("wrong-pdo-length:0x03", FaultId::stale_input, 3)},
    {"foreign_frames", "", "unknown nodes", "identifier", "counted, not used",
     [] { return harmless("foreign-frames:200"); }},
    {"babble", "", "", "above 100 frames in 100 ms", "ignored; emergency `module_silent`",
     cut("babble:0x03", FaultId::module_silent, 3)},
    {"emcy_storm", "", "", "count", "limited events, counted",
     [] { return harmless("emcy-storm:0x03:50"); }},
};

const std::array kSections = {
    FailureSection{"Wheels (7.1)", kWheels,
                   "Several at once: without two sensors (state 6) the wheel works on; clutch and "
                   "sensor (7) stop its motor; all sensors (8) are an\nemergency, as are more lost "
                   "wheels than `lost_wheels`.\n"},
    FailureSection{"Steering (7.2)", kSteeringModes, ""},
    FailureSection{"Rocker-bogie (7.3)", kRockerModes, ""},
    FailureSection{"Logic, power, links (7.5, 7.6, 7.8)", kLogicModes,
                   "Wrong values of 7.5.1 and 7.5.2: the comparisons of 7.1 and 7.2.\n"},
    FailureSection{"Position sensor, cameras, arm (7.7, 7.9, 7.4)", kSensorModes, ""},
    FailureSection{"Safety requirements (part III, 10)", kSafetyModes, ""},
    FailureSection{"Bus, in addition to the thesis", kBusModes,
                   "Not in this chain, which has no port: emergencies `bus_off`, `port_lost` "
                   "(tests/ardito/daemon/safety_test.cpp). Resets by\ncommand: "
                   "tests/ardito/daemon/reset_test.cpp.\n"},
};

}  // namespace

std::span<const FailureSection> failure_sections() { return kSections; }

}  // namespace lss::ardito
