// States and events of Lunar Zebro's controller as people read them.

#include <fmt/format.h>

#include "tools/lss-lc/zebro_words.h"

namespace lss::zebro {

using namespace words;

std::string text(const ControllerState& s) {
  static constexpr const char* kGoals[] = {"none", "stand", "walk",     "lie",
                                           "stow", "idle",  "lie_idle", "leg"};
  std::string text = kStateNames[static_cast<std::size_t>(s.state)];
  if (s.mode != 0) text += fmt::format(" {}", kModeNames[s.mode]);
  if (s.goal != 0) text += fmt::format(", goal {}", kGoals[s.goal]);
  if (s.strategy != 0) text += fmt::format(", strategy {}", s.strategy);
  const auto say = [&](bool holds, const char* what) {
    if (holds) text += fmt::format(", {}", what);
  };
  say(has(s, kPanelMoving), "panel moves");
  say(has(s, kPanelOut) && !has(s, kPanelMoving), "panel out");
  say(confirmed(s), "motors confirmed");
  say(has(s, kFreeing), "leg is freed");
  say(link(s, lc::kPortClosed), "port closed");
  say(link(s, lc::kObcSilent), "OBC silent");
  say(link(s, lc::kHeld), "held");
  for (std::size_t i = 0; i < kModules; ++i) {
    const auto is = [&](std::uint16_t set) { return (unsigned{set} >> i & 1u) != 0; };
    if (is(s.silent)) text += fmt::format(", {} silent", kModuleNames[i]);
    if (is(s.unheard)) text += fmt::format(", {} never heard", kModuleNames[i]);
    if (is(s.isolated)) text += fmt::format(", {} isolated", kModuleNames[i]);
  }
  return text;
}

std::string text(const lc::Table& table, Happening happening) {
  for (const std::span<const lc::EventInfo> events : {lc::kCommonEvents, table.events}) {
    for (const lc::EventInfo& e : events) {
      if (e.event != happening.event) continue;
      return happening.subject == 0
                 ? e.name
                 : fmt::format("{} {}", e.name, kModuleNames[happening.subject - 1]);
    }
  }
  return "?";
}

}  // namespace lss::zebro
