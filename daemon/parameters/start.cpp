#include "daemon/parameters/start.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

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

namespace {
constexpr const char* kIsolated = "isolated";  // the only value there
}

Isolation load_isolation(const config::Config& config) {
  Isolation isolation{
      .store = {config.parameters_folder, config.vehicle, config.vehicle_id, disk(), "isolation"},
      .modules = 0,
      .troubles = {}};
  ParameterStore::Loaded loaded = isolation.store.load();
  isolation.troubles = std::move(loaded.troubles);
  if (!loaded.taken) return isolation;
  for (const config::SavedValue& value : loaded.taken->values) {
    if (value.name == kIsolated && value.value >= 0 && value.value <= UINT16_MAX)
      isolation.modules = static_cast<std::uint16_t>(value.value);
  }
  return isolation;
}

int save_isolation(ParameterStore& store, std::uint16_t modules, std::int64_t utc_ns) {
  std::uint64_t number = 0;
  return store.save({{.name = kIsolated, .value = static_cast<double>(modules)}}, utc_ns, number);
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
