#pragma once

// Events as sentences, for the log and for DDS. Ordinary threads.

#include <array>
#include <span>
#include <string>

#include "daemon/cycle/messages.h"
#include "daemon/cycle/tunables.h"

namespace lss {

// What clients need to drive and to show a vehicle, beside its tables. Fields of the telemetry are
// named as in its IDL: "speed", and "modules.link" in an array of structs. Commands by their kind,
// modes by their number; lists may be empty. Pure data.
struct Presentation {
  struct Example {
    std::uint16_t command;
    const char* lines;  // of its help, each ended
  };
  // In one of these modes `step` is completed before any of `commands`: in Operational, and in Idle
  // after the start, which leads to `begins`.
  struct Step {
    std::uint16_t step;
    std::span<const std::uint8_t> modes;
    std::span<const std::uint16_t> commands;
    double argument = kRequired;  // its first parameter; NaN: its default
    double when = kRequired;      // only with this first parameter of the command; NaN: any
  };
  // The command with this value of its parameter `index`.
  struct Case {
    std::uint16_t command;
    unsigned index;
    double value;
    double takes_s = 0;
  };
  // A field whose numbers have names, from 0 on.
  struct Words {
    const char* field;
    std::span<const char* const> words;
    bool shown_only = false;  // in JSON it stays a number
  };
  // An array of structs whose element with the id i is subject `first` + i. Those with a member
  // `online` that is false are a problem, with the words before the age of their last message;
  // subjects of `lesser` (bit i: subject i + 1) only a warning, and of `optional` none.
  struct Parts {
    const char* field;
    unsigned first = 0;
    const char* unheard = nullptr;  // "does not answer, last reply"; nullptr: no problem
    std::uint32_t lesser = 0, optional = 0;
  };
  // A boolean that must be `good`.
  struct Alarm {
    const char* field;
    bool good;
    const char *text, *advice;
    // With the faults port_lost and port_absent of this subject nothing is said; 0: any.
    std::uint16_t subject = 0;
    bool alone = false;  // what depends on it is no problem of its own
  };

  // What a pilot looks at first, in this order, by the words of a pilot. An element of an array:
  // "position_m[0]"; the member of each element of a part: "wheels.current_A".
  struct Headline {
    const char *field, *label;
    const char* limit = nullptr;  // parameter with the value from which the daemon acts
    const char* parts = nullptr;  // of an array with an element for each of these
  };

  // A way to drive by holding a key or a stick, with the first parameters of `command`; NaN: the
  // default. Letting go is `rest`.
  struct Hold {
    const char* way;  // "forward", "backward", "left", "right", "forward left", ...
    std::uint16_t command;
    std::array<double, 3> parameters;
  };

  std::span<const Example> examples = {};
  std::uint8_t begins = 0;
  std::span<const Step> steps = {};
  std::span<const Case> ends = {};  // an endless command that ends by itself
  std::span<const Case> slow = {};  // takes longer than usual
  std::uint16_t rest = static_cast<std::uint16_t>(CommandKind::stop);  // ends an endless command
  const char* at_rest = "nothing moves";                               // outside Operational
  const char* distance = "distance_m";  // the way so far, as a field; an element: "position_m[2]"
  std::span<const Words> words = {};
  std::span<const Parts> parts = {};
  std::span<const Alarm> alarms = {};
  std::span<const char* const> details = {};  // fields that only `lss-cli data` shows
  std::span<const Headline> headline = {};
  const char* supply = nullptr;  // field of the supply voltage, or member of each element of a part
  std::span<const Hold> hold = {};
  // Its own commands that a pilot uses most, in this order; empty: all.
  std::span<const std::uint16_t> first = {};
  const char* without_client = "comes to a safe stop";  // after the last heartbeat of who commands
};

// Lists of a Presentation.
template <class... Kind>
constexpr auto kinds(Kind... kind) {
  return std::array{static_cast<std::uint16_t>(kind)...};
}
template <class... Mode>
constexpr auto modes(Mode... mode) {
  return std::array{static_cast<std::uint8_t>(mode)...};
}

// A vehicle's names for its modes, modules (wheels, nodes; subject n is modules[n - 1]), strategies
// of error solving, and, when it flies, phases and programs of a flight and findings of a
// calibration. Those of its commands and parameters are in its Logic.
struct Vocabulary {
  std::span<const char*const> modes, modules, strategies, phases = {}, programs = {}, findings = {};
  Presentation presentation = {};
};

// "limits.current_A", and the unit with a leading blank; for numbers from 1 on.
std::string tunable_name(std::span<const TunableInfo> tunables, std::size_t number);
std::string tunable_unit(std::span<const TunableInfo> tunables, std::size_t number);

// "module 3 (LM): leg passed its calibration sensor"
std::string event_text(const EventRecord& event, const Vocabulary& vocabulary,
                       std::span<const TunableInfo> tunables);

}  // namespace lss
