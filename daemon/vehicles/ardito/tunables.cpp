#include "daemon/vehicles/ardito/tunables.h"

#include <algorithm>

namespace lss::ardito {
namespace {

using P = Parameters;
using M = gnc::ardito::Parameters;
using S = SolverParameters;

constexpr Change kAlways = Change::always, kAtRest = Change::at_rest;

constexpr std::array kTunables{
    tunable<&P::mobility, &M::max_sigma_rad>(
        "mobility.heading_limit_deg", "deg", 0.5, 5, kAtRest,
        "largest angle between motion and rover; larger orders are rejected"),
    tunable<&P::mobility, &M::proportional>(
        "mobility.ratio_p", "", 0, 10, kAtRest,
        "controller with which all wheels, and all steering motors, settle together"),
    tunable<&P::mobility, &M::integral_1_s>("mobility.ratio_i", "1/s", 0, 100, kAtRest,
                                            "integral of the same controller"),
    tunable<&P::mobility, &M::correction_sign>(
        "mobility.correction_sign", "", -1, 1, kAtRest,
        "sign of the correction of wheel speeds on uneven ground; 0: none", true),
    tunable<&P::mobility, &M::warm_temperature_C>("mobility.motor_temperature_degC", "degC", 0, 200,
                                                  kAlways, "hotter motors are reported"),
    tunable<&P::mobility, &M::max_temperature_C>(
        "mobility.motor_cutoff_degC", "degC", 0, 200, kAlways,
        "hotter motors are taken out of service: clutch open, motor off"),
    tunable<&P::mobility, &M::max_current>(
        "mobility.motor_current", "", 0.1, 10, kAlways,
        "a wheel motor with more than this times its rated current for a second has failed"),
    tunable<&P::mobility, &M::max_steering_current>(
        "mobility.steering_current", "", 0.1, 10, kAlways,
        "a steering motor with more than this times its rated current for a second has failed"),
    tunable<&P::mobility, &M::deceleration_m_s2>("mobility.deceleration_m_s2", "m/s2", 0.05, 2,
                                                 kAtRest,
                                                 "deceleration of every stop except emergencies"),
    tunable<&P::mobility, &M::slip_share>(
        "mobility.slip_limit", "", 0.2, 0.95, kAlways,
        "above this share of the wheels' speed lost, the rover is stuck and stops"),
    tunable<&P::mobility, &M::slow_share>(
        "mobility.slip_slows", "", 0.15, 0.95, kAlways,
        "above this share of the wheels' speed lost, the rover drives slower than commanded"),
    tunable<&P::mobility, &M::slow_factor>(
        "mobility.slip_speed", "", 0.2, 1, kAlways,
        "share of the commanded speed that it then drives with; 1: as commanded"),
    tunable<&P::mobility, &M::slip_load>(
        "mobility.slip_load", "", 0.02, 1, kAlways,
        "slipping wheels draw more than this times the rated current above no load"),
    tunable<&P::mobility, &M::sink_m>("mobility.sink_limit_m", "m", 0.03, 0.5, kAlways,
                                      "a wheel lower than the plane of the others by more, whose "
                                      "motor pushes harder, has dug itself in"),
    tunable<&P::mobility, &M::max_lost_wheels>("mobility.lost_wheels", "", 0, 2, kAlways,
                                               "more lost wheels are an emergency"),
    tunable<&P::wheel_current_A>("bus.wheel_rated_A", "A", 0.1, 100, kAlways,
                                 "rated current of a wheel motor, to show currents in A"),
    tunable<&P::steering_current_A>("bus.steering_rated_A", "A", 0.1, 100, kAlways,
                                    "rated current of a steering motor, to show currents in A"),
    tunable<&P::beacon_ns>("safety.beacon_s", "s", 0, 60, kAtRest,
                           "time for which the lamp is on before the motors are switched on"),
    tunable<&P::autonomy_ns>("safety.autonomy_s", "s", 0, 60, kAtRest,
                             "time for which the lamp flashes before autonomous driving"),
    tunable<&P::mobility, &M::top_speed_m_s>("safety.max_speed_m_s", "m/s", 0.1, 1, kAtRest,
                                             "largest speed limit that can be chosen; ERC: 0.5"),
    tunable<&P::io_silent_ns>(
        "safety.io_silent_ms", "ms", 150, 5000, kAlways,
        "no message of the emergency-stop button for this time is an emergency"),
    tunable<&P::solver, &S::budget_ns>("solve.budget_s", "s", 3, 600, kAlways,
                                       "time for one strategy of error solving"),
    tunable<&P::reset_ns>("bus.reset_s", "s", 1, 120, kAlways,
                          "a node must answer within this time after a commanded reset"),
};

const char* check(const P& p) {
  const char* wrong = gnc::ardito::check(p.mobility);
  return wrong != nullptr ? wrong : check_ramp(p);
}

constexpr Tuning<P> kTuning{.tunables = kTunables, .infos = kInfosOf<kTunables>, .check = check};

}  // namespace

const Tuning<Parameters>& tuning() noexcept { return kTuning; }

// An emergency stop must not brake less than any other; a wheel that lags behind looks failed.
const char* check_ramp(const Parameters& p) noexcept {
  const gnc::ardito::Geometry& g = p.mobility.geometry;
  const double ramp_rad_s2 =
      p.bus.wheel_acceleration_rpm_s * gnc::ardito::kRadPerSecondPerRpm / g.gear_ratio;
  return ramp_rad_s2 * g.wheel_radius_m >=
                 std::max(kAcceleration_m_s2, p.mobility.deceleration_m_s2)
             ? nullptr
             : "bus.wheel_acceleration_rpm_s is at the ground less than 1 m/s2, or than "
               "mobility.deceleration_m_s2: a quick stop takes too long; make it larger";
}

}  // namespace lss::ardito
