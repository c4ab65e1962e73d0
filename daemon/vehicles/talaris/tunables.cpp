#include "daemon/vehicles/talaris/tunables.h"

namespace lss::talaris {
namespace {

using P = Parameters;
using F = gnc::talaris::Parameters;
using gnc::talaris::Fans;
using gnc::talaris::Gains;
using gnc::talaris::Gas;
using gnc::talaris::Limits;
using gnc::talaris::Profile;
using S = SolverParameters;

constexpr Change kAlways = Change::always, kAtRest = Change::at_rest;

constexpr std::array kTunables{
    tunable<&P::flight, &F::limits, &Limits::imu_hold_s>(
        "limits.imu_hold_s", "s", 0.05, 1, kAtRest,
        "longest silence of the IMU in flight without a descent"),
    tunable<&P::flight, &F::limits, &Limits::valve_age_s>(
        "limits.valve_age_s", "s", 0.2, 5, kAtRest,
        "the valve node is lost without a message for this time"),
    tunable<&P::flight, &F::limits, &Limits::fan_age_s>(
        "limits.fan_age_s", "s", 0.05, 5, kAtRest,
        "the fan node is lost without a message for this time"),
    tunable<&P::flight, &F::limits, &Limits::tilt_rad>("limits.tilt_deg", "deg", 6, 68, kAtRest,
                                                       "with a larger tilt the flight has failed"),
    tunable<&P::flight, &F::limits, &Limits::rate_rad_s>(
        "limits.rate_deg_s", "deg/s", 30, 450, kAtRest, "with larger rates the flight has failed"),
    tunable<&P::flight, &F::limits, &Limits::escape_m_s2>(
        "limits.escape_m_s2", "m/s2", 0.1, 3, kAtRest,
        "peak acceleration of the descent of an escape"),
    tunable<&P::flight, &F::limits, &Limits::blind_m_s>(
        "limits.blind_m_s", "m/s", 0.05, 1, kAtRest,
        "speed at the end of an escape without altimeter"),
    tunable<&P::flight, &F::limits, &Limits::parachute_m_s>(
        "limits.parachute_m_s", "m/s", 0.1, 2, kAtRest, "speed of the descent by fans"),
    tunable<&P::flight, &F::limits, &Limits::level_m_s>(
        "limits.level_m_s", "m/s", 0.1, 2, kAtRest,
        "speed of the descent by fans without attitude"),
    tunable<&P::flight, &F::limits, &Limits::contact_height_m>(
        "limits.contact_height_m", "m", 0.01, 0.5, kAtRest,
        "lower and slower than limits.contact_m_s: on the ground"),
    tunable<&P::flight, &F::limits, &Limits::contact_speed_m_s>(
        "limits.contact_m_s", "m/s", 0.01, 1, kAtRest, "largest speed for contact by height"),
    tunable<&P::flight, &F::limits, &Limits::contact_m_s2>(
        "limits.contact_m_s2", "m/s2", 0.1, 5, kAtRest,
        "more acceleration than commanded, in descent: contact"),
    tunable<&P::flight, &F::limits, &Limits::run_down_s>("limits.run_down_s", "s", 0.2, 20, kAtRest,
                                                         "time for which fans run after touchdown"),
    tunable<&P::flight, &F::profile, &Profile::climb_m_s2>("profile.climb_m_s2", "m/s2", 0.05, 5,
                                                           kAtRest, "peak acceleration of a climb"),
    tunable<&P::flight, &F::profile, &Profile::descend_m_s2>(
        "profile.descend_m_s2", "m/s2", 0.05, 5, kAtRest, "peak acceleration of a descent"),
    tunable<&P::flight, &F::profile, &Profile::hover_s>(
        "profile.hover_s", "s", 0.2, 30, kAtRest, "time of hovering before and after the traverse"),
    tunable<&P::flight, &F::profile, &Profile::touchdown_height_m>(
        "profile.touchdown_height_m", "m", 0.02, 1, kAtRest, "height at which guidance ends"),
    tunable<&P::flight, &F::profile, &Profile::touchdown_speed_m_s>(
        "profile.touchdown_speed_m_s", "m/s", 0.02, 0.5, kAtRest, "speed at which guidance ends"),
    tunable<&P::flight, &F::gas, &Gas::reserve_s>("gas.reserve_s", "s", 0, 100, kAtRest,
                                                  "thruster-seconds that a plan must leave"),
    tunable<&P::flight, &F::gas, &Gas::min_regulated_kPa>(
        "gas.min_regulated_kPa", "kPa", 0, 10000, kAtRest,
        "with less pressure thrust is not reliable"),
    tunable<&P::min_voltage_V>("gas.min_voltage_V", "V", 0, 100, kAlways,
                               "with less voltage a flight is rejected; 0: not checked"),
    tunable<&P::flight, &F::fans, &Fans::spin_up_timeout_s>(
        "fans.spin_up_timeout_s", "s", 1, 60, kAtRest,
        "time for the fans to spin up; then a flight is cancelled on the ground"),
    tunable<&P::flight, &F::fans, &Fans::max_run_s>(
        "fans.max_run_s", "s", 5, 600, kAtRest,
        "longest time for which fans run: batteries and speed controllers get hot"),
    tunable<&P::flight, &F::gains, 0, &Gains::attitude_wn_rad_s>(
        "gains.1.attitude_wn_rad_s", "rad/s", 0.1, 4, kAtRest,
        "attitude by cold gas, first set of gains"),
    tunable<&P::flight, &F::gains, 0, &Gains::attitude_zeta>(
        "gains.1.attitude_zeta", "", 0.3, 2, kAtRest, "damping of the attitude by cold gas"),
    tunable<&P::flight, &F::gains, 0, &Gains::attitude_ki_1_s3>(
        "gains.1.attitude_ki_1_s3", "1/s3", 0.001, 5, kAtRest,
        "integral of the attitude by cold gas"),
    tunable<&P::flight, &F::gains, 0, &Gains::lateral_wn_rad_s>(
        "gains.1.lateral_wn_rad_s", "rad/s", 0.01, 1, kAtRest, "lateral position"),
    tunable<&P::flight, &F::gains, 0, &Gains::lateral_zeta>(
        "gains.1.lateral_zeta", "", 0.3, 2, kAtRest, "damping of the lateral position"),
    tunable<&P::flight, &F::gains, 0, &Gains::height_kp_1_s2>(
        "gains.1.height_kp_1_s2", "1/s2", 0.05, 5, kAtRest, "height by the fans"),
    tunable<&P::flight, &F::gains, 0, &Gains::height_ki_1_s3>(
        "gains.1.height_ki_1_s3", "1/s3", 0, 2, kAtRest, "integral of the height by the fans"),
    tunable<&P::flight, &F::gains, 0, &Gains::height_kd_1_s>(
        "gains.1.height_kd_1_s", "1/s", 0.1, 5, kAtRest, "damping of the height by the fans"),
    tunable<&P::flight, &F::gains, 0, &Gains::fan_attitude_pole_rad_s>(
        "gains.1.fan_attitude_pole_rad_s", "rad/s", 0.3, 4, kAtRest, "attitude by the fans"),
    tunable<&P::imu_silent_ns>("imu.silent_ms", "ms", 20, 1000, kAtRest,
                               "the IMU is lost without a packet for this time"),
    tunable<&P::imu_lost_per_s>("imu.lost_per_s", "1/s", 1, 200, kAlways,
                                "more lost packets in a second are a fault"),
    tunable<&P::altimeter_silent_ns>("altimeter.silent_ms", "ms", 200, 5000, kAtRest,
                                     "the altimeter is lost without a good reading for this time"),
    tunable<&P::solver, &S::budget_ns>("solve.budget_s", "s", 3, 600, kAlways,
                                       "time for one strategy of error solving"),
    tunable<&P::reset_ns>("bus.reset_s", "s", 1, 120, kAlways,
                          "a node must answer within this time after a commanded reset"),
};

void derive(P& p) {
  p.flight.limits.range_age_s = static_cast<double>(p.altimeter_silent_ns) * 1e-9;
}

const char* check(const P& p) {
  const char* wrong = gnc::talaris::check(p.navigation);
  return wrong != nullptr ? wrong : gnc::talaris::check(p.flight);
}

constexpr Tuning<P> kTuning{kTunables, kInfosOf<kTunables>, derive, check};

}  // namespace

const Tuning<Parameters>& tuning() noexcept { return kTuning; }

}  // namespace lss::talaris
