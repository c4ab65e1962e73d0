#include "tools/lss-lc/vehicle.h"

#include <fmt/format.h>

namespace lss::lc {

std::string text(const Verified& vehicle, Happening happening) {
  for (const std::span<const EventInfo> events : {kCommonEvents, vehicle.table->events}) {
    for (const EventInfo& e : events) {
      if (e.event != happening.event) continue;
      return happening.subject == 0
                 ? e.name
                 : fmt::format("{} {}", e.name, vehicle.module_names[happening.subject - 1u]);
    }
  }
  return "?";
}

std::string text(const Verified& vehicle, const ControllerState& s) {
  std::string text = kStateNames[static_cast<std::size_t>(s.state)];
  if (s.mode != 0) text += fmt::format(" {}", vehicle.mode_names[s.mode]);
  if (s.goal != 0) text += fmt::format(", goal {}", vehicle.goal_names[s.goal]);
  if (s.strategy != 0) text += fmt::format(", strategy {}", s.strategy);
  const auto say = [&](bool holds, const char* what) {
    if (holds) text += fmt::format(", {}", what);
  };
  for (const FlagName& flag : vehicle.flag_names)
    say((s.flags & flag.flag) != 0 && (s.flags & flag.unless) == 0, flag.text);
  say((s.links & kPortClosed) != 0, "port closed");
  say((s.links & kObcSilent) != 0, "OBC silent");
  say((s.links & kHeld) != 0, "held");
  for (std::size_t i = 0; i < vehicle.module_names.size(); ++i) {
    const auto is = [&](std::uint16_t set) { return (unsigned{set} >> i & 1u) != 0; };
    if (is(s.silent)) text += fmt::format(", {} silent", vehicle.module_names[i]);
    if (is(s.unheard)) text += fmt::format(", {} never heard", vehicle.module_names[i]);
    if (is(s.isolated)) text += fmt::format(", {} isolated", vehicle.module_names[i]);
  }
  return text;
}

}  // namespace lss::lc
