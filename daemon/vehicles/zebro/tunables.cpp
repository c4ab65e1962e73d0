#include "daemon/vehicles/zebro/tunables.h"

#include "idl/angles.h"

namespace lss::zebro {
namespace {

using P = Parameters;
using Place = TunablePlace;

// A module stops itself at 1.7 A (docs/icd-zebro.md section 7).
constexpr double kBelowHardware = 0.9, kMostCurrent_A = 1.5;
static_assert(kMostCurrent_A <= kBelowHardware * 1.7);

constexpr double kMs = 1e6, kS = 1e9;  // to ns
constexpr Change kAlways = Change::always, kAtRest = Change::at_rest;

constexpr auto kTunables = std::to_array<Tunable<P>>({
    {{"limits.current_A", "A", 0.05, kMostCurrent_A, kAlways, false,
      "a leg that draws more for current_time_ms is an emergency"},
     1,
     [](P& p) -> Place { return &p.current_limit_A; }},
    {{"limits.current_time_ms", "ms", 0, 10'000, kAlways, false, "how long it may draw more"},
     kMs,
     [](P& p) -> Place { return &p.current_time_ns; }},
    {{"limits.total_A", "A", 0.05, 100, kAlways, false,
      "all motors together that draw more for current_time_ms are an emergency"},
     1,
     [](P& p) -> Place { return &p.total_limit_A; }},
    {{"limits.temperature_warning_degC", "degC", -50, 150, kAlways, false,
      "a hotter module is reported"},
     1,
     [](P& p) -> Place { return &p.temperature_warning_degC; }},
    {{"bus.module_silent_ms", "ms", 50, 7900, kAlways, false,
      "a module without a reply for so long is an emergency"},
     kMs,
     [](P& p) -> Place { return &p.module_silent_ns; }},
    {{"gait.flight_s", "s", 0.1, 60, kAtRest, false, "a leg in the air"},
     1,
     [](P& p) -> Place { return &p.locomotion.flight_s; }},
    {{"gait.stance_min_s", "s", 0.1, 60, kAtRest, false, "a leg on the ground, at least"},
     1,
     [](P& p) -> Place { return &p.locomotion.stance_min_s; }},
    {{"gait.double_stance_s", "s", 0, 10, kAtRest, false,
      "from one group's touchdown to the next group's lift-off"},
     1,
     [](P& p) -> Place { return &p.locomotion.double_stance_s; }},
    {{"gait.start_delay_s", "s", 0.1, 10, kAtRest, false, "from the command to the first lift-off"},
     1,
     [](P& p) -> Place { return &p.locomotion.start_delay_s; }},
    {{"motion.stand_up_s", "s", 0.5, 60, kAtRest, false, "pushing the body up"},
     1,
     [](P& p) -> Place { return &p.locomotion.stand_up_s; }},
    {{"motion.lay_down_s", "s", 0.5, 60, kAtRest, false, "letting it down"},
     1,
     [](P& p) -> Place { return &p.locomotion.lay_down_s; }},
    {{"motion.lift_s", "s", 0.5, 60, kAtRest, false,
      "legs through the air to where standing up begins"},
     1,
     [](P& p) -> Place { return &p.locomotion.lift_s; }},
    {{"motion.align_s", "s", 0.2, 60, kAtRest, false, "all legs in stance to straight down"},
     1,
     [](P& p) -> Place { return &p.locomotion.align_s; }},
    {{"motion.arrived_deg", "deg", 0.1, 20, kAtRest, false,
      "a leg this close to its target has arrived"},
     kDegree,
     [](P& p) -> Place { return &p.locomotion.arrived_rad; }},
    {{"motion.late_limit_s", "s", 0.5, 60, kAtRest, false, "a movement this late has failed"},
     1,
     [](P& p) -> Place { return &p.locomotion.late_limit_s; }},
    {{"motion.swing_limit_deg_s", "deg/s", 10, 720, kAtRest, false, "the fastest a leg may turn"},
     kDegree,
     [](P& p) -> Place { return &p.locomotion.swing_limit_rad_s; }},
    {{"panel.deployed_deg", "deg", 10, 350, kAtRest, false, "where the panel is deployed"},
     1,
     [](P& p) -> Place { return &p.panel_deployed_deg; }},
    {{"panel.move_s", "s", 1, 60, kAtRest, false, "from one end to the other"},
     kS,
     [](P& p) -> Place { return &p.panel_move_ns; }},
    {{"solve.budget_s", "s", 2, 600, kAlways, false, "for one strategy of error solving"},
     kS,
     [](P& p) -> Place { return &p.solver.budget_ns; }},
    {{"solve.cool_down_s", "s", 2, 3600, kAlways, false, "for the strategy cool_down"},
     kS,
     [](P& p) -> Place { return &p.solver.cool_down_ns; }},
    {{"solve.cool_degC", "degC", -50, 150, kAlways, false, "cool enough"},
     1,
     [](P& p) -> Place { return &p.solver.cool_degC; }},
    {{"solve.rounds", "", 1, 1000, kAlways, true,
      "of solving the same fault, then a person is needed"},
     1,
     [](P& p) -> Place { return &p.solver.rounds; }},
    {{"solve.healthy_s", "s", 1, 3600, kAlways, false,
      "of operation, after which rounds count again from 0"},
     kS,
     [](P& p) -> Place { return &p.solver.healthy_ns; }},
    {{"bus.reset_s", "s", 1, 120, kAlways, false,
      "a module that a command resets has to answer again within it"},
     kS,
     [](P& p) -> Place { return &p.reset_ns; }},
});
constexpr auto kInfos = infos_of(kTunables);

void derive(P& p) { p.solver.current_limit_A = p.current_limit_A; }

const char* check(const P& p) {
  if (const char* wrong = check_currents(p)) return wrong;
  return gnc::zebro::check(p.locomotion);
}

constexpr Tuning<P> kTuning{kTunables, kInfos, derive, check};

}  // namespace

const Tuning<Parameters>& tuning() noexcept { return kTuning; }

const char* check_currents(const Parameters& p) noexcept {
  return p.total_limit_A <= kBelowHardware * p.power_limit_A
             ? nullptr
             : "the limit of all motors together must be 10 % below that of the Power sub-system, "
               "power_A";
}

}  // namespace lss::zebro
