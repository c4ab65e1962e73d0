#include "daemon/vehicles/talaris/tunables.h"

#include "idl/angles.h"

namespace lss::talaris {
namespace {

using P = Parameters;
using Place = TunablePlace;

constexpr double kMs = 1e6, kS = 1e9;  // to ns
constexpr Change kAlways = Change::always, kAtRest = Change::at_rest;

constexpr auto kTunables = std::to_array<Tunable<P>>({
    {{"limits.imu_hold_s", "s", 0.05, 1, kAtRest, false,
      "silence of the IMU that is bridged in flight"},
     1,
     [](P& p) -> Place { return &p.flight.limits.imu_hold_s; }},
    {{"limits.valve_age_s", "s", 0.2, 5, kAtRest, false,
      "no message of the valve node for so long: lost"},
     1,
     [](P& p) -> Place { return &p.flight.limits.valve_age_s; }},
    {{"limits.fan_age_s", "s", 0.05, 5, kAtRest, false,
      "no message of the fan node for so long: lost"},
     1,
     [](P& p) -> Place { return &p.flight.limits.fan_age_s; }},
    {{"limits.tilt_deg", "deg", 6, 68, kAtRest, false, "above it the flight has failed"},
     kDegree,
     [](P& p) -> Place { return &p.flight.limits.tilt_rad; }},
    {{"limits.rate_deg_s", "deg/s", 30, 450, kAtRest, false, "the same of rates"},
     kDegree,
     [](P& p) -> Place { return &p.flight.limits.rate_rad_s; }},
    {{"limits.escape_m_s2", "m/s2", 0.1, 3, kAtRest, false,
      "peak acceleration of the way down of an escape"},
     1,
     [](P& p) -> Place { return &p.flight.limits.escape_m_s2; }},
    {{"limits.blind_m_s", "m/s", 0.05, 1, kAtRest, false, "the end of an escape without altimeter"},
     1,
     [](P& p) -> Place { return &p.flight.limits.blind_m_s; }},
    {{"limits.parachute_m_s", "m/s", 0.1, 2, kAtRest, false, "how fast down by the fans"},
     1,
     [](P& p) -> Place { return &p.flight.limits.parachute_m_s; }},
    {{"limits.level_m_s", "m/s", 0.1, 2, kAtRest, false, "the same without attitude"},
     1,
     [](P& p) -> Place { return &p.flight.limits.level_m_s; }},
    {{"limits.contact_height_m", "m", 0.01, 0.5, kAtRest, false,
      "below it and slow: on the ground"},
     1,
     [](P& p) -> Place { return &p.flight.limits.contact_height_m; }},
    {{"limits.contact_m_s", "m/s", 0.01, 1, kAtRest, false, "how slow"},
     1,
     [](P& p) -> Place { return &p.flight.limits.contact_speed_m_s; }},
    {{"limits.contact_m_s2", "m/s2", 0.1, 5, kAtRest, false,
      "more than commanded, on the way down: contact"},
     1,
     [](P& p) -> Place { return &p.flight.limits.contact_m_s2; }},
    {{"limits.run_down_s", "s", 0.2, 20, kAtRest, false, "fans after touchdown"},
     1,
     [](P& p) -> Place { return &p.flight.limits.run_down_s; }},
    {{"profile.climb_m_s2", "m/s2", 0.05, 5, kAtRest, false, "peak acceleration of a climb"},
     1,
     [](P& p) -> Place { return &p.flight.profile.climb_m_s2; }},
    {{"profile.descend_m_s2", "m/s2", 0.05, 5, kAtRest, false, "of a descent"},
     1,
     [](P& p) -> Place { return &p.flight.profile.descend_m_s2; }},
    {{"profile.hover_s", "s", 0.2, 30, kAtRest, false, "before and after the traverse"},
     1,
     [](P& p) -> Place { return &p.flight.profile.hover_s; }},
    {{"profile.touchdown_height_m", "m", 0.02, 1, kAtRest, false, "guidance ends here"},
     1,
     [](P& p) -> Place { return &p.flight.profile.touchdown_height_m; }},
    {{"profile.touchdown_speed_m_s", "m/s", 0.02, 0.5, kAtRest, false, "and with this speed"},
     1,
     [](P& p) -> Place { return &p.flight.profile.touchdown_speed_m_s; }},
    {{"gas.reserve_s", "s", 0, 100, kAtRest, false, "thruster-seconds that a plan leaves"},
     1,
     [](P& p) -> Place { return &p.flight.gas.reserve_s; }},
    {{"gas.min_regulated_kPa", "kPa", 0, 10000, kAtRest, false,
      "below it there is no thrust to count on"},
     1,
     [](P& p) -> Place { return &p.flight.gas.min_regulated_kPa; }},
    {{"gas.min_voltage_V", "V", 0, 100, kAlways, false,
      "below it nothing is flown; 0: not looked at"},
     1,
     [](P& p) -> Place { return &p.min_voltage_V; }},
    {{"fans.spin_up_timeout_s", "s", 1, 60, kAtRest, false,
      "then a flight is given up on the ground"},
     1,
     [](P& p) -> Place { return &p.flight.fans.spin_up_timeout_s; }},
    {{"fans.max_run_s", "s", 5, 600, kAtRest, false, "batteries and speed controllers get hot"},
     1,
     [](P& p) -> Place { return &p.flight.fans.max_run_s; }},
    {{"gains.1.attitude_wn_rad_s", "rad/s", 0.1, 4, kAtRest, false,
      "attitude by cold gas, first set of gains"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].attitude_wn_rad_s; }},
    {{"gains.1.attitude_zeta", "", 0.3, 2, kAtRest, false, "its damping"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].attitude_zeta; }},
    {{"gains.1.attitude_ki_1_s3", "1/s3", 0.001, 5, kAtRest, false, "its integral"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].attitude_ki_1_s3; }},
    {{"gains.1.lateral_wn_rad_s", "rad/s", 0.01, 1, kAtRest, false, "lateral position"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].lateral_wn_rad_s; }},
    {{"gains.1.lateral_zeta", "", 0.3, 2, kAtRest, false, "its damping"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].lateral_zeta; }},
    {{"gains.1.height_kp_1_s2", "1/s2", 0.05, 5, kAtRest, false, "height by the fans"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].height_kp_1_s2; }},
    {{"gains.1.height_ki_1_s3", "1/s3", 0, 2, kAtRest, false, "its integral"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].height_ki_1_s3; }},
    {{"gains.1.height_kd_1_s", "1/s", 0.1, 5, kAtRest, false, "its damping"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].height_kd_1_s; }},
    {{"gains.1.fan_attitude_pole_rad_s", "rad/s", 0.3, 4, kAtRest, false, "attitude by the fans"},
     1,
     [](P& p) -> Place { return &p.flight.gains[0].fan_attitude_pole_rad_s; }},
    {{"imu.silent_ms", "ms", 20, 1000, kAtRest, false, "no packet for so long: lost"},
     kMs,
     [](P& p) -> Place { return &p.imu_silent_ns; }},
    {{"imu.lost_per_s", "1/s", 1, 200, kAlways, true, "more lost packets than that are a fault"},
     1,
     [](P& p) -> Place { return &p.imu_lost_per_s; }},
    {{"altimeter.silent_ms", "ms", 200, 5000, kAtRest, false, "no good reading for so long: lost"},
     kMs,
     [](P& p) -> Place { return &p.altimeter_silent_ns; }},
    {{"solve.budget_s", "s", 3, 600, kAlways, false, "for one strategy of error solving"},
     kS,
     [](P& p) -> Place { return &p.solver.budget_ns; }},
    {{"bus.reset_s", "s", 1, 120, kAlways, false,
      "a node that a command resets has to answer again within it"},
     kS,
     [](P& p) -> Place { return &p.reset_ns; }},
});
constexpr auto kInfos = infos_of(kTunables);

void derive(P& p) {
  p.flight.limits.range_age_s = static_cast<double>(p.altimeter_silent_ns) * 1e-9;
}

const char* check(const P& p) {
  const char* wrong = gnc::talaris::check(p.navigation);
  return wrong != nullptr ? wrong : gnc::talaris::check(p.flight);
}

constexpr Tuning<P> kTuning{kTunables, kInfos, derive, check};

}  // namespace

const Tuning<Parameters>& tuning() noexcept { return kTuning; }

}  // namespace lss::talaris
