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
  return rover.expects(rover.told(events::slip_begun), "slip is not told")
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
    {"motor_stuck", "7.1.1", "motor burnt: stuck",
     "motor and wheel do not follow the command while their sensors agree (state 3)",
     "clutch open, motor off; fault `wheel_motor`; five wheels go on",
     taken_out("TM:4", faults::wheel_motor, 3)},
    {"motor_without_torque", "7.1.1", "motor burnt: no torque",
     "no current while the others work; the clutch probe shows that the motor does not follow",
     "the same", taken_out("TM:4:1", faults::wheel_motor, 6)},
    {"motor_warm", "7.1.1", "motor too warm", "temperature above `motor_temperature_degC`",
     "fault `temperature_warning`; driving goes on", warm},
    {"motor_hot", "7.1.1", "motor too hot", "temperature above `motor_cutoff_degC`",
     "clutch open, motor off; fault `wheel_motor`; five wheels go on",
     taken_out("motor-hot:4:107", faults::wheel_motor, 5)},
    {"motor_over_current", "7.1.1", "motor draws too much",
     "current above `motor_current` for a second", "the same",
     taken_out("encoder-jump:0x04:4:2500", faults::wheel_motor, 3)},
    {"clutch_open", "7.1.2", "clutch always open",
     "wheel rolls along while the motor draws no-load current (state 5), proven by a probe",
     "motor off; fault `wheel_clutch`; five wheels go on",
     taken_out("TC:4", faults::wheel_clutch, 6)},
    {"gear_jammed", "7.1.3", "gear jammed",
     "the motor turns with its clutch open, the wheel does not (state 4)",
     "clutch open, motor off; fault `wheel_gear`; an error when it lasts: emergency",
     [] {
       return std::string(Broken().breaks("TRG:4").finds(faults::wheel_gear, 4, 3).emergency(3));
     }},
    {"gear_coupling_lost", "7.1.3", "gear lost its coupling", "as a clutch that transmits nothing",
     "motor off; fault `wheel_clutch`; five wheels go on",
     taken_out("TRG:4:1", faults::wheel_clutch, 6)},
    {"no_grip", "7.1.4, 7.1.5", "grousers without grip: the rover is blocked",
     "the wheels are faster than the rover by the IMU (slip) while the motors push or it does not "
     "turn as steered",
     "slip in telemetry, event `slip_begun`; above `slip_limit` for 1.2 s fault `rover_stuck` and "
     "a "
     "safe stop; odometry counts by the IMU",
     blocked},
    {"", "7.1.4, 7.1.5", "grouser torn off", "mechanical", ""},
    {"", "7.1.6 to 7.1.9", "skin, cylinders, hub, slewing ring", "mechanical", ""},
    {"motor_encoder_dead", "7.1.10", "motor encoder dead",
     "it alone differs from Hall, reduction encoder and command (state 1)",
     "Hall sensors take its place; fault `wheel_sensor`", sensor("E-TM:3")},
    {"motor_encoder_wrong", "7.1.10", "motor encoder wrong", "the same", "the same",
     sensor("E-TM:3:500")},
    {"hall_dead", "7.1.11", "Hall sensors dead", "the same for them (state 1)",
     "motor encoder goes on; fault `wheel_sensor`", sensor("H-TM:3")},
    {"hall_wrong", "7.1.11", "Hall sensors wrong", "the same", "the same", sensor("H-TM:3:500")},
    {"reduction_encoder_dead", "7.1.12", "reduction encoder dead",
     "it alone differs and is 0 (state 2)",
     "motor encoder through the gear ratio; fault `wheel_sensor`", sensor("E-TRG:3")},
    {"reduction_encoder_wrong", "7.1.12", "reduction encoder wrong",
     "it alone differs, and the motor's load or the IMU contradicts it", "the same",
     sensor("E-TRG:3:12")},
};

const std::vector<FailureMode> kSteeringModes = {
    {"bracket_bent", "7.2.1", "brackets bent (two of one side by 30 deg)",
     "yaw rate of the IMU against the inverse model, filtered over 5 s; as the thesis says, only a "
     "large angle shows",
     "fault `yaw_disagrees`; driving goes on", bent},
    {"steering_motor_burnt", "7.2.2", "motor burnt",
     "both encoders agree and do not follow the command (state 3)",
     "emergency: `steering_critical`", steering("SM:1", faults::steering_critical, true)},
    {"steering_over_current", "7.2.2", "motor draws too much",
     "current above `steering_current` for a second", "the same",
     [] {
       return std::string(Broken()
                              .breaks("encoder-jump:0x11:3:2500")
                              .finds(faults::steering_critical, 7, 3)
                              .emergency());
     }},
    {"steering_gear_jammed", "7.2.3", "gear jammed",
     "both encoders stand (state 3), or its current", "the same",
     steering("SRG:1", faults::steering_critical, true)},
    {"steering_coupling_lost", "7.2.3", "gear lost its coupling",
     "motor follows, the wheel does not (state 2): not distinguished from its encoder",
     "fault `steering_sensor`", steering("SRG:1:1", faults::steering_sensor, false)},
    {"steering_motor_encoder", "7.2.4", "motor encoder wrong, or dead",
     "it alone stands while the other turns (state 1)",
     "reduction encoder takes its place; fault `steering_sensor`",
     steering("E-SM:1", faults::steering_sensor, false)},
    {"steering_reduction_encoder", "7.2.5", "reduction encoder wrong, or dead",
     "it alone stands (state 2)", "motor encoder through the gear ratio; fault `steering_sensor`",
     steering("E-SRG:1", faults::steering_sensor, false)},
    {"", "7.2.6", "support", "mechanical", ""},
};

