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

std::string text_of_links(const ControllerState& s, std::span<const char* const> module_names) {
  std::string text;
  const auto say = [&](bool holds, const char* what) {
    if (holds) text += fmt::format(", {}", what);
  };
  say((s.links & kPortClosed) != 0, "port closed");
  say((s.links & kObcSilent) != 0, "OBC silent");
  say((s.links & kHeld) != 0, "held");
  for (std::size_t i = 0; i < module_names.size(); ++i) {
    const auto is = [&](std::uint16_t set) { return (unsigned{set} >> i & 1u) != 0; };
    if (is(s.silent)) text += fmt::format(", {} silent", module_names[i]);
    if (is(s.unheard)) text += fmt::format(", {} never heard", module_names[i]);
    if (is(s.isolated)) text += fmt::format(", {} isolated", module_names[i]);
  }
  return text;
}

}  // namespace lss::lc
