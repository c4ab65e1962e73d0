#pragma once

// Visits every state that the locomotion controller can reach, breadth first, with every event in
// every state: commands, links, timers and error solving come in any order and at any time. It runs
// the step() that ships (daemon/lc/controller.h); nothing is modelled a second time. Memory is
// bounded: a state takes 8 octets packed, 6 for how it was reached, and its share of the index.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/lc/controller.h"

namespace lss::lc {

// All of a ControllerState in 8 octets, 16 modules at most.
using Key = std::uint64_t;
Key pack(const ControllerState& state) noexcept;
ControllerState unpack(Key key) noexcept;

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

// What must hold. `source`: the requirement or the part of the specification that wants it.
struct StateProperty {
  const char* name;
  const char* source;
  bool (*holds)(const Table& table, const ControllerState& state);
};
// What a step did, as bits: a property is looked at when the step did something that it is about.
enum About : unsigned {
  kChange = 1u << 0,   // of state, mode, goal or strategy
  kActions = 1u << 1,  // something for the vehicle to do
  kLinks = 1u << 2,    // a change of links, modules or flags
};
struct StepProperty {
  const char* name;
  const char* source;
  unsigned about;
  bool (*holds)(const Transition& transition);
};
// When an event is taken, and what it leads to.
struct Contract {
  const char* name;
  Event event;
  bool (*accepts)(const ControllerState& before, unsigned subject);
  bool (*leads)(const Transition& transition);  // taken ones only
};
// From every state the target is reached when the world helps.
struct Return {
  const char* name;
  bool (*reached)(const ControllerState& state);
  Happening (*help)(const ControllerState& state);  // what a helpful world does next
};

struct Model {
  const Table* table;
  ControllerState begin;
  std::vector<Happening> happenings;
  std::span<const StateProperty> states;
  std::span<const StepProperty> steps;
  std::span<const Contract> contracts;
  std::span<const Return> returns;
};

// Begins as at boot, with these modules only (bit i: module i+1).
Model model(const Table& table, std::uint16_t modules);

struct Violation {
  std::string property;
  std::vector<Happening> trace;  // shortest, from the beginning; the last one breaks the property
};

struct Exploration {
  std::size_t states = 0;
  std::uint64_t transitions = 0;  // states x events
  std::uint64_t taken = 0;        // of these, by a row of the table
  std::size_t depth = 0;          // longest of the shortest ways to a state
  std::size_t octets = 0;         // of memory, all in all
  double seconds = 0;
  bool complete = false;           // else: violated, or more than max_states
  std::vector<std::uint64_t> row;  // how often each row was taken, common rows first
  std::optional<Violation> violation;
};

Exploration explore(const Model& model, std::size_t max_states = 16'000'000);

}  // namespace lss::lc
