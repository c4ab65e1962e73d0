// Requirements on the scout's locomotion controller, as properties of its states, steps and events:
// lss-lc explores all states of the table that ships (docs/verification.md).

#include "modes.h"
#include "tools/lss-lc/common.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::scout {
namespace {

using namespace lc::common;

bool moves(S s) { return in_mode(s, {Mode::driving, Mode::stopping}); }
bool slows_down(T t) {
  return moves(t.before) ? to(t, Mode::stopping) && does(t, kHalt) : idle(t.result.next);
}

constexpr std::array kOwnStates = {
    StateProperty{
        "the scout drives only while somebody holds authority", "safety",
        [](const lc::Table&, S s) { return !in_mode(s, Mode::driving) || link(s, lc::kHeld); }},
    StateProperty{
        "it is on its way off exactly while it slows down", "safety",
        [](const lc::Table&, S s) { return in_mode(s, Mode::stopping) == (s.goal != 0); }},
};
constexpr std::array kOwnSteps = {
    StepProperty{"motors go on only from Idle, by start", "safety", lc::kChange | lc::kActions,
                 [](T t) {
                   const bool enters = !operational(t.before) && operational(t.result.next);
                   return enters == does(t, kMotorsOn) &&
                          (!enters || t.happening.event == event::start);
                 }},
};
constexpr std::array kOwnContracts = {
    next_strategy_contract<next_strategy>(),
    lease_expired_contract<slows_down>(),
    Contract{"start", event::start, [](S s, unsigned) { return can_start(s); },
             [](T t) { return to(t, Mode::enabling) && held_after(t); }},
    Contract{"stop", event::stop, [](S s, unsigned) { return !fatal(s); },
             [](T t) {
               if (solving(t.before)) return breaks_off(t);
               return idle(t.before) ? keeps(t) : slows_down(t);
             }},
    Contract{"drive", event::drive,
             [](S s, unsigned) { return in_mode(s, Mode::ready) || moves(s); },
             [](T t) { return to(t, Mode::driving) && does(t, kDrive) && held_after(t); }},
    Contract{"motors confirmed", event::motors_confirmed,
             [](S s, unsigned) { return in_mode(s, Mode::enabling); },
             [](T t) { return to(t, Mode::ready); }},
    Contract{"stands", event::stands, [](S s, unsigned) { return in_mode(s, Mode::stopping); },
             [](T t) { return idle(t.result.next) && does(t, lc::kMotorsOff); }},
};
constexpr auto kStates = lc::join(lc::common::kStates, kOwnStates);
constexpr auto kSteps = lc::join(lc::common::kSteps, kOwnSteps);
constexpr auto kContracts = lc::join(lc::common::kContracts, kOwnContracts);

Happening help(S s) {
  if (const auto any = help_any(s)) return *any;
  return {in_mode(s, Mode::stopping) ? event::stands : event::stop, 0};
}
constexpr std::array kReturns = {return_to_idle<help>()};
constexpr const char* kGoals[] = {"none", "idle"};

lc::Model model_of(const lc::Table& table, std::uint16_t modules) {
  return lc::model_of<kStates, kSteps>(table, modules, kDuties, kContracts, kReturns);
}

}  // namespace
}  // namespace lss::scout

LSS_VERIFIED(scout, .title = "the scout", .modules = (1u << scout::kDrives) - 1,
             .few = (1u << scout::kDrives) - 1, .flag_names = {},
             .module_names = scout::kDriveNames)
