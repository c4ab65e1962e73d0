#pragma once

// The vocabulary of properties and contracts, and the properties of every vehicle. Included by the
// vehicles' files only.

#include <array>
#include <bit>
#include <initializer_list>
#include <optional>

#include "tools/lss-lc/explorer.h"

namespace lss::lc {

// Concatenates two lists.
template <class Item, std::size_t N, std::size_t M>
constexpr std::array<Item, N + M> join(const std::array<Item, N>& these,
                                       const std::array<Item, M>& those) {
  std::array<Item, N + M> all{};
  for (std::size_t i = 0; i < N; ++i) all[i] = these[i];
  for (std::size_t i = 0; i < M; ++i) all[N + i] = those[i];
  return all;
}

namespace common {

using lc::Contract;
using lc::ControllerState;
using lc::Duty;
using lc::Event;
using lc::Happening;
using lc::Return;
using lc::StateProperty;
using lc::StepProperty;
using S = const ControllerState&;
using T = const Transition&;

inline bool idle(S s) { return s.state == State::idle; }
inline bool operational(S s) { return s.state == State::operational; }
inline bool fatal(S s) { return s.state == State::fatal_error; }
inline bool solving(S s) { return s.state == State::solve_errors; }
inline bool has(S s, std::uint8_t flags) { return (s.flags & flags) != 0; }
inline bool link(S s, Link bit) { return (s.links & bit) != 0; }
inline bool in_service(S s, unsigned module) { return (s.isolated >> (module - 1) & 1u) == 0; }
inline bool contact(S s) { return s.silent == 0 && s.unheard == 0 && !link(s, kPortClosed); }
inline bool stops_motors(ActionSet actions) {
  return (actions & (kMotorsOff | lc::kEmergencyStop)) != 0;
}
inline bool same_mode(T t) {
  return t.result.next.state == t.before.state && t.result.next.mode == t.before.mode;
}
inline bool keeps(T t) { return t.result.next == t.before; }
// The module of this event goes out of service, and nothing moves by that.
inline bool leaves_service(T t) {
  return same_mode(t) && !in_service(t.result.next, t.happening.subject) &&
         stops_motors(t.result.actions);
}
inline bool held_after(T t) { return link(t.result.next, kHeld); }
inline bool emergency(T t) {
  return fatal(t.result.next) && (t.result.actions & kEmergencyStop) != 0 && !held_after(t);
}
// `Mode`: that of the vehicle.
template <class Mode>
bool in_mode(S s, Mode m) {
  return operational(s) && s.mode == static_cast<std::uint8_t>(m);
}
template <class Mode>
bool in_mode(S s, std::initializer_list<Mode> modes) {
  for (const Mode m : modes) {
    if (in_mode(s, m)) return true;
  }
  return false;
}
template <class Mode>
bool to(T t, Mode m) {
  return in_mode(t.result.next, m);
}
// Any of these.
inline bool does(T t, ActionSet actions) { return (t.result.actions & actions) != 0; }
inline bool can_start(S s) { return idle(s) && contact(s) && !link(s, kObcSilent); }
inline bool next_strategy(T t) {
  return solving(t.result.next) && t.result.next.strategy == t.before.strategy + 1 &&
         stops_motors(t.result.actions);
}
inline bool breaks_off(T t) { return emergency(t) && does(t, kEndSolve); }
inline bool one_of(Event event, std::initializer_list<Event> events) {
  for (const Event e : events) {
    if (e == event) return true;
  }
  return false;
}
// These actions follow from these events, and from no other.
inline bool only_by(T t, ActionSet actions, std::initializer_list<Event> events) {
  return !does(t, actions) || one_of(t.happening.event, events);
}
inline bool any_state(S, const Happening&) { return true; }
inline bool always(S, unsigned) { return true; }
inline bool rests(S s, const Happening&) { return idle(s) || fatal(s); }
inline bool of_one_in_service(S s, const Happening& h) {
  return h.subject == 0 || in_service(s, h.subject);
}
// Of the module or the link of this event.
inline bool lost(S s, const Happening& h) {
  switch (h.event) {
    case Event::module_heard:
    case Event::module_silent: return ((s.silent | s.unheard) >> (h.subject - 1) & 1u) != 0;
    case Event::port_opened:
    case Event::port_closed: return link(s, kPortClosed);
    default: return link(s, kObcSilent);
  }
}
// The vehicle's own commands, without these, are refused because of the state.
inline bool refuses_for_its_state(const Table& table, S s, std::initializer_list<Event> without) {
  for (const EventInfo& e : table.events) {
    if (e.command && !one_of(e.event, without) &&
        lc::step(table, s, e.event).verdict.reason != Reason::not_in_state)
      return false;
  }
  return true;
}
// Exactly these actions; state, mode, goal and strategy stay.
inline bool starts_nothing_but(T t, ActionSet actions) {
  return same_mode(t) && t.result.next.goal == t.before.goal &&
         t.result.next.strategy == t.before.strategy && (t.result.actions & ~kOnlyState) == actions;
}
inline bool starts_nothing(T t) { return starts_nothing_but(t, 0); }
inline bool lost_is_emergency(T t) { return operational(t.before) ? emergency(t) : same_mode(t); }

// ---- states

inline constexpr std::array kStates = {
    StateProperty{"a mode runs exactly in Operational", "4.3.1",
                  [](const Table&, S s) { return operational(s) == (s.mode != 0); }},
    StateProperty{
        "Operational has every link: port, OBC, all modules in service", "O-Int-2",
        [](const Table&, S s) { return !operational(s) || (contact(s) && !link(s, kObcSilent)); }},
    StateProperty{"authority is held only in Operational", "architecture",
                  [](const Table&, S s) { return operational(s) || !link(s, kHeld); }},
    StateProperty{"a chain of motions has a goal only in Operational", "4.3.1",
                  [](const Table&, S s) { return operational(s) || s.goal == 0; }},
    StateProperty{"a strategy runs exactly in SolveErrors", "Conf-3",
                  [](const Table&, S s) {
                    return solving(s) == (s.strategy != 0) && s.strategy <= kMaxStrategies;
                  }},
    StateProperty{"a module is silent, never heard or isolated, not two of these", "P-Int-2",
                  [](const Table&, S s) {
                    return (s.silent & s.unheard) == 0 && (s.silent & s.isolated) == 0 &&
                           (s.unheard & s.isolated) == 0;
                  }},
    StateProperty{"a lease runs as long as a source has authority, no longer", "architecture",
                  [](const Table& table, S s) {
                    return link(s, kHeld) || lc::step(table, s, Event::lease_expired).row < 0;
                  }},
};

// ---- steps that were taken

inline constexpr std::array kSteps = {
    StepProperty{"FatalError is left only for SolveErrors, by solve", "Oper-6", kChange,
                 [](T t) {
                   return !fatal(t.before) || fatal(t.result.next) ||
                          (solving(t.result.next) && t.happening.event == Event::solve);
                 }},
    StepProperty{"SolveErrors is left only for FatalError, or for Idle when all is well", "Oper-6",
                 kChange,
                 [](T t) {
                   return !solving(t.before) || solving(t.result.next) || fatal(t.result.next) ||
                          (idle(t.result.next) && t.happening.event == Event::solved &&
                           contact(t.result.next));
                 }},
    StepProperty{
        "SolveErrors is entered only from FatalError", "4.3.1", kChange,
        [](T t) { return !solving(t.result.next) || solving(t.before) || fatal(t.before); }},
    StepProperty{
        "into FatalError every module gets an emergency stop", "Oper-5", kChange,
        [](T t) { return fatal(t.before) || !fatal(t.result.next) || does(t, kEmergencyStop); }},
    StepProperty{"leaving Operational stops the motors", "Oper-7", kChange,
                 [](T t) {
                   return !operational(t.before) || operational(t.result.next) ||
                          stops_motors(t.result.actions);
                 }},
    StepProperty{"leaving SolveErrors stops the motors", "Oper-7", kChange,
                 [](T t) {
                   return !solving(t.before) || solving(t.result.next) ||
                          (stops_motors(t.result.actions) && does(t, kEndSolve));
                 }},
    StepProperty{"links change by what is heard of them, only", "O-Int-2", kLinks,
                 [](T t) {
                   const ControllerState &a = t.before, &b = t.result.next;
                   const Event e = t.happening.event;
                   const auto changed = [&](Link bit) { return ((a.links ^ b.links) & bit) != 0; };
                   if (changed(kPortClosed) && e != Event::port_opened && e != Event::port_closed)
                     return false;
                   if (changed(kObcSilent) && e != Event::obc_heard && e != Event::obc_silent)
                     return false;
                   const bool of_modules = e == Event::module_heard || e == Event::module_silent ||
                                           e == Event::restore ||
                                           t.before.isolated != t.result.next.isolated;
                   return of_modules || (a.silent == b.silent && a.unheard == b.unheard);
                 }},
    StepProperty{"modules are isolated one by one, outside Operational, and restored by command "
                 "only",
                 "Conf-3", kLinks,
                 [](T t) {
                   const unsigned gone = t.before.isolated & ~t.result.next.isolated,
                                  more = t.result.next.isolated & ~t.before.isolated;
                   return (gone == 0 || does(t, kRestore)) &&
                          (more == 0 ||
                           (!operational(t.before) && same_mode(t) && (more & (more - 1)) == 0));
                 }},
    StepProperty{
        "faults are forgotten only when they are solved", "Oper-6", kActions,
        [](T t) { return !does(t, kClearFaults) || (solving(t.before) && idle(t.result.next)); }},
    StepProperty{"a module is reset only by its command, and nothing else happens then", "Oper-4",
                 kActions,
                 [](T t) {
                   return only_by(t, kResetModule, {Event::reset_module}) &&
                          (!does(t, kResetModule) || keeps(t));
                 }},
    StepProperty{
        "by command modules are reset and put into service again in Idle and FatalError "
        "only: what solves errors does this by itself",
        "Oper-4", kActions,
        [](T t) { return !does(t, kResetModule | kRestore) || idle(t.before) || fatal(t.before); }},
    StepProperty{"data leaves only when it is asked for", "O-Int-1", kActions,
                 [](T t) { return only_by(t, kPublishData, {Event::request_data}); }},
    StepProperty{"error solving begins by solve in FatalError only, its next strategy when one has "
                 "ended",
                 "Oper-6", kActions,
                 [](T t) {
                   return only_by(t, kBeginSolve, {Event::solve}) &&
                          (!does(t, kBeginSolve) || fatal(t.before)) &&
                          only_by(t, kNextStrategy, {Event::next_strategy});
                 }},
    StepProperty{
        "reports of error solving count while errors are solved", "Oper-6", kChange | kActions,
        [](T t) {
          return solving(t.before) ||
                 !one_of(t.happening.event, {Event::next_strategy, Event::solved, Event::unsolved});
        }},
    StepProperty{"error solving is not broken off while it goes on", "Oper-6", kActions,
                 [](T t) {
                   return !does(t, kEndSolve) || fatal(t.result.next) ||
                          (solving(t.before) && !solving(t.result.next));
                 }},
    StepProperty{"out of service and back goes what was named, and its faults with it, no other",
                 "Conf-3", kActions,
                 [](T t) {
                   const bool one = t.happening.subject != 0 &&
                                    in_service(t.before, t.happening.subject) &&
                                    !in_service(t.result.next, t.happening.subject);
                   const Event e = t.happening.event;
                   const bool back =
                       e == Event::restore ||
                       (static_cast<unsigned>(e) >= kVehicleEvents && t.happening.subject != 0);
                   return (!does(t, kIsolate) || one) && (!does(t, kRestore) || back);
                 }},
    StepProperty{"every module gets an emergency stop in an emergency, by its command and by a "
                 "reset of the controller, and else goes on",
                 "Oper-5", kActions,
                 [](T t) {
                   const bool commanded =
                       one_of(t.happening.event, {Event::emergency_stop, Event::reset_controller});
                   return !does(t, kEmergencyStop) || commanded ||
                          (fatal(t.result.next) && !fatal(t.before));
                 }},
    StepProperty{
        "what operates has its motors on, and what moves at rest is stopped by a reset only",
        "Func-2", kActions,
        [](T t) {
          return !does(t, kMotorsOff) || solving(t.before) ||
                 (idle(t.result.next) &&
                  (!idle(t.before) || t.happening.event == Event::reset_controller));
        }},
    StepProperty{"in FatalError a module gets no order but to reset and to stop", "4.3.1", kActions,
                 [](T t) {
                   constexpr ActionSet kOfAll = (ActionSet{1} << kVehicleActions) - 1;
                   constexpr ActionSet kLegal = kResetModule | kPublishData | kIsolate | kRestore |
                                                kEmergencyStop | kEndSolve | kOnlyState;
                   return !fatal(t.before) || !fatal(t.result.next) ||
                          (t.result.actions & kOfAll & ~kLegal) == 0;
                 }},
};

// ---- what has to happen

// Of a vehicle's own command to stop.
constexpr Duty stop_at_rest(const std::array<Event, 4>& events) {
  return {"stop at rest is accepted and changes nothing", "Func-2", events,
          [](S s, const Happening&) { return idle(s); },
          [](T t) { return keeps(t) && starts_nothing(t); }};
}
// Only FatalError, where nothing moves, takes no stop.
constexpr Duty stop_while_solving(const std::array<Event, 4>& events) {
  return {"stop breaks error solving off and stops everything, with faults where they were",
          "Func-2", events, [](S s, const Happening&) { return solving(s); }, breaks_off};
}

inline constexpr std::array kDuties = {
    Duty{"an emergency stop is obeyed in every state",
         "Oper-5",
         {Event::emergency_stop},
         any_state,
         breaks_off},
    Duty{"a fatal fault is an emergency in every state",
         "Oper-5",
         {Event::emergency},
         any_state,
         [](T t) { return fatal(t.before) ? keeps(t) : breaks_off(t); }},
    Duty{"what is lost is remembered, stops what operates, and begins nothing",
         "O-Int-2",
         {Event::module_silent, Event::port_closed, Event::obc_silent},
         of_one_in_service,
         [](T t) {
           return lost(t.result.next, t.happening) &&
                  (operational(t.before) ? emergency(t)
                                         : starts_nothing(t) || fatal(t.result.next));
         }},
    Duty{"a module that is lost at rest is an emergency, its motor may be on",
         "P-Int-2",
         {Event::module_silent},
         [](S s, const Happening& h) { return idle(s) && in_service(s, h.subject); },
         emergency},
    Duty{"at rest the port and the OBC may go and come",
         "Oper-3",
         {Event::port_closed, Event::obc_silent},
         [](S s, const Happening&) { return !operational(s); },
         starts_nothing},
    Duty{"what is back is remembered, and starts nothing by itself",
         "P-Int-2",
         {Event::module_heard, Event::port_opened, Event::obc_heard},
         of_one_in_service,
         [](T t) { return !lost(t.result.next, t.happening) && starts_nothing(t); }},
    Duty{"a reset of the controller ends safe from everywhere, with faults where they were",
         "Oper-2",
         {Event::reset_controller},
         any_state,
         [](T t) {
           return stops_motors(t.result.actions) &&
                  (idle(t.before) || operational(t.before) ? idle(t.result.next) : emergency(t)) &&
                  (!operational(t.before) || does(t, kEmergencyStop)) &&
                  (!solving(t.before) || does(t, kEndSolve));
         }},
    Duty{"at rest each module can be reset",
         "Oper-4",
         {Event::reset_module},
         rests,
         [](T t) { return does(t, kResetModule); }},
    Duty{"data can be asked for at any time, which changes nothing",
         "O-Int-3",
         {Event::request_data, Event::reset_timing},
         any_state,
         [](T t) {
           return keeps(t) && does(t, kPublishData) == (t.happening.event == Event::request_data);
         }},
    Duty{"errors are solved on command",
         "Oper-6",
         {Event::solve},
         [](S s, const Happening&) { return fatal(s); },
         [](T t) { return solving(t.result.next) && does(t, kBeginSolve); }},
    Duty{"with all errors solved it is Idle without faults, else an emergency",
         "Oper-6",
         {Event::solved, Event::unsolved},
         [](S s, const Happening& h) {
           return solving(s) && (h.event == Event::unsolved || contact(s));
         },
         [](T t) {
           return t.happening.event == Event::unsolved
                      ? emergency(t)
                      : idle(t.result.next) && does(t, kClearFaults);
         }},
    Duty{"a strategy that did not help leaves nothing moving to the next",
         "Conf-3",
         {Event::next_strategy},
         [](S s, const Happening&) { return solving(s) && s.strategy < kMaxStrategies; },
         [](T t) { return next_strategy(t) && does(t, kNextStrategy); }},
    Duty{"at rest all modules can be put into service again, and have to answer then",
         "Conf-3",
         {Event::restore},
         rests,
         [](T t) {
           return starts_nothing_but(t, kRestore) && t.result.next.isolated == 0 &&
                  t.result.next.silent == (t.before.silent | t.before.isolated);
         }},
};

// ---- events

inline constexpr std::array kContracts = {
    Contract{"emergency stop", Event::emergency_stop, always, breaks_off},
    Contract{"fatal fault", Event::emergency, always,
             [](T t) { return fatal(t.before) ? keeps(t) : emergency(t); }},
    Contract{"solve", Event::solve, [](S s, unsigned) { return fatal(s); },
             [](T t) {
               return solving(t.result.next) && does(t, kBeginSolve) && t.result.next.strategy == 1;
             }},
    Contract{"solved", Event::solved, [](S s, unsigned) { return solving(s) && contact(s); },
             [](T t) { return idle(t.result.next) && does(t, kClearFaults); }},
    Contract{"unsolved", Event::unsolved, [](S s, unsigned) { return solving(s); }, emergency},
    Contract{"reset of the controller", Event::reset_controller, always,
             [](T t) {
               const bool back = fatal(t.before) || solving(t.before);
               return (back ? emergency(t) : idle(t.result.next)) &&
                      stops_motors(t.result.actions) &&
                      (!operational(t.before) || does(t, kEmergencyStop));
             }},
    Contract{"reset of a module", Event::reset_module,
             [](S s, unsigned) { return idle(s) || fatal(s); },
             [](T t) { return keeps(t) && does(t, kResetModule); }},
    Contract{"restore", Event::restore, [](S s, unsigned) { return idle(s) || fatal(s); },
             [](T t) {
               return same_mode(t) && t.result.next.isolated == 0 &&
                      t.result.next.silent == (t.before.silent | t.before.isolated) &&
                      does(t, kRestore);
             }},
    Contract{"data", Event::request_data, always,
             [](T t) { return keeps(t) && does(t, kPublishData); }},
    Contract{"reset of the timing", Event::reset_timing, always, keeps},
    Contract{"module heard", Event::module_heard,
             [](S s, unsigned module) { return in_service(s, module); },
             [](T t) {
               const unsigned bit = 1u << (t.happening.subject - 1);
               return same_mode(t) && t.result.next.silent == (t.before.silent & ~bit) &&
                      t.result.next.unheard == (t.before.unheard & ~bit);
             }},
    Contract{"module silent", Event::module_silent,
             [](S s, unsigned module) { return in_service(s, module); },
             [](T t) {
               const unsigned bit = 1u << (t.happening.subject - 1);
               const bool moves = operational(t.before) || idle(t.before);
               return t.result.next.silent == (t.before.silent | bit) &&
                      (moves ? emergency(t) : same_mode(t));
             }},
    Contract{"port opened", Event::port_opened, always,
             [](T t) { return same_mode(t) && !link(t.result.next, kPortClosed); }},
    Contract{"port closed", Event::port_closed, always,
             [](T t) { return lost_is_emergency(t) && link(t.result.next, kPortClosed); }},
    Contract{"OBC heard", Event::obc_heard, always,
             [](T t) { return same_mode(t) && !link(t.result.next, kObcSilent); }},
    Contract{"OBC silent", Event::obc_silent, always,
             [](T t) { return lost_is_emergency(t) && link(t.result.next, kObcSilent); }},
};

// ---- what vehicles have in common with words of their own

template <auto kLeads>
constexpr Contract next_strategy_contract() {
  return {"next strategy", Event::next_strategy,
          [](S s, unsigned) { return solving(s) && s.strategy < kMaxStrategies; }, kLeads};
}
template <auto kLeads>
constexpr Contract lease_expired_contract() {
  return {"lease expired", Event::lease_expired, [](S s, unsigned) { return link(s, kHeld); },
          [](T t) { return kLeads(t) && !held_after(t); }};
}
// Given back only where `kRests`.
template <auto kRests>
constexpr StepProperty authority_property() {
  return {"authority is taken only by commands that move, and given back only on the way to rest",
          "architecture", kLinks, [](T t) {
            const bool before = link(t.before, kHeld), after = held_after(t);
            if (after && !before) return does(t, kTakeAuthority);
            return !before || after || !operational(t.result.next) || kRests(t);
          }};
}

// The next event of a world that helps, as far as it is the same for every vehicle.
inline std::optional<Happening> help_any(S s) {
  if (link(s, kPortClosed)) return Happening{Event::port_opened, 0};
  const auto lost = static_cast<std::uint16_t>(s.silent | s.unheard);
  if (!operational(s) && lost != 0)
    return Happening{Event::module_heard, static_cast<std::uint8_t>(std::countr_zero(lost) + 1)};
  if (fatal(s)) return Happening{Event::solve, 0};
  if (solving(s)) return Happening{Event::solved, 0};
  return std::nullopt;
}
template <auto kHelp>
constexpr Return return_to_idle() {
  return {"from every state it comes back to Idle when the world helps", idle, kHelp};
}

}  // namespace common

// The model with the properties of every vehicle and its own.
template <const auto& kStates, const auto& kSteps>
Model model_of(const Table& table, std::uint16_t modules, std::span<const Duty> duties,
               std::span<const Contract> contracts, std::span<const Return> returns) {
  Model m = model(table, modules);
  m.states = state_properties<kStates>();
  m.steps = step_properties<kSteps>();
  m.duties = duties;
  m.contracts = contracts;
  m.returns = returns;
  return m;
}

}  // namespace lss::lc
