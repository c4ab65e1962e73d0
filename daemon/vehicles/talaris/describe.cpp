// Telemetry of TALARIS.

#include <algorithm>

#include "daemon/vehicles/talaris/vehicle.h"

namespace lss::talaris {
namespace {

template <std::size_t N>
void put(const std::array<double, N>& from, double (&to)[N]) noexcept {
  std::ranges::copy(from, to);
}
void put(const gnc::talaris::Vector3& v, double (&to)[3]) noexcept {
  put(std::array{v.x(), v.y(), v.z()}, to);
}
double seconds(TimeNs time) noexcept { return static_cast<double>(time) * 1e-9; }

}  // namespace

bool Vehicle::describe(const lss::Inputs<Vehicle>& in, const SupervisorState& state,
                       Telemetry& out) noexcept {
  const lc::ControllerState& c = state.controller;
  out.time_ns = in.time_ns;
  out.frame = in.frame;
  out.state = static_cast<std::uint8_t>(c.state);
  out.mode = c.mode;
  out.program = static_cast<std::uint8_t>(program_);
  out.gains = static_cast<std::uint8_t>(flight_.gains());
  out.calibrated = (c.flags & kCalibrated) != 0;
  out.planned = (c.flags & kPlanned) != 0;
  out.calibrated_share = navigation_.aligned() ? 1 : navigation_.calibration().progress;
  describe_flight(out);
  describe_actuators(out);
  describe_modules(out);
  for (lss_TalarisFan& fan : out.fans) fan.armed = (c.flags & kFansArmed) != 0;
  out.script_id = script_.id();
  out.script_steps = script_.steps();
  out.script_done = script_.done();
  out.script_s = script_.elapsed_s();
  return data_requested_;
}

void Vehicle::describe_flight(Telemetry& out) const noexcept {
  const gnc::talaris::NavState& nav = navigation_.state();
  const gnc::talaris::NavCounters& counters = navigation_.counters();
  const gnc::talaris::FlightOutput& f = output_;
  put(nav.position_N_m, out.position_m);
  put(nav.velocity_N_m_s, out.velocity_m_s);
  put(std::array{nav.q_NB.w(), nav.q_NB.x(), nav.q_NB.y(), nav.q_NB.z()}, out.attitude_wxyz);
  put(nav.rate_B_rad_s, out.rate_rad_s);
  put(nav.acceleration_N_m_s2, out.acceleration_m_s2);
  put(nav.position_sigma_m, out.position_sigma_m);
  put(nav.attitude_sigma_rad, out.attitude_sigma_rad);
  put(nav.gyro_bias_rad_s, out.gyro_bias_rad_s);
  put(nav.accelerometer_bias_m_s2, out.accelerometer_bias_m_s2);
  out.innovation_m = counters.innovation_m;
  out.ranges_used = counters.ranges_used;
  out.ranges_gated = counters.ranges_gated;
  out.range_m = sensors_.range_age_s() < 1e6 ? sensors_.range_m() : 0;

  out.phase = static_cast<std::uint8_t>(f.phase);
  out.airborne = f.airborne;
  out.phase_s = f.phase_s;
  const double left_s = flight_.planned().total_s - seconds(now_ns_ - executed_ns_);
  out.remaining_s = flight_.active() ? std::max(0.0, left_s) : 0;
  put(f.target_N_m, out.target_position_m);
  put(f.target_N_m_s, out.target_velocity_m_s);
  put(f.force_N, out.thrust_N);
  put(f.attitude_error_rad, out.attitude_error_rad);
  out.suspicion = f.suspicion;
  out.gas_thruster_s = f.gas_used_s;
  out.gas_left_thruster_s = f.gas_left_s;
}

void Vehicle::describe_actuators(Telemetry& out) const noexcept {
  const GasState& gas = sensors_.gas();
  const double kPa = sensors_.gas_age_s() < 1e6 ? 1e3 : 0;
  put(kPa > 0 ? std::array{sensors_.tank_kPa() * kPa, sensors_.regulated_kPa() * kPa}
              : std::array{0.0, 0.0},
      out.pressure_Pa);
  out.voltage_V = gas.voltage_V;
  out.temperature_degC = gas.temperature_degC;
  put(sensors_.load_N(), out.load_N);
  put(sensors_.load_Nm(), out.load_Nm);
  const EdgeReport& edges = bus_.edges;
  static_assert(std::extent_v<decltype(out.valves)> == kHopperValves &&
                std::extent_v<decltype(out.fans)> == kHopperFans &&
                std::extent_v<decltype(out.modules)> == kModuleCount);
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    out.valves[i] = {.id = static_cast<std::uint8_t>(i + 1),
                     .enabled = (enabled_ >> i & 1u) != 0,
                     .open = (edges.open >> i & 1u) != 0,
                     .on_s = seconds(sent_.pulse[i].on_ns),
                     .delay_s = seconds(sent_.pulse[i].delay_ns),
                     .health = static_cast<std::uint8_t>(output_.health[i]),
                     .fired_s = seconds(edges.counters.open_ns[i]),
                     .pulses = edges.counters.pulses[i]};
  }
  const bool execute = static_cast<Mode>(out.mode) == Mode::execute;
  constexpr double kRange_us = kFanFull_us - kFanOff_us;
  for (std::size_t i = 0; i < kHopperFans; ++i) {
    out.fans[i] = {.id = static_cast<std::uint8_t>(i + 1),
                   .armed = false,
                   .throttle = (sent_.fan_us[i] - kFanOff_us) / kRange_us,
                   .health = static_cast<std::uint8_t>(output_.health[kHopperValves + i]),
                   .target_rpm = execute ? output_.rpm_target[i] : hand_.target_rpm(i),
                   .rpm = sensors_.rpm()[i]};
  }
  out.edges = edges.counters.edges;
  out.edge_worst_s = seconds(edges.counters.worst_late_ns);
}

