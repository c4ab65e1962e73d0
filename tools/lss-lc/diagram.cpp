#include "tools/lss-lc/diagram.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <set>
#include <vector>

namespace lss::lc {

std::string diagram(const Verified& vehicle) {
  const Model model = vehicle.model(*vehicle.table, vehicle.few);
  const auto box = [&](const ControllerState& s) -> std::string {
    return s.mode != 0 ? vehicle.mode_names[s.mode]
                       : kStateNames[static_cast<std::size_t>(s.state)];
  };
  std::map<std::pair<std::string, std::string>, std::set<std::string>> ways;
  std::map<std::string, std::set<std::string>> boxes;  // of a state
  std::set<Key> seen{pack(model.begin)};
  std::vector<ControllerState> left{model.begin};
  while (!left.empty()) {
    const ControllerState before = left.back();
    left.pop_back();
    boxes[kStateNames[static_cast<std::size_t>(before.state)]].insert(box(before));
    for (const Happening h : model.happenings) {
      const ControllerState next = step(*model.table, before, h.event, h.subject).next;
      // Transitions from every mode: one arrow from each state is enough.
      const bool falls = (next.state == State::fatal_error && before.state != State::fatal_error) ||
                         h.event == Event::reset_controller;
      const std::string from =
          falls ? kStateNames[static_cast<std::size_t>(before.state)] : box(before);
      if (box(before) != box(next)) ways[{from, box(next)}].insert(text(vehicle, {h.event, 0}));
      if (seen.insert(pack(next)).second) left.push_back(next);
    }
  }
  std::string drawn =
      "// Made by: lss-lc diagram\n"
      "digraph locomotion_controller {\n"
      "  compound=true; rankdir=TB; fontname=\"sans-serif\"; nodesep=0.5; ranksep=0.6;\n"
      "  node [shape=box, style=\"rounded,filled\", fillcolor=white, fontname=\"sans-serif\"];\n"
      "  edge [fontname=\"sans-serif\", fontsize=10];\n";
  std::map<std::string, std::string> first;  // a box in each state with several
  for (const auto& [state, of_state] : boxes) {
    if (of_state.size() == 1) continue;
    first[state] = *of_state.begin();
    drawn +=
        fmt::format("  subgraph \"cluster_{}\" {{ label=\"{}\"; style=rounded; bgcolor=gray95;\n",
                    state, state);
    for (const std::string& b : of_state) drawn += fmt::format("    \"{}\";\n", b);
    drawn += "  }\n";
  }
  for (const auto& [way, events] : ways) {
    const auto cluster = first.find(way.first);
    drawn += fmt::format(
        "  \"{}\" -> \"{}\" [label=\"{}\"{}];\n",
        cluster == first.end() ? way.first : cluster->second, way.second, fmt::join(events, "\\n"),
        cluster == first.end() ? "" : fmt::format(", ltail=\"cluster_{}\"", way.first));
  }
  return drawn + "}\n";
}

}  // namespace lss::lc
