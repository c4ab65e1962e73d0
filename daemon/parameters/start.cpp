#include "daemon/parameters/start.h"

#include <fmt/format.h>

namespace lss {

TakenParameters vet(std::span<const TunableInfo> infos,
                    const std::vector<config::SavedValue>& saved) {
  TakenParameters taken;
  for (const config::SavedValue& value : saved) {
    const int index = find_tunable(infos, value.name);
    if (index < 0) {
      taken.refused.push_back(fmt::format("no parameter has the name \"{}\"", value.name));
      continue;
    }
    const TunableInfo& t = infos[static_cast<std::size_t>(index)];
    if (!in_range(t, value.value)) {
      taken.refused.push_back(fmt::format("{}: {} is out of range {} to {}{}", t.name, value.value,
                                          t.min, t.max, t.whole ? ", whole numbers" : ""));
      continue;
    }
    taken.values.push_back(value);
  }
  return taken;
}

ParameterReport report_of(const ParameterStart& start, std::span<const TunableInfo> infos,
                          const TunableValues& present) {
  ParameterReport report{.infos = infos, .present = present, .configured = start.configured};
  report.saved.fill(kRequired);
  for (const config::SavedValue& value : start.taken.values)
    report.saved[static_cast<std::size_t>(find_tunable(infos, value.name))] = value.value;
  report.number = start.loaded.taken ? start.loaded.taken->number : 0;
  report.state = start.loaded.state;
  return report;
}

}  // namespace lss
