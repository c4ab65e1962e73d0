#include "daemon/cycle/text.h"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>

namespace lss {
namespace {

std::string name_of(std::span<const char* const> names, std::size_t index) {
  return index < names.size() ? names[index] : "unknown";
}

// Six digits; counts as whole numbers.
std::string number(double value) {
  return std::abs(value) < 1e6 ? fmt::format("{:.6g}", value) : fmt::format("{:.0f}", value);
}

}  // namespace

std::string tunable_name(std::span<const TunableInfo> tunables, std::size_t number) {
  return number >= 1 && number <= tunables.size() ? tunables[number - 1].name
                                                  : fmt::format("{}", number);
}

std::string tunable_unit(std::span<const TunableInfo> tunables, std::size_t number) {
  const bool has = number >= 1 && number <= tunables.size() && *tunables[number - 1].unit != '\0';
  return has ? fmt::format(" {}", tunables[number - 1].unit) : "";
}

namespace {

std::string text_of_one(const EventRecord& event, const Vocabulary& vocabulary,
                        std::span<const TunableInfo> tunables) {
  std::string prefix;
  if (event.subject > 0 && event.subject <= vocabulary.modules.size()) {
    prefix = fmt::format("module {} ({}): ", event.subject, vocabulary.modules[event.subject - 1u]);
  }
  if (event.id >= kFaultEventBase) {
    const CodeInfo* fault = info(static_cast<FaultId>(event.id - kFaultEventBase));
    const bool numbers = event.argument[0] != 0 || event.argument[1] != 0;
    return prefix + (fault ? fault->text : fmt::format("fault {}", event.id - kFaultEventBase)) +
           (numbers ? fmt::format(": {:.3g}, {:.3g}", event.argument[0], event.argument[1]) : "");
  }
  const CodeInfo* code = info(static_cast<EventId>(event.id));
  if (code == nullptr) return fmt::format("{}event {}", prefix, event.id);

  // Numbers that have names are shown by name.
  fmt::dynamic_format_arg_store<fmt::format_context> arguments;
  const auto id = static_cast<EventId>(event.id);
  for (const double& argument : event.argument) {
    const auto index = static_cast<std::size_t>(argument >= 0 ? argument : 0);
    if (id == EventId::state_changed) {
      arguments.push_back(kStateNames[index < 4 ? index : 0]);
    } else if (id == EventId::mode_changed) {
      arguments.push_back(name_of(vocabulary.modes, index));
    } else if (id == EventId::phase_changed || id == EventId::contingency) {
      arguments.push_back(name_of(vocabulary.phases, index));
    } else if (id == EventId::planned && &argument == &event.argument[0]) {
      arguments.push_back(name_of(vocabulary.programs, index));
    } else if (id == EventId::calibration_refused && &argument == &event.argument[0]) {
      arguments.push_back(name_of(vocabulary.findings, index));
    } else if (id == EventId::fault_cleared) {
      const CodeInfo* fault = info(static_cast<FaultId>(static_cast<std::uint16_t>(index)));
      arguments.push_back(fault ? fault->name : "none");
    } else if (id == EventId::command_rejected && &argument == &event.argument[1]) {
      const CodeInfo* reason = info(static_cast<Reason>(static_cast<std::uint16_t>(index)));
      arguments.push_back(reason ? reason->text : "none");
    } else if (id == EventId::strategy_ended && &argument == &event.argument[1]) {
      arguments.push_back(argument > 0 ? "solved" : "not solved");
    } else if (id == EventId::strategy_begun || id == EventId::strategy_ended) {
      arguments.push_back(name_of(vocabulary.strategies, index));
    } else if (id == EventId::parameter_changed && &argument == &event.argument[0]) {
      arguments.push_back(tunable_name(tunables, index));
    } else if (id == EventId::parameter_changed && &argument == &event.argument[2]) {
      const auto of = static_cast<std::size_t>(std::max(event.argument[0], 0.0));
      arguments.push_back(number(argument) + tunable_unit(tunables, of));
    } else if (id == EventId::parameters_not_saved) {
      arguments.push_back(std::generic_category().message(static_cast<int>(index)));
    } else if (id == EventId::emergency_message) {
      arguments.push_back(fmt::format("{:#06x}", index));
    } else {
      arguments.push_back(number(argument));
    }
  }
  return prefix + fmt::vformat(code->text, arguments);
}

}  // namespace

std::string event_text(const EventRecord& event, const Vocabulary& vocabulary,
                       std::span<const TunableInfo> tunables) {
  std::string text = text_of_one(event, vocabulary, tunables);
  if (event.count > 1)
    text += fmt::format(" ({} times in {:.1f} s)", event.count,
                        static_cast<double>(event.time_ns - event.first_ns) * 1e-9);
  return text;
}

}  // namespace lss
