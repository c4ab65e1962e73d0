#include "daemon/vehicles/zebro/tunables.h"

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
                                 "a leg that draws more for current_time_ms is an emergency"),
    tunable<&P::current_time_ns>("limits.current_time_ms", "ms", 0, 10'000, kAlways,
                                 "how long it may draw more"),
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
                                              "a leg on the ground, at least"),
    tunable<&P::locomotion, &L::double_stance_s>(
        "gait.double_stance_s", "s", 0, 10, kAtRest,
        "from one group's touchdown to the next group's lift-off"),
    tunable<&P::locomotion, &L::start_delay_s>("gait.start_delay_s", "s", 0.1, 10, kAtRest,
                                               "from the command to the first lift-off"),
    tunable<&P::locomotion, &L::stand_up_s>("motion.stand_up_s", "s", 0.5, 60, kAtRest,
                                            "pushing the body up"),
    tunable<&P::locomotion, &L::lay_down_s>("motion.lay_down_s", "s", 0.5, 60, kAtRest,
                                            "letting it down"),
    tunable<&P::locomotion, &L::lift_s>("motion.lift_s", "s", 0.5, 60, kAtRest,
                                        "legs through the air to where standing up begins"),
    tunable<&P::locomotion, &L::align_s>("motion.align_s", "s", 0.2, 60, kAtRest,
                                         "all legs in stance to straight down"),
    tunable<&P::locomotion, &L::arrived_rad>("motion.arrived_deg", "deg", 0.1, 20, kAtRest,
                                             "a leg this close to its target has arrived"),
    tunable<&P::locomotion, &L::late_limit_s>("motion.late_limit_s", "s", 0.5, 60, kAtRest,
                                              "a movement this late has failed"),
    tunable<&P::locomotion, &L::swing_limit_rad_s>("motion.swing_limit_deg_s", "deg/s", 10, 720,
                                                   kAtRest, "the fastest a leg may turn"),
    tunable<&P::soil_share>("ground.soil_share", "", 0.05, 1, kAlways,
                            "of a leg's current in soil, where the belly would touch it: with more "
                            "of all legs it rows; 1: never"),
    tunable<&P::panel_deployed_rad>("panel.deployed_deg", "deg", 10, 350, kAtRest,
                                    "where the panel is deployed"),
    tunable<&P::panel_move_ns>("panel.move_s", "s", 1, 60, kAtRest, "from one end to the other"),
    tunable<&P::solver, &S::budget_ns>("solve.budget_s", "s", 2, 600, kAlways,
                                       "for one strategy of error solving"),
    tunable<&P::solver, &S::cool_down_ns>("solve.cool_down_s", "s", 2, 3600, kAlways,
                                          "for the strategy cool_down"),
    tunable<&P::solver, &S::cool_degC>("solve.cool_degC", "degC", -50, 150, kAlways, "cool enough"),
    tunable<&P::solver, &S::rounds>("solve.rounds", "", 1, 1000, kAlways,
                                    "of solving the same fault, then a person is needed"),
    tunable<&P::solver, &S::healthy_ns>("solve.healthy_s", "s", 1, 3600, kAlways,
                                        "of operation, after which rounds count again from 0"),
    tunable<&P::reset_ns>("bus.reset_s", "s", 1, 120, kAlways,
                          "a module that a command resets has to answer again within it"),
};

void derive(P& p) { p.solver.current_limit_A = p.current_limit_A; }

const char* check(const P& p) {
  if (const char* wrong = check_currents(p)) return wrong;
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

}  // namespace lss::zebro
