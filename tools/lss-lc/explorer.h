#pragma once

// Visits every state that the locomotion controller can reach, breadth first, with every event in
// every state: commands, links, timers and error solving come in any order and at any time. It runs
// the step() that ships (daemon/cycle/controller.h); there is no second model. Memory is bounded: a
// state takes 8 bytes packed, 5 for its predecessor, and its share of the index.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/cycle/controller.h"
#include "tools/lss-lc/key.h"

namespace lss::lc {

// An event with its subject.
struct Happening {
  Event event = Event::none;
  std::uint8_t subject = 0;
};

struct Transition {
  const Table& table;
  const ControllerState& before;
  Happening happening;
  const Result& result;  // a rejection, too
};

// A property. `source`: its requirement or part of the specification.
struct StateProperty {
  const char* name;
  const char* source;
  bool (*holds)(const Table& table, const ControllerState& state);
};
// The changes of a step, as bits: a property is evaluated only when the step made a change that
// concerns it.
enum About : unsigned {
  kChange = 1u << 0,   // of state, mode, goal or strategy
  kActions = 1u << 1,  // an action for the vehicle
  kLinks = 1u << 2,    // a change of links, modules or flags
};
inline constexpr std::size_t kAbouts = 8;
struct StepProperty {
  const char* name;
  const char* source;
  unsigned about;
  bool (*holds)(const Transition& transition);
};
// Properties, all in one function, which compiles to one piece of code without a call for each:
// there are many, and they are evaluated in every state and step.
struct StateProperties {
  std::span<const StateProperty> each;
  bool (*all)(const Table& table, const ControllerState& state);
};
struct StepProperties {
  std::span<const StepProperty> each;
  std::array<bool (*)(const Transition& transition), kAbouts> all;  // by the changes of the step
};
// Whether property i is satisfied. A constant, so that its code is inlined and not behind a
// pointer.
template <const auto& kProperties, std::size_t i>
bool holds(const Table& table, const ControllerState& state) {
  constexpr StateProperty kProperty = kProperties[i];
  return kProperty.holds(table, state);
}
template <const auto& kProperties, std::size_t i, unsigned about>
bool holds(const Transition& transition) {
  constexpr StepProperty kProperty = kProperties[i];
  return (kProperty.about & about) == 0 || kProperty.holds(transition);
}
template <const auto& kProperties, unsigned about>
[[gnu::flatten]] bool all_hold(const Transition& transition) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    return (holds<kProperties, i, about>(transition) && ...);
  }
  (std::make_index_sequence<kProperties.size()>());
}
template <const auto& kProperties>
[[gnu::flatten]] bool all_hold(const Table& table, const ControllerState& state) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    return (holds<kProperties, i>(table, state) && ...);
  }
  (std::make_index_sequence<kProperties.size()>());
}
template <const auto& kProperties>
constexpr StateProperties state_properties() {
  return {kProperties, all_hold<kProperties>};
}
template <const auto& kProperties>
constexpr StepProperties step_properties() {
  return [&]<std::size_t... about>(std::index_sequence<about...>) {
    return StepProperties{kProperties, {all_hold<kProperties, about>...}};
  }
  (std::make_index_sequence<kAbouts>());
}
// A requirement that something happens: in these states the events are accepted, and lead there. It
// says nothing of other states.
struct Duty {
  const char* name;
  const char* source;
  std::array<Event, 4> events;  // none: no further ones
  bool (*due)(const ControllerState& before, const Happening& happening);
  bool (*met)(const Transition& transition);  // of a taken one
};
// When an event is accepted, exactly, and its result.
struct Contract {
  const char* name;
  Event event;
  bool (*accepts)(const ControllerState& before, unsigned subject);
  bool (*leads)(const Transition& transition);  // taken ones only
};
// From every state the target is reachable in a cooperative environment.
struct Return {
  const char* name;
  bool (*reached)(const ControllerState& state);
  Happening (*help)(const ControllerState& state);  // the next event of a cooperative environment
};

struct Model {
  const Table* table;
  ControllerState begin;
  std::vector<Happening> happenings;
  StateProperties states;
  StepProperties steps;
  std::span<const Duty> duties;
  std::span<const Contract> contracts;
  std::span<const Return> returns;
  // The representative of all states that differ only in which of several equivalent modules is
  // silent, unheard or isolated; nullptr: no reduction. Neither step nor properties may distinguish
  // between equivalent modules.
  ControllerState (*stands_for)(const ControllerState& state) = nullptr;
};
inline ControllerState stand_in(const Model& model, const ControllerState& state) {
  return model.stands_for == nullptr ? state : model.stands_for(state);
}

// Begins as at boot, with these modules only (bit i: module i+1).
Model model(const Table& table, std::uint16_t modules);

struct Violation {
  std::string property;
  // The shortest path from the initial state, in representatives; its last step violates the
  // property.
  std::vector<Happening> trace;
};

// Everything except bytes and seconds is independent of the number of threads.
struct Exploration {
  std::size_t states = 0;
  std::uint64_t transitions = 0;  // states x events
  std::uint64_t taken = 0;        // of these, by a row of the table
  std::size_t depth = 0;          // longest of the shortest paths to a state
  std::size_t bytes = 0;          // of memory, in total
  double seconds = 0;
  bool complete = false;           // otherwise: violated, or more than max_states
  std::vector<std::uint64_t> row;  // how often each row was taken, common rows first
  std::optional<Violation> violation;
};

struct Effort {
  std::size_t max_states = 16'000'000;
  unsigned threads = 0;  // 0: one for each processor
};

Exploration explore(const Model& model, const Effort& effort = {});

}  // namespace lss::lc
