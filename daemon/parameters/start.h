#pragma once

// The initial parameters of a daemon or of a replay: the values of the configuration, some replaced
// by saved values. Saved values that are not accepted are reported by name. Start-up only.

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/cycle/tunables.h"
#include "daemon/parameters/store.h"

namespace lss {

struct TakenParameters {
  std::vector<config::SavedValue> values;  // accepted
  std::vector<std::string> refused;        // messages about values that were not accepted
};

// Modules that were out of service when the daemon ended, and the store in which each change is
// saved at once.
struct Isolation {
  ParameterStore store;
  std::uint16_t modules = 0;          // bit i: module i+1
  std::vector<std::string> troubles;  // messages
};
Isolation load_isolation(const config::Config& config);
// Returns 0 or errno.
int save_isolation(ParameterStore& store, std::uint16_t modules, std::int64_t utc_ns);

// The parameters at a daemon's start, and the store of the saved ones.
struct ParameterStart {
  TunableValues configured;
  TakenParameters taken;
  ParameterStore store;
  ParameterStore::Loaded loaded;  // loaded.taken: the saved values, accepted or not
  Isolation isolation;
};

// Checks each value alone: its parameter is known, and it is in range.
TakenParameters vet(std::span<const TunableInfo> infos,
                    const std::vector<config::SavedValue>& saved);

// Checks the values also together. If they do not fit together, none is accepted.
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
    taken.refused.push_back(std::string("the saved parameters do not fit the configuration: ") +
                            wrong);
    return taken;
  }
  parameters = changed;
  return taken;
}

// Replaces values in `parameters`, which come from the configuration, by the saved ones.
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

// The first report to publish. `present`: the values that the vehicle uses.
ParameterReport report_of(const ParameterStart& start, std::span<const TunableInfo> infos,
                          const TunableValues& present);

}  // namespace lss
