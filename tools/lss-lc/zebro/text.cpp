// Lunar Zebro's controller as it is verified, and its states as people read them.

#include <fmt/format.h>

#include "tools/lss-lc/vehicle.h"
#include "tools/lss-lc/zebro/words.h"

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
  return text + lc::text_of_links(s, kModuleNames);
}

}  // namespace lss::zebro

namespace lss::lc {

const Verified& zebro_verified() {
  static const Verified vehicle{.name = "zebro",
                                .title = "Lunar Zebro",
                                .table = &zebro::kTable,
                                .model = zebro::model_of,
                                .modules = zebro::kAllModules,
                                .few = 0x41,  // a leg and the panel
                                .mode_names = zebro::kModeNames,
                                .goals = static_cast<std::uint8_t>(zebro::Goal::leg) + 1,
                                .text = zebro::text,
                                .module_names = zebro::kModuleNames};
  return vehicle;
}

}  // namespace lss::lc