const std::vector<FailureMode> kRockerModes = {
    {"torsion_bar_jumps", "7.3.1", "torsion bar encoder jumps",
     "faster than a rocker turns: 0.5 rad in a frame",
     "no correction to uneven ground for 5 s; fault `rocker_lost`; driving goes on (the thesis "
     "stops: its correction has no other way)",
     rocker("rocker-encoder:1:0.8")},
    {"torsion_bar_impossible", "7.3.1", "torsion bar encoder wrong",
     "out of the range of the suspension; a plausible wrong angle cannot be detected (the thesis: "
     "a "
     "second encoder is needed)",
     "the same while it lasts", rocker("rocker-encoder:1:2")},
    {"left_bogie_jumps", "7.3.2", "bogie encoder, left", "the same", "the same",
     rocker("rocker-encoder:2:0.8")},
    {"right_bogie_jumps", "7.3.2", "bogie encoder, right", "the same", "the same",
     rocker("rocker-encoder:3:0.8")},
    {"suspension_silent", "7.3.1, 7.3.2", "encoders silent",
     "heartbeat of the node, 300 ms; age limit of the values, 0.25 s",
     "emergency: `module_silent` (the node has the emergency-stop button, too)",
     cut("node-silent:0x20", FaultId::module_silent, kIoNode)},
    {"", "7.3.3 to 7.3.7", "slewing rings, hub, rocker arm, torsion bar", "mechanical", ""},
};

const std::vector<FailureMode> kLogicModes = {
    {"encoder_logic_silent", "7.5.1", "encoder logic sends nothing",
     "heartbeat of the node, 300 ms; age limit of each value", "emergency: `module_silent`",
     cut("node-silent:0x03", FaultId::module_silent, 3)},
    {"driver_fault", "7.5.2", "motor driver in fault", "CiA 402 state", "emergency: `drive_fault`",
     cut("drive-fault:0x03", FaultId::drive_fault, 3)},
    {"driver_drops_out", "7.5.2", "motor driver drops out of operation enabled",
     "statusword, while enabled is ordered",
     "event `drive_dropped_out`; four in 10 s are an emergency, `drive_drops_out`", drop_outs},
    {"cycle_halted", "7.5.3", "mobility controller sends nothing: cycle halted",
     "the bus thread: orders older than 300 ms", "quick stop of all drives",
     [] { return dead(Chain::Daemon::halted); }},
    {"computer_dead", "7.5.3", "mobility controller sends nothing: process or computer dead",
     "nodes: heartbeat of the master, 300 ms; systemd's watchdog", "nodes stop by themselves",
     [] { return dead(Chain::Daemon::killed); }},
    {"controller_upset", "7.5.3", "mobility controller computes wrong values",
     "three instances, compared bit by bit in every frame; the gate",
     "the majority counts, the other is set to it; fault `instance_disagreed`",
     [] { return upset(1); }},
    {"controllers_upset", "7.5.3", "two instances at once", "no majority",
     "emergency: `no_majority`", [] { return upset(2); }},
    {"commander_silent", "7.6.1, 7.6.3, 7.8", "main CPU, network switch or radio silent",
     "heartbeat of who commands (lease), of anyone (link)", "safe stop; emergency after 30 s",
     silent_commander},
    {"power_lost", "7.6.2", "battery management cuts the motors", "motor power good, link voltage",
     "emergency: `power_lost`", cut("power-bad", faults::power_lost, kIoNode)},
};

