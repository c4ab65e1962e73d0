#pragma once

// The initial parameters of a daemon or of a replay: those of the configuration, replaced by those
// that were saved. Refused ones are reported by name. Start-up only.

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/cycle/tunables.h"
#include "daemon/parameters/store.h"

namespace lss {

struct TakenParameters {
  std::vector<config::SavedValue> values;  // in force
  std::vector<std::string> refused;        // sentences
};

// Modules that were out of service when the daemon ended, with the place where they are saved: at
// once, when they change.
struct Isolation {
  ParameterStore store;
  std::uint16_t modules = 0;          // bit i: module i+1
  std::vector<std::string> troubles;  // sentences
};
Isolation load_isolation(const config::Config& config);
// 0, or the error's number.
int save_isolation(ParameterStore& store, std::uint16_t modules, std::int64_t utc_ns);

// Of a daemon, with the place of its saved parameters.
struct ParameterStart {
  TunableValues configured;
  TakenParameters taken;
  ParameterStore store;
  ParameterStore::Loaded loaded;  // `taken` of it: the saved ones, not necessarily accepted
  Isolation isolation;
};

// Checks each alone: known, and in its range.
TakenParameters vet(std::span<const TunableInfo> infos,
                    const std::vector<config::SavedValue>& saved);

// Checks them together, too; else none is accepted.
template <class P>
TakenParameters take_saved(const Tuning<P>& tuning, const std::vector<config::SavedValue>& saved,
                           P& parameters) {
  TakenParameters taken = vet(tuning.infos, saved);
  P changed = parameters;
  for (const config::SavedValue& value : taken.values) {
    const auto index = static_cast<std::size_t>(find_tunable(tuning.infos, value.name));
    set_tunable(tuning.tunables[index], changed, value.value);
  }
  tuning.derive(changed);
  if (const char* wrong = tuning.check(changed); wrong != nullptr) {
    taken.values.clear();
    taken.refused.push_back(std::string("the saved parameters do not go with the configuration: ") +
                            wrong);
    return taken;
  }
  parameters = changed;
  return taken;
}

// Reads the saved parameters into `parameters`, which are those of the configuration.
template <class P>
ParameterStart start_parameters(const Tuning<P>& tuning, const config::Config& config,
                                P& parameters) {
  ParameterStart start{.configured = values_of(tuning.tunables, parameters),
                       .taken = {},
                       .store = {config.parameters_folder, config.vehicle, config.vehicle_id},
                       .loaded = {},
                       .isolation = load_isolation(config)};
  start.loaded = start.store.load();
  if (start.loaded.taken) start.taken = take_saved(tuning, start.loaded.taken->values, parameters);
  if (!start.taken.refused.empty() && start.loaded.state != SavedState::lost)
    start.loaded.state = SavedState::partly;
  return start;
}

// The initial report to publish. `present`: the values of the vehicle.
ParameterReport report_of(const ParameterStart& start, std::span<const TunableInfo> infos,
                          const TunableValues& present);

}  // namespace lss
