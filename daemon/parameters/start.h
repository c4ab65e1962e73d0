#pragma once

// The parameters that a daemon, or a replay, begins with: those of the configuration, and in their
// place those that were saved. What is not taken is told by name. Start-up only.

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/core/tunables.h"
#include "daemon/parameters/store.h"

namespace lss {

struct TakenParameters {
  std::vector<config::SavedValue> values;  // in force
  std::vector<std::string> refused;        // sentences
};

// Of a daemon, with where they are saved.
struct ParameterStart {
  TunableValues configured;
  TakenParameters taken;
  ParameterStore store;
  ParameterStore::Loaded loaded;  // `taken` of it: what was saved, and not necessarily taken
};

// Each by itself: known, and in its range.
TakenParameters vet(std::span<const TunableInfo> infos,
                    const std::vector<config::SavedValue>& saved);

// Also together; else none of them.
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

// Reads what was saved and puts it into `parameters`, which are those of the configuration.
template <class P>
ParameterStart start_parameters(const Tuning<P>& tuning, const config::Config& config,
                                P& parameters) {
  ParameterStart start{.configured = values_of(tuning.tunables, parameters),
                       .taken = {},
                       .store = {config.parameters_folder, config.vehicle, config.vehicle_id},
                       .loaded = {}};
  start.loaded = start.store.load();
  if (start.loaded.taken) start.taken = take_saved(tuning, start.loaded.taken->values, parameters);
  if (!start.taken.refused.empty() && start.loaded.state != SavedState::lost)
    start.loaded.state = SavedState::partly;
  return start;
}

// How they begin, to be published. `present`: as the vehicle has them.
ParameterReport report_of(const ParameterStart& start, std::span<const TunableInfo> infos,
                          const TunableValues& present);

}  // namespace lss