const std::vector<FailureMode> kSensorModes = {
    {"imu_silent", "7.7.1", "IMU silent, manual drive", "heartbeat, age limit, standing counter",
     "fault `imu_lost`; driving goes on without slip detection",
     [] { return imu("imu-silent", false); }},
    {"imu_stuck", "7.7.1", "IMU frozen, manual drive", "its counter stands", "the same",
     [] { return imu("imu-stuck", false); }},
    {"imu_wrong", "7.7.1", "IMU wrong, manual drive",
     "its velocity against the inverse model of wheels that agree, when load and yaw rate do not "
     "speak for slip; a small error of direction cannot be distinguished from sliding down a slope",
     "the same", [] { return imu("imu-jump:800", false); }},
    {"imu_silent_autonomous", "7.7.2", "IMU silent, autonomous drive", "the same",
     "safe stop, back to driving by hand", [] { return imu("imu-silent", true); }},
    {"imu_wrong_autonomous", "7.7.2", "IMU wrong, autonomous drive", "the same", "the same",
     [] { return imu("imu-jump:800", true); }},
    {"imu_zero_uphill", "7.7", "IMU's speed fails towards 0, straight uphill (5 deg)",
     "not distinguished from wheels that turn in place: motors that climb push as well, and the "
     "IMU reports no pitch",
     "safe stop; fault `rover_stuck`, which names both causes", imu_zero_uphill},
    {"", "7.9", "cameras", "not of the Locomotion Sub-System", ""},
    {"", "7.4, 7.5.4", "arm", "not of the Locomotion Sub-System", ""},
};

const std::vector<FailureMode> kSafetyModes = {
    {"lamp", "3", "the lamp is active for 5 s before any operation", "",
     "mode Warning: beacon on, no drive enabled", lamp},
    {"lamp_flashes", "2", "autonomous operation starts 5 s after its activation at the earliest",
     "", "the lamp flashes and the rover stands for `autonomy_s` from the command on", flash},
    {"button", "3", "emergency-stop button cuts everything until reset", "",
     "FatalError until `solve`, refused while the button is in", button},
    {"cap", "10", "0.5 m/s (ERC) or 1 m/s (URC) are never exceeded", "",
     "`max_speed_m_s` of the configuration, limit chosen at `start`: guards `over_cap`, "
     "`over_limit`; limit in the controller; gate",
     cap},
};

const std::vector<FailureMode> kBusModes = {
    {"node_missing", "", "node missing", "boot of the CANopen master",
     "`start` is refused: it was never heard",
     [] { return unfit("node-silent:0x02", FaultId::none, Reason::never_heard); }},
    {"node_wrong", "", "node of another type", "its device type",
     "fault `node_wrong`; `start` is refused: not as configured",
     [] { return unfit("wrong-device-type:0x02", FaultId::node_wrong, Reason::not_configured); }},
    {"node_refuses", "", "node refuses its configuration", "SDO abort of an object that is needed",
     "fault `node_refuses`; `start` is refused: not as configured",
     [] { return unfit("sdo-abort:0x02", FaultId::node_refuses, Reason::not_configured); }},
    {"node_without_optional", "", "node without an optional object", "SDO abort: no such object",
     "it is done without",
     [] { return std::string(Broken({.before = {"no-object:2:0x1029"}}).drives_on()); }},
    {"node_restarts", "", "node restarts while driving", "boot-up message",
     "emergency: `module_reset`; configured again when it stands",
     cut("node-reboot:0x03", FaultId::module_reset, 3)},
    {"wrong_length", "", "PDOs of wrong length", "length against the mapping",
     "not used, counted; their values become old: emergency `stale_input`",
     cut("wrong-pdo-length:0x03", FaultId::stale_input, 3)},
    {"foreign_frames", "", "frames of unknown nodes", "identifier", "not used, counted",
     [] { return harmless("foreign-frames:200"); }},
    {"babble", "", "babbling node", "more than 100 frames in 100 ms",
     "not listened to; emergency `module_silent`", cut("babble:0x03", FaultId::module_silent, 3)},
    {"emcy_storm", "", "EMCY storm", "count", "limited events, counted",
     [] { return harmless("emcy-storm:0x03:50"); }},
};

const std::array kSections = {
    FailureSection{
        "Wheels (7.1)", kWheels,
        "Several at once are states 6 to 8: two sensors (6) are done without, clutch and "
        "sensor (7) stop the motor, all sensors (8)\nstop the motor and are an emergency. "
        "More lost wheels than `lost_wheels` are an emergency. Times of all of them:\n"
        "[ardito-results.md](ardito-results.md).\n"},
    FailureSection{"Steering (7.2)", kSteeringModes, ""},
    FailureSection{"Rocker-bogie (7.3)", kRockerModes, ""},
    FailureSection{"Logic, power, links (7.5, 7.6, 7.8)", kLogicModes,
                   "7.5.1 and 7.5.2 with wrong values are the comparisons of 7.1 and 7.2.\n"},
    FailureSection{"Position sensor, cameras, arm (7.7, 7.9, 7.4)", kSensorModes, ""},
    FailureSection{"Safety requirements (part III, 10)", kSafetyModes, ""},
    FailureSection{
        "Bus, in addition to the thesis", kBusModes,
        "Bus-off, and an interface that is down or gone, are no faults of this chain, "
        "which has no port: emergency `bus_off`,\n`port_lost`, shown by the safety suite "
        "(tests/ardito/daemon/safety_test.cpp). Resets by command:\n"
        "tests/ardito/daemon/reset_test.cpp.\n"},
};

}  // namespace

std::span<const FailureSection> failure_sections() { return kSections; }

}  // namespace lss::ardito