void Vehicle::describe_modules(Telemetry& out) const noexcept {
  const auto age_ms = [&](TimeNs heard_ns) {
    return heard_ns == 0 ? kNeverHeard_ms
                         : static_cast<std::uint64_t>(age_of(heard_ns) / kMillisecond);
  };
  const LineCounters& imu = bus_.imu.status.counters;
  const LineCounters& altimeter = bus_.altimeter.status.counters;
  out.modules[0] = {.id = kImuModule,
                    .online = !sensors_.imu_lost(),
                    .link = 0,
                    .age_ms = age_ms(sensors_.imu_ns()),
                    .samples = imu.packets,
                    .errors = imu.errors(),
                    .lost = sensors_.imu_lost_in_all()};
  out.modules[1] = {.id = kAltimeterModule,
                    .online = !sensors_.altimeter_lost(),
                    .link = 0,
                    .age_ms = age_ms(sensors_.altimeter_ns()),
                    .samples = altimeter.packets,
                    .errors = altimeter.errors(),
                    .lost = sensors_.range_errors_in_all()};
  for (std::size_t i = 0; i < kHopperNodes; ++i) {
    const canopen::NodeStatus& node = link(i).node;
    out.modules[i + 2] = {.id = static_cast<std::uint8_t>(i + kValveModule),
                          .online = answers(i),
                          .link = static_cast<std::uint8_t>(node.state),
                          .age_ms = age_ms(node.heartbeat_ns),
                          .samples = node.frames,
                          .errors = node.wrong_lengths,
                          .lost = node.losses};
  }
  const HopperCan::Report& can = bus_.can;
  out.imu_port_open = bus_.imu.open;
  out.altimeter_port_open = bus_.altimeter.open;
  out.can_port_open = can.open;
  out.bus_frames_sent = can.port.sent;
  out.bus_frames_received = can.port.received;
  out.bus_frames_dropped =
      can.port.foreign + can.port.cannelloni.broken() + can.status.counters.master.unknown_nodes +
      can.status.counters.master.unknown_frames + can.status.counters.master.other_masters +
      can.port.overflows + can.port.dropped_full + can.status.counters.overflows;
  // Samples of the sensors' lines, too: a queue was full, or radiation damaged them.
  for (const LineReport* line : {&bus_.imu, &bus_.altimeter, &bus_.camera, &bus_.standby})
    out.bus_frames_dropped += line->status.counters.overflows;
  out.bus_frames_dropped += bus_.corner_overflows;
  out.bus_offs = can.port.bus_offs;
}

}  // namespace lss::talaris
