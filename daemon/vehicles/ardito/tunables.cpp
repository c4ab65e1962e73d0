#include "daemon/vehicles/ardito/tunables.h"

#include "idl/angles.h"

namespace lss::ardito {
namespace {

using P = Parameters;
using Place = TunablePlace;

constexpr double kMs = 1e6, kS = 1e9;  // to ns
constexpr Change kAlways = Change::always, kAtRest = Change::at_rest;

constexpr auto kTunables = std::to_array<Tunable<P>>({
    {{"mobility.heading_limit_deg", "deg", 0.5, 5, kAtRest, false,
      "of the motion against the rover"},
     kDegree,
     [](P& p) -> Place { return &p.mobility.max_sigma_rad; }},
    {{"mobility.ratio_p", "", 0, 10, kAtRest, false,
      "controllers that let all wheels, and all steering motors, settle together"},
     1,
     [](P& p) -> Place { return &p.mobility.proportional; }},
    {{"mobility.ratio_i", "1/s", 0, 100, kAtRest, false, "the same"},
     1,
     [](P& p) -> Place { return &p.mobility.integral_1_s; }},
    {{"mobility.correction_sign", "", -1, 1, kAtRest, true,
      "of the correction of wheel speeds on uneven ground; 0: none"},
     1,
     [](P& p) -> Place { return &p.mobility.correction_sign; }},
    {{"mobility.motor_temperature_degC", "degC", 0, 200, kAlways, false,
      "hotter motors are reported"},
     1,
     [](P& p) -> Place { return &p.mobility.warm_temperature_C; }},
    {{"mobility.motor_cutoff_degC", "degC", 0, 200, kAlways, false,
      "hotter motors are taken out: clutch open, motor off"},
     1,
     [](P& p) -> Place { return &p.mobility.max_temperature_C; }},
    {{"mobility.motor_current", "", 0.1, 10, kAlways, false,
      "times the rated one, longer than a second: the same as a failed motor"},
     1,
     [](P& p) -> Place { return &p.mobility.max_current; }},
    {{"mobility.steering_current", "", 0.1, 10, kAlways, false, "the same of a steering motor"},
     1,
     [](P& p) -> Place { return &p.mobility.max_steering_current; }},
    {{"mobility.deceleration_m_s2", "m/s2", 0.05, 2, kAtRest, false,
      "of every stop but emergencies"},
     1,
     [](P& p) -> Place { return &p.mobility.deceleration_m_s2; }},
    {{"mobility.slip_limit", "", 0.2, 0.95, kAlways, false,
      "share of the wheels' speed that is lost: the rover is stuck, and stops"},
     1,
     [](P& p) -> Place { return &p.mobility.slip_share; }},
    {{"mobility.slip_load", "", 0.02, 1, kAlways, false,
      "times the rated current above no load: motors of wheels that slip draw more"},
     1,
     [](P& p) -> Place { return &p.mobility.slip_load; }},
    {{"mobility.lost_wheels", "", 0, 2, kAlways, true,
      "so many may be out of work without an error"},
     1,
     [](P& p) -> Place { return &p.mobility.max_lost_wheels; }},
    {{"bus.wheel_rated_A", "A", 0.1, 100, kAlways, false,
      "what 1000 per mille of a wheel's current are, for people"},
     1,
     [](P& p) -> Place { return &p.wheel_current_A; }},
    {{"bus.steering_rated_A", "A", 0.1, 100, kAlways, false, "the same of the steering"},
     1,
     [](P& p) -> Place { return &p.steering_current_A; }},
    {{"safety.beacon_s", "s", 0, 60, kAtRest, false,
      "the lamp runs for so long before the motors go on"},
     kS,
     [](P& p) -> Place { return &p.beacon_ns; }},
    {{"safety.autonomy_s", "s", 0, 60, kAtRest, false,
      "the lamp flashes for so long before the rover drives by itself"},
     kS,
     [](P& p) -> Place { return &p.autonomy_ns; }},
    {{"safety.max_speed_m_s", "m/s", 0.1, 1, kAtRest, false,
      "no limit is above it: 0.5 at the ERC"},
     1,
     [](P& p) -> Place { return &p.mobility.top_speed_m_s; }},
    {{"safety.io_silent_ms", "ms", 150, 5000, kAlways, false,
      "no message of the emergency-stop button for so long: emergency"},
     kMs,
     [](P& p) -> Place { return &p.io_silent_ns; }},
    {{"solve.budget_s", "s", 3, 600, kAlways, false, "for one strategy of error solving"},
     kS,
     [](P& p) -> Place { return &p.solver.budget_ns; }},
    {{"bus.reset_s", "s", 1, 120, kAlways, false,
      "a node that a command resets has to answer again within it"},
     kS,
     [](P& p) -> Place { return &p.reset_ns; }},
});
constexpr auto kInfos = infos_of(kTunables);

void derive(P&) {}

const char* check(const P& p) { return gnc::ardito::check(p.mobility); }

constexpr Tuning<P> kTuning{kTunables, kInfos, derive, check};

}  // namespace

const Tuning<Parameters>& tuning() noexcept { return kTuning; }

}  // namespace lss::ardito
