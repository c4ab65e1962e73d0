#include "daemon/cycle/allowed.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "daemon/cycle/common_commands.h"

namespace lss::lc {
namespace {

std::string where(const Row& row, std::span<const char* const> modes) {
  if (row.from == kAnyState) return "every state";
  std::vector<std::string> states;
  for (unsigned s = 0; s < 4; ++s) {
    const auto state = static_cast<State>(s);
    if ((row.from & in(state)) == 0) continue;
    states.emplace_back(kStateNames[s]);
    if (state != State::operational || row.modes == kAnyMode) continue;
    std::vector<std::string> names;
    for (unsigned m = 1; m < modes.size(); ++m) {
      if ((row.modes >> m & 1u) != 0) names.emplace_back(modes[m]);
    }
    states.back() += fmt::format(" {}", fmt::join(names, ", "));
  }
  return fmt::format("{}", fmt::join(states, "; "));
}

constexpr double kMostVaried = 4096;

std::vector<std::string> when(const Table& table, const Row& row) {
  std::vector<std::string> names;
  for (unsigned bit = 0; bit < 16; ++bit) {
    if ((unsigned{row.guards} >> bit & 1u) == 0) continue;
    names.emplace_back(bit < kVehicleGuards ? kCommonGuardNames[bit]
                                            : table.guard_names[bit - kVehicleGuards]);
  }
  return names;
}

}  // namespace

std::vector<Allowed> allowed(const Table& table, std::span<const char* const> modes,
                             std::span<const Event> events) {
  std::vector<Allowed> all;
  for (const Rows* rows : {table.common, table.rows}) {
    for (const Row& row : rows->rows) {
      if (std::ranges::find(events, row.event) == events.end()) continue;
      Allowed one{.where = where(row, modes), .when = when(table, row)};
      const bool known = std::ranges::any_of(
          all, [&](const Allowed& a) { return a.where == one.where && a.when == one.when; });
      if (!known) all.push_back(std::move(one));
    }
  }
  return all;
}

std::vector<Event> events_of(const CommandInfo& info, Event (*event_of)(const Request& request)) {
  std::vector<Event> events;
  Request request{.kind = info.kind};
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const ParameterInfo& p = info.parameters[i];
    request.parameter[i] = p.fallback == p.fallback ? p.fallback : p.min;
  }
  const auto add = [&](const Request& r) {
    const Event event = event_of(r);
    if (std::ranges::find(events, event) == events.end()) events.push_back(event);
  };
  add(request);
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const ParameterInfo& p = info.parameters[i];
    // A parameter with this many values is a name or a count: its value does not matter here.
    if (!p.is_whole() || p.max - p.min > kMostVaried) continue;
    Request varied = request;
    for (double v = p.min; v <= p.max; ++v) {
      varied.parameter[i] = v;
      add(varied);
    }
  }
  return events;
}

std::vector<Allowed> allowed(const CommandInfo& info, const Table& table,
                             std::span<const char* const> modes,
                             Event (*event_of)(const Request& request)) {
  if (!is_of_parameters(info.kind)) return allowed(table, modes, events_of(info, event_of));
  if (info.kind == static_cast<std::uint16_t>(CommandKind::save_parameters))
    return {{.where = "every state", .when = {}}};
  return {{.where = "every state", .when = {"the parameter may be changed there (param get)"}}};
}

}  // namespace lss::lc
