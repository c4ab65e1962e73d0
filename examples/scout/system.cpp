// Requirements on the scout's locomotion controller, as properties of its states, steps and events:
// lss-lc explores all states of the table that ships (docs/verification.md).

#include <fmt/format.h>

#include <bit>

#include "modes.h"
#include "tools/lss-lc/common.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::scout {
namespace {

using namespace lc::common;
using lc::Contract;
using lc::Event;

bool in_mode(S s, Mode mode) { return operational(s) && s.mode == static_cast<int>(mode); }
bool moves(S s) { return in_mode(s, Mode::driving) || in_mode(s, Mode::stopping); }
bool does(T t, lc::ActionSet action) { return (t.result.actions & action) != 0; }
bool slows_down(T t) {
  return moves(t.before) ? in_mode(t.result.next, Mode::stopping) && does(t, kHalt)
                         : idle(t.result.next);
}

constexpr std::array kOwnStates = {
    lc::StateProperty{
        "the scout drives only while somebody holds authority", "safety",
        [](const lc::Table&, S s) { return !in_mode(s, Mode::driving) || link(s, lc::kHeld); }},
    lc::StateProperty{
        "it is on its way off exactly while it slows down", "safety",
        [](const lc::Table&, S s) { return in_mode(s, Mode::stopping) == (s.goal != 0); }},
};
constexpr std::array kOwnSteps = {
    lc::StepProperty{"motors go on only from Idle, by start", "safety", lc::kChange | lc::kActions,
                     [](T t) {
                       const bool enters = !operational(t.before) && operational(t.result.next);
                       return enters == does(t, kMotorsOn) &&
                              (!enters || t.happening.event == event::start);
                     }},
};
constexpr std::array kOwnContracts = {
    Contract{"next strategy", Event::next_strategy,
             [](S s, unsigned) { return solving(s) && s.strategy < lc::kMaxStrategies; },
             [](T t) {
               return solving(t.result.next) && t.result.next.strategy == t.before.strategy + 1 &&
                      stops_motors(t.result.actions);
             }},
    Contract{"lease expired", Event::lease_expired,
             [](S s, unsigned) { return link(s, lc::kHeld); },
             [](T t) { return slows_down(t) && !held_after(t); }},
    Contract{"start", event::start,
             [](S s, unsigned) { return idle(s) && contact(s) && !link(s, lc::kObcSilent); },
             [](T t) { return in_mode(t.result.next, Mode::enabling) && held_after(t); }},
    Contract{"stop", event::stop, [](S s, unsigned) { return idle(s) || operational(s); },
             [](T t) { return idle(t.before) ? keeps(t) : slows_down(t); }},
    Contract{"drive", event::drive,
             [](S s, unsigned) { return in_mode(s, Mode::ready) || moves(s); },
             [](T t) {
               return in_mode(t.result.next, Mode::driving) && does(t, kDrive) && held_after(t);
             }},
    Contract{"motors confirmed", event::motors_confirmed,
             [](S s, unsigned) { return in_mode(s, Mode::enabling); },
             [](T t) { return in_mode(t.result.next, Mode::ready); }},
    Contract{"stands", event::stands, [](S s, unsigned) { return in_mode(s, Mode::stopping); },
             [](T t) { return idle(t.result.next) && does(t, lc::kMotorsOff); }},
};
constexpr auto kStates = lc::join(lc::common::kStates, kOwnStates);
constexpr auto kSteps = lc::join(lc::common::kSteps, kOwnSteps);
constexpr auto kContracts = lc::join(lc::common::kContracts, kOwnContracts);

lc::Happening help(S s) {
  const auto lost = static_cast<unsigned>(s.silent | s.unheard);
  if (link(s, lc::kPortClosed)) return {Event::port_opened, 0};
  if (lost != 0)
    return {Event::module_heard, static_cast<std::uint8_t>(std::countr_zero(lost) + 1)};
  if (fatal(s)) return {Event::solve, 0};
  if (solving(s)) return {Event::solved, 0};
  return {in_mode(s, Mode::stopping) ? event::stands : event::stop, 0};
}
constexpr std::array kReturns = {
    lc::Return{"from every state it comes back to Idle when the world helps",
               [](S s) { return idle(s); }, help}};

lc::Model model_of(const lc::Table& table, std::uint16_t modules) {
  lc::Model m = lc::model(table, modules);
  m.states = lc::state_properties<kStates>();
  m.steps = lc::step_properties<kSteps>();
  m.contracts = kContracts;
  m.returns = kReturns;
  return m;
}

std::string text(const lc::ControllerState& s) {
  return fmt::format("{} {}, goal {}, strategy {}{}",
                     kStateNames[static_cast<std::size_t>(s.state)], kModeNames[s.mode], s.goal,
                     s.strategy, lc::text_of_links(s, kDriveNames));
}

}  // namespace
}  // namespace lss::scout

namespace lss::lc {

const Verified& scout_verified() {
  static const Verified vehicle{.name = "scout",
                                .title = "the scout",
                                .table = &scout::kTable,
                                .model = scout::model_of,
                                .modules = (1u << scout::kDrives) - 1,
                                .few = (1u << scout::kDrives) - 1,
                                .mode_names = scout::kModeNames,
                                .goals = 2,
                                .text = scout::text,
                                .module_names = scout::kDriveNames};
  return vehicle;
}

}  // namespace lss::lc
