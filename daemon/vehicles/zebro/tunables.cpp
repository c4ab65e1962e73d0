#include "daemon/vehicles/zebro/tunables.h"

#include <algorithm>
#include <cmath>

namespace lss::zebro {
namespace {

using P = Parameters;
using L = gnc::zebro::LocomotionParameters;
using S = SolverParameters;

// A module stops itself at 1.7 A (docs/icd-zebro.md section 7).
constexpr double kBelowHardware = 0.9, kMostCurrent_A = 1.5;
static_assert(kMostCurrent_A <= kBelowHardware * 1.7);

constexpr Change kAlways = Change::always, kAtRest = Change::at_rest;

constexpr std::array kTunables{
    tunable<&P::current_limit_A>("limits.current_A", "A", 0.05, kMostCurrent_A, kAlways,
                                 "a motor that draws more for current_time_ms is an emergency"),
    tunable<&P::current_time_ns>("limits.current_time_ms", "ms", 0, 10'000, kAlways,
                                 "time for which a motor may draw more than limits.current_A"),
    tunable<&P::total_limit_A>(
        "limits.total_A", "A", 0.05, 100, kAlways,
        "all motors together that draw more for current_time_ms are an emergency"),
    tunable<&P::temperature_warning_degC>("limits.temperature_warning_degC", "degC", -50, 150,
                                          kAlways, "a hotter module is reported"),
    tunable<&P::module_silent_ns>("bus.module_silent_ms", "ms", 50, 7900, kAlways,
                                  "a module without a reply for so long is an emergency"),
    tunable<&P::locomotion, &L::flight_s>("gait.flight_s", "s", 0.1, 60, kAtRest,
                                          "a leg in the air"),
    tunable<&P::locomotion, &L::stance_min_s>("gait.stance_min_s", "s", 0.1, 60, kAtRest,
                                              "shortest time of a leg on the ground"),
    tunable<&P::locomotion, &L::double_stance_s>(
        "gait.double_stance_s", "s", 0, 10, kAtRest,
        "time from one group's touchdown to the next group's lift-off"),
    tunable<&P::locomotion, &L::start_delay_s>("gait.start_delay_s", "s", 0.1, 10, kAtRest,
                                               "time from the command to the first lift-off"),
    tunable<&P::locomotion, &L::stand_up_s>("motion.stand_up_s", "s", 0.5, 60, kAtRest,
                                            "time to push the body up"),
    tunable<&P::locomotion, &L::lay_down_s>("motion.lay_down_s", "s", 0.5, 60, kAtRest,
                                            "time to let the body down"),
    tunable<&P::locomotion, &L::lift_s>(
        "motion.lift_s", "s", 0.5, 60, kAtRest,
        "time to turn the legs through the air to where standing up begins"),
    tunable<&P::locomotion, &L::align_s>("motion.align_s", "s", 0.2, 60, kAtRest,
                                         "time to turn all legs in stance to straight down"),
    tunable<&P::locomotion, &L::arrived_rad>("motion.arrived_deg", "deg", 0.1, 20, kAtRest,
                                             "a leg this close to its target has arrived"),
    tunable<&P::locomotion, &L::late_limit_s>("motion.late_limit_s", "s", 0.5, 60, kAtRest,
                                              "a movement this late has failed"),
    tunable<&P::locomotion, &L::swing_limit_rad_s>("motion.swing_limit_deg_s", "deg/s", 10, 720,
                                                   kAtRest, "largest speed of a leg"),
    tunable<&P::soil_share>(
        "ground.soil_share", "", 0.05, 1, kAlways,
        "above this share of the legs' current in soil (docs/soil.md) the vehicle rows; 1: never"),
    tunable<&P::panel_deployed_rad>("panel.deployed_deg", "deg", 10, 350, kAtRest,
                                    "position of the deployed panel"),
    tunable<&P::panel_move_ns>("panel.move_s", "s", 1, 60, kAtRest,
                               "time of the panel from one end to the other"),
    tunable<&P::solver, &S::budget_ns>("solve.budget_s", "s", 2, 600, kAlways,
                                       "time for one strategy of error solving"),
    tunable<&P::solver, &S::cool_down_ns>("solve.cool_down_s", "s", 2, 3600, kAlways,
                                          "time for the strategy cool_down"),
    tunable<&P::solver, &S::cool_degC>("solve.cool_degC", "degC", -50, 150, kAlways,
                                       "the strategy cool_down waits until modules are not hotter"),
    tunable<&P::solver, &S::rounds>(
        "solve.rounds", "", 1, 1000, kAlways,
        "how often the same fault may be solved before a person must repair the module"),
    tunable<&P::solver, &S::healthy_ns>("solve.healthy_s", "s", 1, 3600, kAlways,
                                        "healthy operation after which rounds count from 0 again"),
    tunable<&P::reset_ns>("bus.reset_s", "s", 1, 120, kAlways,
                          "a module must answer within this time after a commanded reset"),
};

void derive(P& p) { p.solver.current_limit_A = p.current_limit_A; }

const char* check(const P& p) {
  if (const char* wrong = check_currents(p)) return wrong;
  if (const char* wrong = check_panel(p)) return wrong;
  if (const char* wrong = check_stop(p)) return wrong;
  return gnc::zebro::check(p.locomotion);
}

constexpr Tuning<P> kTuning{kTunables, kInfosOf<kTunables>, derive, check};

}  // namespace

const Tuning<Parameters>& tuning() noexcept { return kTuning; }

const char* check_currents(const Parameters& p) noexcept {
  return p.total_limit_A <= kBelowHardware * p.power_limit_A
             ? nullptr
             : "the limit of all motors together must be 10 % below that of the Power sub-system, "
               "power_A";
}

// The gate would close.
const char* check_panel(const Parameters& p) noexcept {
  const double move_s = static_cast<double>(p.panel_move_ns) * 1e-9;
  return p.panel_deployed_rad <= p.locomotion.swing_limit_rad_s * move_s
             ? nullptr
             : "the panel would turn faster than motion.swing_limit_deg_s: make move_s longer";
}

double safe_stop_s(const Parameters& p) noexcept {
  const gnc::zebro::LocomotionParameters& l = p.locomotion;
  return std::max(l.flight_s, l.lift_s + l.stand_up_s) + l.align_s + l.lay_down_s;
}

TimeNs usual_lease_ns(const Parameters& p) noexcept {
  constexpr TimeNs kOfClients = 2 * kSecond;
  return std::max(kOfClients, p.lease_min_ns);
}

double longest_lease_ms(const Parameters& p) noexcept {
  return std::round(static_cast<double>(p.obc_timeout_ns) * 1e-6 - safe_stop_s(p) * 1e3);
}

const char* check_stop(const Parameters& p) noexcept {
  return safe_stop_s(p) <= static_cast<double>(p.obc_timeout_ns - usual_lease_ns(p)) * 1e-9
             ? nullptr
             : "a safe stop would take longer than link.obc_timeout_s less the usual lease, 2 s or "
               "lease_min_ms: make obc_timeout_s longer";
}

}  // namespace lss::zebro
